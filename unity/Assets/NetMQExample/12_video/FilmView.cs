// Lesson 12, a view of the game: what can be filmed, and the film that Python makes of it now.
//
//     var picture = view.Due();       the game, in each of its frames: is a picture to be taken now?
//     … picture.Pixels …              the lowest row first
//     view.Take(picture);             now or some frames later
//
// Two pictures are on the way to Python at most, and two more are with a camera or wait. A fifth one is
// skipped and counted, so nothing piles up, and the game waits for nobody.
// In Python: netmq_example/video/view_sender.py.
using System;
using System.Collections.Generic;
using System.Globalization;
using System.Text.RegularExpressions;

namespace NetMQExample
{
    /// <summary>Due and Take are for the game's thread, the rest is for the network's.</summary>
    public sealed class FilmView
    {
        private readonly int channels;
        private volatile RunningFilm film;

        /// <summary>Offers a view of at most so many pixels. Its name, of letters, digits, spaces, - and _, becomes
        /// that of a file. A pixel has 3 bytes; or 4, with the alpha of graphics cards, which Python drops.</summary>
        /// <exception cref="ArgumentException">The name cannot be that of a view, or it is too large.</exception>
        public FilmView(string name, int width, int height, int channels = 3)
        {
            if (!Regex.IsMatch(Require.Given("name", name), @"^[A-Za-z0-9_ -]{1,40}\z"))
                throw new ArgumentException($"a view cannot be '{name}': give it a name of letters, digits, - and _");
            if (!(width > 0 && height > 0 && (long)width * height * channels <= Message.LimitBytes))
                throw new ArgumentException($"a view of {width} x {height} is too small, or too large for a message");
            Name = name;
            Width = width;
            Height = height;
            this.channels = channels;
        }

        public string Name { get; }
        public int Width { get; }
        public int Height { get; }

        /// <summary>Whether a film of it is made. For any thread.</summary>
        public bool Filming => film != null;

        /// <summary>The picture to be taken now; null if there is none to take.</summary>
        public Picture Due() => film?.Due();

        /// <summary>The picture is taken, and goes to Python; or it could not be taken.</summary>
        public void Take(Picture picture, bool failed = false) => picture.Film.Take(picture, failed);

        /// <summary>Does what Python asks for: begin, look, took or end.</summary>
        /// <returns>The answer, or null: that to end comes after the last picture.</returns>
        /// <exception cref="MessageException">It cannot be done.</exception>
        public Message Do(Message request)
        {
            if (request.Kind == "begin") return Begin(request);
            if (request.Kind == "took") film?.Took(request);
            else if (film == null || film.Ending)
                throw new MessageException("not-filmed", $"{Name} is not being filmed: begin a film first");
            else if (request.Kind == "look") film.Look();
            else film.End(request);
            return null;
        }

        /// <summary>The messages to send now: the pictures that are there, and the end after the last one.</summary>
        public IEnumerable<Message> Outgoing()
        {
            for (var message = film?.Next(); message != null; message = film?.Next())
            {
                yield return message;
                // Not before it is sent: a game may end when it is not filmed any more.
                if (message.Kind == "ended") film = null;
            }
        }

        /// <summary>Ends its film without a word: Python is gone.</summary>
        public void Stop() => film = null;

        private Message Begin(Message request)
        {
            double Number(string name)
            {
                var value = request.Values.GetValueOrDefault(name);
                if (value is long || value is double) return Convert.ToDouble(value, CultureInfo.InvariantCulture);
                throw new MessageException("missing-field", $"begin needs a number '{name}'");
            }
            double width = Number("width"), height = Number("height"), fps = Number("fps");
            if (width == 0) width = Width;
            if (height == 0) height = Height;
            if (film != null)
                throw new MessageException("busy-view", $"{Name} is being filmed already: end that film first");
            if (!(width >= 1 && width <= Width && height >= 1 && height <= Height))
                throw new MessageException("bad-size", $"{Name} is at most {Width} x {Height}");
            if (!(fps >= 0 && fps <= 1000))
                throw new MessageException("bad-rate", "fps is at most 1000, and 0 for pictures on demand alone");
            film = new RunningFilm(request.Id, Name, (int)width, (int)height, channels, fps);
            var begun = new Message("begun", request.Id) { Values = { ["view"] = Name } };
            begun.Values["width"] = film.Width;
            begun.Values["height"] = film.Height;
            return begun;
        }
    }
}
