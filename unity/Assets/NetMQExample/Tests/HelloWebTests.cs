// For Window > General > Test Runner, PlayMode: lesson 16 in Unity itself, whose client has a WebSocket and no NetMQ.
using System;
using System.Collections;
using System.Collections.Generic;
using System.IO;
using System.Net;
using System.Net.Sockets;
using System.Security.Cryptography;
using System.Text;
using System.Threading.Tasks;
using NUnit.Framework;
using UnityEngine;
using UnityEngine.Events;
using UnityEngine.TestTools;

namespace NetMQExample.Tests
{
    public class HelloWebTests
    {
        [UnityTest]
        public IEnumerator GetsItsReply()
        {
            var listener = new TcpListener(IPAddress.Loopback, 0);
            listener.Start();
            var gateway = Task.Run(() => Answer(listener));
            var heard = new List<string>();
            var wired = new UnityEvent<string>();
            wired.AddListener(heard.Add);
            var endpoint = $"http://127.0.0.1:{((IPEndPoint)listener.LocalEndpoint).Port}";
            var client = (HelloWeb)Scene.Play(typeof(HelloWeb), null, endpoint, ("count", 1), ("replied", wired));
            client.Replied += heard.Add;
            LogAssert.Expect(LogType.Log, "1: sent Hello, received World");
            LogAssert.Expect(LogType.Log, "done: 1 replies");
            yield return Scene.Until(() => client.Done, "the end");
            Assert.That(heard, Is.EqualTo(new[] { "World", "World" }));
            yield return Scene.End(client);
            gateway.Result.Dispose();
            listener.Stop();
        }

        // A gateway for one request: the handshake of RFC 6455, and one short message each way. It stays connected.
        private static IDisposable Answer(TcpListener listener)
        {
            var stream = new NetworkStream(listener.AcceptSocket(), true) { ReadTimeout = 5000 };
            var head = new StreamReader(stream);
            var key = "";
            for (var line = head.ReadLine(); !string.IsNullOrEmpty(line); line = head.ReadLine())
                if (line.StartsWith("Sec-WebSocket-Key:", StringComparison.OrdinalIgnoreCase))
                    key = line.Substring(18).Trim();
            using var sha = SHA1.Create();
            var accept = Convert.ToBase64String(
                sha.ComputeHash(Encoding.ASCII.GetBytes(key + "258EAFA5-E914-47DA-95CA-C5AB0DC85B11")));
            stream.Write(Encoding.ASCII.GetBytes("HTTP/1.1 101 Switching Protocols\r\nUpgrade: websocket\r\n"
                + $"Connection: Upgrade\r\nSec-WebSocket-Accept: {accept}\r\n\r\n"));
            // A client masks what it says, with the four bytes after the length: ["Hello"].
            var asked = new BinaryReader(stream).ReadBytes(2 + 4 + 9);
            for (var i = 6; i < asked.Length; i++) asked[i] ^= asked[2 + (i - 6) % 4];
            var reply = Encoding.ASCII.GetString(asked, 6, 9) == "[\"Hello\"]" ? "[\"World\"]" : "[\"What?\"]";
            stream.Write(new byte[] { 0x81, 9 });
            stream.Write(Encoding.ASCII.GetBytes(reply));
            return stream;
        }
    }
}
