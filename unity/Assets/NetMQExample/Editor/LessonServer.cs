// A Python program beside the editor. It outlives a reload of recompiled scripts, which forgets all objects and closes
// all pipes: hence it writes to a file, and what is to be remembered is one line of text.
using System;
using System.ComponentModel;
using System.Diagnostics;
using System.Globalization;
using System.IO;
using System.Threading;

namespace NetMQExample.Editor
{
    /// <summary>One run of a server, or of kit.py.</summary>
    internal sealed class LessonServer
    {
        // So many characters of the end are shown: a text field of the editor's takes no more than 65,535 vertices.
        private const int ShownBytes = 8000;
        private static readonly TimeSpan Timeout = TimeSpan.FromSeconds(2);

        // Redirects the output as a shell's > does on every system, in the same process: the one whose number is known.
        // A program with windows has no output to hand on in Windows, and then Python none that it could print to.
        private const string Redirect = "import os, runpy, sys; "
            + "out = open(sys.argv[1], 'ab'); os.dup2(out.fileno(), 1); os.dup2(out.fileno(), 2); "
            + "sys.stdout, sys.stderr = (open(n, 'w', 1, 'utf-8', 'replace') for n in (1, 2)); "
            + "sys.argv[:] = sys.argv[2:]; sys.path.insert(0, os.path.dirname(sys.argv[0])); "
            + "runpy.run_path(sys.argv[0], run_name='__main__')";

        private readonly Process process;
        private readonly string log;

        private LessonServer(Process process, string log) => (this.process, this.log) = (process, log);

        public bool Running => process != null && !process.HasExited;

        /// <summary>The end of what it has printed.</summary>
        public string Lines
        {
            get
            {
                try
                {
                    const FileShare others = FileShare.ReadWrite | FileShare.Delete;
                    using var file = new FileStream(log, FileMode.Open, FileAccess.Read, others);
                    file.Position = Math.Max(0, file.Length - ShownBytes);
                    using var reader = new StreamReader(file);
                    return reader.ReadToEnd();
                }
                catch (Exception e) when (e is IOException || e is UnauthorizedAccessException) { return ""; }
            }
        }

        /// <summary>Starts a program, with options as one would type them, in this folder. The log is the whole path of
        /// the file for its lines. If it ends at once, the reason is among them.</summary>
        public static LessonServer Start(string python, string script, string options, string folder, string log)
        {
            Directory.CreateDirectory(Path.GetDirectoryName(log));
            File.Delete(log);
            var start = new ProcessStartInfo(python, $"-u -c \"{Redirect}\" \"{log}\" \"{script}\" {options}")
            {
                UseShellExecute = false,
                CreateNoWindow = true,
                WorkingDirectory = folder,
            };
            // Not the code page of a Windows console.
            start.EnvironmentVariables["PYTHONUTF8"] = "1";
            var process = Process.Start(start);
            File.WriteAllText(Note(log), FormattableString.Invariant($"{process.Id} {Born(process)}"));
            return new LessonServer(process, log);
        }

        /// <summary>Finds it again, running or ended, after a reload of the scripts or an end of the editor that nobody
        /// wanted; null if none was started with this log.</summary>
        public static LessonServer Find(string log)
        {
            if (!File.Exists(log)) return null;
            try
            {
                var parts = File.ReadAllText(Note(log)).Split(' ');
                var process = Process.GetProcessById(int.Parse(parts[0], CultureInfo.InvariantCulture));
                // Once it has ended, its number may be another one's. Systems know the time of birth to the second.
                var apart = Born(process) - long.Parse(parts[parts.Length - 1], CultureInfo.InvariantCulture);
                if (Born(process) > 0 && Math.Abs(apart) < Timeout.Ticks) return new LessonServer(process, log);
            }
            catch (Exception e) when (e is IOException || e is UnauthorizedAccessException || e is FormatException
                || e is OverflowException || e is ArgumentException || e is InvalidOperationException
                || e is Win32Exception)
            {
                // There is no note, or no process has this number.
            }
            return new LessonServer(null, log);
        }

        /// <summary>Ends it: where the system can ask, it is asked, and closes what it writes; else at once.</summary>
        public void Stop()
        {
            try { End(); }
            catch (Exception e) when (e is InvalidOperationException || e is Win32Exception)
            {
                // It has ended by itself meanwhile.
            }
        }

        private void End()
        {
            if (!Running) return;
            // The shell's own kill, which says SIGTERM. One that has just ended by itself is no news.
            var command = $"-c \"kill {process.Id} 2>/dev/null\"";
            if (Path.DirectorySeparatorChar == '/') Process.Start("/bin/sh", command)?.Dispose();
            else process.Kill();
            if (Ended()) return;
            process.Kill();
            Ended();
        }

        // Mono's WaitForExit does not wait for what another editor has started.
        private bool Ended()
        {
            for (var waited = Stopwatch.StartNew(); Running && waited.Elapsed < Timeout;) Thread.Sleep(20);
            return !Running;
        }

        private static string Note(string log) => $"{log}.pid";

        private static long Born(Process process)
        {
            try { return process.StartTime.ToUniversalTime().Ticks; }
            catch (Exception e) when (e is InvalidOperationException || e is Win32Exception) { return 0; }
        }
    }
}
