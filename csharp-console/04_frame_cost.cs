// What lesson 04's client costs the main thread: dotnet run --project csharp-console -- 4 --measure 10000.
//
// One frame is what Update does in a game: run the callback of what came back, and ask once. Frames follow each other
// as soon as the reply is there, a millisecond instead of sixteen, so that ten thousand take some ten seconds.
using System;
using System.Threading;

namespace NetMQExample.Terminal
{
    internal static class Cost04
    {
        public static void Measure(BackgroundClient client, string text, int frames)
        {
            var (cost, replies, why) = (new FrameCost(frames), 0, (string?)null);
            // Made here, once. Inside the loop they would be what is measured.
            Action<string> onReply = _ => replies++;
            Action<string> onError = error => why ??= error;
            for (var asked = 1; !cost.Done && why == null; asked++)
            {
                cost.Begin();
                client.Poll();
                client.Request(text, onReply, onError);
                cost.End();
                do Thread.Sleep(1);
                while (client.Replies < asked && client.State != ClientState.Lost);
            }
            if (why != null) throw new TimeoutException(why);
            Console.WriteLine($"measured: {replies} replies in {cost}");
        }
    }
}
