// JPEG and PNG, by StbImageWriteSharp and StbImageSharp.
using System;
using System.IO;
using StbImageSharp;
using StbImageWriteSharp;
using UnityEngine.Experimental.Rendering;

namespace UnityEngine.Experimental.Rendering
{
    public enum GraphicsFormat { R8G8B8_SRGB = 3, R8G8B8A8_SRGB = 4 }
}

namespace UnityEngine
{
    using Of = StbImageSharp.ColorComponents;

    public static class ImageConversion
    {
        public static byte[] EncodeToJPG(this Texture2D tex) => tex.EncodeToJPG(75);

        public static byte[] EncodeToJPG(this Texture2D tex, int quality)
        {
            MainThread.Only(nameof(EncodeToJPG));
            return Encode(tex.Pixels, tex.width, tex.height, quality);
        }

        public static byte[] EncodeToPNG(this Texture2D tex)
        {
            MainThread.Only(nameof(EncodeToPNG));
            return Encode(tex.Pixels, tex.width, tex.height, 0);
        }

        /// <summary>The texture gets the picture's size, and what was in it is gone.</summary>
        /// <returns>False if these bytes are no picture: nothing has changed then, where Unity shows a question
        /// mark.</returns>
        public static bool LoadImage(this Texture2D tex, byte[] data)
        {
            MainThread.Only(nameof(LoadImage));
            try
            {
                var picture = ImageResult.FromMemory(data, IsJpeg(data) ? Of.RedGreenBlue : Of.RedGreenBlueAlpha);
                tex.Become(picture.Width, picture.Height, UpsideDown(picture.Data, picture.Height));
                return true;
            }
            catch (InvalidOperationException) { return false; }
        }

        public static bool LoadImage(this Texture2D tex, byte[] data, bool markNonReadable) => tex.LoadImage(data);
        private static bool IsJpeg(byte[] data) => data.Length > 1 && data[0] == 0xff && data[1] == 0xd8;

        // On any thread.
        public static byte[] EncodeArrayToJPG(
            Array array, GraphicsFormat format, uint width, uint height, uint rowBytes = 0, int quality = 75)
        {
            if (array.Length != width * height * (int)format || rowBytes != 0)
                throw new ArgumentException("the array is not of this size");
            return Encode((byte[])array, (int)width, (int)height, quality);
        }

        // With the quality 0 as PNG.
        private static byte[] Encode(byte[] pixels, int width, int height, int quality)
        {
            var rows = UpsideDown(pixels, height);
            var parts = (StbImageWriteSharp.ColorComponents)(pixels.Length / height / width);
            using var file = new MemoryStream();
            if (quality == 0) new ImageWriter().WritePng(rows, width, height, parts, file);
            else new ImageWriter().WriteJpg(rows, width, height, parts, file, quality);
            return file.ToArray();
        }

        // A texture's lowest row comes first, a file's last.
        private static byte[] UpsideDown(byte[] pixels, int height)
        {
            var rows = new byte[pixels.Length];
            var row = pixels.Length / height;
            for (var y = 0; y < height; y++) Array.Copy(pixels, y * row, rows, (height - 1 - y) * row, row);
            return rows;
        }
    }
}
