// How the sections write their lines, and the waits they share.
using System;
using System.Collections.Generic;
using System.Diagnostics;
using System.Globalization;
using System.Linq;
using System.Threading;
using NetMQ;

namespace NetMQExample.Conformance
{
    internal static class Say
    {
        /// <summary>More than anything here takes, also on a busy machine.</summary>
        internal static readonly TimeSpan Timeout = TimeSpan.FromSeconds(20);

        /// <summary>How long to look for something that must not come.</summary>
        internal static readonly TimeSpan Moment = TimeSpan.FromMilliseconds(200);

        internal static void That(string what, params object?[] values)
            => Console.WriteLine($"{what}: {string.Join(" ", values.Select(Text))}");

        /// <summary>The type of what is thrown.</summary>
        internal static void Throws(string what, Action action)
            => That(what, Thrown(action)?.GetType().Name ?? "nothing thrown");

        /// <summary>
        /// The type and the text, where people search for the text. What .NET adds to it differs by version.
        /// </summary>
        internal static void ThrowsText(string what, Action action)
        {
            var thrown = Thrown(action);
            That(what, thrown == null ? "nothing thrown"
                : $"{thrown.GetType().Name}: {thrown.Message.Split('\r', '\n')[0].Replace(Parameter(thrown), "")}");
        }

        private static string Parameter(Exception thrown)
            => $" (Parameter '{(thrown as ArgumentException)?.ParamName}')";

        internal static Exception? Thrown(Action action)
        {
            try
            {
                action();
                return null;
            }
            catch (Exception e)
            {
                return e;
            }
        }

        /// <summary>True as soon as something is so; false if it does not come to be.</summary>
        internal static bool Soon(Func<bool> condition)
        {
            var clock = Stopwatch.StartNew();
            while (clock.Elapsed < Timeout)
            {
                if (condition()) return true;
                Thread.Sleep(5);
            }
            return false;
        }

        /// <summary>What is received next, with all its frames.</summary>
        internal static string Received(IReceivingSocket socket)
        {
            NetMQMessage? message = null;
            if (!socket.TryReceiveMultipartMessage(Timeout, ref message)) return "nothing came";
            return string.Join("|",
                message.Select(frame => frame.ConvertToString(SendReceiveConstants.DefaultEncoding)));
        }

        /// <summary>True if nothing is received for a moment.</summary>
        internal static bool Silent(IReceivingSocket socket) => !socket.TryReceiveFrameBytes(Moment, out _);

        /// <summary>A loopback address that was free just now.</summary>
        internal static string FreeAddress()
        {
            var listener = new System.Net.Sockets.TcpListener(System.Net.IPAddress.Loopback, 0);
            listener.Start();
            var address = "tcp://" + listener.LocalEndpoint;
            listener.Stop();
            return address;
        }

        private static string Text(object? value) => value switch
        {
            null => "null",
            string text => text,
            byte[] bytes => BitConverter.ToString(bytes),
            TimeSpan time => time.TotalMilliseconds.ToString(CultureInfo.InvariantCulture) + " ms",
            IEnumerable<string> many => string.Join("|", many),
            _ => Convert.ToString(value, CultureInfo.InvariantCulture) ?? "",
        };
    }
}
