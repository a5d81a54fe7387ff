// The beacon: a client asks its network for a server by name, and the server answers. In Python: beacon.py, which says
// what the bytes are.
//
//     beacon://lab:5553        in an Endpoint field, for a server with --beacon lab
//
// It asks this machine and, by broadcast, each of its networks; then also each of the 254 addresses around one's own,
// since iOS sends no broadcast without an entitlement of Apple's. An answer comes to this device alone, so Android
// needs no multicast lock.
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
        private readonly Stopwatch asked = new Stopwatch();
        // More than any answer. A longer datagram is cut off, or refused.
        private readonly byte[] heard = new byte[100];
        private readonly string name, answer;
        private readonly byte[] question;
        private readonly int port;
        // The hosts that were asked, and those that are still to be.
        private readonly HashSet<string> reached = new HashSet<string>();
        private List<string> unasked = new List<string>();
        private string[] broadcasts = new string[0];
        private Socket ear;
        private int vain;

        /// <summary>It does not ask yet.</summary>
        /// <param name="endpoint">One with a name: see <see cref="Has"/>.</param>
        public BeaconSearch(string endpoint)
        {
            var parts = endpoint.Split('/', ':');
            name = parts[3];
            port = int.Parse(parts[4]);
            question = Encoding.ASCII.GetBytes($"NMQX2 {name}?");
            answer = $"NMQX2 {name}!";
        }

        /// <summary>Whether an endpoint has a server's name in place of its address.</summary>
        public static bool Has(string endpoint) =>
            Regex.IsMatch(endpoint ?? "", "^beacon://[A-Za-z0-9._-]{1,32}:[0-9]{1,5}$");

        /// <summary>Asks now and then, and takes an answer that is there: call it again and again.</summary>
        /// <returns>Such as tcp://192.168.0.7:5553, or null: there is none yet.</returns>
        public string Poll()
        {
            if (ear == null || asked.Elapsed >= Round) BeginQuestion();
            Ask();
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

        /// <summary>The cure where nothing came: the network, as long as nobody has answered.</summary>
        public string Cure(string otherwise)
        {
            if (vain == 0) return otherwise;
            var networks = broadcasts.Where(reached.Contains).ToList();
            return $"asked {string.Join(", ", networks.DefaultIfEmpty("no network"))} and "
                + $"{reached.Count - networks.Count} single addresses: is a server with --beacon {name} in "
                + "this network, and that no guest network, does its firewall "
                + $"let in UDP and TCP port {port}, and may this program use the local network?";
        }

        /// <summary>The next look begins anew.</summary>
        public void Dispose()
        {
            ear?.Dispose();
            ear = null;
            vain = 0;
            unasked.Clear();
            reached.Clear();
        }

        private void BeginQuestion()
        {
            ear ??= new Socket(AddressFamily.InterNetwork, SocketType.Dgram, ProtocolType.Udp);
            ear.EnableBroadcast = true;
            ear.Blocking = false;
            var here = Networks();
            broadcasts = here.Select(each => Broadcast(each.Key, each.Value)).Prepend("255.255.255.255").Distinct()
                .ToArray();
            var around = here.Keys.Select(address => Regex.Replace(address, @"\d+$", "")).Distinct().Take(MostNetworks)
                .SelectMany(network => Enumerable.Range(1, vain > 0 ? 254 : 0).Select(last => $"{network}{last}"));
            // Those that the last question did not reach come before the others.
            unasked = broadcasts.Prepend("127.0.0.1").Concat(unasked).Concat(around).Distinct().ToList();
            vain++;
            asked.Restart();
        }

        private void Ask()
        {
            var done = 0;
            // Where the system has no room for more, it takes them a moment later.
            for (; done < unasked.Count && ear.Poll(0, SelectMode.SelectWrite); done++)
            {
                try
                {
                    ear.SendTo(question, new IPEndPoint(IPAddress.Parse(unasked[done]), port));
                    reached.Add(unasked[done]);
                }
                catch (SocketException) { /* Where one of them cannot be asked, others can. */ }
            }
            unasked.RemoveRange(0, done);
        }

        // Of an address's network. Where its mask is not known: a plain cable is a /16, and most others are a /24.
        private static string Broadcast(string address, IPAddress mask)
        {
            if (mask == null || mask.Equals(IPAddress.Any))
                mask = IPAddress.Parse(Regex.IsMatch(address, @"^169\.254\.") ? "255.255.0.0" : "255.255.255.0");
            var mine = IPAddress.Parse(address).GetAddressBytes();
            return $"{new IPAddress(mine.Zip(mask.GetAddressBytes(), (own, kept) => (byte)(own | ~kept)).ToArray())}";
        }

        // The addresses of this machine, with their masks where the system tells. The way out comes first.
        private static Dictionary<string, IPAddress> Networks()
        {
            var found = new Dictionary<string, IPAddress>();
            using (var probe = new Socket(AddressFamily.InterNetwork, SocketType.Dgram, ProtocolType.Udp))
            {
                // This sends nothing: it is the system's choice of one's own address that counts.
                try
                {
                    probe.Connect("198.51.100.1", 9);
                    found[$"{((IPEndPoint)probe.LocalEndPoint).Address}"] = null;
                }
                catch (SocketException) { /* There is no router: each device has to be asked. */ }
            }
            try
            {
                foreach (var each in NetworkInterface.GetAllNetworkInterfaces()
                    .SelectMany(device => device.GetIPProperties().UnicastAddresses)
                    .Where(each => each.Address.AddressFamily == AddressFamily.InterNetwork
                        && !IPAddress.IsLoopback(each.Address)))
                    found[$"{each.Address}"] = each.IPv4Mask;
            }
            // Not every phone lets an app ask.
            catch (Exception e) when (e is NetworkInformationException || e is NotSupportedException
                || e is NotImplementedException)
            {
            }
            return found;
        }
    }
}
