// Lesson 11 in a terminal: what a locator means.
//
//     dotnet run --project csharp-console -- 11 --locator car@.speed           prints: 'car'@['speed'] = $
//     dotnet run --project csharp-console -- 11 --locator .speed --scope car@.body
//     dotnet run --project csharp-console -- 11 --locator=-speed               says at which column it is wrong
namespace NetMQExample.Terminal
{
    internal static class Lesson11
    {
        public static void Run(Arguments arguments)
        {
            if (arguments.Has("locator")) PrintLocator(arguments);
            else throw new UsageException("which locator? Give it in quotes, such as: 11 --locator \".speed\"");
        }

        private static void PrintLocator(Arguments arguments)
        {
            var text = arguments.Text("locator", "");
            var given = arguments.Has("scope");
            var (scope, name) = (arguments.Text("scope", ""), arguments.Text("name", ""));
            arguments.RefuseTheRest();
            System.Console.WriteLine(Locator.Parse(text, name, given ? Scope(scope) : null));
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
