// What messages are made of: Msg, NetMQFrame, NetMQMessage, the buffer pool, and all ways to send and receive them.
using System;
using System.Collections.Generic;
using System.Linq;
using System.Text;
using System.Threading;
using NetMQ;
using NetMQ.Sockets;

namespace NetMQExample.Conformance
{
    internal static class Messages
    {
        internal static void Run()
        {
            Frames();
            WholeMessages();
            Msgs();
            SendAndReceiveMsg();
            Pool();
            PairSocket.CreateSocketPair(out var from, out var to);
            using (from)
            using (to)
            {
                Sending(from, to);
                Receiving(from, to);
                Skipping(from, to);
                Wrapped(from, to);
            }
        }

        private static void Frames()
        {
            var frame = new NetMQFrame("abc");
            Say.That("frame", frame.ConvertToString(), frame.MessageSize, frame.BufferSize, frame.IsEmpty);
            Say.That("text is ASCII", new NetMQFrame("é").ConvertToString());
            Say.That("with an encoding", new NetMQFrame("é", Encoding.UTF8).ConvertToString(Encoding.UTF8));
            Say.That("empty", NetMQFrame.Empty.IsEmpty, new NetMQFrame((byte[]?)null).MessageSize,
                new NetMQFrame(3).MessageSize);
            Say.That("part of an array", new NetMQFrame(new byte[] { 65, 66, 67 }, 2).ConvertToString());
            Say.That("equal", frame == new NetMQFrame("abc"), frame != new NetMQFrame("abd"),
                frame.Equals(new byte[] { 97, 98, 99 }));
            Say.That("hash", frame.GetHashCode());
            var copy = frame.Duplicate();
            copy.Buffer[0] = 122;
            Say.That("copy", frame.ConvertToString(), copy.ConvertToString(), NetMQFrame.Copy(copy).ConvertToString(),
                NetMQFrame.Copy(copy.Buffer).ConvertToString());
            copy.MessageSize = 1;
            Say.That("shortened", copy.ConvertToString(), copy.ToByteArray().Length, copy.ToByteArray(true).Length,
                copy.AsSpan().Length);
            Say.That("numbers", new NetMQFrame(new byte[] { 0, 0, 1, 2 }).ConvertToInt32(),
                new NetMQFrame(new byte[] { 255, 255, 255, 255, 255, 255, 255, 254 }).ConvertToInt64());
            Say.Throws("too short", () => copy.MessageSize = -1);
            Say.Throws("too long", () => _ = new NetMQFrame(new byte[2], 3));
            Say.Throws("negative", () => _ = new NetMQFrame(-1));
        }

        private static void WholeMessages()
        {
            var message = new NetMQMessage();
            Say.That("no frames", message, message.IsEmpty, message.FrameCount);
            message.Append("b");
            message.Append("ü", Encoding.UTF8);
            message.Append(new byte[] { 99 });
            message.Append(new NetMQFrame("d"));
            message.Append(258);
            message.Append(-2L);
            message.AppendEmptyFrame();
            message.Push("a");
            message.PushEmptyFrame();
            message.Push(1);
            message.Push(1L);
            message.Push(new byte[] { 48 });
            message.Push(new NetMQFrame("0"));
            message.Push("ö", Encoding.UTF8);
            Say.That("frames", string.Join(" ", message.Select(f => BitConverter.ToString(f.ToByteArray()))));
            Say.That("count", message.FrameCount);
            Say.That("first and last", message.First.ConvertToString(Encoding.UTF8), message.Last.MessageSize,
                message[1].ConvertToString());
            Say.That("pop", message.Pop().ConvertToString(Encoding.UTF8), message.FrameCount);
            Say.That("remove", message.RemoveFrame(new NetMQFrame("d")), message.RemoveFrame(new NetMQFrame("d")),
                message.FrameCount);
            Say.That("text", new NetMQMessage(new[] { new NetMQFrame("x"), NetMQFrame.Empty, new NetMQFrame("y") }));
            Say.That("of arrays", new NetMQMessage(new[] { new byte[] { 65 }, new byte[] { 66 } }));
            message.Clear();
            Say.That("cleared", message.IsEmpty);
            Say.Throws("pop nothing", () => message.Pop());
            Say.Throws("first of nothing", () => _ = message.First);
        }

