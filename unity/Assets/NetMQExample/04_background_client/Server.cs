// Lesson 04, a game that serves: the game answers, and the clients of lessons 01, 02, 04 and 06 ask, in C# or Python.
//
//     server = new Server(text => text == "score" ? $"{score}" : "error: expected score", "tcp://127.0.0.1:5554");
//     server.Poll();         in Update: `answer` runs here, and may touch the scene
//     server.Dispose();      in OnDisable
//
// Bytes: UTF-8 text, [text] or [id][text], at most 65,536 bytes each; the reply goes back with the same id. Behind a
// ROUTER that is [client][text] or [client][id][text], with REQ's empty frame after the client where it has sent one.
// Of a message of more frames the text is that of all, with a blank between.
// An answered request that comes again with its id is answered from memory: the work is not done twice.
using System;
using System.Collections.Generic;
using System.Linq;
using System.Text;
using System.Text.RegularExpressions;
using System.Threading;
using NetMQ;
using NetMQ.Sockets;
using Stopwatch = System.Diagnostics.Stopwatch;

namespace NetMQExample
{
    /// <summary>Answers clients over a ROUTER socket. Make it, call it and dispose it on one thread, in Unity the main
    /// thread: only Run waits.</summary>
    public sealed class Server : IDisposable
    {
        private const int MostRemembered = 1000, MostInAPoll = 50, LongestMistake = 1000;
        // The way back through some brokers is shorter. A longer one would fill the memory.
        private const int LongestWay = 1000;
        // A shorter id may be another client's as well.
        private const int UniqueIdBytes = 16;
        // Poll spends at most 2 ms in a frame. One request is always answered, however long that takes.
        private static readonly long BudgetTicks = Stopwatch.Frequency / 500;
        // Of the server before, which may have ended in this very frame, NetMQ closes the port on a thread of its own.
        private static readonly TimeSpan PortTimeout = TimeSpan.FromSeconds(1);
        // Any bytes as a text.
        private static readonly Encoding Bytes = Encoding.GetEncoding("iso-8859-1");

        private readonly Dictionary<(string way, string id), (byte[] text, byte[] reply)> remembered =
            new Dictionary<(string, string), (byte[], byte[])>();
        private readonly Queue<(string way, string id)> oldest = new Queue<(string, string)>();
        private readonly Stopwatch reported = new Stopwatch();
        private readonly Func<string, string> answer;
        private readonly Action<string> report;
        private readonly NetMQLifetime lifetime;
        private readonly RouterSocket socket;
        private int unreported;
        private bool disposed;

        /// <summary>Listens.</summary>
        /// <param name="answer">Gets the text of a request and returns that of its reply, inside Poll or Run. If it
        /// throws, the reply is <c>error: </c> and why.</param>
        /// <param name="endpoint">Where to listen, such as <c>tcp://127.0.0.1:5554</c>; port 0 takes a free
        /// one.</param>
        /// <param name="openToAnyone">Whether other machines may ask. Each that reaches the port can end NetMQ, as
        /// SECURITY.md says.</param>
        /// <param name="report">Called with what <paramref name="answer"/> has thrown, once a second at most; when left
        /// out it goes to Unity's console, elsewhere to the standard error stream.</param>
        /// <exception cref="ArgumentException">One of them cannot work; the message names cause and cure.</exception>
        /// <exception cref="GaveUpException">The port is taken, or the address not this machine's.</exception>
        public Server(Func<string, string> answer, string endpoint = "tcp://127.0.0.1:0", bool openToAnyone = false,
            Action<string> report = null)
        {
            this.answer = Require.Given("answer", answer);
#if UNITY_5_3_OR_NEWER
            this.report = report ?? UnityEngine.Debug.LogError;
#else
            this.report = report ?? Console.Error.WriteLine;
#endif
            if (!ushort.TryParse(Regex.Match(endpoint ?? "", @"^tcp://[^\s:\[\]]+:(\d+)\z").Groups[1].Value, out _))
                throw new ArgumentException(
                    $"bad endpoint '{endpoint}': write it like tcp://127.0.0.1:PORT; port 0 takes a free one");
            if (!openToAnyone && !Regex.IsMatch(endpoint, @"^tcp://(localhost|127\.[\d.]+):"))
                throw new ArgumentException(
                    $"endpoint '{endpoint}' would let anyone in: take 127.0.0.1, or pass openToAnyone: true");
            lifetime = new NetMQLifetime();
            try
            {
                socket = new RouterSocket { Options = { Linger = TimeSpan.Zero, MaxMsgSize = 65536 } };
                Listen(endpoint);
                Endpoint = socket.Options.LastEndpoint;
            }
            catch (Exception e)
            {
                Dispose();
                if (socket == null) throw;
                var why = (e as NetMQException)?.ErrorCode.ToString() ?? e.Message;
                throw new GaveUpException($"cannot listen on {endpoint}: " + (e is AddressAlreadyInUseException
                    ? "the port is taken; end the server that has it, or take port 0, which is a free one"
                    : $"{why}; is that an address of this machine?"));
            }
        }

