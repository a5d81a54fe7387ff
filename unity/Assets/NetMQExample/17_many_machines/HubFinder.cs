// Lesson 17, the hub is found: it tells its network once a second where it is. In Python: `find` in beacon.py.
//
//     HubFinder.Find(5567, "", TimeSpan.FromSeconds(30))        tcp://192.168.0.7:5567, or TimeoutException
//
// Bytes: a UDP datagram, `NMQX1 PORT FINGERPRINT` in ASCII; the address is the sender's. The fingerprint is the
// beginning of the SHA-256 of the hub's public key, or `-` without keys. Anybody can send such a datagram: so a
// simulator that has the hub's key passes over all others, and one without keys trusts its network.
using System;
using System.Diagnostics;
using System.Globalization;
using System.Linq;
using System.Net;
using System.Net.Sockets;
using System.Security.Cryptography;
using System.Text;
using System.Text.RegularExpressions;
using System.Threading;

namespace NetMQExample
{
    /// <summary>Listens for a hub. Not for Unity's main thread: it waits.</summary>
    public static class HubFinder
    {
        /// <summary>Listens until a hub is heard that has this key.</summary>
        /// <param name="port">The UDP port that the hub tells it on.</param>
        /// <param name="serverKey">The hub's public key; empty without keys.</param>
        /// <param name="timeout">How long to listen.</param>
        /// <param name="stop">Ends the wait early.</param>
        /// <returns>The hub's endpoint.</returns>
        /// <exception cref="TimeoutException">None was heard; the message says what to try.</exception>
        /// <exception cref="GaveUpException">The port is another program's.</exception>
        public static string Find(int port, string serverKey, TimeSpan timeout, CancellationToken stop = default)
        {
            Require.Seconds("timeout", timeout);
            var waited = Stopwatch.StartNew();
            var own = Fingerprint(Require.Given("serverKey", serverKey));
            var why = "; is the hub started with --announce, on this network?";
            using var ear = new Socket(AddressFamily.InterNetwork, SocketType.Dgram, ProtocolType.Udp);
            // Several simulators of one machine listen on the same port.
            ear.SetSocketOption(SocketOptionLevel.Socket, SocketOptionName.ReuseAddress, true);
            try { ear.Bind(new IPEndPoint(IPAddress.Any, port)); }
            catch (SocketException e)
            {
                throw new GaveUpException($"cannot listen on UDP port {port}: {e.Message}; give --endpoint instead");
            }
            var datagram = new byte[65_536];
            EndPoint sender = new IPEndPoint(IPAddress.Any, 0);
            while (waited.Elapsed < timeout)
            {
                stop.ThrowIfCancellationRequested();
                if (!ear.Poll(20_000, SelectMode.SelectRead)) continue;
                var length = ear.ReceiveFrom(datagram, ref sender);
                var told = Regex.Match(
                    Encoding.ASCII.GetString(datagram, 0, length), "^NMQX1 ([0-9]{1,5}) ([0-9a-f]{16}|-)$");
                var address = ((IPEndPoint)sender).Address;
                var place = told.Success ? int.Parse(told.Groups[1].Value, CultureInfo.InvariantCulture) : 0;
                if (place > 0 && place < 65536 && told.Groups[2].Value == own) return $"tcp://{address}:{place}";
                if (told.Success && told.Groups[2].Value != own)
                    why = own == "-" ? $", only one that has keys, {address}; give its keys"
                        : $", only of another key, {address}; have both sides the same server.key?";
            }
            throw new TimeoutException(FormattableString.Invariant(
                $"no hub was heard on UDP port {port} within {timeout.TotalSeconds} s{why}"));
        }

        private static string Fingerprint(string key)
        {
            if (key == "") return "-";
            using var sha = SHA256.Create();
            return string.Concat(sha.ComputeHash(Encoding.ASCII.GetBytes(key)).Take(8).Select(b => $"{b:x2}"));
        }
    }
}
