// The UI as far as scripts use it: what they show is kept and printed, and what one would do with it is --click of
// `kit.py play`.
using System;
using System.Globalization;
using UnityEngine.Events;

namespace UnityEngine.EventSystems
{
    public abstract class UIBehaviour : MonoBehaviour
    {
        internal void Show<T>(ref T kept, T value)
        {
            MainThread.Only("SetVerticesDirty");
            if (Equals(kept, value)) return;
            kept = value;
            Console.WriteLine(FormattableString.Invariant($"[{Title}] {value}"));
        }
    }
}

namespace UnityEngine.UI
{
    using UnityEngine.EventSystems;

    public abstract class Graphic : UIBehaviour
    {
        public virtual Color color { get; set; } = Color.white;
    }

    public abstract class MaskableGraphic : Graphic { }

    public class Text : MaskableGraphic
    {
        private string shown = "";
        public virtual string text { get => shown; set => Show(ref shown, value ?? ""); }
        public int fontSize { get; set; } = 14;
    }

    public class Image : MaskableGraphic
    {
        private Color tint = Color.white;
        private float filled = 1;
        public override Color color { get => tint; set => Show(ref tint, value); }
        public Sprite sprite { get; set; }
        public float fillAmount { get => filled; set => Show(ref filled, Mathf.Clamp01(value)); }
    }

    public class RawImage : MaskableGraphic
    {
        public Texture texture { get; set; }
    }

    /// <summary>A control that somebody can use.</summary>
    public class Selectable : UIBehaviour
    {
        public bool interactable { get; set; } = true;

        /// <summary>Acts as a user does, for --click.</summary>
        /// <param name="value">The text behind the equals sign, or an empty one.</param>
        internal void Click(string value)
        {
            if (interactable) Use(value);
            else Debug.LogWarning($"[{Title}] is not interactable");
        }

        private protected virtual void Use(string value) { }
    }

    public class Button : Selectable
    {
        public class ButtonClickedEvent : UnityEvent { }
        public ButtonClickedEvent onClick { get; } = new ButtonClickedEvent();
        private protected override void Use(string value) => onClick.Invoke();
    }

    public class Toggle : Selectable
    {
        public class ToggleEvent : UnityEvent<bool> { }
        private bool on = true;
        public ToggleEvent onValueChanged = new ToggleEvent();

        public bool isOn
        {
            get => on;
            set
            {
                if (on == value) return;
                Show(ref on, value);
                onValueChanged.Invoke(on);
            }
        }

        private protected override void Use(string value) => isOn = !isOn;
    }

    public class Slider : Selectable
    {
        public class SliderEvent : UnityEvent<float> { }
        private float shown;
        public float minValue { get; set; }
        public float maxValue { get; set; } = 1;
        public bool wholeNumbers { get; set; }
        public SliderEvent onValueChanged { get; } = new SliderEvent();

        public virtual float value
        {
            get => shown;
            set
            {
                var (before, put) = (shown, Mathf.Clamp(value, minValue, maxValue));
                Show(ref shown, wholeNumbers ? Mathf.Round(put) : put);
                if (shown != before) onValueChanged.Invoke(shown);
            }
        }

        private protected override void Use(string value) =>
            this.value = float.Parse(value, CultureInfo.InvariantCulture);
    }

    public class InputField : Selectable
    {
        public class SubmitEvent : UnityEvent<string> { }
        public class OnChangeEvent : UnityEvent<string> { }
        private string typed = "";
        public OnChangeEvent onValueChanged { get; } = new OnChangeEvent();
        public SubmitEvent onEndEdit { get; } = new SubmitEvent();
        public SubmitEvent onSubmit { get; } = new SubmitEvent();

        public string text
        {
            get => typed;
            set
            {
                if (typed == value) return;
                Show(ref typed, value ?? "");
                onValueChanged.Invoke(typed);
            }
        }

        public Text textComponent { get; set; }
        public void ActivateInputField() => MainThread.Only(nameof(ActivateInputField));

        // Typed, and ended by the Enter key.
        private protected override void Use(string value)
        {
            text = value;
            onSubmit.Invoke(text);
            onEndEdit.Invoke(text);
        }
    }
}

namespace TMPro
{
    public abstract class TMP_Text : UnityEngine.UI.Text
    {
        public new float fontSize { get; set; } = 36;
        public void SetText(string sourceText) => text = sourceText;
    }

    public class TextMeshPro : TMP_Text { }
    public class TextMeshProUGUI : TMP_Text { }
    public class TMP_InputField : UnityEngine.UI.InputField { }
}

namespace UnityEngine
{
    public sealed class Canvas : Behaviour { }

    public sealed class Sprite : Object
    {
        private Sprite(Texture2D texture, Rect rect) => (this.texture, this.rect) = (texture, rect);
        public Texture2D texture { get; }
        public Rect rect { get; }
        public static Sprite Create(Texture2D texture, Rect rect, Vector2 pivot) => new Sprite(texture, rect);
    }
}
