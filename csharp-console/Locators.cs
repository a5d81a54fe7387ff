// Lesson 11 in a terminal, the locators: prints what one means. The Python side is locator.py.
using System;

namespace NetMQExample.Terminal
{
    internal static class Locators
    {
        public static void Print(Arguments arguments)
        {
            var text = arguments.Text("locator", "");
            var given = arguments.Has("scope");
            var scope = arguments.Text("scope", "");
            var name = arguments.Text("name", "");
            arguments.RefuseTheRest();
            Console.WriteLine(Locator.Parse(text, name, given ? Scope(scope) : null));
        }

        private static Locator Scope(string text)
        {
            try
            {
                return Locator.Parse(text);
            }
            catch (LocatorException e)
            {
                throw new UsageException($"scope, {e.Message}");
            }
        }
    }
}
