// Application 21 in a terminal: the terminal client of TalkingCharacter.cs, with the same Speech.
//
//     dotnet run --project csharp-console -- 21                            a line for each sentence, which grows
//     dotnet run --project csharp-console -- 21 --prompt "Who are you?"
//     dotnet run --project csharp-console -- 21 --leave-after 5            walks away when 5 words were said
using System;

namespace NetMQExample.Terminal
{
    internal static class Lesson21
    {
        public static void Run(Arguments arguments)
        {
            var endpoint = arguments.Text("endpoint", "tcp://127.0.0.1:5571");
            var prompt = arguments.Text("prompt", "Who built this bridge?");
            var count = arguments.Whole("count", 200);
            var leaveAfter = arguments.Whole("leave-after", 0);
            var timeout = arguments.Seconds("timeout", 1);
            var tries = arguments.Whole("tries", 5);
            arguments.RefuseTheRest();

            var speech = new Speech();
            void Say(string line) => Console.WriteLine(speech.Text == "" ? line : $"\n{line}");
            using var client = new JobClient(endpoint, null, timeout, tries, Say);
            var goal = Speech.Ask(client, prompt, count);
            Console.WriteLine($"asking {endpoint}: {LogText.Printable(prompt)}");
            foreach (var news in client.Watch(goal))
            {
                Console.Write(speech.Hear(news));
                if (news.Kind == "feedback" && leaveAfter > 0 && speech.Words >= leaveAfter) client.Cancel();
            }
            Console.WriteLine(speech.Outcome());
        }
    }
}
