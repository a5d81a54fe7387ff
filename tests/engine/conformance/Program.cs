// Exercises what the kit uses of NetMQ and prints what came of it: the same lines on every engine.
//
// Run: dotnet run --project tests/engine/conformance -p:NetMQEngine=libzmq [-- section …]
// Prints: transcript.txt, which was recorded from NetMQ 4.0.4.5. Nothing in it depends on ports, times or chance.
//
// Known differences between the engines, which are therefore not in the transcript:
//   ipc://            NetMQ maps the path to a loopback TCP port, libzmq has real ones (and none on some systems).
//   monitors          Which events come besides the named ones, how often, and NetMQ's event argument Socket.
//   sent Msg          NetMQ gives a sent buffer back to the pool when it is on the wire, libzmq copies it at once.
//   received buffers  NetMQ takes them from the pool on its I/O thread, libzmq's engine when they are received.
//   use after Dispose NetMQ checks addresses and options; sending and receiving then is undefined there.
//   Cleanup(false)    Disposing a socket that was left open may throw ObjectDisposedException in NetMQ.
//   empty frames      NetMQ's ReceiveMultipartStrings fails on the empty frame before a request within a process.
//   watermarks        How many messages the system's own TCP buffers hold besides.
//   IPv6              NetMQ binds a literal IPv6 address even with IPv4Only; libzmq refuses it.
//   rest of NetMQ     Actor, Beacon, Runtime, routing keys, thread-safe and STREAM sockets: NetMQ only.
//   CONFLATE          libzmq has it, NetMQ does not: not offered.
//   other threads     The section "threads", which runs only when it is named: there NetMQ waits for ever.
using System;
using System.Linq;
using System.Threading;

namespace NetMQExample.Conformance
{
    internal static class Program
    {
        private static int Main(string[] wanted)
        {
            // In a pipe Windows would use another encoding.
            Console.OutputEncoding = new System.Text.UTF8Encoding(false);
            var sections = new (string Name, Action Run)[]
            {
                ("request-reply", RequestReply.Run),
                ("patterns", Patterns.Run),
                ("messages", Messages.Run),
                ("options", Options.Run),
                ("polling", Polling.Run),
                ("monitoring", Monitoring.Run),
                ("errors", Errors.Run),
                ("lifecycle", Lifecycle.Run),
                ("threads", Threads.Run),
            };
            var running = "";
            // Each wait has its own limit; this one is for a call that never returns.
            using var watchdog = new Timer(_ =>
            {
                Console.Error.WriteLine($"gave up: {running} did not end within 350 seconds");
                Environment.Exit(1);
            }, null, TimeSpan.FromSeconds(350), Timeout.InfiniteTimeSpan);
            foreach (var (name, run) in sections)
            {
                if (wanted.Length > 0 ? !wanted.Contains(name) : name == "threads") continue;
                running = name;
                Console.WriteLine($"== {name}");
                try
                {
                    run();
                }
                catch (Exception e)
                {
                    // An unforeseen exception is a difference like any other: the rest shall still be compared.
                    Console.WriteLine($"ended by {e.GetType().Name}: {e.Message}");
                    Console.Error.WriteLine(e);
                }
            }
            return 0;
        }
    }
}
