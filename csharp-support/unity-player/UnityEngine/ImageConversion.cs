// EncodeToJPG and EncodeArrayToJPG, by StbImageWriteSharp.
using System;
using System.IO;
using StbImageWriteSharp;
using UnityEngine.Experimental.Rendering;

namespace UnityEngine.Experimental.Rendering
{
    public enum GraphicsFormat { R8G8B8_SRGB = 3, R8G8B8A8_SRGB = 4 }
}

namespace UnityEngine
{
    public static class ImageConversion
    {
        public static byte[] EncodeToJPG(this Texture2D tex) => tex.EncodeToJPG(75);

        public static byte[] EncodeToJPG(this Texture2D tex, int quality)
        {
            MainThread.Only(nameof(EncodeToJPG));
            return Encode(tex.Pixels, tex.width, tex.height, quality);
        }

        // On any thread.
        public static byte[] EncodeArrayToJPG(Array array, GraphicsFormat format, uint width, uint height, uint rowBytes = 0, int quality = 75)
        {
            if (array.Length != width * height * (int)format || rowBytes != 0) throw new ArgumentException("the array is not of this size");
            return Encode((byte[])array, (int)width, (int)height, quality);
        }

        private static byte[] Encode(byte[] pixels, int width, int height, int quality)
        {
            // A texture's lowest row comes first, a file's last.
            var rows = new byte[pixels.Length];
            var row = pixels.Length / height;
            for (var y = 0; y < height; y++) Array.Copy(pixels, y * row, rows, (height - 1 - y) * row, row);
            using var file = new MemoryStream();
            new ImageWriter().WriteJpg(rows, width, height, (ColorComponents)(row / width), file, quality);
            return file.ToArray();
        }
    }
}
