// A socket as every client of this kit uses it: with a checked endpoint, limits, and waits that can be ended.
//
//     using var connection = new NetMQConnection("tcp://127.0.0.1:5551", () => new RequestSocket());
//     if (!connection.TrySend(timeout, stop, "Hello") || !connection.TryReceive(timeout, stop, out var frames))
//         throw connection.NoReply(timeout);
using System;
using System.Collections;
using System.Collections.Concurrent;
using System.Collections.Generic;
using System.Diagnostics;
using System.IO;
using System.Linq;
using System.Net;
using System.Text;
using System.Text.RegularExpressions;
using System.Threading;
using System.Threading.Tasks;
using NetMQ;

namespace NetMQExample
{
    /// <summary>One socket at a time, on one connection. Make it, use it and dispose it on one thread, and not on
    /// Unity's main thread: to send and to receive is to wait.</summary>
    public sealed class NetMQConnection : IDisposable
    {
        // The address that each endpoint had when a socket was connected to it.
        private static readonly ConcurrentDictionary<string, string> Known = new ConcurrentDictionary<string, string>();

        private static readonly Encoding Strict = new UTF8Encoding(false, throwOnInvalidBytes: true);

        private readonly NetMQLifetime lifetime = new NetMQLifetime();
        private readonly string endpoint;
        private readonly Func<NetMQSocket> make;
        private readonly long maxBytes;
        private readonly BeaconSearch search;
        private NetMQSocket socket;
        private Task<IPAddress[]> lookUp;
        private volatile bool disposed;
        // The address that the socket is connected to, or null.
        private string where;

        /// <summary>Connects, which succeeds even while no server is there: ZeroMQ goes on trying.</summary>
        /// <param name="endpoint">The server, such as <c>tcp://127.0.0.1:5551</c>, or <c>beacon://lab:5551</c>, which
        /// is looked for with each new socket.</param>
        /// <param name="make">Makes a socket, with the options that only this client needs.</param>
        /// <param name="maxBytes">The longest frame to accept. A peer that announces more is disconnected before it is
        /// in memory.</param>
        /// <exception cref="ArgumentException">The endpoint cannot work; the message names cause and cure.</exception>
        public NetMQConnection(string endpoint, Func<NetMQSocket> make, long maxBytes = 65536)
        {
            this.endpoint = endpoint;
            this.maxBytes = maxBytes;
            try
            {
                Host(endpoint);
                if (BeaconSearch.Has(endpoint)) search = new BeaconSearch(endpoint);
                this.make = make ?? throw new ArgumentNullException(null, "make must not be null");
                Open();
            }
            catch
            {
                Dispose();
                throw;
            }
        }

        /// <summary>Each message as it was sent (true) or received, on the thread that did it: for a window of the
        /// editor. In a build nothing comes.</summary>
        public static event Action<string, bool, IEnumerable> Seen;

        /// <summary>Whether somebody looks: otherwise nothing needs to be made to be shown.</summary>
        internal static bool Watched => Seen != null;

        /// <summary>How long one wait lasts: short enough that ten clients stop at once, one after the other, and long
        /// enough to cost nothing.</summary>
        public static TimeSpan Slice { get; } = TimeSpan.FromMilliseconds(10);

        /// <summary>How long to wait after so many tries in vain: each time twice as long, up to 8 times the first. A
        /// new connection takes several round trips. On a slow line only a longer wait ever succeeds.</summary>
        public static TimeSpan Longer(TimeSpan first, int tries) => first * (1 << Math.Min(tries, 3));

        /// <summary>Sets up every socket of this kit before it connects, such as with lesson 15's keys:
        /// <c>NetMQConnection.Prepare = new ClientKeys("keys").Apply</c>, before the first client.</summary>
        public static Action<NetMQSocket> Prepare { get; set; }

        /// <summary>The socket; after <see cref="Close()"/> a new one.</summary>
        /// <exception cref="ObjectDisposedException">After Dispose: a new one would never be closed.</exception>
        public NetMQSocket Socket => !disposed ? Open() : throw Disposed(endpoint);

        /// <summary>Whether it is not known where the server is. Until then the socket sends nothing.</summary>
        public bool Searching => search != null && where == null;

        /// <summary>Whether its server was asked for by name, and has not answered yet.</summary>
        public bool Unanswered => search != null && search.Unanswered;

        /// <summary>Names what is wrong with an endpoint, where NetMQ itself reports in riddles.</summary>
        /// <param name="endpoint">Transport, host and port, such as <c>tcp://127.0.0.1:5551</c>.</param>
        /// <exception cref="ArgumentException">The endpoint cannot work; the message names cause and cure.</exception>
        /// <exception cref="TimeoutException">The host's address could not be found out within 5 s.</exception>
        public static void Check(string endpoint) => Reach(null, endpoint);

