// Reads addresses as NetMQ does, with its exceptions, before libzmq sees them.
using System;
using System.Globalization;
using System.Linq;
using System.Net;
using System.Net.Sockets;

namespace NetMQ
{
    internal static class Endpoint
    {
        /// <summary>
        /// Splits at "://". NetMQ does not ask whether it is there, hence the ArgumentOutOfRangeException that people
        /// see for an address without a protocol.
        /// </summary>
        internal static void Split(string address, out string protocol, out string rest)
        {
            var at = address.IndexOf("://", StringComparison.Ordinal);
            protocol = address.Substring(0, at);
            rest = address.Substring(at + 3);
        }

        internal static void CheckProtocol(string protocol, ZmqSocketType type)
        {
            if (protocol == "tcp" || protocol == "inproc" || protocol == "ipc") return;
            throw protocol == "pgm" || protocol == "epgm"
                ? new ProtocolNotSupportedException("Multicast protocols are not supported by socket type: " + type)
                : new ProtocolNotSupportedException("Invalid protocol: " + protocol);
        }

        /// <summary>"host:port" as numbers. Names are looked up here, so that an unknown one fails at once.</summary>
        internal static string ResolveTcp(string rest, bool ipv4Only)
        {
            var colon = rest.LastIndexOf(':');
            if (colon < 0) throw new InvalidException($"TcpAddress.Resolve, delimiter ({colon}) must be non-negative.");
            var host = rest.Substring(0, colon);
            if (host.Length >= 2 && host[0] == '[' && host[^1] == ']') host = host[1..^1];
            var portText = rest.Substring(colon + 1);
            var port = portText == "*" ? 0 : Convert.ToInt32(portText, CultureInfo.InvariantCulture);
            if (port == 0 && portText != "*" && portText != "0")
            {
                throw new InvalidException($"TcpAddress.Resolve, port ({portText}) must be a valid nonzero integer.");
            }
            IPAddress? ip;
            if (host == "*")
            {
                ip = ipv4Only ? IPAddress.Any : IPAddress.IPv6Any;
            }
            else if (!IPAddress.TryParse(host, out ip))
            {
                ip = Dns.GetHostEntry(host).AddressList.FirstOrDefault(
                    a => a.AddressFamily == AddressFamily.InterNetwork
                        || (!ipv4Only && a.AddressFamily == AddressFamily.InterNetworkV6))
                    ?? throw new InvalidException($"TcpAddress.Resolve, unable to find an IP address for {rest}");
            }
            // It refuses a port beyond 65535, and puts an IPv6 address in brackets.
            return new IPEndPoint(ip, port).ToString();
        }
    }
}
