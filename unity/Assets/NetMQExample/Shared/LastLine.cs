// Shows the lessons' log in the scene itself: where a headset or a phone has no console, and so that a scene shows
// something.
//
// Use: it is on the 3D text of each lesson's scene. For one of your own: Component, Mesh, Text Mesh, and this
// component.
using System.Text.RegularExpressions;
using UnityEngine;

namespace NetMQExample
{
    /// <summary>Shows the line that was logged last.</summary>
    [AddComponentMenu("NetMQ Example/Last Line")]
    [RequireComponent(typeof(TextMesh))]
    public sealed class LastLine : MonoBehaviour
    {
        // 60 characters: 12 m in the scenes, of which a window of 4 to 3 shows 15.
        private static readonly Regex TooLong = new Regex("(?=.{61})(.{1,60}) ");

        private TextMesh mesh;

        private void OnEnable()
        {
            mesh = GetComponent<TextMesh>();
            Application.logMessageReceived += Show;
        }

        private void OnDisable() => Application.logMessageReceived -= Show;
        private void Show(string line, string stack, LogType type) => mesh.text = Wrapped(line);

        /// <summary>The same in lines that fit, for a text that does not wrap by itself.</summary>
        internal static string Wrapped(string text) => TooLong.Replace(text, "$1\n");
    }
}
