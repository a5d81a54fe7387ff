using System;
using System.Linq;

namespace NetMQExample.Tests
{
    /// <summary>Bytes in a line of text: two digits each, and a minus where there are none.</summary>
    internal static class Hex
    {
        public static byte[] Bytes(string digits) => digits == "-" ? new byte[0]
            : Enumerable.Range(0, digits.Length / 2)
                .Select(i => Convert.ToByte(digits.Substring(2 * i, 2), 16)).ToArray();

        public static string Digits(byte[] bytes) =>
            bytes.Length == 0 ? "-" : BitConverter.ToString(bytes).Replace("-", "").ToLowerInvariant();
    }
}
