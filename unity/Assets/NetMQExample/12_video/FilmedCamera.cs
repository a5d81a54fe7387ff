// Lesson 12, a camera that can be filmed: any camera of a scene, also the main one.
//
// While a film is made it renders once more for each picture, into a texture as large as Python asked for; at all other
// times it costs nothing. The pixels come a frame or two later, as in lesson 08: no frame waits for the graphics card,
// but for a picture on demand.
using System.Collections.Generic;
using UnityEngine;

namespace NetMQExample
{
    /// <summary>For Unity's main thread.</summary>
    public sealed class FilmedCamera
    {
        private readonly Dictionary<Picture, CameraReadback> readbacks = new Dictionary<Picture, CameraReadback>();
        private readonly Queue<Picture> begun = new Queue<Picture>();
        private readonly Camera camera;
        private RenderTexture texture;
        private RunningFilm film;
        private bool turned;

        /// <summary>Offers a camera, which goes on as it is, as a view with its name: at most so many pixels.</summary>
        /// <exception cref="System.ArgumentException">Its name cannot be that of a view, or there is no graphics
        /// card.</exception>
        public FilmedCamera(Camera camera, int width, int height)
        {
            this.camera = Require.Given("camera", camera);
            View = new FilmView(camera.name, width, height, 4);
            // For its check alone.
            _ = new CameraReadback(camera, new byte[0]);
        }

        public FilmView View { get; }

        /// <summary>Takes what has come, and a new picture if one is due. Call it in each LateUpdate.</summary>
        public void Poll()
        {
            if (camera == null || (begun.Count == 0 && !View.Filming)) return;
            var before = camera.targetTexture;
            if (View.Due() is Picture due)
            {
                if (due.Film != film) Begin(due.Film);
                camera.targetTexture = texture;
                if (!readbacks.ContainsKey(due)) readbacks[due] = Readback(due);
                readbacks[due].Begin();
                // Python does nothing until it is there.
                if (due.Film.OnDemand) readbacks[due].Wait();
                begun.Enqueue(due);
            }
            if (begun.Count > 0) camera.targetTexture = texture;
            while (begun.Count > 0 && readbacks[begun.Peek()].Poll())
            {
                var picture = begun.Dequeue();
                View.Take(picture, readbacks[picture].Failed);
            }
            camera.targetTexture = before;
        }

        public void Dispose()
        {
            if (texture != null) Object.Destroy(texture);
        }

        private void Begin(RunningFilm next)
        {
            Dispose();
            begun.Clear();
            readbacks.Clear();
            // The bytes in it are those of the screen, also where a project computes its light in linear space.
            texture = new RenderTexture(next.Width, next.Height, 24,
                RenderTextureFormat.ARGB32, RenderTextureReadWrite.sRGB);
            film = next;
        }

        private CameraReadback Readback(Picture picture)
        {
            var readback = new CameraReadback(camera, picture.Pixels);
            // Looked at once in each film: it takes two pictures and waits for them.
            if (readbacks.Count == 0) turned = readback.IsTurned();
            readback.Turned = turned;
            return readback;
        }
    }
}
