// Shows a client's state as a text in the scene: a headset shows nothing that is drawn on the screen.
//
// Use: Component, Mesh, Text Mesh (Character Size 0.01, Font Size 80), this component, and in its field the client. It
// follows the camera; with Distance 0 it stays where you put it.
using UnityEngine;

namespace NetMQExample
{
    /// <summary>Shows a client's state, and why it has given up.</summary>
    [AddComponentMenu("NetMQ Example/Client Hud")]
    [RequireComponent(typeof(TextMesh))]
    public sealed class ClientHud : MonoBehaviour
    {
        // A text is garbage once it is drawn.
        private const float IntervalSeconds = 0.5f;

        [SerializeField, Tooltip("The client")] private ConnectedBehaviour client;
        [SerializeField, Min(0), Tooltip("In front of the camera, in metres; 0: not")] private float distance = 2;

        private TextMesh mesh;
        private float next;

        private void OnEnable()
        {
            mesh = GetComponent<TextMesh>();
            next = 0;
        }

        // After the camera has moved.
        private void LateUpdate()
        {
            if (distance > 0 && Camera.main != null) Follow(Camera.main.transform);
            var now = Time.realtimeSinceStartup;
            if (now < next) return;
            next = now + IntervalSeconds;
            mesh.text = LastLine.Wrapped(
                client == null ? "no client" : $"{client.GetType().Name}: {client.State}\n{client.LastError}");
        }

        private void Follow(Transform eye) =>
            transform.SetPositionAndRotation(eye.position + eye.rotation * Vector3.forward * distance, eye.rotation);
    }
}
