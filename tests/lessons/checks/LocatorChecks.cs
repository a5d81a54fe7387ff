// Locator.cs reads each text of test_11_locators.py. A line of the input is the text, the name and the scope, with
// a blank between them; each is its UTF-16 code units in hexadecimal digits after a "=", and no scope is "-". The
// answer is "ok" and the canonical text, or "error" and what is wrong, in the same digits.
//
// A line "culture NAME" is answered with how that culture writes; what follows is read in it. "minus" is one of no
// country, where -1 is written ~1.
using System;
using System.Globalization;
using System.Linq;

namespace NetMQExample.Tests
{
    internal static class LocatorChecks
    {
        public static void Run() => Program.EachLine(line =>
        {
            var words = line.Split(' ');
            return words[0] == "culture" ? Begin(words[1]) : Answer(Read(words[0]), Read(words[1]), Read(words[2]));
        });

        private static string Begin(string name)
        {
            var culture = (CultureInfo)CultureInfo.GetCultureInfo(name == "minus" ? "" : name).Clone();
            if (name == "minus") culture.NumberFormat.NegativeSign = "~";
            CultureInfo.CurrentCulture = CultureInfo.CurrentUICulture = culture;
            return $"here: {"file".ToUpper()} {0.5} {-1}";
        }

        private static string Answer(string text, string name, string scope)
        {
            try
            {
                var locator = Locator.Parse(text, name, scope == null ? null : Locator.Parse(scope));
                return "ok " + Digits(locator.ToString());
            }
            catch (LocatorException e) { return "error " + Digits(e.Message); }
        }

        private static string Read(string field) => field == "-" ? null : string.Concat(
            Enumerable.Range(0, field.Length / 4)
                .Select(i => (char)Convert.ToInt32(field.Substring(1 + 4 * i, 4), 16)));

        private static string Digits(string text) => string.Concat(text.Select(unit => ((int)unit).ToString("x4")));
    }
}
