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
            var (kind, count) = (arguments.Text("kind", "count"), arguments.Whole("count", 100));
            var text = arguments.Text("text", "");
            var (id, forget) = (arguments.Text("resume", ""), arguments.Flag("forget"));
            var (cancelAt, leaveAt) = (arguments.Whole("cancel-at", 0), arguments.Whole("leave-at", 0));
            var (timeout, tries) = (arguments.Seconds("timeout", 1), arguments.Whole("tries", 10));
            arguments.RefuseTheRest();

            var (bar, last) = (new ProgressBar(), (JobNews?)null);
            using var client = new JobClient(endpoint, id == "" ? JobClient.NewId() : id, timeout, tries, bar.Say);
            Console.WriteLine($"asking {endpoint} for job {client.Job}");
            try
            {
                foreach (var news in client.Watch(id == "" ? client.Goal(kind, count, text) : client.Ask("status")))
                {
                    bar.Show(last = news);
                    if (news.Kind != "feedback") continue;
                    if (cancelAt > 0 && news.Done >= cancelAt) client.Cancel();
                    if (leaveAt == 0 || news.Done < leaveAt) continue;
                    bar.Say($"left at {news.Done}; come back with --resume {client.Job}");
                    return;
                }
                if (forget) foreach (var news in client.Watch(client.Ask("forget"))) bar.Show(news);
            }
            catch (MessageException e)
            {
                throw new TimeoutException(e.Message, e);
            }
            if (last!.Status == "aborted") throw new TimeoutException("the job was aborted; see above");
            Console.WriteLine(last.Outcome);
        }
    }
}
