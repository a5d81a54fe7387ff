// Attributes speak to the inspector and the engine. The player heeds RequireComponent, DisallowMultipleComponent,
// Min and RuntimeInitializeOnLoadMethod; the others only have to compile.
using System;

namespace UnityEngine
{
    [AttributeUsage(AttributeTargets.Field)]
    public sealed class SerializeField : Attribute { }
    public sealed class HideInInspector : Attribute { }
    public abstract class PropertyAttribute : Attribute { }
    public class TooltipAttribute : PropertyAttribute { public readonly string tooltip; public TooltipAttribute(string tooltip) => this.tooltip = tooltip; }

    // Properties too only since Unity 6; the lessons are for 2022.3 as well.
    [AttributeUsage(AttributeTargets.Field, AllowMultiple = true)]
    public class HeaderAttribute : PropertyAttribute { public readonly string header; public HeaderAttribute(string header) => this.header = header; }

    [AttributeUsage(AttributeTargets.Field, AllowMultiple = true)]
    public class SpaceAttribute : PropertyAttribute
    {
        public readonly float height;
        public SpaceAttribute() : this(8) { }
        public SpaceAttribute(float height) => this.height = height;
    }

    [AttributeUsage(AttributeTargets.Field)]
    public sealed class TextAreaAttribute : PropertyAttribute
    {
        public readonly int minLines, maxLines;
        public TextAreaAttribute() : this(3, 3) { }
        public TextAreaAttribute(int minLines, int maxLines) => (this.minLines, this.maxLines) = (minLines, maxLines);
    }

    [AttributeUsage(AttributeTargets.Field)]
    public sealed class RangeAttribute : PropertyAttribute
    {
        public readonly float min, max;
        public RangeAttribute(float min, float max) => (this.min, this.max) = (min, max);
    }

    [AttributeUsage(AttributeTargets.Field)]
    public sealed class MinAttribute : PropertyAttribute { public readonly float min; public MinAttribute(float min) => this.min = min; }

    [AttributeUsage(AttributeTargets.Class, AllowMultiple = true)]
    public sealed class RequireComponent : Attribute { public Type m_Type0; public RequireComponent(Type requiredComponent) => m_Type0 = requiredComponent; }
    public sealed class AddComponentMenu : Attribute { public AddComponentMenu(string menuName) => componentMenu = menuName; public string componentMenu { get; } }

    [AttributeUsage(AttributeTargets.Method)]
    public sealed class ContextMenu : Attribute { public readonly string menuItem; public ContextMenu(string itemName) => menuItem = itemName; }

    [AttributeUsage(AttributeTargets.Class, Inherited = false)]
    public sealed class DisallowMultipleComponent : Attribute { }
    public enum RuntimeInitializeLoadType { AfterSceneLoad, BeforeSceneLoad, AfterAssembliesLoaded, BeforeSplashScreen, SubsystemRegistration }

    [AttributeUsage(AttributeTargets.Method)]
    public class RuntimeInitializeOnLoadMethodAttribute : Scripting.PreserveAttribute
    {
        public RuntimeInitializeOnLoadMethodAttribute() { }
        public RuntimeInitializeOnLoadMethodAttribute(RuntimeInitializeLoadType loadType) => this.loadType = loadType;
        public RuntimeInitializeLoadType loadType { get; private set; }
    }
}

namespace UnityEngine.Scripting
{
    [AttributeUsage(AttributeTargets.All, Inherited = false)]
    public class PreserveAttribute : Attribute { }
}
