// Lesson 06's measurement: requests of 32 bytes, one at a time as in lesson 01, and many in flight.
//
// The rounds take turns, so that whatever else the machine does hits all of them alike; medians are compared.
using System;
using System.Collections.Generic;
using System.Diagnostics;
using System.Linq;

namespace NetMQExample.Terminal
{
    internal static class Measure06
    {
        private static readonly TimeSpan Patience = TimeSpan.FromSeconds(10);

        public static void Run(string endpoint, string alternation, int count)
        {
            using var strict = new HelloRequester(alternation);
            using var one = new ManyRequester(endpoint, 1, Patience);
            using var many = new ManyRequester(endpoint, 64, Patience);
            var rounds = new[]
            {
                // Lesson 01's server takes blanks after Hello, and answers World.
                (Name: "lesson 01, strict alternation", Run: n => Enumerable.Range(0, n).Count(_ => strict.Request("Hello".PadRight(32), Patience) == "World"), Rates: new List<double>()),
                (Name: "lesson 06, 1 in flight", Run: n => Answers(one, n), Rates: new List<double>()),
                (Name: "lesson 06, 64 in flight", Run: (Func<int, int>)(n => Answers(many, n)), Rates: new List<double>()),
            };
            for (var round = 0; round <= count; round++)
            {
                foreach (var (name, run, rates) in rounds)
                {
                    var requests = name.EndsWith("64 in flight", StringComparison.Ordinal) ? 60_000 : 6_000;
                    var watch = Stopwatch.StartNew();
                    if (run(requests) != requests) throw new TimeoutException($"{name}: not every request has the right reply");
                    // The first round only warms up: code is compiled, buffers grow.
                    if (round > 0) rates.Add(requests / watch.Elapsed.TotalSeconds);
                }
            }
            foreach (var (name, _, rates) in rounds)
                Console.WriteLine(FormattableString.Invariant($"{name}: {Median(rates):0} requests of 32 bytes a second, {Median(rates) / Median(rounds[0].Rates):0.0} times lesson 01"));
            Console.WriteLine(FormattableString.Invariant($"64 in flight: {Median(rounds[2].Rates) / Median(rounds[1].Rates):0.0} times 1 in flight"));
        }

        private static int Answers(ManyRequester requester, int count)
        {
            var text = "echo ".PadRight(32, 'x');
            return requester.RequestMany(Enumerable.Repeat(text, count)).Count(answer => answer.Reply == text[5..]);
        }

        private static double Median(List<double> values) => values.OrderBy(value => value).ElementAt(values.Count / 2);
    }
}
