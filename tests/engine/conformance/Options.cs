// Options: their defaults, what can be read back, and what is refused.
using System;
using System.Text;
using NetMQ;
using NetMQ.Sockets;

namespace NetMQExample.Conformance
{
    internal static class Options
    {
        internal static void Run()
        {
            using var socket = new DealerSocket();
            var o = socket.Options;
            Show("default", o);

            o.Affinity = 1;
            o.Backlog = 10;
            o.DelayAttachOnConnect = true;
            o.HeartbeatInterval = TimeSpan.FromMilliseconds(700);
            Say.That("heartbeat timeout follows the interval", o.HeartbeatTimeout);
            o.HeartbeatTimeout = TimeSpan.FromMilliseconds(1500);
            o.HeartbeatTtl = TimeSpan.FromMilliseconds(2345);
            o.IPv4Only = false;
            o.Identity = Encoding.ASCII.GetBytes("me");
            o.Linger = TimeSpan.FromSeconds(2);
            o.MaxMsgSize = 1_000_000;
            o.ReceiveBuffer = 65536;
            o.ReceiveHighWatermark = 7;
            o.ReconnectInterval = TimeSpan.FromMilliseconds(50);
            o.ReconnectIntervalMax = TimeSpan.FromSeconds(3);
            o.SendBuffer = 32768;
            o.SendHighWatermark = 8;
            o.TcpKeepalive = true;
            o.TcpKeepaliveCnt = 4;
            o.TcpKeepaliveIdle = TimeSpan.FromSeconds(30);
            o.TcpKeepaliveInterval = TimeSpan.FromSeconds(5);
            o.Relaxed = true;
            o.Correlate = true;
            Show("set", o);

            o.SendBuffer = 0;
            o.Linger = TimeSpan.FromMilliseconds(-1);
            o.ReconnectInterval = TimeSpan.FromMilliseconds(-1);
            o.HeartbeatInterval = TimeSpan.Zero;
            Say.That("special values", o.SendBuffer, o.Linger.TotalMilliseconds, o.ReconnectInterval.TotalMilliseconds,
                o.HeartbeatInterval.TotalMilliseconds);

            Say.Throws("no identity", () => o.Identity = Array.Empty<byte>());
            Say.Throws("identity of 256 bytes", () => o.Identity = new byte[256]);
            Say.Throws("negative longest pause", () => o.ReconnectIntervalMax = TimeSpan.FromSeconds(-1));
            Say.Throws("pause below -1 ms", () => o.ReconnectInterval = TimeSpan.FromMilliseconds(-2));
            Say.Throws("key of 31 bytes", () => o.CurveServerKey = new byte[31]);

            NetMQConfig.Linger = TimeSpan.FromMilliseconds(1234);
            using (var later = new PairSocket()) Say.That("linger of a later socket", later.Options.Linger);
            NetMQConfig.Linger = TimeSpan.Zero;
            Say.That("process", NetMQConfig.Linger.TotalMilliseconds, NetMQConfig.ThreadPoolSize,
                NetMQConfig.MaxSockets);

            using var router = new RouterSocket();
            router.Options.RouterMandatory = true;
            router.Options.RouterHandover = true;
            using var publisher = new XPublisherSocket();
            publisher.Options.XPubVerbose = true;
            Say.That("write-only options", "accepted");
            Welcome();
            MaxMsgSize();
            Curve();
            AsyncIO.ForceDotNet.Force();
            AsyncIO.ForceDotNet.Unforce();
        }

