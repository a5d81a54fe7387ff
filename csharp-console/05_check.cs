// Message.cs as a filter, for tests: dotnet run --project csharp-console -- 5 --check
//
// Each line of the input is one message, its frames in hexadecimal digits with a space between them, an empty one as -.
// The line that answers it is "ok" and the message as it is written again, or "error" and the code.
using System;
using System.Globalization;
using System.Linq;
using System.Text;

namespace NetMQExample.Terminal
{
    internal static class MessageCheck
    {
        public static void Run()
        {
            // A machine where 0.5 is written 0,5 must read and write the same bytes.
            var german = (CultureInfo)CultureInfo.InvariantCulture.Clone();
            (german.NumberFormat.NumberDecimalSeparator, german.NumberFormat.NumberGroupSeparator) = (",", ".");
            CultureInfo.CurrentCulture = german;
            // A message from before the pool was chosen gives back a buffer that is not the pool's: it must not throw.
            new PooledBuffers().Return(new byte[TestCamera.Size]);
            Console.WriteLine($"here a half is written {0.5}");
            for (var line = Console.ReadLine(); line != null; line = Console.ReadLine()) Console.WriteLine(Answer(line));
        }

        private static string Answer(string line)
        {
            try
            {
                var frames = line.Split(' ').Select(frame => new ReadOnlyMemory<byte>(Bytes(frame))).ToArray();
                var message = Message.Read(frames);
                var again = message.Arrays.Select(array => array.Data.ToArray()).Prepend(Encoding.UTF8.GetBytes(message.Header()));
                return "ok " + string.Join(" ", again.Select(Digits));
            }
            catch (MessageException e)
            {
                return $"error {e.Code}";
            }
            catch (FormatException e)
            {
                throw new UsageException($"--check takes hexadecimal digits, not '{line}': {e.Message}");
            }
        }

        private static byte[] Bytes(string digits) => digits == "-" ? Array.Empty<byte>() : Convert.FromHexString(digits);

        private static string Digits(byte[] bytes) => bytes.Length == 0 ? "-" : Convert.ToHexString(bytes).ToLowerInvariant();
    }
}
