// The inspector of every client: while it plays, what it is doing, why it has given up, and buttons.
using System.Collections.Generic;
using System.Linq;
using UnityEditor;
using UnityEditor.UIElements;
using UnityEngine;
using UnityEngine.UIElements;

namespace NetMQExample.Editor
{
    /// <summary>Below the fields of each component that connects.</summary>
    [CustomEditor(typeof(ConnectedBehaviour), true), CanEditMultipleObjects]
    internal sealed class ClientInspector : UnityEditor.Editor
    {
        public override bool RequiresConstantRepaint() => EditorApplication.isPlaying;

        public override VisualElement CreateInspectorGUI()
        {
            var inspector = new VisualElement();
            // As Unity draws them by itself: with the drawers that a project has for its own attributes.
            InspectorElement.FillDefaultInspector(inspector, serializedObject, this);
            inspector.Add(new IMGUIContainer(DrawClients));
            return inspector;
        }

        // Of a prefab in Assets a button would change the file. And what is selected may just have been destroyed.
        private IEnumerable<ConnectedBehaviour> Playing => targets.Cast<ConnectedBehaviour>().Where(client =>
            EditorApplication.isPlaying && client != null && !EditorUtility.IsPersistent(client));

        private void DrawClients()
        {
            foreach (var client in Playing) Draw(client);
        }

        private static void Draw(ConnectedBehaviour client)
        {
            var lamp = client.LastError.Length > 0 ? MessageType.Error
                : client.isActiveAndEnabled ? MessageType.Info : MessageType.Warning;
            EditorGUILayout.HelpBox(client.State, lamp);
            if (client.LastError.Length > 0) EditorGUILayout.HelpBox(client.LastError, MessageType.Error);
            if (!client.enabled && GUILayout.Button("Connect")) client.enabled = true;
            else if (client.enabled && GUILayout.Button("Drop the connection")) client.enabled = false;
            if (client is HelloBackground hello && client.isActiveAndEnabled && GUILayout.Button("Send hello"))
                hello.Client.Request("hello", Say, Debug.LogError);
        }

        private static void Say(string reply) => Debug.Log($"received {LogText.Printable(reply)}");
        private void OnEnable() => EditorApplication.update += Poll;
        private void OnDisable() => EditorApplication.update -= Poll;

        // The component itself listens only until its own last reply is there.
        private void Poll()
        {
            foreach (var hello in Playing.OfType<HelloBackground>())
                if (hello.isActiveAndEnabled) hello.Client?.Poll();
        }
    }
}
