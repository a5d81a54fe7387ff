// test_05_messages.py asks this of the C# side:
//
//     read                  each line of the input is a message, its frames in hexadecimal digits with a space between
//                           them, an empty one as -; its answer is "ok" and the message as it is written again, or
//                           "error" and the code
//     write                 what no message may hold is refused before it is sent
//     ask WHO ENDPOINT      a requester, plain or pooled, is refused, and asks again; then how many bytes a pooled one
//                           allocates for the echo of a picture
//     again ENDPOINT        one that waits 0.2 s asks up to twenty times
using System;
using System.Globalization;
using System.Linq;
using System.Text;

namespace NetMQExample.Tests
{
    internal static class MessageChecks
    {
        private const int Picture = 230_400;
        private static readonly TimeSpan Timeout = TimeSpan.FromSeconds(20);

        public static void Run(string[] words)
        {
            Program.WriteNumbersInGerman();
            Console.WriteLine($"here a half is written {0.5}");
            if (words[0] == "read") Program.EachLine(Answer);
            else if (words[0] == "write") Write();
            else if (words[0] == "again") Again(words[1]);
            else Ask(words[1] == "pooled", words[2]);
        }

        private static string Answer(string line)
        {
            var message =
                Message.Read(line.Split(' ').Select(frame => new ReadOnlyMemory<byte>(Hex.Bytes(frame))).ToArray());
            var again = message.Arrays.Select(array => array.Data.ToArray())
                .Prepend(Encoding.UTF8.GetBytes(message.Header()));
            return "ok " + string.Join(" ", again.Select(Hex.Digits));
        }

        // Of all threads; .NET has it, and .NET Standard does not know it.
        private static long Allocated() =>
            (long)typeof(GC).GetMethod("GetTotalAllocatedBytes").Invoke(null, new object[] { true });

        private static void Write()
        {
            var wrong = new object[] { double.NaN, float.PositiveInfinity, 1L << 53, null, 'c', new int[1],
                new string('x', 70_000), "half \ud83d", "\ude00 half" };
            foreach (var value in wrong.Concat(new object[] { 1f, 2 }))
            {
                var message = new Message("echo", 1);
                message.Values["it"] = value;
                Console.WriteLine(Written(() => message));
            }
            foreach (var id in new[] { -1, 1L << 53 }) Console.WriteLine(Written(() => new Message("echo", id)));
            foreach (var shape in new[] { new[] { -1, -1 }, new int[9], new[] { 0, int.MaxValue } })
                Console.WriteLine(Written(() => Of(new MessageArray("uint8", new byte[shape[1] < 0 ? 1 : 0], shape))));
            // All arrays together are as many bytes as they may be, and then one more.
            foreach (var size in new[] { Message.LimitBytes - 1, Message.LimitBytes })
            {
                var small = new MessageArray("uint8", new byte[1], 1);
                Console.WriteLine(Written(() => Of(small, new MessageArray("uint8", new byte[size], size))));
            }
        }

        private static Message Of(params MessageArray[] arrays)
        {
            var message = new Message("echo");
            message.Arrays.AddRange(arrays);
            return message;
        }

        private static string Written(Func<Message> make)
        {
            try { return make().Header(); }
            catch (MessageException e) { return e.Code; }
        }

        private static void Again(string endpoint)
        {
            using var requester = new MessageRequester(endpoint, TimeSpan.FromSeconds(0.2), tries: 20);
            Console.WriteLine(requester.Request(new Message("echo", 7)).Id);
        }

        private static void Ask(bool pooled, string endpoint)
        {
            using var requester = pooled ? new PooledRequester(endpoint) : new MessageRequester(endpoint);
            var echo = new Message("echo", 1);
            echo.Arrays.Add(new MessageArray("uint8", new byte[Picture], Picture));
            try { requester.Request(new Message("frames", 5), Timeout); }
            catch (MessageException e) { Console.WriteLine($"{e.Id} {e.Message}"); }
            Console.WriteLine($"{requester.Request(echo, Timeout).Arrays[0].Data.Length} bytes");
            if (!pooled) return;
            PooledBuffers.Use();
            // Those before the first fill the pool. The first gives back a buffer that is not the pool's: it must not
            // throw.
            for (var i = 0; i < 10; i++) requester.Request(echo, Timeout);
            var before = Allocated();
            for (var i = 0; i < 20; i++) requester.Request(echo, Timeout);
            Console.WriteLine($"{(Allocated() - before) / 20}");
        }
    }
}
