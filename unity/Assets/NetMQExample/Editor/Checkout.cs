// Where the kit lies, with its Python servers: this package may be in it, or have been copied into a game.
using System;
using System.ComponentModel;
using System.Diagnostics;
using System.IO;
using System.Linq;
using System.Runtime.InteropServices;
using System.Text.RegularExpressions;

namespace NetMQExample.Editor
{
    /// <summary>The kit's folder: its lessons, and the Python that runs them.</summary>
    internal sealed class Checkout
    {
        // Both are asked at once: an old Python, and one without pyzmq.
        private const string Question = "import sys, importlib.util as found; sys.exit(3 if sys.version_info < (3, 11) "
            + "else 0 if found.find_spec('zmq') else 4)";

        private Checkout(string root) => Root = root;

        public string Root { get; }

        /// <summary>The lessons that have a server, such as 01_request_reply.</summary>
        public string[] Lessons => Directory.GetDirectories(Path.Combine(Root, "python"))
            .Where(folder => File.Exists(Path.Combine(folder, "server.py")))
            .Select(Path.GetFileName).OrderBy(key => key, StringComparer.Ordinal).ToArray();

        /// <summary>The first of these folders that is the kit, or lies in it; null if none does.</summary>
        public static Checkout Find(params string[] folders)
        {
            foreach (var start in folders.Where(folder => !string.IsNullOrEmpty(folder)))
                for (var folder = new DirectoryInfo(start); folder != null; folder = folder.Parent)
                    if (File.Exists(Path.Combine(folder.FullName, "kit.py"))
                        && Directory.Exists(Path.Combine(folder.FullName, "python"))
                        && new Checkout(folder.FullName).Lessons.Length > 0) return new Checkout(folder.FullName);
            return null;
        }

        /// <summary>The server.py of a lesson, such as 01_request_reply.</summary>
        public string Server(string key) => Path.Combine(Root, "python", key, "server.py");

        /// <summary>Where a lesson's programs run, so that what they leave behind lies in one place.</summary>
        public string Folder(string key) =>
            Directory.CreateDirectory(Path.Combine(Root, ".build", "run", key.Substring(0, 2))).FullName;

        /// <summary>The Python for the servers: that of .venv, or the first one on the PATH that has pyzmq. Where
        /// something is missing, <paramref name="trouble"/> has cause and cure; null: there is none.</summary>
        public string Python(out string trouble)
        {
            // In this order kit.py makes them, macOS and Linux call theirs, and Windows has them.
            var known = new[] { ".venv/bin/python", ".venv/Scripts/python.exe" }
                .Select(path => Path.Combine(Root, path)).Where(File.Exists);
            // An editor that was started from macOS' Dock has not the PATH of a terminal: there python.org and Homebrew
            // put theirs.
            var beside = RuntimeInformation.IsOSPlatform(OSPlatform.OSX)
                ? new[] { "/usr/local/bin/python3", "/opt/homebrew/bin/python3" }.Where(File.Exists) : new string[0];
            var names = known.Concat(beside).Concat(new[] { "python3", "python", "py" });
            string bare = null;
            trouble = "";
            // One after the other: a macOS without developer tools asks to install them when it is asked for python3.
            foreach (var name in names)
            {
                var code = Ask(name);
                if (code == 0) return name;
                if (code == 4) bare ??= name;
            }
            trouble = bare != null
                ? $"{bare} has no pyzmq: run the pip line in a terminal; or kit.py run 1, once, which makes a .venv"
                : "no Python 3.11 or later was found: install one from python.org, and restart Unity Hub";
            return bare;
        }

        /// <summary>The command that installs a lesson's packages, for a terminal.</summary>
        public string PipLine(string python, string key)
        {
            // All lessons need kit, and this one the extra of its name, as body for a webcam: see pyproject.toml.
            var project = File.ReadAllText(Path.Combine(Root, "pyproject.toml"));
            var own = key.Split('_').Where(word => Regex.IsMatch(project, $"^{word} = \\[", RegexOptions.Multiline));
            var extras = string.Join(",", new[] { "camera", "envs", "web" }.Union(own));
            // PowerShell takes what is in quotation marks for a text, and no command.
            var command = python.Contains(" ") ? $"\"{python}\"" : python;
            return $"{command} -m pip install \"{Root}[{extras}]\"";
        }

        private static int Ask(string python)
        {
            try
            {
                var start = new ProcessStartInfo(python, $"-c \"{Question}\"") { UseShellExecute = false };
                start.CreateNoWindow = true;
                using var process = Process.Start(start);
                if (process.WaitForExit(10_000)) return process.ExitCode;
                process.Kill();
            }
            catch (Win32Exception) { /* There is none of this name. */ }
            return -1;
        }
    }
}