        private static void Msgs()
        {
            var msg = new Msg();
            Say.That("new", msg.IsInitialised, msg.MsgType, msg.Size);
            Say.ThrowsText("close what was never made", () => new Msg().Close());
            Say.ThrowsText("copy what was never made",
                () => { var to = new Msg(); var from = new Msg(); to.Copy(ref from); });
            Say.ThrowsText("move what was never made",
                () => { var to = new Msg(); var from = new Msg(); to.Move(ref from); });
            msg.InitEmpty();
            Say.That("empty", msg.MsgType, msg.Size, msg.IsEmpty, msg.Slice().Length, msg.CloneData().Length);
            msg.Close();
            Say.That("closed", msg.IsInitialised, msg.MsgType);
            msg.InitGC(new byte[] { 1, 2, 3, 4, 5 }, 1, 3);
            Say.That("own array", msg.MsgType, msg.Size, msg[0], BitConverter.ToString(msg.ToArray()));
            msg.TrimPrefix(1);
            Say.That("trimmed", BitConverter.ToString(msg.CloneData()));
            Say.Throws("trimmed too much", () => { var m = new Msg(); m.InitGC(new byte[2], 2); m.TrimPrefix(3); });
            msg.Close();
            msg.InitPool(6);
            Say.That("pool", msg.MsgType, msg.Size, msg.IsShared);
            msg.Put(Encoding.ASCII, "hello!", 0);
            msg.Put(new byte[] { 72 }, 0, 1);
            msg.Put(63, 5);
            msg[1] = 69;
            Say.That("written", msg.GetString(Encoding.ASCII), msg.GetString(Encoding.ASCII, 1, 3));
            Say.That("slices", msg.Slice(4).Length, msg.Slice(1, 2).Length, ((ReadOnlySpan<byte>)msg).Length,
                msg.SliceAsMemory().Length);
            Say.Throws("slice too far", () => { var m = new Msg(); m.InitPool(2); m.Slice(3); });
            var copy = new Msg();
            copy.Copy(ref msg);
            Say.That("shared", msg.IsShared, copy.IsShared, copy.GetString(Encoding.ASCII));
            msg.Close();
            Say.That("still there", copy.GetString(Encoding.ASCII));
            msg.InitEmpty();
            msg.Move(ref copy);
            Say.That("moved", msg.GetString(Encoding.ASCII), copy.MsgType);
            msg.SetFlags(MsgFlags.More);
            Say.That("flags", $"{msg.HasMore}");
            msg.ResetFlags(MsgFlags.More);
            Say.That("flags", $"{msg.HasMore}");
            msg.Close();
            copy.Close();
        }

        private static void SendAndReceiveMsg()
        {
            using var server = new ResponseSocket("@inproc://msg");
            using var client = new RequestSocket(">inproc://msg");
            var msg = new Msg();
            Say.Throws("send what was never made", () => { var m = new Msg(); client.Send(ref m, false); });
            Say.Throws("receive into what was never made",
                () => { var m = new Msg(); server.TryReceive(ref m, TimeSpan.Zero); });
            msg.InitPool(3);
            msg.Put(Encoding.ASCII, "one", 0);
            client.Send(ref msg, true);
            Say.That("sent", msg.IsInitialised, msg.Size);
            msg.Close();
            msg.InitGC(Encoding.ASCII.GetBytes("  two"), 2, 3);
            Say.That("sent", client.TrySend(ref msg, Say.Timeout, false));
            msg.Close();
            msg.InitEmpty();
            server.Receive(ref msg);
            Say.That("received", msg.GetString(Encoding.ASCII), msg.HasMore);
            Say.That("received", server.TryReceive(ref msg, Say.Timeout), msg.GetString(Encoding.ASCII), msg.HasMore);
            server.SendFrameEmpty();
            Say.That("empty reply", client.TryReceive(ref msg, Say.Timeout), msg.Size, msg.HasMore, msg.IsInitialised);
            msg.Close();
            using var lonely = new PushSocket();
            msg.InitPool(3);
            msg.Put(Encoding.ASCII, "old", 0);
            Say.That("not sent", lonely.TrySend(ref msg, TimeSpan.Zero, false), msg.GetString(Encoding.ASCII));
            using var silent = new PullSocket();
            Say.That("not received", silent.TryReceive(ref msg, TimeSpan.Zero), msg.MsgType, msg.Size);
            msg.Close();
        }

        private sealed class CountingPool : IBufferPool
        {
            internal int Taken;
            internal int Returned;
            internal bool Disposed;

            public byte[] Take(int size)
            {
                Interlocked.Increment(ref Taken);
                return new byte[size];
            }

            public void Return(byte[] buffer) => Interlocked.Increment(ref Returned);

            public void Dispose() => Disposed = true;
        }

