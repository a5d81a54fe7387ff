// As much of UI Toolkit as an inspector needs: its fields are one line of text.
using System;
using System.Collections.Generic;
using UnityEngine.UIElements;

namespace UnityEditor
{
    public class SerializedObject
    {
        internal SerializedObject() { }
    }
}

namespace UnityEditor.UIElements
{
    public class InspectorElement : BindableElement
    {
        private InspectorElement() { }

        public static void FillDefaultInspector(
            VisualElement container, SerializedObject serializedObject, Editor editor) =>
            container.Add(new IMGUIContainer(() => Drawing.Lines.Add($"fields of {editor.target.GetType().Name}")));
    }
}

namespace UnityEngine.UIElements
{
    public abstract class CallbackEventHandler { }

    public abstract class Focusable : CallbackEventHandler { }

    public class VisualElement : Focusable
    {
        private readonly List<VisualElement> children = new List<VisualElement>();

        public void Add(VisualElement child) => children.Add(child);
        internal virtual void Draw() => children.ForEach(child => child.Draw());
    }

    public class BindableElement : VisualElement { }

    public class IMGUIContainer : VisualElement
    {
        private readonly Action onGUIHandler;

        public IMGUIContainer(Action onGUIHandler) => this.onGUIHandler = onGUIHandler;
        internal override void Draw() => onGUIHandler();
    }
}
