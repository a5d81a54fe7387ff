// ML-Agents' shape, the connection: whether Python is there is found out once, and from then on it decides.
//
// A build takes the port from --mlagents-port 5005, as ML-Agents' own, or the endpoint from --endpoint; the editor has
// the port 5004. A ZeroMQ connection is never refused, so a plain one comes first: without Python Play begins at once,
// and ZeroMQ greets whoever comes, so another program, such as ML-Agents' own trainer, is known as soon.
// The main thread itself sends and waits, in each step that has something to tell: another one would cost a tenth of
// the speed. It never waits for a Python that is gone.
using System;
using System.Net;
using System.Net.Sockets;
using UnityEngine;

namespace NetMQExample.MLAgents
{
    /// <summary>Brings what the scene has to tell to Python.</summary>
    internal sealed class SceneConnection : IDisposable
    {
        private const int EditorPort = 5004;
        // Milliseconds: on Windows a refused connection of one's own machine takes two seconds.
        private const int Near = 300, Far = 3000;
        // The first byte that ZeroMQ sends (ZMTP 3.1, section Greeting).
        private const byte Greeting = 0xFF;
        private static readonly TimeSpan Patience = TimeSpan.FromSeconds(30);

        private EnvironmentClient client;
        // Why it has ended, or null.
        private string why;

        private SceneConnection() => Clock.Mistake = Debug.LogException;

        public SceneClock Clock { get; } = new SceneClock();

        /// <summary>Connects, and waits for Python's first reset.</summary>
        /// <returns>Null: there is no Python.</returns>
        public static SceneConnection ToPython()
        {
            var endpoint = Endpoint();
            if (endpoint == null) return null;
            if (!Listens(endpoint, out var other))
            {
                if (other)
                    Debug.LogWarning($"trouble: the program at {endpoint} speaks no ZeroMQ, and Heuristic decides; to "
                        + "train, start python -m netmq_example.mlagents_learn in place of mlagents-learn");
                else
                    Debug.Log(
                        $"no Python at {endpoint}: Heuristic decides; to train, start Python before you press Play");
                return null;
            }
            var made = new SceneConnection();
            if (made.Next(endpoint))
            {
                // Without it Unity stops where another window has the focus, and Python would wait.
                Application.runInBackground = true;
                return made;
            }
            Debug.LogWarning($"trouble: {made.why}; Heuristic decides");
            made.Dispose();
            return null;
        }

        /// <summary>Tells Python what there is to tell, and hears what it says.</summary>
        /// <returns>Whether all begins anew.</returns>
        public bool Exchange()
        {
            if (!Clock.HasRows || why != null) return false;
            if (Next(null)) return Clock.Resets;
            Debug.Log($"Play ends: {why}");
#if UNITY_EDITOR
            UnityEditor.EditorApplication.isPlaying = false;
#endif
            Application.Quit();
            return false;
        }

        public void Dispose() => client?.Dispose();

        // The next request that waits for a step; at first it connects.
        private bool Next(string endpoint)
        {
            try
            {
                if (client == null)
                {
                    client = new EnvironmentClient(endpoint, Patience, Debug.Log) { Once = true };
                    client.Join(Clock);
                }
                if (client.Next(Clock)) return true;
                why = "Python has closed it";
            }
            catch (Exception e) { why = LogText.Why(e); }
            return false;
        }

        private static string Endpoint()
        {
            var words = Environment.GetCommandLineArgs();
            string After(string option) =>
                Array.LastIndexOf(words, option) is int at && at >= 0 && at + 1 < words.Length ? words[at + 1] : null;
            if (After("--mlagents-port") is string port) return $"tcp://127.0.0.1:{port}";
#if UNITY_EDITOR
            return After("--endpoint") ?? $"tcp://127.0.0.1:{EditorPort}";
#else
            return After("--endpoint");
#endif
        }

        // Whether ZeroMQ does, or another program.
        private static bool Listens(string endpoint, out bool other)
        {
            other = false;
            // One that is looked for by a beacon, or is wrong: the connection says so.
            if (!Uri.TryCreate(endpoint, UriKind.Absolute, out var place) || place.Scheme != "tcp") return true;
            try
            {
                var address = Dns.GetHostAddresses(place.Host)[0];
                using var probe = new Socket(address.AddressFamily, SocketType.Stream, ProtocolType.Tcp);
                probe.Blocking = false;
                try { probe.Connect(new IPEndPoint(address, place.Port)); }
                catch (SocketException e) when (e.SocketErrorCode == SocketError.WouldBlock
                    || e.SocketErrorCode == SocketError.InProgress)
                { /* It is on its way. */ }
                // The system's own answer: one of a thread of .NET's comes too late where all cores are busy.
                var wait = 1000 * (IPAddress.IsLoopback(address) ? Near : Far);
                if (!probe.Poll(wait, SelectMode.SelectWrite)
                    || (int)probe.GetSocketOption(SocketOptionLevel.Socket, SocketOptionName.Error) != 0) return false;
                var first = new byte[1];
                other = !probe.Poll(1000 * Far, SelectMode.SelectRead) || probe.Receive(first) == 0
                    || first[0] != Greeting;
                return !other;
            }
            // It is refused, or there is no such host.
            catch (SocketException) { return false; }
        }
    }
}
