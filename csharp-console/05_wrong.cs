// A wrong message, and what the server says about it: dotnet run --project csharp-console -- 5 --wrong shape
using System;
using System.Collections.Generic;

namespace NetMQExample.Terminal
{
    internal static class WrongMessage
    {
        // What --wrong changes in the header of a good message.
        private static readonly Dictionary<string, (string good, string bad)> Spoil = new()
        {
            ["json"] = ("{\"kind\"", "{kind"),
            ["version"] = ("\"version\":1", "\"version\":2"),
            ["kind"] = ("\"frame\"", "\"frames\""),
            ["shape"] = ("[240,320,3]", "[240,320,4]"),
            ["frames"] = ("[{", "[{\"dtype\":\"uint8\",\"shape\":[0]},{"),
        };

        public static void Check(string wrong)
        {
            if (wrong != "" && !Spoil.ContainsKey(wrong)) throw new UsageException($"--wrong takes one of: {string.Join(" ", Spoil.Keys)}");
        }

        public static void ShowRefusal(MessageRequester requester, string wrong, TimeSpan patience)
        {
            var message = TestCamera.Frame(1, new byte[TestCamera.Size]);
            try
            {
                requester.Request(message.Header().Replace(Spoil[wrong].good, Spoil[wrong].bad), message.Arrays, patience);
            }
            catch (MessageException e)
            {
                Console.WriteLine($"refused: {e.Message}");
            }
        }
    }
}
