// What pooled buffers are worth: dotnet run --project csharp-console -- 5 --measure, with lesson 05's server.
//
// Echoes of a picture's size, once with SendFrame and ReceiveFrameBytes as a beginner writes them, once with
// MessageRequester. Both ways take turns, because a machine is not equally fast all the time, and the ratio that is
// printed is the middle one of the rounds' ratios.
using System;
using System.Collections.Generic;
using System.Diagnostics;
using System.Linq;
using NetMQ;
using NetMQ.Sockets;

namespace NetMQExample.Terminal
{
    internal static class MessageMeasure
    {
        private const int Rounds = 15, Echoes = 100;

        public static void Run(string endpoint, TimeSpan patience)
        {
            Console.WriteLine($"asking {endpoint}");
            using var pooled = new MessageRequester(endpoint);
            using var naive = new NetMQConnection(endpoint, () => new RequestSocket(), 4 * Message.Limit);

            var request = new Message("echo", 1);
            // Both ways send this one array, as a program does that has its picture in an array already.
            var pixels = new byte[TestCamera.Size];
            request.Arrays.Add(new MessageArray("uint8", pixels, pixels.Length));
            var rounds = new List<(double time, long bytes)[]>();
            // The round before the first warms up the compiler, the connections and the pool, and does not count.
            for (var round = 0; round <= Rounds; round++)
            {
                BufferPool.SetGCBufferPool();
                var before = Time(() => EchoNaively((RequestSocket)naive.Socket, request, pixels, patience));
                PooledBuffers.Use();
                var after = Time(() => pooled.Request(request, patience));
                if (round > 0) rounds.Add(new[] { before, after });
            }

            Console.WriteLine($"{Rounds} rounds of {Echoes} echoes of {TestCamera.Size} bytes each way, the middle of the rounds:");
            foreach (var (name, way) in new[] { ("naive", 0), ("pooled", 1) })
                Console.WriteLine(FormattableString.Invariant(
                    $"{name,-6} {Middle(rounds.Select(round => round[way].time)):F0} us and {Middle(rounds.Select(round => (double)round[way].bytes)):F0} new bytes for each"));
            Console.WriteLine(FormattableString.Invariant(
                $"pooled is {Middle(rounds.Select(round => round[0].time / round[1].time)):F2} times as fast"));
        }

        private static void EchoNaively(RequestSocket socket, Message request, byte[] pixels, TimeSpan patience)
        {
            socket.SendMoreFrame(request.Header()).SendFrame(pixels);
            if (!socket.TryReceiveFrameBytes(patience, out var header)) throw new TimeoutException("no reply; is the server running?");
            Message.Read(new ReadOnlyMemory<byte>[] { header, socket.ReceiveFrameBytes() });
        }

        private static (double time, long bytes) Time(Action echo)
        {
            // Neither way may pay for what the other has thrown away.
            GC.Collect();
            GC.WaitForPendingFinalizers();
            var bytes = GC.GetTotalAllocatedBytes(true);
            var watch = Stopwatch.StartNew();
            for (var i = 0; i < Echoes; i++) echo();
            return (watch.Elapsed.TotalMilliseconds * 1000 / Echoes, (GC.GetTotalAllocatedBytes(true) - bytes) / Echoes);
        }

        private static double Middle(IEnumerable<double> values) => values.OrderBy(value => value).ElementAt(Rounds / 2);
    }
}
