// Lesson 11, observed values: what a member holds, as a message can have it; and which members a class has declared.
//
// Reflection is used once for each class: it finds the members and reads their attributes. After that a step costs one
// FieldInfo.GetValue or PropertyInfo.GetValue for each member, which work everywhere; IL2CPP compiles no code at run
// time that could replace them. The numbers of most are written as they are.
using System;
using System.Collections;
using System.Collections.Concurrent;
using System.Collections.Generic;
using System.Linq;
using System.Reflection;
using System.Text;

namespace NetMQExample
{
    /// <summary>A member of a class that has an attribute of Obs.cs.</summary>
    public sealed class Observed
    {
        private const BindingFlags Own =
            BindingFlags.Instance | BindingFlags.Static | BindingFlags.Public | BindingFlags.NonPublic
            | BindingFlags.DeclaredOnly;

        private static readonly ConcurrentDictionary<Type, Observed[]> Known = new();

        [ThreadStatic] private static int depth;

        [ThreadStatic] private static StringBuilder spelled;

        private readonly FieldInfo field;
        private readonly PropertyInfo property;
        private readonly ObsAttribute attribute;

        private Observed(Type type, MemberInfo member, ObsAttribute attribute)
        {
            field = member as FieldInfo;
            property = member as PropertyInfo;
            this.attribute = attribute;
            // [field: Box] stands at the field behind a property, whose name is <Speed>k__BackingField.
            var parts = member.Name.Split('<', '>');
            Name = parts[parts.Length > 1 ? 1 : 0];
            FullName = $"{type.Name}.{Name}";
        }

        /// <summary>Makes numbers or lists of what an engine has, such as a Vector3. Agent.cs sets it.</summary>
        public static Func<object, object> Engine { get; set; } = value => value;

        /// <summary>Class and member, for a person who must mend something.</summary>
        public string FullName { get; }

        /// <summary>The member alone: the key where its locator says none.</summary>
        public string Name { get; }

        /// <summary>As it was declared.</summary>
        public string Locator => attribute.Locator;

        /// <summary>All that a class and its base classes have declared, the base classes' first.</summary>
        public static IReadOnlyList<Observed> Members(Type type) => Known.GetOrAdd(type, Find);

        /// <summary>The value that an object has here now.</summary>
        /// <exception cref="MessageException">It has no place in a message; the text names the member.</exception>
        public object Read(object from)
        {
            try { return attribute.Read(ValueOf(from)); }
            catch (Exception e) when (e is MessageException || e is TargetInvocationException) { throw Named(e); }
        }

        /// <summary>Writes the same, and returns its form. Most have that of the value before again.</summary>
        internal string Write(object from, FrameBuffer to, string last)
        {
            try
            {
                var value = ValueOf(from);
                return attribute.Write(value, to) ?? Write(attribute.Read(value), last, to);
            }
            catch (Exception e) when (e is MessageException || e is TargetInvocationException) { throw Named(e); }
        }

        /// <summary>The form of any value, whose numbers are written.</summary>
        internal static string Write(object value, string last, FrameBuffer to)
        {
            spelled ??= new StringBuilder();
            spelled.Clear();
            MessageTree.Add(spelled, to, value);
            return last != null && spelled.Equals(last) ? last : spelled.ToString();
        }

        private object ValueOf(object from) => field != null ? field.GetValue(from) : property.GetValue(from);

        private Exception Named(Exception e) => e is MessageException known
            ? new MessageException(known.Code, $"{FullName}: {known.Text}")
            : (Exception)new InvalidOperationException($"{FullName}: {e.InnerException?.Message}", e.InnerException);

        /// <summary>A value of any kind as its own kind says.</summary>
        public static object Of(object value)
        {
            value = Engine(value);
            switch (value)
            {
                case null:
                case bool _:
                case string _:
                case EncodedImage _:
                case MessageArray _: return value;
                case GraphInstance graph:
                    return new GraphInstance(Part(graph.Nodes), Part(graph.Edges), Part(graph.EdgeLinks));
                case float _:
                case double _:
                case decimal _: return MessageTree.Finite(Convert.ToDouble(value));
                case Enum _:
                case IConvertible it when it.GetTypeCode() >= TypeCode.SByte && it.GetTypeCode() <= TypeCode.UInt64:
                    return Whole(value);
                case IDictionary _: return Dict(value);
                case IEnumerable items: return BoxOf.IsNumbers(items) ? (object)BoxOf.Value(items) : List(items);
            }
            throw new MessageException("no-space", $"no space takes a {value.GetType().Name}");
        }

