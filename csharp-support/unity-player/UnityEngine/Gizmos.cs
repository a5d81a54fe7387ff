// Lines in the editor's view of the scene, which nobody sees here.
namespace UnityEngine
{
    public sealed class Gizmos
    {
        public static Color color { get; set; } = Color.white;
        public static void DrawLine(Vector3 from, Vector3 to) { }
        public static void DrawRay(Vector3 from, Vector3 direction) { }
        public static void DrawWireSphere(Vector3 center, float radius) { }
    }
}
