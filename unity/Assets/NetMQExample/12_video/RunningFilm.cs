// Lesson 12, a film while it is made: which pictures are due, which are on the way, and how many were skipped.
using System;
using System.Collections.Concurrent;
using System.Collections.Generic;
using System.Diagnostics;

namespace NetMQExample
{
    /// <summary>A picture's bytes, which are used again once Python has them.</summary>
    public sealed class Picture
    {
        internal Picture(RunningFilm film, int channels)
        {
            Film = film;
            Pixels = new byte[film.Width * film.Height * channels];
        }

        /// <summary>The film that it belongs to, which says how large it is.</summary>
        public RunningFilm Film { get; }

        /// <summary>Red, green and blue, and alpha if the view has it; the lowest row first.</summary>
        public byte[] Pixels { get; }

        internal int Number { get; set; }
        internal double Time { get; set; }
    }

    /// <summary>The game's thread calls Due and Take, and is the only one that changes Number and Skipped; the rest is
    /// for the network's.</summary>
    public sealed class RunningFilm
    {
        // Pictures that were sent and are not yet with Python, and pictures at all: a camera needs a frame or two.
        private const int PicturesUnderWay = 2, Pictures = 4;
        private readonly ConcurrentQueue<Picture> free = new ConcurrentQueue<Picture>();
        private readonly ConcurrentQueue<Picture> ready = new ConcurrentQueue<Picture>();
        private readonly Dictionary<int, Picture> sent = new Dictionary<int, Picture>();
        private readonly Stopwatch clock = Stopwatch.StartNew();
        private readonly string view;
        private readonly double interval;
        private volatile Message ending;
        private volatile bool wanted;
        private volatile int number, skipped;
        private int frames;
        private double next, seconds;

        internal RunningFilm(long id, string view, int width, int height, int channels, double fps)
        {
            Id = id;
            this.view = view;
            Width = width;
            Height = height;
            // Without end, where pictures are taken on demand alone.
            interval = 1 / fps;
            next = fps > 0 ? 0 : interval;
            for (var i = 0; i < Pictures; i++) free.Enqueue(new Picture(this, channels));
        }

        public int Width { get; }
        public int Height { get; }

        /// <summary>Whether it has only the pictures that Python asks for.</summary>
        public bool OnDemand => double.IsInfinity(interval);

        internal long Id { get; }
        internal bool Ending => ending != null;

        internal Picture Due()
        {
            var now = clock.Elapsed.TotalSeconds;
            if (Ending || (now < next && !wanted)) return null;
            // As often as it was asked for, whenever the game has its frames; more than one is not made up for.
            next = Math.Max(next + interval, now - interval);
            number++;
            if (!free.TryDequeue(out var picture))
            {
                skipped++;
                return null;
            }
            wanted = false;
            picture.Number = number;
            picture.Time = now;
            return picture;
        }

        internal void Take(Picture picture, bool failed)
        {
            if (failed) skipped++;
            // Python waits for it.
            wanted |= failed && OnDemand;
            (failed ? free : ready).Enqueue(picture);
        }

        internal void Look() => wanted = true;

        internal void Took(Message request)
        {
            if (request.Id != Id || !(request.Values.GetValueOrDefault("number") is long taken)) return;
            if (sent.Remove((int)taken, out var picture)) free.Enqueue(picture);
        }

        internal void End(Message request)
        {
            seconds = clock.Elapsed.TotalSeconds;
            ending = request;
        }

        /// <summary>The next picture that is there, and after the last one the answer to end; or null.</summary>
        internal Message Next()
        {
            if (sent.Count < PicturesUnderWay && ready.TryDequeue(out var picture))
            {
                frames++;
                sent[picture.Number] = picture;
                var frame = new Message("frame", Id) { Values = { ["view"] = view, ["number"] = picture.Number } };
                frame.Values["time"] = picture.Time;
                frame.Values["bottom_up"] = true;
                var channels = picture.Pixels.Length / (Width * Height);
                frame.Arrays.Add(new MessageArray("uint8", picture.Pixels, Height, Width, channels));
                return frame;
            }
            // It waits for pictures that a camera still has, but not for ever.
            var all = frames + skipped == number || clock.Elapsed.TotalSeconds > seconds + 1;
            if (!Ending || !all) return null;
            var ended = new Message("ended", ending.Id) { Values = { ["view"] = view, ["time"] = seconds } };
            ended.Values["frames"] = frames;
            ended.Values["skipped"] = skipped;
            return ended;
        }
    }
}