        private static void Pool()
        {
            var pool = new CountingPool();
            BufferPool.SetCustomBufferPool(pool);
            var msg = new Msg();
            msg.InitPool(10);
            Say.That("taken, returned", $"{pool.Taken}, {pool.Returned}");
            var copy = new Msg();
            copy.Copy(ref msg);
            msg.Close();
            Say.That("one of two closed", $"{pool.Taken}, {pool.Returned}");
            copy.Close();
            Say.That("both closed", $"{pool.Taken}, {pool.Returned}");
            var buffer = BufferPool.Take(5);
            BufferPool.Return(buffer);
            Say.That("by hand", $"{pool.Taken}, {pool.Returned}");
            using (var server = new ResponseSocket("@tcp://127.0.0.1:0"))
            using (var client = new RequestSocket(server.Options.LastEndpoint))
            {
                var before = pool.Taken;
                for (var i = 0; i < 10; i++)
                {
                    msg.InitPool(100);
                    client.Send(ref msg, false);
                    msg.Close();
                    msg.InitEmpty();
                    server.Receive(ref msg);
                    server.Send(ref msg, false);
                    msg.Close();
                    msg.InitEmpty();
                    client.Receive(ref msg);
                    msg.Close();
                }
                Say.That("used by sockets", pool.Taken >= before + 30);
            }
            Say.That("all returned", Say.Soon(() => pool.Taken == pool.Returned));
            BufferPool.SetGCBufferPool();
            Say.That("replaced and disposed", pool.Disposed);
        }

        private static void Sending(NetMQSocket from, NetMQSocket to)
        {
            var ok = true;
            from.SendFrame("text");
            from.SendFrame(new byte[] { 97, 98 });
            from.SendFrame(new byte[] { 97, 98 }, 1);
            from.SendFrameEmpty();
            from.SendFrame("more", true);
            from.SendMoreFrame("text").SendMoreFrame(new byte[] { 97, 98 }).SendMoreFrame(new byte[] { 97, 98 }, 1)
                .SendMoreFrameEmpty().SendFrame("end");
            ok &= from.TrySendFrame("try") && from.TrySendFrame(Say.Timeout, "try");
            ok &= from.TrySendFrame(new byte[] { 97 }) && from.TrySendFrame(Say.Timeout, new byte[] { 97 });
            ok &= from.TrySendFrame(new byte[] { 97, 98 }, 1)
                && from.TrySendFrame(Say.Timeout, new byte[] { 97, 98 }, 1);
            ok &= from.TrySendFrameEmpty(true) && from.TrySendFrameEmpty(Say.Timeout);
            from.SendMultipartBytes(new byte[] { 49 }, new byte[] { 50 });
            from.SendMultipartBytes(new List<byte[]> { new byte[] { 51 }, new byte[] { 52 }, new byte[] { 53 } });
            ok &= from.TrySendMultipartBytes(new byte[] { 54 })
                && from.TrySendMultipartBytes(Say.Timeout, new byte[] { 55 }, new byte[] { 56 });
            ok &= from.TrySendMultipartBytes(new List<byte[]> { new byte[] { 57 } })
                && from.TrySendMultipartBytes(Say.Timeout, new List<byte[]> { new byte[] { 58 } });
            var message = new NetMQMessage(new[] { new NetMQFrame("m1"), NetMQFrame.Empty, new NetMQFrame("m3") });
            from.SendMultipartMessage(message);
            ok &= from.TrySendMultipartMessage(message) && from.TrySendMultipartMessage(Say.Timeout, message);
            Say.That("sent", ok);
            Say.That("message kept", message.FrameCount);
            from.SendFrame("end");
            string text;
            do
            {
                text = Say.Received(to);
                Say.That("got", text);
            }
            while (text != "end" && text != "nothing came");
            Say.ThrowsText("no frames", () => from.SendMultipartMessage(new NetMQMessage()));
            Say.ThrowsText("no frames", () => from.SendMultipartBytes());
            Say.Throws("null text", () => from.SendFrame((string)null!));
            Say.Throws("null bytes", () => from.SendFrame((byte[])null!));
            Say.Throws("longer than the array", () => from.SendFrame(new byte[2], 3));
            Say.That("nothing of that was sent", Say.Silent(to));
        }

