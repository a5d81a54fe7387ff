// Lesson 08, the cameras' pictures of one moment, with their number and what the car did just then.
//
// Its buffers are used again and again: a new array for each picture would be collected only by the slowest of .NET's
// collections. The numbers become a message on the network thread, so that a frame of Unity allocates nothing.
// The Python side is pictures.py.
using System;
using System.Collections.Generic;
using System.Linq;

namespace NetMQExample
{
    /// <summary>What is sent: kind <c>frame</c>, whose id is the picture's number, and one array for each
    /// camera.</summary>
    public sealed class CameraPictures
    {
        private static readonly object True = true, False = false;
        private readonly Message message = new Message(new MessageStore(true));
        private readonly MessageArray[] arrays;

        /// <summary>Makes room for pictures of uint8 [height, width, channels], the lowest row first.</summary>
        /// <param name="cameras">Their names: <c>center</c>; <c>left,right</c>; or <c>left,center,right</c>.</param>
        /// <param name="channels">3; or 4, with the alpha that graphics cards add, which Python drops.</param>
        /// <exception cref="ArgumentException">There are no such cameras.</exception>
        public CameraPictures(string cameras, int width, int height, int channels)
        {
            if (!(cameras == "center" || cameras == "left,right" || cameras == "left,center,right"))
                throw new ArgumentException($"cameras are center, left,right or left,center,right, not '{cameras}'");
            Cameras = cameras;
            Width = width;
            Height = height;
            Channels = channels;
            Pixels = cameras.Split(',').Select(camera => new byte[width * height * channels]).ToArray();
            arrays = new MessageArray[Pixels.Length];
        }

        /// <summary>The cameras' names, and the measures of their pictures.</summary>
        public string Cameras { get; }
        public int Width { get; }
        public int Height { get; }
        public int Channels { get; }

        /// <summary>One array for each camera.</summary>
        public byte[][] Pixels { get; }

        /// <summary>How far to the right of the car's middle each camera is, in metres: two are as far apart as eyes,
        /// three as in Udacity's car.</summary>
        public double[] Right => Pixels.Length switch
        {
            1 => new[] { 0.0 },
            2 => new[] { -0.075, 0.075 },
            _ => new[] { -0.8, 0, 0.8 },
        };

        /// <summary>The picture's number: the step at which it was taken.</summary>
        public long Frame { get; internal set; }

        /// <summary>The world's time then in seconds, since the drive began.</summary>
        public double SimTime { get; internal set; }

        /// <summary>The clock's time then in seconds, since 1970.</summary>
        public double WallTime { get; internal set; }

        /// <summary>The action in force at the picture: -1 to 1, 0 to 1, and -1, left, to 1, right.</summary>
        public DriveAction Action { get; internal set; }

        /// <summary>In metres a second.</summary>
        public double Speed { get; internal set; }

        public bool Manual { get; internal set; }

        /// <summary>The drive that it belongs to: another text for each Play.</summary>
        public string Run { get; internal set; } = "";

        /// <summary>Values of the car's own: numbers, texts, true or false by name.</summary>
        public Dictionary<string, object> Telemetry { get; } = new Dictionary<string, object>();

        /// <summary>The message to send: the same one each time, which belongs to this. Its numbers are used again as
        /// well, so they are no double and no long: read <see cref="Speed"/> and the others from here.</summary>
        /// <exception cref="MessageException">The car adds a value with a name of this lesson.</exception>
        /// <param name="jpeg">Makes a JPEG file of a picture's pixels; null to send them as they are.</param>
        public Message ToMessage(Func<byte[], byte[]> jpeg = null)
        {
            var store = message.Begin("frame", Frame);
            var values = message.Values;
            values["frame"] = store.Number(Frame);
            values["run"] = Run;
            values["manual"] = Manual ? True : False;
            values["sim_time"] = store.Number(SimTime);
            values["wall_time"] = store.Number(WallTime);
            values["speed"] = store.Number(Speed);
            values["throttle"] = store.Number(Action.Throttle);
            values["brake"] = store.Number(Action.Brake);
            values["steer"] = store.Number(Action.Steer);
            values["cameras"] = Cameras;
            values["encoding"] = jpeg == null ? "raw" : "jpeg";
            // A JPEG file has its top row first, in Unity as everywhere.
            values["bottom_up"] = jpeg == null ? True : False;
            foreach (var own in Telemetry)
                if (!values.TryAdd(own.Key, own.Value))
                    throw new MessageException("bad-name", $"each picture has '{own.Key}': give yours another name");
            for (var i = 0; i < Pixels.Length; i++)
                message.Arrays.Add(jpeg == null ? Raw(i) : Jpeg(jpeg(Pixels[i])));
            return message;
        }

        private static MessageArray Jpeg(byte[] file) => new MessageArray("uint8", file, file.Length);

        private MessageArray Raw(int camera)
        {
            var pixels = new ReadOnlyMemory<byte>(Pixels[camera]);
            if (arrays[camera] == null || !arrays[camera].Data.Equals(pixels))
                arrays[camera] = new MessageArray("uint8", pixels, Height, Width, Channels);
            return arrays[camera];
        }
    }
}
