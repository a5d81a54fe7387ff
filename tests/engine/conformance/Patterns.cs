// The other patterns: publish-subscribe, push-pull, dealer-router, pair, proxies.
using System;
using System.Collections.Generic;
using System.Linq;
using System.Text;
using System.Threading;
using NetMQ;
using NetMQ.Sockets;

namespace NetMQExample.Conformance
{
    internal static class Patterns
    {
        internal static void Run()
        {
            Prefixes();
            Subscriptions();
            OneWaySockets();
            PushPull();
            Watermarks();
            Linger();
            Identities();
            Mandatory();
            Handover();
            Pairs();
            Proxies();
        }

        /// <summary>Publishes until the subscriber hears it: before that, what is published is lost.</summary>
        private static void Meet(NetMQSocket publisher, NetMQSocket subscriber, string topic)
        {
            Say.Soon(() =>
            {
                publisher.SendFrame(topic + "-meet");
                return subscriber.TryReceiveFrameString(TimeSpan.FromMilliseconds(20), out _);
            });
            publisher.SendFrame(topic + "-met");
            while (subscriber.TryReceiveFrameString(Say.Timeout, out var text) && text != topic + "-met") { }
        }

        private static void Prefixes()
        {
            using var publisher = new PublisherSocket("@tcp://127.0.0.1:0");
            using var subscriber = new SubscriberSocket(publisher.Options.LastEndpoint);
            subscriber.Subscribe("a");
            Meet(publisher, subscriber, "a");
            foreach (var topic in new[] { "a", "ab", "b", "A", "", "abc", "a-end" }) publisher.SendFrame(topic);
            Say.That("subscribed to a", UpTo(subscriber, "a-end"));
            publisher.SendMoreFrame("a").SendMoreFrame("b").SendFrame("");
            publisher.SendMoreFrame("b").SendFrame("a");
            publisher.SendFrame("a-end");
            Say.That("only the first frame counts", UpTo(subscriber, "a-end"));
            subscriber.Subscribe("bb");
            subscriber.Unsubscribe("a");
            Meet(publisher, subscriber, "bb");
            foreach (var topic in new[] { "a", "b", "bb", "bbb", "bb-end" }) publisher.SendFrame(topic);
            Say.That("changed to bb", UpTo(subscriber, "bb-end"));
            subscriber.SubscribeToAnyTopic();
            Meet(publisher, subscriber, "-");
            foreach (var topic in new[] { "a", "", "z", "end" }) publisher.SendFrame(topic);
            Say.That("any topic", UpTo(subscriber, "end"));
        }

        private static List<string> UpTo(NetMQSocket subscriber, string end)
        {
            var all = new List<string>();
            List<string>? frames = null;
            while (subscriber.TryReceiveMultipartStrings(Say.Timeout, ref frames) && frames[0] != end)
            {
                all.Add("[" + string.Join("+", frames) + "]");
            }
            return all;
        }

        private static void Subscriptions()
        {
            using var publisher = new XPublisherSocket("@tcp://127.0.0.1:0");
            using var subscriber = new SubscriberSocket(publisher.Options.LastEndpoint);
            subscriber.Subscribe("abc");
            Say.That("subscribe", Bytes(publisher));
            subscriber.Subscribe("é");
            Say.That("a string topic is ASCII", Bytes(publisher));
            subscriber.Subscribe("é", Encoding.UTF8);
            Say.That("with an encoding", Bytes(publisher));
            subscriber.Subscribe(new byte[] { 0, 255 });
            Say.That("bytes", Bytes(publisher));
            subscriber.Unsubscribe(new byte[] { 0, 255 });
            Say.That("unsubscribe", Bytes(publisher));
            subscriber.SubscribeToAnyTopic();
            Say.That("any topic", Bytes(publisher));
            using var other = new XSubscriberSocket(publisher.Options.LastEndpoint);
            other.SendFrame(new byte[] { 1, 120 });
            Say.That("subscribe by a message", Bytes(publisher));
            publisher.SendFrame("xy");
            Say.That("published", Say.Received(other));
        }

        private static byte[]? Bytes(NetMQSocket socket)
            => socket.TryReceiveFrameBytes(Say.Timeout, out var bytes) ? bytes : null;

