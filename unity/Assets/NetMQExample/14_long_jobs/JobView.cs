// Lesson 14: a progress bar in the corner of the game's view, the picture as far as it is drawn, and a button.
//
// Use: add it to the GameObject with JobRunner.
using UnityEngine;

namespace NetMQExample
{
    /// <summary>Draws the newest state of a job. The network thread makes all that needs memory.</summary>
    [AddComponentMenu("NetMQ Example/14 Job View")]
    [RequireComponent(typeof(JobRunner))]
    public sealed class JobView : MonoBehaviour
    {
        private JobRunner runner;
        private JobNews shown;
        private Texture2D picture;

        private void OnEnable()
        {
            // IMGUI's own layout would cost a pass, and garbage, in each frame.
            useGUILayout = false;
            runner = GetComponent<JobRunner>();
        }

        private void OnDestroy() => Destroy(picture);

        private void Update()
        {
            if (runner.Newest == shown) return;
            shown = runner.Newest;
            if (shown?.Pixels == null) return;
            if (picture == null || picture.width != shown.Side)
            {
                Destroy(picture);
                picture = new Texture2D(shown.Side, shown.Side, TextureFormat.RGB24, false);
            }
            picture.LoadRawTextureData(shown.Pixels);
            picture.Apply();
        }

        private void OnGUI()
        {
            if (shown == null) return;
            GUI.Label(new Rect(10, 10, 800, 30), shown.Line);
            GUI.DrawTexture(new Rect(10, 40, 300 * shown.Share, 10), Texture2D.whiteTexture);
            if (picture != null) GUI.DrawTexture(new Rect(10, 60, 300, 300), picture);
            var ended = shown.Kind == "result" || shown.Kind == "forgotten";
            if (!ended && GUI.Button(new Rect(320, 35, 80, 20), "Cancel")) runner.Cancel();
        }
    }
}