        /// <summary>A dictionary with keys of text, whose values are of any kind.</summary>
        public static object Dict(object value)
        {
            if (!(value is IDictionary parts) || parts.Keys.Cast<object>().Any(key => !(key is string)))
                throw new MessageException("no-space", $"{value?.GetType().Name ?? "null"} is no dictionary of texts");
            return Inside(() => parts.Keys.Cast<string>().ToDictionary(key => key, key => Of(parts[key])));
        }

        /// <summary>Anything that has items, as a list of values of any kind.</summary>
        public static object List(object value) => value is IEnumerable items && !(value is string)
            ? Inside(() => items.Cast<object>().Select(Of).ToList())
            : throw new MessageException("no-space", $"{value?.GetType().Name ?? "null"} has no items");

        // A graph's numbers are arrays, also a single one of them.
        private static object Part(object value) => value == null ? null : BoxOf.Value(value);

        private static object Inside(Func<object> read)
        {
            // Without a limit, a list that holds itself would end the program.
            if (depth > 100) throw new MessageException("no-space", "it is nested more than 100 times, or has no end");
            depth++;
            try { return read(); }
            finally { depth--; }
        }

        private static object Whole(object value)
        {
            try { return Convert.ToInt64(value); }
            catch (OverflowException) { throw new MessageException("bad-value", $"{value} is too large for an int64"); }
        }

        // DeclaredOnly, class by class: private members of base classes are not found otherwise.
        private static Observed[] Find(Type type)
        {
            var found = type.BaseType == null ? new List<Observed>() : Members(type.BaseType).ToList();
            foreach (var member in type.GetFields(Own).Cast<MemberInfo>().Concat(type.GetProperties(Own)))
            {
                var attributes = member.GetCustomAttributes<ObsAttribute>(false).ToArray();
                if (attributes.Length == 0) continue;
                var one = new Observed(type, member, attributes[0]);
                ArgumentException Wrong(string what) => new ArgumentException($"{one.FullName} {what}");
                if (attributes.Length > 1) throw Wrong("has two attributes: one is enough");
                if (one.property != null && (!one.property.CanRead || one.property.GetIndexParameters().Length > 0))
                    throw Wrong("cannot be read: give it a get");
                if (one.field?.IsStatic ?? one.property.GetMethod.IsStatic)
                    throw Wrong("is static: it belongs to no agent");
                // A member stands for the one that it overrides, or hides at the same place.
                found.RemoveAll(other => other.Name == one.Name && other.Locator == one.Locator);
                found.Add(one);
            }
            return found.ToArray();
        }
    }

    /// <summary>One place where a value comes from, and where it goes.</summary>
    public sealed class Source
    {
        private readonly Func<Locator> place;

        public Source(string name, Locator locator, Func<object> read)
            : this(name, Always(Require.Given("locator", locator)), read) { }

        /// <summary>With a locator that names agents, whose names are not decided yet.</summary>
        public Source(string name, Func<Locator> place, Func<object> read)
        {
            Name = Require.Given("name", name);
            this.place = Require.Given("place", place);
            Read = Require.Given("read", read);
            Write = (to, form) => Observed.Write(read(), form, to);
            Place();
        }

        private static Func<Locator> Always(Locator locator) => () => locator;

        /// <summary>For a person who must mend something.</summary>
        public string Name { get; }

        /// <summary>Where it goes; it names agents.</summary>
        public Locator Locator { get; private set; }

        public Func<object> Read { get; }

        // Writes its value as it stands in a message: takes the form of the value before, and returns that of this one.
        internal Func<FrameBuffer, string, string> Write { get; set; }

        /// <summary>Whether its value goes into the observation of this agent, perhaps among others.</summary>
        public bool Names(string agent)
        {
            foreach (var mapping in Locator.Mappings) if (mapping.Names(agent)) return true;
            return false;
        }

        /// <summary>The canonical text of its places in the observation of one agent, which is not named.</summary>
        internal string For(string agent) =>
            string.Join(" & ", Locator.Mappings.Where(mapping => mapping.Names(agent)).Select(one => one.InIt)
                .OrderBy(text => text, StringComparer.Ordinal));

        /// <summary>The names of agents have been decided.</summary>
        internal void Place() => Locator = place();
    }
}
