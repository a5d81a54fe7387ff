// Pixels in memory, as far as a lesson sends them somewhere: RGB24 without mipmaps, the lowest row first.
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

        public void CopyTo(T[] array)
        {
            if (array.Length != Length) throw new ArgumentException("source and destination length must be the same");
            items.CopyTo(array, 0);
        }
    }
}

namespace UnityEngine
{
    using Unity.Collections;

    public enum TextureFormat
    {
        RGB24 = 3,
    }

    public class Texture : Object
    {
        public virtual int width { get; set; }

        public virtual int height { get; set; }
    }

    public sealed class Texture2D : Texture
    {
        private readonly byte[] pixels;

        public Texture2D(int width, int height, TextureFormat textureFormat, bool mipChain)
        {
            MainThread.Only("Internal_Create");
            if (textureFormat != TextureFormat.RGB24 || mipChain) throw new NotSupportedException("the player has only RGB24 without mipmaps");
            this.width = width;
            this.height = height;
            pixels = new byte[width * height * 3];
        }

        public void LoadRawTextureData(byte[] data)
        {
            MainThread.Only(nameof(LoadRawTextureData));
            if (data.Length < pixels.Length)
                throw new UnityException($"LoadRawTextureData: not enough data provided (will result in overread).");
            Array.Copy(data, pixels, pixels.Length);
        }

        public NativeArray<T> GetRawTextureData<T>() where T : struct
        {
            MainThread.Only(nameof(GetRawTextureData));
            return new NativeArray<T>(pixels as T[] ?? throw new NotSupportedException("the player has only bytes"));
        }

        internal byte[] Pixels => pixels;
    }
}