        private static void Show(string when, SocketOptions o)
        {
            Say.That($"{when} affinity, backlog", o.Affinity, o.Backlog);
            Say.That($"{when} delay attach", o.DelayAttachOnConnect);
            Say.That($"{when} heartbeat", o.HeartbeatInterval.TotalMilliseconds, o.HeartbeatTimeout.TotalMilliseconds,
                o.HeartbeatTtl.TotalMilliseconds);
            Say.That($"{when} IPv4 only", o.IPv4Only);
            Say.That($"{when} identity", o.Identity);
            Say.That($"{when} linger", o.Linger);
            Say.That($"{when} largest message", o.MaxMsgSize);
            Say.That($"{when} buffers", o.SendBuffer, o.ReceiveBuffer);
            Say.That($"{when} watermarks", o.SendHighWatermark, o.ReceiveHighWatermark);
            Say.That($"{when} reconnect", o.ReconnectInterval.TotalMilliseconds,
                o.ReconnectIntervalMax.TotalMilliseconds);
            Say.That($"{when} keepalive", o.TcpKeepalive, o.TcpKeepaliveCnt, o.TcpKeepaliveIdle.TotalMilliseconds,
                o.TcpKeepaliveInterval.TotalMilliseconds);
            Say.That($"{when} last endpoint, more", o.LastEndpoint ?? "null", o.ReceiveMore);
            Say.That($"{when} curve", o.CurveServer, o.CurveServerKey!.Length);
        }

        private static void Welcome()
        {
            using var publisher = new XPublisherSocket();
            publisher.SetWelcomeMessage("welcome");
            publisher.Bind("tcp://127.0.0.1:0");
            using var subscriber = new SubscriberSocket(publisher.Options.LastEndpoint);
            subscriber.SubscribeToAnyTopic();
            // The publisher notices a subscriber when it is used.
            publisher.TrySkipFrame(Say.Timeout);
            Say.That("welcome message", Say.Received(subscriber));
        }

        private static void MaxMsgSize()
        {
            using var server = new PullSocket();
            server.Options.MaxMsgSize = 100;
            server.Bind("tcp://127.0.0.1:0");
            using var polite = new PushSocket(server.Options.LastEndpoint);
            polite.SendFrame(new byte[100]);
            Say.That("100 bytes", server.TryReceiveFrameBytes(Say.Timeout, out var bytes) ? bytes.Length : -1);
            using var rude = new PushSocket(server.Options.LastEndpoint);
            rude.SendFrame(new byte[101]);
            Say.That("101 bytes are refused", Say.Silent(server));
        }

        private static void Curve()
        {
            var keys = new NetMQCertificate();
            Say.That("keys", keys.PublicKey.Length, keys.SecretKey!.Length, keys.HasSecretKey, keys.PublicKeyZ85.Length,
                keys.SecretKeyZ85!.Length);
            Say.That("public key of a secret one",
                NetMQCertificate.CreateFromSecretKey(keys.SecretKey).PublicKeyZ85 == keys.PublicKeyZ85);
            Say.That("as text", new NetMQCertificate(keys.SecretKeyZ85,
                keys.PublicKeyZ85).PublicKeyZ85 == keys.PublicKeyZ85);
            const string known = "JTKVSB%%)wK0E.X)V>+}o?pNmC{O&4W4b!Ni{Lh6";
            Say.That("known secret key", NetMQCertificate.CreateFromSecretKey(known).PublicKeyZ85);
            var open = NetMQCertificate.FromPublicKey(keys.PublicKey);
            Say.That("public only", open.HasSecretKey, open.SecretKeyZ85 ?? "null",
                open.PublicKeyZ85 == keys.PublicKeyZ85);
            Say.Throws("key of 31 bytes", () => NetMQCertificate.FromPublicKey(new byte[31]));
            Say.Throws("key with a blank", () => NetMQCertificate.FromPublicKey(new string(' ', 40)));

            using var server = new ResponseSocket();
            server.Options.CurveServer = true;
            server.Options.CurveCertificate = keys;
            server.Bind("tcp://127.0.0.1:0");
            Say.That("server", server.Options.CurveServer);
            using var client = new RequestSocket();
            Say.Throws("a certificate without secret key", () => client.Options.CurveCertificate = open);
            client.Options.CurveServerCertificate = open;
            client.Options.CurveCertificate = new NetMQCertificate();
            client.Connect(server.Options.LastEndpoint!);
            client.SendFrame("secret");
            Say.That("encrypted", Say.Received(server));
            server.SendFrame("as well");
            Say.That("encrypted", Say.Received(client));
        }
    }
}
