// What a text is drawn with. A terminal has no place for it: it is only kept.
namespace UnityEngine
{
    public struct Rect
    {
        public Rect(float x, float y, float width, float height)
        {
            this.x = x;
            this.y = y;
            this.width = width;
            this.height = height;
        }

        public float x { get; set; }

        public float y { get; set; }

        public float width { get; set; }

        public float height { get; set; }
    }

    public class GUI
    {
        internal static string Drawn { get; private set; } = "";

        internal static Texture Picture { get; private set; }

        public static void Label(Rect position, string text) => Drawn = text;

        public static void DrawTexture(Rect position, Texture image) => Picture = image;

        // Nobody clicks in a terminal.
        public static bool Button(Rect position, string text) => false;
    }

    public sealed class TextMesh : Component
    {
        public string text { get; set; } = "";
    }
}
