// Lesson 08, the newest pictures: the main thread takes them again and again, the network thread gets the newest.
//
// A set has a picture of each camera at one moment. Two are on their way from the graphics card, one lies ready, one is
// being sent: four sets do for ever, and nobody waits for the other but the network thread for a first picture.
using System;
using System.Collections.Generic;
using System.Linq;
using System.Threading;
using UnityEngine;
using UnityEngine.Experimental.Rendering;
using Object = UnityEngine.Object;

namespace NetMQExample
{
    /// <summary>Takes pictures with some cameras.</summary>
    public sealed class PictureTaker : IDisposable
    {
        private readonly Queue<Taking> begun = new Queue<Taking>(2);
        private readonly Stack<Taking> free = new Stack<Taking>();
        private readonly object gate = new object();
        private readonly Camera[] cameras;
        private readonly RenderTexture[] textures;
        private readonly bool jpeg;
        private Taking newest, sent;
        private readonly int steps;
        private long next, number = -1;
        private bool trouble;

        /// <summary>Makes room, and finds out which row of a picture comes first.</summary>
        /// <param name="names">The cameras' names, as in <see cref="CameraPictures"/>.</param>
        /// <param name="jpeg">Whether they are sent as JPEG files.</param>
        /// <param name="steps">Pictures are taken after each so many of the world's steps.</param>
        /// <param name="make">Makes a camera with a texture, so many metres to the right of the middle.</param>
        /// <exception cref="ArgumentException">There are no such cameras, or there is no graphics card.</exception>
        public PictureTaker(string names, bool jpeg, int steps, Func<double, Camera> make)
        {
            this.jpeg = jpeg;
            this.steps = steps;
            Require.Given("names", names);
            cameras = new CameraPictures(names, 1, 1, 4).Right.Select(Require.Given("make", make)).ToArray();
            textures = Array.ConvertAll(cameras, camera => camera.targetTexture);
            for (var i = 0; i < 4; i++) free.Push(new Taking(names, cameras));
            var turned = free.Peek().Readbacks[0].IsTurned();
            if (turned) Debug.Log("pictures come with the highest row first here: they are turned over");
            foreach (var readback in free.SelectMany(taking => taking.Readbacks)) readback.Turned = turned;
        }

        /// <summary>How many sets of pictures since the first one were not sent, or not taken.</summary>
        public long Skipped { get; private set; }

        /// <summary>Takes what has come, and new pictures if the world has moved far enough. For Update.</summary>
        /// <param name="drive">What is written beside the pictures.</param>
        /// <param name="wait">Whether the pictures are wanted in this very frame.</param>
        public void Poll(Drive drive, bool wait)
        {
            Collect();
            if (drive.Frame < next || begun.Count == 2) return;
            Taking taking;
            // It is only ever held for an instant.
            lock (gate) taking = free.Pop();
            // Both now: what is written beside the pictures belongs to the moment that they show.
            drive.Note(taking.Pictures);
            foreach (var readback in taking.Readbacks) readback.Begin();
            next = drive.Frame + steps;
            begun.Enqueue(taking);
            if (!wait) return;
            foreach (var readback in taking.Readbacks) readback.Wait();
            Collect();
        }

        /// <summary>Waits for pictures that are newer than the last ones, which must not be used any more. For the
        /// network thread, which also makes the JPEG files.</summary>
        public Message Next(CancellationToken stop)
        {
            lock (gate)
            {
                if (sent != null) free.Push(sent);
                for (sent = null; newest == null; Monitor.Wait(gate, 50)) stop.ThrowIfCancellationRequested();
                (sent, newest) = (newest, null);
            }
            var pictures = sent.Pictures;
            if (number >= 0) Skipped += ((pictures.Frame - number) / steps) - 1;
            number = pictures.Frame;
            return pictures.ToMessage(jpeg ? Encoder(pictures) : null);
        }

        // Apart, for C# makes the object of a lambda where its method begins, also where there is no JPEG.
        private static Func<byte[], byte[]> Encoder(CameraPictures pictures) => pixels => ImageConversion
            .EncodeArrayToJPG(pixels, GraphicsFormat.R8G8B8A8_SRGB, (uint)pictures.Width, (uint)pictures.Height);

        /// <summary>Takes the cameras away. For the main thread.</summary>
        public void Dispose()
        {
            foreach (var camera in cameras)
            {
                // Its object may have been destroyed before.
                if (camera == null) continue;
                camera.targetTexture = null;
                Object.Destroy(camera.gameObject);
            }
            foreach (var texture in textures) Object.Destroy(texture);
        }

        private void Collect()
        {
            // In each frame, and each camera by itself: what is done is there for one frame only.
            foreach (var taking in begun) taking.Poll();
            while (begun.Count > 0 && begun.Peek().Poll())
            {
                var taking = begun.Dequeue();
                if (taking.Failed != trouble)
                    Debug.Log(taking.Failed ? "trouble: the graphics card gave no picture" : "pictures again");
                trouble = taking.Failed;
                // A world that waits for its picture gets another one.
                if (trouble) next = 0;
                lock (gate)
                {
                    var unused = taking;
                    if (!taking.Failed) (unused, newest) = (newest, taking);
                    if (unused != null) free.Push(unused);
                    Monitor.Pulse(gate);
                }
            }
        }

        /// <summary>One set of pictures, and where they are.</summary>
        private sealed class Taking
        {
            public readonly CameraPictures Pictures;
            public readonly CameraReadback[] Readbacks;

            public Taking(string names, Camera[] cameras)
            {
                var size = cameras[0].targetTexture;
                Pictures = new CameraPictures(names, size.width, size.height, 4);
                Readbacks = cameras.Zip(Pictures.Pixels, (camera, pixels) => new CameraReadback(camera, pixels))
                    .ToArray();
            }

            public bool Failed { get; private set; }

            public bool Poll()
            {
                var all = true;
                Failed = false;
                foreach (var readback in Readbacks)
                {
                    if (!readback.Poll()) all = false;
                    if (readback.Failed) Failed = true;
                }
                return all;
            }
        }
    }
}