        /// <summary>Where it listens, with the port.</summary>
        public string Endpoint { get; }

        /// <summary>Answers what has come and never waits; of very much the next call answers the rest. Call it in
        /// Update.</summary>
        /// <returns>How many requests it has answered.</returns>
        /// <exception cref="ObjectDisposedException">After Dispose.</exception>
        public int Poll()
        {
            var end = Stopwatch.GetTimestamp() + BudgetTicks;
            var answered = 0;
            while (answered < MostInAPoll && TryAnswer(TimeSpan.Zero))
            {
                answered++;
                if (disposed || Stopwatch.GetTimestamp() >= end) break;
            }
            return answered;
        }

        /// <summary>Answers until it is told to stop, for a program without frames.</summary>
        /// <param name="stop">Ends it, within 50 ms of being cancelled.</param>
        /// <exception cref="ObjectDisposedException">After Dispose.</exception>
        public void Run(CancellationToken stop = default)
        {
            do TryAnswer(NetMQConnection.Slice);
            while (!stop.IsCancellationRequested && !disposed);
        }

        public override string ToString() => $"Server {Endpoint}";

        /// <summary>Closes the socket, with what it has not sent yet, then leaves NetMQ. <c>answer</c> may call it.
        /// </summary>
        public void Dispose()
        {
            if (disposed) return;
            disposed = true;
            NetMQConnection.Close(socket);
            // The last one to leave waits for NetMQ, which may take its time: Stop must never freeze Unity.
            var leaving = new Thread(lifetime.Dispose) { IsBackground = true, Name = "Server" };
            leaving.Start();
            NetworkThread.Join(leaving);
        }

        private void Listen(string endpoint)
        {
            for (var waited = Stopwatch.StartNew(); ; Thread.Sleep(1))
                try
                {
                    socket.Bind(endpoint);
                    return;
                }
                catch (AddressAlreadyInUseException) when (waited.Elapsed < PortTimeout) { }
        }

        // One request, if one comes in time.
        private bool TryAnswer(TimeSpan wait)
        {
            List<byte[]> frames = null;
            if (disposed) throw NetMQConnection.Disposed(Endpoint);
            if (!socket.TryReceiveMultipartBytes(wait, ref frames)) return false;
            NetMQConnection.Show(Endpoint, false, frames);
            // The way back ends with REQ's empty frame, or with the client's name.
            var body = Math.Max(1, frames.FindIndex(0, frames.Count - 1, frame => frame.Length == 0) + 1);
            var reply = frames.GetRange(0, body);
            if (frames.Count == body + 2 && frames[body].Length > 0)
            {
                // The whole way: clients behind one broker have one name here.
                var way = string.Join(" ", reply.Select(Bytes.GetString));
                reply.Add(frames[body]);
                reply.Add(way.Length > LongestWay ? Answer(frames.Skip(body + 1))
                    : AnswerOnce(way, frames[body], frames[body + 1]));
            }
            else reply.Add(Answer(frames.Skip(body)));
            if (disposed) return true;
            // This never waits: ROUTER drops the reply to a client that has gone, or does not read.
            if (socket.TrySendMultipartBytes(TimeSpan.Zero, reply)) NetMQConnection.Show(Endpoint, true, reply);
            return true;
        }

        private byte[] AnswerOnce(string way, byte[] id, byte[] text)
        {
            var key = (id.Length < UniqueIdBytes ? way : "", Bytes.GetString(id));
            var again = remembered.TryGetValue(key, out var known);
            if (again && known.text.AsSpan().SequenceEqual(text)) return known.reply;
            var reply = Answer(new[] { text });
            if (!again) oldest.Enqueue(key);
            remembered[key] = (text, reply);
            if (oldest.Count > MostRemembered) remembered.Remove(oldest.Dequeue());
            return reply;
        }

        // A mistake in `answer` is reported to both sides, and ends neither.
        private byte[] Answer(IEnumerable<byte[]> request)
        {
            try
            {
                var text = string.Join(" ", request.Select(NetMQConnection.Text));
                return Encoding.UTF8.GetBytes(Require.Text("answer's reply", answer(text)));
            }
            catch (Exception e)
            {
                Report(e);
                var why = LogText.Printable($"{e.GetType().Name}: {e.Message}", LongestMistake);
                return Encoding.UTF8.GetBytes($"error: {why}");
            }
        }

        // A client may go on asking, and must not fill a disk.
        private void Report(Exception e)
        {
            unreported++;
            if (reported.IsRunning && reported.ElapsedMilliseconds < 1000) return;
            try { report($"{this}: answer threw {e}" + (unreported > 1 ? $" (and {unreported - 1} more)" : "")); }
            catch (Exception) { /* There is nobody else to tell. */ }
            reported.Restart();
            unreported = 0;
        }
    }
}
