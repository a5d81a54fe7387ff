// Pixels in memory, as far as a lesson sends them somewhere: RGB24 and RGBA32 without mipmaps, the lowest row first.
using System;

namespace Unity.Collections
{
    public struct NativeArray<T> where T : struct
    {
        private readonly T[] items;
        internal NativeArray(T[] items) => this.items = items;
        public int Length => items.Length;

        public T this[int index]
        {
            get => items[index];
            set => items[index] = value;
        }

        public void CopyTo(T[] array) => Copy(this, array);
        public T[] ToArray() => (T[])items.Clone();

        public static void Copy(NativeArray<T> src, T[] dst)
        {
            if (dst.Length != src.Length) throw new ArgumentException("source and destination length must be the same");
            Copy(src, 0, dst, 0, src.Length);
        }

        public static void Copy(NativeArray<T> src, int srcIndex, T[] dst, int dstIndex, int length) =>
            Array.Copy(src.items, srcIndex, dst, dstIndex, length);
    }
}

namespace UnityEngine
{
    using Unity.Collections;

    public enum TextureFormat { RGB24 = 3, RGBA32 = 4 }

    public class Texture : Object
    {
        public virtual int width { get; set; }
        public virtual int height { get; set; }
    }

    public sealed class Texture2D : Texture
    {
        private static Texture2D white;
        private byte[] pixels;

        public static Texture2D whiteTexture
        {
            get
            {
                if (white == null) LoadedScene.Made.Remove(white = new Texture2D(4, 4, TextureFormat.RGBA32, false));
                return white;
            }
        }

        public Texture2D(int width, int height) : this(width, height, TextureFormat.RGBA32, false) { }

        public Texture2D(int width, int height, TextureFormat textureFormat, bool mipChain)
        {
            MainThread.Only("Internal_Create");
            if (!Enum.IsDefined(typeof(TextureFormat), textureFormat) || mipChain)
                throw new NotSupportedException("the player has only RGB24 and RGBA32 without mipmaps");
            this.width = width;
            this.height = height;
            pixels = new byte[width * height * (int)textureFormat];
            LoadedScene.Made.Add(this);
        }

        public void LoadRawTextureData(byte[] data)
        {
            MainThread.Only(nameof(LoadRawTextureData));
            if (data.Length < pixels.Length)
                throw new UnityException($"LoadRawTextureData: not enough data provided (will result in overread).");
            Array.Copy(data, pixels, pixels.Length);
        }

        /// <summary>Where a graphics card is, it gets the pixels now.</summary>
        public void Apply() => MainThread.Only(nameof(Apply));
        public void Apply(bool updateMipmaps) => Apply();
        public void Apply(bool updateMipmaps, bool makeNoLongerReadable) => Apply();

        public NativeArray<T> GetRawTextureData<T>() where T : struct
        {
            MainThread.Only(nameof(GetRawTextureData));
            return new NativeArray<T>(pixels as T[] ?? throw new NotSupportedException("the player has only bytes"));
        }

        /// <summary>The lowest row first.</summary>
        public Color32[] GetPixels32()
        {
            MainThread.Only(nameof(GetPixels32));
            var size = pixels.Length / (width * height);
            var all = new Color32[width * height];
            for (var i = 0; i < all.Length; i++)
            {
                var at = size * i;
                var alpha = size == 4 ? pixels[at + 3] : byte.MaxValue;
                all[i] = new Color32(pixels[at], pixels[at + 1], pixels[at + 2], alpha);
            }
            return all;
        }

        public byte[] GetRawTextureData() => (byte[])pixels.Clone();

        public void ReadPixels(Rect source, int destX, int destY, bool recalculateMipMaps = true)
        {
            MainThread.Only(nameof(ReadPixels));
            var from = RenderTexture.active;
            if (from == null || source.width != width || source.height != height || from.width != width
                || from.height != height)
                throw new NotSupportedException("the player reads only all of a render texture of the same size");
            var size = pixels.Length / (width * height);
            for (var i = 0; i < width * height; i++) Array.Copy(from.Pixels, 4 * i, pixels, size * i, size);
        }

        internal byte[] Pixels => pixels;

        /// <summary>Another picture, of whatever size.</summary>
        internal void Become(int width, int height, byte[] pixels) =>
            (this.width, this.height, this.pixels) = (width, height, pixels);
    }
}
