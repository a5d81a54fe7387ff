// The beacon: a client asks its network for a server by name, and the server answers. In Python: beacon.py, which says
// what the bytes are.
//
//     beacon://lab:5553        in an Endpoint field, for a server with --beacon lab
//
// It asks this machine and, by broadcast, its networks; then also each of the 254 addresses around one's own, since iOS
// sends no broadcast without an entitlement of Apple's. What answers comes to this device alone, so Android needs no
// multicast lock.
using System;
using System.Collections.Generic;
using System.Diagnostics;
using System.Linq;
using System.Net;
using System.Net.NetworkInformation;
using System.Net.Sockets;
using System.Text;
using System.Text.RegularExpressions;

namespace NetMQExample
{
    /// <summary>Looks for the server of one endpoint. For one thread, which it never keeps waiting.</summary>
    internal sealed class BeaconSearch : IDisposable
    {
        private const int MostNetworks = 4;
        private static readonly TimeSpan Round = TimeSpan.FromMilliseconds(500);
        private static readonly string[] Everybody = { "127.0.0.1", "255.255.255.255" };
        private readonly Stopwatch asked = new Stopwatch();
        // More than any answer. A longer datagram is cut off, or refused.
        private readonly byte[] heard = new byte[100];
        private readonly string name, question, answer;
        private readonly int port;
        private Socket ear;
        private int vain;

        /// <summary>It does not ask yet.</summary>
        /// <param name="endpoint">One with a name: see <see cref="Has"/>.</param>
        public BeaconSearch(string endpoint)
        {
            var parts = endpoint.Split('/', ':');
            name = parts[3];
            port = int.Parse(parts[4]);
            question = $"NMQX2 {name}?";
            answer = $"NMQX2 {name}!";
        }

        /// <summary>Whether an endpoint has a server's name in place of its address.</summary>
        public static bool Has(string endpoint) =>
            Regex.IsMatch(endpoint ?? "", "^beacon://[A-Za-z0-9._-]{1,32}:[0-9]{1,5}$");

        /// <summary>Asks now and then, and takes an answer that is there: call it again and again.</summary>
        /// <returns>Such as tcp://192.168.0.7:5553, or null: there is none yet.</returns>
        public string Look()
        {
            if (ear == null || asked.Elapsed >= Round) Ask();
            // So many: strangers may send more than anybody can read.
            for (var most = 100; most > 0 && ear.Poll(0, SelectMode.SelectRead); most--)
            {
                EndPoint sender = new IPEndPoint(IPAddress.Any, 0);
                var length = 0;
                try { length = ear.ReceiveFrom(heard, ref sender); }
                catch (SocketException) { /* Too long; or Windows reports where nobody was asked. */ }
                var from = (IPEndPoint)sender;
                if (from.Port != port || Encoding.ASCII.GetString(heard, 0, length) != answer) continue;
                Dispose();
                return $"tcp://{from.Address}:{port}";
            }
            return null;
        }

        /// <summary>Whether it has asked, and nobody has answered.</summary>
        public bool Unanswered => vain > 0;

        /// <summary>What to look at where nothing came: the network, as long as nobody has answered.</summary>
        /// <param name="otherwise">What to look at else.</param>
        /// <returns>A question.</returns>
        public string Cure(string otherwise)
        {
            if (vain == 0) return otherwise;
            return $"is a server with --beacon {name} in this network, and that no guest network, does its firewall "
                + $"let in UDP and TCP port {port}, and may this program use the local network?";
        }

        /// <summary>The next look begins anew.</summary>
        public void Dispose()
        {
            ear?.Dispose();
            ear = null;
            vain = 0;
        }

        private void Ask()
        {
            ear ??= new Socket(AddressFamily.InterNetwork, SocketType.Dgram, ProtocolType.Udp);
            ear.EnableBroadcast = true;
            ear.Blocking = false;
            var bytes = Encoding.ASCII.GetBytes(question);
            var numbers = vain > 0 ? Enumerable.Range(1, 255) : new[] { 255 };
            var around = Networks().SelectMany(network => numbers.Select(last => $"{network}.{last}"));
            foreach (var address in Everybody.Concat(around))
            {
                try { ear.SendTo(bytes, new IPEndPoint(IPAddress.Parse(address), port)); }
                catch (SocketException) { /* Where one of them cannot be asked, others can. */ }
            }
            vain++;
            asked.Restart();
        }

        // The networks of this machine, such as 192.168.0: a few, of what may be many.
        private static string[] Networks()
        {
            var found = new List<string>();
            using (var probe = new Socket(AddressFamily.InterNetwork, SocketType.Dgram, ProtocolType.Udp))
            {
                // This sends nothing: it is the system's choice of one's own address that counts.
                try
                {
                    probe.Connect("198.51.100.1", 9);
                    found.Add($"{((IPEndPoint)probe.LocalEndPoint).Address}");
                }
                catch (SocketException) { /* There is no router: each device has to be asked. */ }
            }
            try
            {
                found.AddRange(NetworkInterface.GetAllNetworkInterfaces()
                    .SelectMany(device => device.GetIPProperties().UnicastAddresses)
                    .Where(each => each.Address.AddressFamily == AddressFamily.InterNetwork)
                    .Select(each => $"{each.Address}"));
            }
            // Not every phone lets an app ask.
            catch (Exception e) when (e is NetworkInformationException || e is NotSupportedException) { }
            return found.Where(address => !address.StartsWith("127.", StringComparison.Ordinal))
                .Select(address => Regex.Replace(address, @"\.\d+$", "")).Distinct().Take(MostNetworks).ToArray();
        }
    }
}
