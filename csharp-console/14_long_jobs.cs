// Lesson 14 in a terminal: the terminal client of JobRunner.cs, with the same JobClient.
//
//     dotnet run --project csharp-console -- 14                       counts to 100; --kind picture, --kind path
//     dotnet run --project csharp-console -- 14 --cancel-at 30
//     dotnet run --project csharp-console -- 14 --leave-at 30         then: --resume ID
using System;

namespace NetMQExample.Terminal
{
    internal static class Lesson14
    {
        public static void Run(Arguments arguments)
        {
            var endpoint = arguments.Text("endpoint", "tcp://127.0.0.1:5564");
            var kind = arguments.Text("kind", "count");
            var count = arguments.Whole("count", 100);
            var text = arguments.Text("text", "");
            var id = arguments.Text("resume", "");
            var forget = arguments.Flag("forget");
            var cancelAt = arguments.Whole("cancel-at", 0);
            var leaveAt = arguments.Whole("leave-at", 0);
            var timeout = arguments.Seconds("timeout", 1);
            var tries = arguments.Whole("tries", 5);
            arguments.RefuseTheRest();

            var bar = new ProgressBar();
            JobNews? last = null;
            using var client = new JobClient(endpoint, id == "" ? null : id, timeout, tries, bar.Say);
            Console.WriteLine($"asking {endpoint} for job {client.Job}");
            foreach (var news in client.Watch(id == "" ? client.Goal(kind, count, text) : client.Ask("status")))
            {
                last = news;
                bar.Show(news);
                if (news.Kind != "feedback") continue;
                if (cancelAt > 0 && news.Done >= cancelAt) client.Cancel();
                if (leaveAt == 0 || news.Done < leaveAt) continue;
                bar.Say($"left at {news.Done}; come back with --resume {client.Job}");
                return;
            }
            if (forget) foreach (var news in client.Watch(client.Ask("forget"))) bar.Show(news);
            if (last!.Status == "aborted") throw new GaveUpException("the job was aborted; see above");
            Console.WriteLine(last.Outcome);
        }
    }
}