        private static void OneWaySockets()
        {
            using var publisher = new PublisherSocket();
            using var subscriber = new SubscriberSocket();
            using var push = new PushSocket();
            using var pull = new PullSocket();
            Say.ThrowsText("a publisher receives", () => publisher.TryReceiveFrameString(out _));
            Say.ThrowsText("a subscriber sends", () => subscriber.SendFrame("x"));
            Say.ThrowsText("a push socket receives", () => push.ReceiveFrameBytes());
            Say.ThrowsText("a pull socket sends", () => pull.TrySendFrame(new byte[1]));
            Say.That("a publisher without subscribers sends", publisher.TrySendFrame("x"));
            Say.That("a push socket without peers sends", push.TrySendFrame("x"));
            Say.That("even when it waits", push.TrySendFrame(Say.Moment, "x"));
        }

        private static void PushPull()
        {
            using var pull = new PullSocket("@tcp://127.0.0.1:0");
            using var push = new PushSocket(pull.Options.LastEndpoint);
            for (var i = 0; i < 500; i++) push.SendMoreFrame(BitConverter.GetBytes(i)).SendFrame("work");
            var inOrder = true;
            for (var i = 0; i < 500; i++)
            {
                inOrder &= pull.TryReceiveFrameBytes(Say.Timeout, out var number, out var more)
                    && more && BitConverter.ToInt32(number, 0) == i && pull.ReceiveFrameString(out more) == "work"
                        && !more;
            }
            Say.That("500 messages in order", inOrder);

            using var left = new PullSocket("@inproc://left");
            using var right = new PullSocket("@inproc://right");
            using var source = new PushSocket(">inproc://left,>inproc://right");
            for (var i = 0; i < 6; i++) source.SendFrame($"{i}");
            Say.That("left", string.Join(",", Enumerable.Range(0, 3).Select(_ => Say.Received(left))));
            Say.That("right", string.Join(",", Enumerable.Range(0, 3).Select(_ => Say.Received(right))));
        }

        private static void Watermarks()
        {
            using var push = new PushSocket();
            push.Options.SendHighWatermark = 5;
            push.Connect(Say.FreeAddress());
            var sent = 0;
            while (sent < 100 && push.TrySendFrame("x")) sent++;
            Say.That("sent until the watermark", sent);
            Say.That("one more", push.TrySendFrame(Say.Moment, "x"));
            Say.That("ready to send", push.HasOut);

            using var unlimited = new PushSocket();
            unlimited.Options.SendHighWatermark = 0;
            unlimited.Connect(Say.FreeAddress());
            sent = 0;
            while (sent < 5000 && unlimited.TrySendFrame("x")) sent++;
            Say.That("without a watermark", sent);

            using var picky = new PushSocket();
            picky.Options.DelayAttachOnConnect = true;
            picky.Connect(Say.FreeAddress());
            Say.That("only to connected peers", picky.TrySendFrame("x"));

            using var pull = new PullSocket();
            pull.Options.ReceiveHighWatermark = 3;
            pull.Bind("inproc://watermark");
            using var near = new PushSocket();
            near.Options.SendHighWatermark = 4;
            near.Connect("inproc://watermark");
            sent = 0;
            while (sent < 100 && near.TrySendFrame("x")) sent++;
            Say.That("both watermarks within a process", sent);
        }

        private static void Linger()
        {
            foreach (var linger in new[] { TimeSpan.Zero, Say.Timeout })
            {
                var address = Say.FreeAddress();
                using (var push = new PushSocket())
                {
                    push.Options.Linger = linger;
                    push.Connect(address);
                    push.SendFrame("sent before there was anybody");
                }
                // Dispose returns before the socket's connection is gone.
                Thread.Sleep(Say.Moment);
                using var pull = new PullSocket();
                pull.Bind(address);
                var timeout = linger == TimeSpan.Zero ? TimeSpan.FromMilliseconds(600) : Say.Timeout;
                var came = pull.TryReceiveFrameString(timeout, out var text);
                Say.That(linger == TimeSpan.Zero ? "linger 0" : "linger", came ? text : "dropped");
            }
        }

