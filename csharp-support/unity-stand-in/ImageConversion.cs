// EncodeToJPG and EncodeArrayToJPG, with an encoder that is as small as a valid one can be: it keeps one colour for each 8 x 8 pixels.
using System;
using System.Collections.Generic;
using UnityEngine.Experimental.Rendering;

namespace UnityEngine.Experimental.Rendering
{
    public enum GraphicsFormat
    {
        R8G8B8_SRGB = 3,
        R8G8B8A8_SRGB = 4,
    }
}

namespace UnityEngine
{
    public static class ImageConversion
    {
        public static byte[] EncodeToJPG(this Texture2D tex) => tex.EncodeToJPG(75);

        public static byte[] EncodeToJPG(this Texture2D tex, int quality)
        {
            MainThread.Only(nameof(EncodeToJPG));
            return new Encoder(tex.Pixels, tex.width, tex.height).File.ToArray();
        }

        // On any thread.
        public static byte[] EncodeArrayToJPG(Array array, GraphicsFormat format, uint width, uint height, uint rowBytes = 0, int quality = 75)
        {
            if (array.Length != width * height * (int)format || rowBytes != 0) throw new ArgumentException("the array is not of this size");
            return new Encoder((byte[])array, (int)width, (int)height).File.ToArray();
        }

        // Baseline JPEG (ITU T.81): of each block's 64 coefficients only the first, the mean, is written.
        private sealed class Encoder
        {
            private int bits, held;

            public Encoder(byte[] pixels, int width, int height)
            {
                Add(0xFF, 0xD8);
                // Every step of the quantization is 8: the coefficient of a mean is 8 times the mean.
                Segment(0xDB, new byte[65], table => Array.Fill(table, (byte)8, 1, 64));
                Segment(0xC0, new byte[] { 8, (byte)(height >> 8), (byte)height, (byte)(width >> 8), (byte)width, 3, 1, 0x11, 0, 2, 0x11, 0, 3, 0x11, 0 });
                // Huffman codes: twelve of four bits for the size of a difference, and one of one bit for "the rest is 0".
                Segment(0xC4, new byte[] { 0x00, 0, 0, 0, 12, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11 });
                Segment(0xC4, new byte[] { 0x10, 1, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0 });
                Segment(0xDA, new byte[] { 3, 1, 0, 2, 0, 3, 0, 0, 63, 0 });
                var before = new int[3];
                for (var y = 0; y < height; y += 8)
                    for (var x = 0; x < width; x += 8)
                    {
                        var colour = Mean(pixels, width, height, x, y);
                        for (var part = 0; part < 3; part++)
                        {
                            Difference(colour[part] - before[part]);
                            before[part] = colour[part];
                        }
                    }
                Put(0x7F, 7);
                Add(0xFF, 0xD9);
            }

            public List<byte> File { get; } = new List<byte>();

            // Luminance and colour differences of a block, all about 0. The texture's lowest row comes first, the file's last.
            private static int[] Mean(byte[] pixels, int width, int height, int left, int top)
            {
                double red = 0, green = 0, blue = 0, count = 0;
                var channels = pixels.Length / (width * height);
                for (var y = top; y < Math.Min(top + 8, height); y++)
                    for (var x = left; x < Math.Min(left + 8, width); x++, count++)
                    {
                        var at = ((height - 1 - y) * width + x) * channels;
                        red += pixels[at];
                        green += pixels[at + 1];
                        blue += pixels[at + 2];
                    }
                var light = (0.299 * red + 0.587 * green + 0.114 * blue) / count;
                return new[] { (int)Math.Round(light - 128), (int)Math.Round((blue / count - light) / 1.772), (int)Math.Round((red / count - light) / 1.402) };
            }

            private void Difference(int value)
            {
                var size = 0;
                while (Math.Abs(value) >> size != 0) size++;
                Put(size, 4);
                Put(value < 0 ? value + (1 << size) - 1 : value, size);
                Put(0, 1);
            }

            private void Put(int value, int count)
            {
                while (count-- > 0)
                {
                    bits = bits << 1 | (value >> count & 1);
                    if (++held < 8) continue;
                    // In the data of a picture an FF is followed by a 00, to be no marker.
                    if (bits == 0xFF) Add(0xFF, 0x00);
                    else Add((byte)bits);
                    (bits, held) = (0, 0);
                }
            }

            private void Segment(byte marker, byte[] content, Action<byte[]> fill = null)
            {
                fill?.Invoke(content);
                Add(0xFF, marker, (byte)((content.Length + 2) >> 8), (byte)(content.Length + 2));
                Add(content);
            }

            private void Add(params byte[] bytes) => File.AddRange(bytes);
        }
    }
}