        /// <summary>Connects a socket within the limits of this kit.</summary>
        /// <param name="socket">One that was made just now.</param>
        /// <param name="endpoint">The server, such as <c>tcp://127.0.0.1:5551</c>.</param>
        /// <param name="maxBytes">The longest frame to accept. A peer that announces more is disconnected before it is
        /// in memory.</param>
        /// <exception cref="ArgumentException">The endpoint cannot work; the message names cause and cure.</exception>
        public static void Connect(NetMQSocket socket, string endpoint, long maxBytes = 65536)
        {
            // Messages under way are dropped when the socket is closed; waiting for their delivery could take for ever.
            socket.Options.Linger = TimeSpan.Zero;
            socket.Options.MaxMsgSize = maxBytes;
            // At most 64 MB, or 64 messages, wait to be read. NetMQ itself counts only messages, up to 1000. Of few it
            // tells its other thread about nearly each frame that was read, which takes longer than a small message.
            if (maxBytes > 65536) socket.Options.ReceiveHighWatermark = (int)Math.Max(64, (64 << 20) / maxBytes);
            Prepare?.Invoke(socket);
            Reach(socket, endpoint);
        }

        /// <summary>A frame's text. A message's is that of all its frames, with a blank between them.</summary>
        /// <returns>The text; of a frame that is no UTF-8 how long it is, in brackets.</returns>
        public static string Text(byte[] frame)
        {
            try { return Strict.GetString(frame); }
            catch (DecoderFallbackException) { return $"({frame.Length} bytes)"; }
        }

        /// <summary>Closes a socket, with what it has not sent yet.</summary>
        public static void Close(NetMQSocket socket)
        {
            try { socket?.Dispose(); }
            catch (Exception) { /* Somebody called NetMQConfig.Cleanup, and the socket went with it. */ }
        }

        /// <summary>Makes the exception for when nothing came, or there was nowhere to send to.</summary>
        public static TimeoutException NoReply(string endpoint, TimeSpan timeout,
            string cure = "is the server running, or its reply over 64 KB?") => new TimeoutException(
            FormattableString.Invariant($"no reply from {endpoint} within {timeout.TotalSeconds} s; {cure}"));

        public TimeoutException NoReply(TimeSpan timeout) =>
            NoReply(endpoint, timeout, Cure($"is the server running, or its reply over {maxBytes >> 10} KB?"));

        /// <summary>The cure where nothing came: the network, as long as a beacon has not answered.</summary>
        public string Cure(string otherwise) => search?.Cure(otherwise) ?? otherwise;

        public static string Tries(int tries) => tries == 1 ? "1 try" : $"{tries} tries";

        /// <summary>Makes the exception for calls after Dispose.</summary>
        public static ObjectDisposedException Disposed(string endpoint) =>
            new ObjectDisposedException(null, $"what was connected to {endpoint} is disposed; make a new one");

        /// <summary>The time to wait, cut into slices; between two of them <paramref name="stop"/> is heard.</summary>
        /// <param name="timeout">How long to wait; zero gives one slice, of zero.</param>
        /// <returns>Timeouts to give to a method of NetMQ's until it succeeds.</returns>
        /// <exception cref="ArgumentException">The timeout is negative.</exception>
        /// <exception cref="OperationCanceledException"><paramref name="stop"/> was cancelled.</exception>
        public static IEnumerable<TimeSpan> Slices(TimeSpan timeout, CancellationToken stop)
        {
            for (var wait = new Wait(timeout, stop); wait.Next(out var slice);) yield return slice;
        }

        /// <summary>Shows a message to whoever looks. The compiler leaves out the calls, with all that is made for
        /// them, where it does not compile for the editor.</summary>
        /// <param name="sent">Or received.</param>
        /// <param name="frames">Texts, bytes, or what NetMQ has them in.</param>
        [Conditional("UNITY_EDITOR")]
        public static void Show(string endpoint, bool sent, IEnumerable frames) => Seen?.Invoke(endpoint, sent, frames);

        [Conditional("UNITY_EDITOR")]
        public void Show(bool sent, IEnumerable frames) => Show(endpoint, sent, frames);

        /// <summary>Sends a message, and waits when there is no connection to send on.</summary>
        /// <param name="stop">Ends the wait early, within 50 ms of being cancelled.</param>
        /// <param name="frames">Its frames, sent as UTF-8.</param>
        /// <returns>False if it was not sent.</returns>
        public bool TrySend(TimeSpan timeout, CancellationToken stop, params string[] frames)
        {
            var message = new NetMQMessage();
            // Without the encoding, NetMQ makes a question mark of every character that is not ASCII.
            foreach (var frame in frames) message.Append(frame, Encoding.UTF8);
            foreach (var slice in Slices(timeout, stop))
            {
                if (!Socket.TrySendMultipartMessage(slice, message)) continue;
                Show(true, frames);
                return true;
            }
            return false;
        }

