// Prints the types that the stand-ins of Unity have for scripts to use, each with the names of its members.
using System;
using System.Linq;
using System.Reflection;
using System.Text.RegularExpressions;

namespace NetMQExample.PlayTest
{
    internal static class Api
    {
        private const BindingFlags Own = BindingFlags.Public | BindingFlags.NonPublic | BindingFlags.Instance
            | BindingFlags.Static | BindingFlags.DeclaredOnly;

        public static void Print(params Assembly[] standIns)
        {
            // A delegate stands where it is used. Beside a stand-in is the program that uses it.
            var types = standIns.SelectMany(standIn => standIn.GetExportedTypes()).Where(type =>
                !typeof(Delegate).IsAssignableFrom(type)
                && Regex.IsMatch(type.FullName, @"^(Unity(Engine|Editor)?|TMPro)\."));
            foreach (var type in types)
            {
                var plain = type.IsValueType || type.BaseType == typeof(object) || type.BaseType == null;
                Console.WriteLine($"{Kind(type)} {type.FullName}{(plain ? "" : $" : {type.BaseType.Name}")}");
                foreach (var member in type.GetMembers(Own).Where(IsVisible)) Console.WriteLine($"    {member.Name}");
            }
        }

        private static string Kind(Type type) =>
            type.IsEnum ? "enum" : type.IsValueType ? "struct" : type.IsInterface ? "interface" : "class";

        private static bool IsVisible(MemberInfo member) => member switch
        {
            FieldInfo field => !field.IsSpecialName && (field.IsPublic || field.IsFamily),
            PropertyInfo property => property.GetMethod != null && IsVisible(property.GetMethod.Attributes),
            EventInfo happening => happening.AddMethod.IsPublic,
            MethodInfo method => !method.IsSpecialName && IsVisible(method.Attributes),
            _ => false,
        };

        private static bool IsVisible(MethodAttributes method) =>
            (method & MethodAttributes.MemberAccessMask) is MethodAttributes.Public or MethodAttributes.Family;
    }
}