        private static void Identities()
        {
            using var router = new RouterSocket("@tcp://127.0.0.1:0");
            var dealers = new List<DealerSocket>();
            foreach (var name in new[] { "ann", "bob" })
            {
                var dealer = new DealerSocket();
                dealer.Options.Identity = Encoding.ASCII.GetBytes(name);
                dealer.Connect(router.Options.LastEndpoint!);
                dealers.Add(dealer);
                for (var i = 0; i < 3; i++) dealer.SendFrame($"{name} {i}");
            }
            using var nameless = new DealerSocket(router.Options.LastEndpoint);
            nameless.SendFrame("from nobody");
            var arrived = new List<string>();
            byte[]? given = null;
            for (var i = 0; i < 7; i++)
            {
                if (!router.TryReceiveFrameBytes(Say.Timeout, out var identity)) break;
                var text = router.ReceiveFrameString();
                if (text == "from nobody") given = identity;
                else arrived.Add($"{Encoding.ASCII.GetString(identity)}: {text}");
            }
            Say.That("arrived", arrived.OrderBy(x => x, StringComparer.Ordinal));
            Say.That("a given identity begins with 0", given?[0]);
            Say.That("and has bytes", given?.Length);
            router.SendMoreFrame("bob").SendFrame("to bob");
            router.SendMoreFrame("ann").SendMoreFrame("to").SendFrame("ann");
            router.SendMoreFrame(given!).SendFrame("to nobody");
            Say.That("ann", Say.Received(dealers[0]));
            Say.That("bob", Say.Received(dealers[1]));
            Say.That("nobody", Say.Received(nameless));
            foreach (var dealer in dealers) dealer.Dispose();
        }

        private static void Mandatory()
        {
            using var router = new RouterSocket("@tcp://127.0.0.1:0");
            router.SendMoreFrame("stranger").SendFrame("dropped in silence");
            Say.That("to a stranger", "nothing thrown");
            router.Options.RouterMandatory = true;
            Say.ThrowsText("to a stranger, mandatory", () => router.SendMoreFrame("stranger"));
            var thrown = Say.Thrown(() => router.TrySendFrame("stranger", true)) as NetMQException;
            Say.That("error code", thrown?.ErrorCode);
            using var dealer = new DealerSocket();
            dealer.Options.Identity = Encoding.ASCII.GetBytes("friend");
            dealer.Connect(router.Options.LastEndpoint!);
            dealer.SendFrame("here I am");
            Say.That("friend", Say.Received(router));
            router.SendMoreFrame("friend").SendFrame("welcome");
            Say.That("to a friend", Say.Received(dealer));
        }

        private static void Handover()
        {
            using var router = new RouterSocket();
            router.Options.RouterHandover = true;
            router.Bind("tcp://127.0.0.1:0");
            using var first = Twin(router);
            Say.That("first twin", Say.Received(router));
            using var second = Twin(router);
            Say.That("second twin", Say.Received(router));
            router.SendMoreFrame("twin").SendFrame("to the last one");
            Say.That("who gets it", Say.Received(second));
        }

        private static DealerSocket Twin(RouterSocket router)
        {
            var dealer = new DealerSocket();
            dealer.Options.Identity = Encoding.ASCII.GetBytes("twin");
            dealer.Options.ReconnectInterval = TimeSpan.FromSeconds(60);
            dealer.Connect(router.Options.LastEndpoint!);
            dealer.SendFrame("hello");
            return dealer;
        }

        private static void Pairs()
        {
            PairSocket.CreateSocketPair(out var one, out var two);
            using (one)
            using (two)
            {
                one.SendFrame("ping");
                one.SendFrame("ping again");
                Say.That("one way", $"{Say.Received(two)}, {Say.Received(two)}");
                two.SendFrame("pong");
                Say.That("other way", Say.Received(one));
            }
            PairSocket.CreateSocketPair(out one, out two, s => s.Options.SendHighWatermark = 1, s
                => s.Options.ReceiveHighWatermark = 1);
            using (one)
            using (two)
            {
                Say.That("room for two", string.Join(",", Enumerable.Range(0, 3).Select(_ => one.TrySendFrame("x"))));
            }
        }

        private static void Proxies()
        {
            using var frontend = new RouterSocket("@inproc://front");
            using var backend = new DealerSocket("@inproc://back");
            using var watcher = new PullSocket("@inproc://control");
            using var control = new PushSocket(">inproc://control");
            var proxy = new Proxy(frontend, backend, control);
            var thread = new Thread(proxy.Start) { IsBackground = true };
            using var client = new RequestSocket(">inproc://front");
            using var server = new ResponseSocket(">inproc://back");
            thread.Start();
            client.SendFrame("through the proxy");
            Say.That("request", Say.Received(server));
            server.SendFrame("and back");
            Say.That("reply", Say.Received(client));
            Say.That("frames of the copies",
                $"{watcher.ReceiveMultipartBytes().Count}, {watcher.ReceiveMultipartBytes().Count}");
            Say.Throws("start again", proxy.Start);
            proxy.Stop();
            Say.That("stopped", thread.Join(Say.Timeout));
            Say.Throws("stop again", proxy.Stop);
        }
    }
}
