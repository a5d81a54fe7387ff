// Pictures come back from the graphics card two frames after they were asked for, and are there for one frame.
using System;
using System.Collections.Generic;
using Unity.Collections;

namespace UnityEngine.Rendering
{
    public struct AsyncGPUReadbackRequest
    {
        private readonly Readback work;
        private readonly int number;
        internal AsyncGPUReadbackRequest(Readback work) => (this.work, number) = (work, work.Number);
        // A request that is over is done, with an error: so a script that did not look in time learns of it.
        public bool done => work == null || work.Number != number || work.Left <= 0;
        public bool hasError => work == null || work.Number != number || work.Failed;

        public NativeArray<T> GetData<T>(int layer = 0) where T : struct
        {
            MainThread.Only(nameof(GetData));
            if (!done || hasError) throw new InvalidOperationException("Cannot access the data as it is not available");
            if (layer != 0) throw new ArgumentException($"Layer index is out of range {layer} / 1");
            return new NativeArray<T>(work.Pixels as T[]
                ?? throw new NotSupportedException("the player has only bytes"));
        }

        public void WaitForCompletion()
        {
            MainThread.Only(nameof(WaitForCompletion));
            if (!done) work.Left = 0;
        }
    }

    public static class AsyncGPUReadback
    {
        private static readonly List<Readback> Working = new List<Readback>();
        private static readonly Stack<Readback> Idle = new Stack<Readback>();
        /// <summary>So many of the next requests end with an error.</summary>
        internal static int ToFail { get; set; }

        public static AsyncGPUReadbackRequest Request(
            Texture src, int mipIndex, TextureFormat dstFormat, Action<AsyncGPUReadbackRequest> callback = null)
        {
            MainThread.Only(nameof(Request));
            if (!(src is RenderTexture texture) || mipIndex != 0 || dstFormat != TextureFormat.RGBA32)
                throw new NotSupportedException("the player reads only render textures, as RGBA32");
            var work = Idle.Count > 0 && Idle.Peek().Pixels.Length == texture.Pixels.Length
                ? Idle.Pop()
                : new Readback(texture.Pixels.Length);
            Camera.Rendering.Start();
            Buffer.BlockCopy(texture.Pixels, 0, work.Pixels, 0, work.Pixels.Length);
            Camera.Rendering.Stop();
            (work.Left, work.Failed) = (2, ToFail > 0 || !SystemInfo.supportsAsyncGPUReadback);
            ToFail = Math.Max(0, ToFail - 1);
            work.Callback = callback;
            Working.Add(work);
            return new AsyncGPUReadbackRequest(work);
        }

        /// <summary>At the beginning of each frame.</summary>
        internal static void NextFrame()
        {
            Camera.Rendering.Start();
            for (var i = Working.Count - 1; i >= 0; i--)
            {
                var work = Working[i];
                var left = work.Left--;
                if (left <= 1) Tell(work);
                if (left > 0) continue;
                Working.RemoveAt(i);
                work.Number++;
                // A script that has kept it sees that it is no picture any more.
                Array.Fill(work.Pixels, (byte)0xCD);
                Idle.Push(work);
            }
            Camera.Rendering.Stop();
        }

        private static void Tell(Readback work)
        {
            var callback = work.Callback;
            work.Callback = null;
            try { callback?.Invoke(new AsyncGPUReadbackRequest(work)); }
            catch (Exception e) { Debug.LogException(e); }
        }
    }

    internal sealed class Readback
    {
        public readonly byte[] Pixels;
        public int Number, Left;
        public bool Failed;
        public Action<AsyncGPUReadbackRequest> Callback;
        public Readback(int bytes) => Pixels = new byte[bytes];
    }
}
