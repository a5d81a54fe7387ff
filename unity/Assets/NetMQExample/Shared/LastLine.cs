// What the lessons log, in the scene itself: where a headset or a phone has no console, and so that a scene shows
// something.
//
// Use: it is on the 3D text of each lesson's scene. For one of your own: 3D Object, Legacy, 3D Text, and this
// component.
using UnityEngine;

namespace NetMQExample
{
    /// <summary>Shows the line that was logged last.</summary>
    [AddComponentMenu("NetMQ Example/Last Line")]
    [RequireComponent(typeof(TextMesh))]
    public sealed class LastLine : MonoBehaviour
    {
        private TextMesh mesh;

        private void OnEnable()
        {
            mesh = GetComponent<TextMesh>();
            Application.logMessageReceived += Show;
        }

        private void OnDisable() => Application.logMessageReceived -= Show;

        private void Show(string line, string stack, LogType type) => mesh.text = line;
    }
}
