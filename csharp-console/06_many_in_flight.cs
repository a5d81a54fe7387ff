// Lesson 06 in a terminal: the terminal client of ManyClient.cs, with the same ManyRequester.
//
//     dotnet run --project csharp-console -- 6                  a slow request does not hold up the others
//     dotnet run --project csharp-console -- 6 --window 1       one after the other, as in lesson 01
using System;
using System.Linq;

namespace NetMQExample.Terminal
{
    internal static class Lesson06
    {
        public static void Run(Arguments arguments)
        {
            var endpoint = arguments.Text("endpoint", "tcp://127.0.0.1:5556");
            var count = arguments.Whole("count", 6);
            var text = arguments.Text("text", "sleep 0.8|echo one|sleep 0.5|echo two|sleep 0.2|echo three");
            var window = arguments.Whole("window", 4);
            var timeout = arguments.Seconds("timeout", 2.5);
            var tries = arguments.Whole("tries", 3);
            arguments.RefuseTheRest();

            using var requester = new ManyRequester(endpoint, window, timeout, tries, Console.WriteLine);
            Console.WriteLine($"asking {endpoint}, {window} in flight");
            var texts = text.Split('|');
            var failures = 0;
            var requests = Enumerable.Range(0, count).Select(i => texts[i % texts.Length]);
            foreach (var answer in requester.RequestMany(requests))
            {
                if (answer.Failure != null) failures++;
                var outcome = answer.Failure == null
                    ? $"received {LogText.Printable(answer.Reply)}"
                    : $"gave up: {answer.Failure}";
                var asked = LogText.Printable(texts[(answer.Number - 1) % texts.Length]);
                Console.WriteLine($"{answer.Number}: sent {asked}, {outcome}");
            }
            Console.WriteLine($"done: {count - failures} replies");
            var where = $"{count} requests to {endpoint}";
            if (failures > 0) throw new TimeoutException($"{failures} of {where} have no reply; see above");
        }
    }
}