        private static void Receiving(NetMQSocket from, NetMQSocket to)
        {
            void Two() => from.SendMoreFrame("é").SendFrame("b");
            Two();
            Say.That("bytes", BitConverter.ToString(to.ReceiveFrameBytes(out var more)), more,
                BitConverter.ToString(to.ReceiveFrameBytes()));
            Two();
            Say.That("text", to.ReceiveFrameString(out more), more, to.ReceiveFrameString(Encoding.UTF8, out more),
                more);
            Two();
            Say.That("Latin-1", to.ReceiveFrameString(Encoding.GetEncoding("iso-8859-1")), to.Options.ReceiveMore);
            Say.That("text", to.ReceiveFrameString(), to.Options.ReceiveMore);
            Two();
            Say.That("try bytes", to.TryReceiveFrameBytes(Say.Timeout, out var bytes, out more) && more
                && to.TryReceiveFrameBytes(out bytes) && bytes[0] == 98);
            Two();
            Say.That("try bytes", to.TryReceiveFrameBytes(Say.Timeout, out bytes)
                && to.TryReceiveFrameBytes(out bytes, out more) && !more);
            Two();
            Say.That("try text", to.TryReceiveFrameString(Say.Timeout, out var text, out more) && more && text == "é"
                && to.TryReceiveFrameString(out text) && text == "b");
            Two();
            Say.That("try text", to.TryReceiveFrameString(Say.Timeout, Encoding.ASCII, out text) && text == "??"
                && to.TryReceiveFrameString(Encoding.ASCII, out text, out more) && !more);
            Two();
            Say.That("try text", to.TryReceiveFrameString(Say.Timeout, Encoding.UTF8, out text, out more) && more
                && to.TryReceiveFrameString(out text, out more) && !more);
            Two();
            Say.That("try text", to.TryReceiveFrameString(Say.Timeout, out text)
                && to.TryReceiveFrameString(Encoding.UTF8, out text));
            Two();
            Say.That("all bytes", to.ReceiveMultipartBytes().Count);
            Two();
            var frames = new List<byte[]> { new byte[1], new byte[2], new byte[3] };
            to.ReceiveMultipartBytes(ref frames);
            Say.That("into a list", frames.Count);
            Two();
            Say.That("all text", to.ReceiveMultipartStrings());
            Two();
            Say.That("all text", to.ReceiveMultipartStrings(Encoding.ASCII));
            Two();
            Say.That("message", to.ReceiveMultipartMessage());
            Say.That("nothing there", to.TryReceiveMultipartBytes(ref frames), frames.Count);
            List<string>? texts = null;
            Say.That("nothing there", to.TryReceiveMultipartStrings(ref texts), texts?.Count);
            NetMQMessage? message = null;
            Say.That("nothing there", to.TryReceiveMultipartMessage(ref message), message);
            Say.That("nothing came", to.TryReceiveMultipartMessage(TimeSpan.FromMilliseconds(20), ref message));
            Two();
            Say.That("try all bytes", to.TryReceiveMultipartBytes(Say.Timeout, ref frames), frames.Count);
            Two();
            Say.That("try all text", to.TryReceiveMultipartStrings(Say.Timeout, ref texts), texts?.Count);
            Two();
            Say.That("try all text", to.TryReceiveMultipartStrings(Say.Timeout, Encoding.UTF8, ref texts),
                texts?.Count);
            Two();
            Say.That("try message", to.TryReceiveMultipartMessage(Say.Timeout, ref message), message);
        }

        private static void Skipping(NetMQSocket from, NetMQSocket to)
        {
            void Three(string last) => from.SendMoreFrame("1").SendMoreFrame("2").SendFrame(last);
            Three("a");
            to.SkipFrame();
            to.SkipFrame(out var more);
            Say.That("skipped two", more, Say.Received(to));
            Three("b");
            Say.That("try", to.TrySkipFrame(Say.Timeout), to.TrySkipFrame(out more), more, Say.Received(to));
            Three("c");
            to.SkipMultipartMessage();
            Three("d");
            Say.That("try all", to.TrySkipMultipartMessage(Say.Timeout));
            Say.That("nothing left", to.TrySkipFrame(), to.TrySkipFrame(TimeSpan.FromMilliseconds(20), out more), more,
                to.TrySkipMultipartMessage());
            Three("e");
            Say.Soon(() => to.HasIn);
            // Without a timeout NetMQ skips the first frame only.
            Say.That("try all at once", to.TrySkipMultipartMessage(), Say.Received(to));
        }

        /// <summary>The methods are for every IOutgoingSocket and IReceivingSocket, also for a program's own.</summary>
        private sealed class Wrapper : IOutgoingSocket, IReceivingSocket
        {
            private readonly NetMQSocket socket;

            internal Wrapper(NetMQSocket socket) => this.socket = socket;

            internal int Calls { get; private set; }

            public bool TrySend(ref Msg msg, TimeSpan timeout, bool more)
            {
                Calls++;
                return socket.TrySend(ref msg, timeout, more);
            }

            public bool TryReceive(ref Msg msg, TimeSpan timeout)
            {
                Calls++;
                return socket.TryReceive(ref msg, timeout);
            }
        }

        private static void Wrapped(NetMQSocket from, NetMQSocket to)
        {
            var outgoing = new Wrapper(from);
            var incoming = new Wrapper(to);
            outgoing.SendMoreFrame("one").SendMoreFrame(new byte[] { 50 }).SendFrameEmpty();
            outgoing.SendFrame(new string('z', 1000));
            Say.That("wrapped", incoming.ReceiveMultipartStrings());
            Say.That("wrapped", incoming.ReceiveFrameString().Length);
            Say.That("calls", outgoing.Calls, incoming.Calls);
        }
    }
}
