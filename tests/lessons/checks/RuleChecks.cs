// What each public class that talks to a peer says of values that it cannot use: one line that names the value.
//
// The classes are found by the names of their constructors' parameters, so that a new one is asked as well.
using System;
using System.Collections.Generic;
using System.Linq;
using System.Reflection;
using System.Threading;
using NetMQ;
using NetMQ.Sockets;

namespace NetMQExample.Tests
{
    internal static class RuleChecks
    {
        private static readonly object[] Times =
            { TimeSpan.Zero, TimeSpan.FromSeconds(-1), Timeout.InfiniteTimeSpan, TimeSpan.MaxValue };

        private static readonly Dictionary<string, object[]> Wrong = new Dictionary<string, object[]>
        {
            ["endpoint"] = new object[] { null, "", "127.0.0.1:5551", "tcp://127.0.0.1:0", "tcp://127.0.0.1:99999" },
            ["snapshots"] = new object[] { "127.0.0.1:5551", "tcp://127.0.0.1:0" },
            ["timeout"] = Times,
            ["tries"] = new object[] { 0, -1 },
            ["window"] = new object[] { 0, -1 },
            ["capacity"] = new object[] { 0, -1 },
            ["hwm"] = new object[] { -1 },
            ["topic"] = new object[] { null },
            ["person"] = new object[] { -1 },
            ["job"] = new object[] { null, "", "../x" },
        };

        public static void Run()
        {
            var constructors = typeof(NetMQConnection).Assembly.GetExportedTypes()
                .Where(type => !type.IsAbstract)
                .SelectMany(type => type.GetConstructors())
                .Where(one => one.GetParameters().Any(parameter => parameter.Name == "endpoint"));
            foreach (var one in constructors)
                foreach (var parameter in one.GetParameters().Where(each => Wrong.ContainsKey(each.Name)))
                    foreach (var wrong in Wrong[parameter.Name])
                        Refused($"{one.DeclaringType.Name} {parameter.Name}", parameter.Name, wrong, () => one.Invoke(
                            one.GetParameters().Select(each => each == parameter ? wrong : Right(each)).ToArray()));
            foreach (TimeSpan wrong in Times)
                Refused("HubFinder.Find timeout", "timeout", wrong, () => HubFinder.Find(5567, "", wrong));
            Refused("NetMQConnection.Slices timeout", "timeout", Timeout.InfiniteTimeSpan, () =>
                NetMQConnection.Slices(Timeout.InfiniteTimeSpan, default).First());
        }

        private static object Right(ParameterInfo parameter)
        {
            if (parameter.Name == "endpoint")
                return typeof(WebRequester).IsAssignableFrom(parameter.Member.DeclaringType)
                    ? "http://127.0.0.1:5566" : "tcp://127.0.0.1:5551";
            if (parameter.ParameterType == typeof(Action<string>)) return (Action<string>)(line => { });
            if (parameter.ParameterType == typeof(Func<NetMQSocket>)) return (Func<NetMQSocket>)(() => new DealerSocket());
            if (parameter.HasDefaultValue) return parameter.DefaultValue;
            if (parameter.ParameterType == typeof(TimeSpan)) return TimeSpan.FromSeconds(1);
            if (parameter.ParameterType == typeof(int)) return 1;
            return parameter.ParameterType == typeof(string) ? "x" : null;
        }

        private static void Refused(string what, string name, object wrong, Action make)
        {
            var found = "accepted";
            try
            {
                make();
            }
            catch (Exception e)
            {
                var why = e is TargetInvocationException ? e.InnerException : e;
                var says = why.Message.Contains(name) || why.Message.Contains($"bad endpoint '{wrong}'");
                var plain = why is ArgumentException && says && !why.Message.Contains('\n');
                found = plain ? "refused" : $"{why.GetType().Name}: {why.Message}";
            }
            Console.WriteLine($"{what} {wrong ?? "null"}: {found}");
        }
    }
}
