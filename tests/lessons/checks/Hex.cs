using System;
using System.Globalization;
using System.Linq;

namespace NetMQExample.Tests
{
    /// <summary>Bytes in a line of text: two digits each, and a minus where there are none.</summary>
    internal static class Hex
    {
        public static byte[] Bytes(string digits) => digits == "-" ? new byte[0]
            : Enumerable.Range(0, digits.Length / 2)
                .Select(i => byte.Parse(digits.Substring(2 * i, 2), NumberStyles.HexNumber, CultureInfo.InvariantCulture)).ToArray();

        public static string Digits(byte[] bytes) =>
            bytes.Length == 0 ? "-" : BitConverter.ToString(bytes).Replace("-", "").ToLowerInvariant();
    }
}
