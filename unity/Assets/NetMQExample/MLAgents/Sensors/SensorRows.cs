// ML-Agents' shape, rows: the array of each sensor as it stands in a record. Pictures are uint8, 255 for 1.0; all
// others are float32.
using System;
using System.Runtime.InteropServices;

namespace NetMQExample.MLAgents.Sensors
{
    /// <summary>A sensor whose numbers are bytes.</summary>
    internal interface IPicture
    {
        /// <summary>False of a stack of something else.</summary>
        bool IsPicture { get; }

        /// <summary>Writes bytes, [channels, height, width].</summary>
        void Write(Span<byte> to);
    }

    /// <summary>For the main thread. It makes no garbage, unless a sensor does.</summary>
    internal static class SensorRows
    {
        private static readonly ObservationWriter Writer = new ObservationWriter();
        private static float[] numbers = new float[0];

        public static bool IsPicture(ISensor sensor) => sensor is IPicture picture && picture.IsPicture;

        /// <summary>How many bytes its array has.</summary>
        public static int Size(ISensor sensor) => sensor.ObservationSize() * (IsPicture(sensor) ? 1 : sizeof(float));

        /// <summary>Writes its array; of a stack, this also moves on, and so it is called for each decision, once.
        /// </summary>
        public static void Write(ISensor sensor, FrameBuffer to)
        {
            var size = Size(sensor);
            if (IsPicture(sensor))
            {
                ((IPicture)sensor).Write(to.GetSpan(size).Slice(0, size));
                to.Advance(size);
                return;
            }
            var count = size / sizeof(float);
            if (numbers.Length < count) numbers = new float[count];
            Array.Clear(numbers, 0, count);
            Writer.SetTarget(numbers, sensor);
            sensor.Write(Writer);
            to.Write(MemoryMarshal.AsBytes(numbers.AsSpan(0, count)));
        }
    }
}
