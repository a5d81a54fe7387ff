// Prints what the stand-ins of Unity have for scripts to use, one line each, in the words of C#.
using System;
using System.Collections.Generic;
using System.Linq;
using System.Reflection;
using System.Text.RegularExpressions;

namespace NetMQExample.PlayTest
{
    internal static class Api
    {
        private const BindingFlags Own = BindingFlags.Public | BindingFlags.NonPublic | BindingFlags.Instance
            | BindingFlags.Static | BindingFlags.DeclaredOnly;

        private static readonly Dictionary<Type, string> Words = new Dictionary<Type, string>
        {
            [typeof(void)] = "void",
            [typeof(object)] = "object",
            [typeof(string)] = "string",
            [typeof(bool)] = "bool",
            [typeof(int)] = "int",
            [typeof(uint)] = "uint",
            [typeof(byte)] = "byte",
            [typeof(float)] = "float",
            [typeof(double)] = "double",
        };

        public static void Print(params Assembly[] standIns)
        {
            // A delegate stands where it is used. Beside a stand-in is the program that uses it.
            var types = standIns.SelectMany(standIn => standIn.GetExportedTypes()).Where(type =>
                !typeof(Delegate).IsAssignableFrom(type) && Regex.IsMatch(type.FullName, @"^(Unity(Engine|Editor)?|TMPro)\."));
            foreach (var type in types.OrderBy(type => type.FullName, StringComparer.Ordinal))
            {
                var plain = type.IsValueType || type.BaseType == typeof(object) || type.BaseType == null;
                Console.WriteLine($"{Kind(type)} {type.FullName}{(plain ? "" : $" : {Name(type.BaseType)}")}");
                var members = type.IsEnum
                    ? Enum.GetNames(type).Select(name => $"{name} = {Convert.ToInt64(Enum.Parse(type, name))}")
                    : type.GetMembers(Own).Select(Text).Where(text => text != null).OrderBy(text => text, StringComparer.Ordinal);
                foreach (var member in members) Console.WriteLine($"    {member}");
            }
        }

        private static string Kind(Type type) =>
            type.IsEnum ? "enum" : type.IsValueType ? "struct" : type.IsInterface ? "interface" : "class";

        private static string Text(MemberInfo member)
        {
            switch (member)
            {
                case FieldInfo field when Visible(field.IsPublic, field.IsFamily):
                    return $"{Static(field.IsStatic)}{Name(field.FieldType)} {field.Name}";
                case PropertyInfo property when property.GetMethod != null && Visible(property.GetMethod.IsPublic, property.GetMethod.IsFamily):
                    var set = property.SetMethod != null && property.SetMethod.IsPublic ? " set;" : "";
                    return $"{Static(property.GetMethod.IsStatic)}{Name(property.PropertyType)} {property.Name} {{ get;{set} }}";
                case EventInfo happening when happening.AddMethod.IsPublic:
                    return $"{Static(happening.AddMethod.IsStatic)}event {Name(happening.EventHandlerType)} {happening.Name}";
                case ConstructorInfo maker when Visible(maker.IsPublic, maker.IsFamily) && maker.GetParameters().Length > 0:
                    return $"{Name(maker.DeclaringType)}({Parameters(maker)})";
                case MethodInfo method when Visible(method.IsPublic, method.IsFamily) && (!method.IsSpecialName || method.Name.StartsWith("op_", StringComparison.Ordinal)):
                    var generic = method.IsGenericMethod ? $"<{string.Join(", ", method.GetGenericArguments().Select(Name))}>" : "";
                    return $"{Static(method.IsStatic)}{Name(method.ReturnType)} {method.Name}{generic}({Parameters(method)})";
                default:
                    return null;
            }
        }

        private static bool Visible(bool isPublic, bool isProtected) => isPublic || isProtected;

        private static string Static(bool yes) => yes ? "static " : "";

        private static string Parameters(MethodBase method) =>
            string.Join(", ", method.GetParameters().Select(p => $"{(p.IsDefined(typeof(ParamArrayAttribute)) ? "params " : "")}{Name(p.ParameterType)} {p.Name}"));

        private static string Name(Type type)
        {
            if (type.IsArray) return $"{Name(type.GetElementType())}[]";
            if (type.IsByRef) return $"ref {Name(type.GetElementType())}";
            if (type.IsGenericType) return $"{type.Name.Split('`')[0]}<{string.Join(", ", type.GetGenericArguments().Select(Name))}>";
            return Words.TryGetValue(type, out var word) ? word : type.Name;
        }
    }
}