        /// <summary>Waits for a message.</summary>
        /// <param name="stop">Ends the wait early, within 50 ms of being cancelled.</param>
        /// <param name="frames">Its frames, as text. However many there are, they are one message.</param>
        /// <returns>False if none came.</returns>
        public bool TryReceive(TimeSpan timeout, CancellationToken stop, out List<string> frames)
        {
            List<byte[]> received = null;
            frames = null;
            foreach (var slice in Slices(timeout, stop))
            {
                if (!Socket.TryReceiveMultipartBytes(slice, ref received)) continue;
                Show(false, received);
                frames = received.ConvertAll(Text);
                return true;
            }
            return false;
        }

        public void Close()
        {
            Close(socket);
            socket = null;
            where = null;
        }

        /// <summary>Looks up the server's name, and closes the socket if that has another address by now. It never
        /// waits: while nothing comes, call it until it returns true, and some seconds later again.</summary>
        /// <returns>True once the look-up is over.</returns>
        public bool Follow()
        {
            if (search != null)
            {
                var now = search.Poll();
                if (now != null && now != where) Close();
                return now != null;
            }
            // NetMQ looks a name up once for each socket. A publisher that is only slow keeps its connection.
            lookUp ??= Dns.GetHostAddressesAsync(Host(endpoint));
            if (!lookUp.IsCompleted) return false;
            // A name that is unknown for a moment has not moved yet.
            if (socket != null && lookUp.Status == TaskStatus.RanToCompletion)
            {
                var old = IPAddress.Parse(new Uri(socket.Options.LastEndpoint).Host);
                var now = lookUp.Result.Where(address => address.AddressFamily == old.AddressFamily).ToList();
                if (now.Count > 0 && !now.Contains(old)) Close();
            }
            lookUp = null;
            return true;
        }

        public void Dispose()
        {
            disposed = true;
            Close();
            search?.Dispose();
            lifetime.Dispose();
        }

        private NetMQSocket Open()
        {
            socket ??= make();
            if (where != null) return socket;
            where = search == null ? endpoint : search.Poll();
            if (where != null) Connect(socket, where, maxBytes);
            return socket;
        }

        // The endpoint's host, without asking a name server: this never waits.
        internal static string Host(string endpoint)
        {
            // Colons in the host would be IPv6, which libzmq and NetMQ leave off.
            // NetMQ's own words for a missing tcp:// are "ArgumentOutOfRangeException: length ('-1')".
            var parts = Regex.Match(endpoint ?? "", @"^tcp://([^\s:\[\]]+):(\d+)$");
            if (BeaconSearch.Has(endpoint)) parts = Regex.Match(endpoint, "//(.+):(.+)$");
            if (!ushort.TryParse(parts.Groups[2].Value, out var port) || port == 0) throw Bad(endpoint, "");
            return parts.Groups[1].Value;
        }

        private static ArgumentException Bad(string endpoint, string why) => new ArgumentException(
            $"bad endpoint '{endpoint}': {why}write it like tcp://127.0.0.1:PORT, PORT from 1 to 65535");

        private static void Reach(NetMQSocket socket, string endpoint)
        {
            var host = Host(endpoint);
            if (BeaconSearch.Has(endpoint) && socket == null) return;
            if (BeaconSearch.Has(endpoint)) throw Bad(endpoint, "this client looks for no beacon; ");
            try
            {
                // An address such as 127.0.0.1 needs no name server, nor the thread that a look-up takes.
                if (!IPAddress.TryParse(host, out _)) LookUp(host);
                if (socket == null) return;
                socket.Connect(endpoint);
                Known[endpoint] = socket.Options.LastEndpoint;
            }
            // A library that is missing, or of another version, is no unknown host.
            catch (Exception e) when (!(e is IOException || e is TypeLoadException))
            {
                // A name that was known goes on meaning what it meant while no name server knows it.
                if (socket != null && Known.TryGetValue(endpoint, out var last)) socket.Connect(last);
                else throw e is TimeoutException ? e : Bad(endpoint, $"unknown host '{host}'; check its spelling, or ");
            }
        }

        // The system may ask a name server that is silent for half a minute, and cannot be told to stop.
        private static void LookUp(string host)
        {
            var lookUp = Dns.BeginGetHostAddresses(host, null, null);
            if (!lookUp.AsyncWaitHandle.WaitOne(TimeSpan.FromSeconds(5)))
                throw new TimeoutException(
                    $"no address for host '{host}' within 5 s; is the network there? Or write its number");
            Dns.EndGetHostAddresses(lookUp);
        }
    }
}
