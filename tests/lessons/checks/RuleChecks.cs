// Each public class says of a value that it cannot use one line that names it. And a client after its end.
//
// The constructors are found, and what they get is known by their parameters' names and types, so that a new one is
// asked as well.
using System;
using System.Collections.Generic;
using System.Linq;
using System.Linq.Expressions;
using System.Reflection;
using System.Threading;
using NetMQ;
using NetMQ.Sockets;
using UnityEngine;
using Component = UnityEngine.Component;

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
            ["job"] = new object[] { "", "../x" },
        };

        // Where null means "none", as the parameter's words say; so it does wherever it is the default.
        private static readonly string[] None =
        {
            "AvatarBone end", "GraphInstance nodes", "ActionBuffers continuousActions", "ActionBuffers discreteActions",
        };

        public static void Run()
        {
            // A component is made by Unity; an attribute, by the compiler; and an exception takes what it gets.
            var constructors = typeof(NetMQConnection).Assembly.GetExportedTypes()
                .Where(type => !type.IsAbstract && !type.IsGenericTypeDefinition
                    && !typeof(Component).IsAssignableFrom(type)
                    && !typeof(Attribute).IsAssignableFrom(type) && !typeof(Exception).IsAssignableFrom(type))
                .SelectMany(type => type.GetConstructors());
            foreach (var one in constructors)
                foreach (var parameter in one.GetParameters())
                    foreach (var wrong in WrongFor(parameter))
                        Refused(Name(parameter), parameter.Name, wrong, () => one.Invoke(
                            one.GetParameters().Select(each => each == parameter ? wrong : Right(each)).ToArray()));
            Refused("NetMQConnection.Slices timeout", "timeout", Timeout.InfiniteTimeSpan, () =>
                NetMQConnection.Slices(Timeout.InfiniteTimeSpan, default).First());
            Uses();
            if (NetMQLifetime.Users > 0) throw new Exception($"{NetMQLifetime.Users} users of NetMQ are left");
        }

        // A null for what is sent, or what no server would take; and anything after Dispose, which twice is once: it
        // says so at once and opens no socket. Each one is made by as little as it needs.
        private static void Uses()
        {
            const string Endpoint = "tcp://127.0.0.1:5551";
            var second = TimeSpan.FromSeconds(1);
            void Client<T>(T client, string parameter, Action<T> nothing, params Action<T>[] afterwards)
                where T : IDisposable
            {
                if (!$"{client}".Contains("://127.0.0.1:5551"))
                    throw new Exception($"where is it connected to? {client}");
                if (nothing != null)
                    Refused($"{typeof(T).Name}'s {parameter}", parameter, null, () => nothing(client));
                client.Dispose();
                client.Dispose();
                foreach (var use in afterwards)
                    Refused($"{typeof(T).Name} after Dispose", "disposed", "a use", () => use(client));
            }
            var hi = new Message("hi");
            var tooLong = new string('ä', 32_769);
            Client(new HelloRequester(Endpoint), "text", it => it.Request(null),
                it => it.Request("x"), it => it.Send("x"), it => it.Receive());
            Client(new LazyPirateRequester(Endpoint), "text", it => it.Request(null),
                it => it.Request("x"));
            Client(new MessageRequester(Endpoint), "request", it => it.Request(null),
                it => it.Request(hi));
            Client(new PooledRequester(Endpoint), "request", it => it.Request(null),
                it => it.Request(hi));
            Client(new ManyRequester(Endpoint), "texts", it => it.RequestMany(null).First(),
                it => it.RequestMany(new[] { "x" }).First());
            Client(new ManyRequester(Endpoint), "texts", it => it.RequestMany(new string[] { null }).First());
            using (var many = new ManyRequester(Endpoint))
            {
                // The first outcome is there at once: it is not sent.
                foreach (var _ in many.RequestMany(new[] { tooLong, "x" }).Take(1))
                    Refused("ManyRequester's second RequestMany", "has not ended", "a use",
                        () => many.RequestMany(new[] { tooLong }).First());
                if (many.RequestMany(new[] { tooLong }).Count() != 1)
                    throw new Exception("the next one was refused as well");
            }
            Client(new TopicListener(Endpoint), "", null, it => it.Receive(second), it => it.Newest(second));
            Client(new PoseSubscriber(Endpoint), "", null, it => it.Receive(second));
            Client(new DriverClient(Endpoint), "frame", it => it.Ask(null), it => it.Ask(hi));
            Client(new SecureRequester(Endpoint), "text", it => it.Request(null),
                it => it.Request("x"));
            Client(new JobClient(Endpoint), "request", it => it.Watch(null).First(),
                it => it.Watch(hi).First());
            Client(new EnvironmentClient(Endpoint), "", null,
                it => it.Run(new SceneSimulator("CartPole", 0.02, new[] { new CartPole() }), 1, answer => answer()));
            Client(new MessageDealer(Endpoint), "", null, it => it.Send(hi, default),
                it => it.Receive(second, default));
            Client(new ViewSender(Endpoint), "", null);
            Client(new BodyListener(Endpoint), "", null, it => it.Receive(second));
            Client(new MLAgents.SideChannels.SideChannelCarrier(Endpoint), "", null,
                it => it.Exchange(new byte[0], second));
            Client(WebRequester.To("http://127.0.0.1:5551", "hello"), "", null);
            Client(new BackgroundClient(Endpoint), "text", it => it.Request(null, null));
            Client(new BackgroundClient(Endpoint), "text has more", it => it.Request(tooLong, null));
            Client(new HelloRequester(Endpoint), "text has more", it => it.Request(tooLong));
            Client(new LazyPirateRequester(Endpoint), "text has more", it => it.Request(tooLong));
            Client(new SecureRequester(Endpoint), "text has more", it => it.Request(tooLong));
        }

        private static string Name(ParameterInfo parameter) =>
            $"{parameter.Member.DeclaringType.Name} {parameter.Name}";

        private static bool NullIsNone(ParameterInfo parameter) => None.Contains(Name(parameter))
            || (parameter.HasDefaultValue && parameter.DefaultValue == null);

        private static IEnumerable<object> WrongFor(ParameterInfo parameter)
        {
            var wrong = Wrong.TryGetValue(parameter.Name, out var values) && Fits(values, parameter)
                ? values : new object[0];
            // A server may take a free port.
            if (parameter.Member.DeclaringType == typeof(Server))
                wrong = wrong.Where(each => !$"{each}".EndsWith(":0")).ToArray();
            var reference = !parameter.ParameterType.IsValueType && !NullIsNone(parameter);
            return reference ? wrong.Append(null).Distinct() : wrong;
        }

        private static bool Fits(object[] values, ParameterInfo parameter)
        {
            var type = Nullable.GetUnderlyingType(parameter.ParameterType) ?? parameter.ParameterType;
            return values.All(value => value == null ? !type.IsValueType : type.IsInstanceOfType(value));
        }

        private static object Right(ParameterInfo parameter)
        {
            if (parameter.Name == "endpoint")
                return typeof(WebRequester).IsAssignableFrom(parameter.Member.DeclaringType)
                    ? "http://127.0.0.1:5566" : "tcp://127.0.0.1:5551";
            if (parameter.HasDefaultValue) return parameter.DefaultValue;
            if (parameter.Name == "cameras" || parameter.Name == "names") return "center";
            if (parameter.Name == "trouble") return "none";
            return NullIsNone(parameter) ? null : Made(parameter.ParameterType);
        }

        // Anything of a type; of an interface, something of a class that has it.
        private static object Made(Type type)
        {
            if (type == typeof(string)) return "x";
            if (type == typeof(int)) return 1;
            if (type == typeof(double)) return 1.0;
            if (type == typeof(TimeSpan)) return TimeSpan.FromSeconds(1);
            if (type == typeof(object)) return new CoinCar("x");
            if (type == typeof(Func<NetMQSocket>)) return (Func<NetMQSocket>)(() => new DealerSocket());
            if (type == typeof(Locator)) return new CoinCar("x").AgentState.Scope;
            if (type.IsValueType) return Activator.CreateInstance(type);
            if (type == typeof(IReadOnlyList<IAgent>)) return new[] { new CartPole() };
            // Most others are around another one.
            if (type == typeof(SimulatorBase)) return new SceneSimulator("x", 1, new[] { new CartPole() });
            if (type.IsArray) return Array.CreateInstance(type.GetElementType(), 0);
            if (type == typeof(RenderTexture))
                return new RenderTexture(1, 1, 0, RenderTextureFormat.ARGB32, RenderTextureReadWrite.sRGB);
            if (type == typeof(Transform)) return new GameObject("x").transform;
            if (typeof(Component).IsAssignableFrom(type)) return new GameObject("x").AddComponent(type);
            if (typeof(Delegate).IsAssignableFrom(type))
            {
                var call = type.GetMethod("Invoke");
                return Expression.Lambda(type, Expression.Default(call.ReturnType),
                    call.GetParameters().Select(each => Expression.Parameter(each.ParameterType))).Compile();
            }
            if (type.IsGenericType) return Array.CreateInstance(type.GetGenericArguments()[0], 0);
            var makes = typeof(NetMQConnection).Assembly.GetExportedTypes()
                .Where(one => !one.IsAbstract && type.IsAssignableFrom(one) && !typeof(Component).IsAssignableFrom(one))
                .SelectMany(one => one.GetConstructors()).OrderBy(one => one.GetParameters().Length).First();
            return makes.Invoke(makes.GetParameters().Select(Right).ToArray());
        }

        private static void Refused(string what, string name, object wrong, Action make)
        {
            var found = "accepted";
            try { make(); }
            catch (Exception e)
            {
                var why = e is TargetInvocationException ? e.InnerException : e;
                var says = why.Message.Contains(name) || why.Message.Contains($"bad endpoint '{wrong}'");
                var right = name == "disposed" ? why is ObjectDisposedException
                    : name == "has not ended" ? why is InvalidOperationException : why is ArgumentException;
                var plain = right && says && !why.Message.Contains('\n');
                found = plain ? "refused" : $"{why.GetType().Name}: {why.Message}";
            }
            Console.WriteLine($"{what} {wrong ?? "null"}: {found}");
        }
    }
}
