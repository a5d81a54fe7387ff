// Which MonoBehaviours a scene holds: those of a lesson's folder, or all of a reader's own scripts.
using System;
using System.Collections.Generic;
using System.Linq;
using System.Reflection;
using UnityEngine;

namespace UnityPlayer
{
    public static class Scripts
    {
        // For scenes of one's own: no lesson's scene has them.
        private static readonly string[] Spare = { "RaySensor" };

        /// <summary>Every MonoBehaviour of a reader's own, and those of the kit's that kit.py has noted.</summary>
        /// <exception cref="ArgumentException">There is none.</exception>
        public static Type[] Of(Assembly own, Assembly kit)
        {
            var noted = own.GetCustomAttributes<AssemblyMetadataAttribute>()
                .ToLookup(data => data.Value, data => data.Key);
            // A class within another one is no script of Unity's: others add it.
            var found = own.GetTypes().Where(type => !type.IsNested)
                .Where(type => !noted["unnamed"].Contains(type.Name) || kit.GetType(type.FullName) == null)
                .Concat(kit.GetTypes().Where(type => noted["script"].Contains(type.Name)))
                .Where(type => typeof(MonoBehaviour).IsAssignableFrom(type) && !type.IsAbstract).ToArray();
            return found.Length > 0 ? found : throw new ArgumentException("there is no MonoBehaviour in these files");
        }

        /// <summary>The MonoBehaviours of a lesson.</summary>
        /// <param name="assembly">The scripts, with the names of their files as NetMQExample.csproj writes them
        /// down.</param>
        /// <param name="lesson">Such as 1, 01 or 01_request_reply.</param>
        /// <exception cref="ArgumentException">There is no such lesson; the message says which there are.</exception>
        public static Type[] Of(Assembly assembly, string lesson)
        {
            // Unity finds a script's class by the name of its file, in whatever namespace, and so does this.
            var classes = assembly.GetTypes().Where(type => !type.IsNested).ToLookup(type => type.Name);
            var found = assembly.GetCustomAttributes<AssemblyMetadataAttribute>()
                .Where(data => data.Value == "script")
                .Select(data => data.Key.Split('/', '\\'))
                // ML-Agents' shape has names of its own for what lessons have, and no lesson.
                .Where(path => path[0] != "MLAgents")
                .Select(path => (Lesson: path[0], Type: classes[path[path.Length - 1]]
                    .OrderBy(type => type.Namespace?.Contains(".MLAgents") == true).FirstOrDefault()))
                .Where(script => typeof(MonoBehaviour).IsAssignableFrom(script.Type) && !script.Type.IsAbstract
                    && !Spare.Contains(script.Type.Name))
                .ToLookup(script => script.Lesson.Substring(0, 2), script => script.Type);
            var number = lesson.Split('_')[0].PadLeft(2, '0');
            if (found.Contains(number)) return found[number].ToArray();
            var known = string.Join(" ", found.Select(group => group.Key).OrderBy(key => key, StringComparer.Ordinal));
            throw new ArgumentException($"which lesson? Give its number first, one of: {known}");
        }

        /// <summary>Gives an object one of each. One may have brought another along, by RequireComponent; and who needs
        /// one of a base class waits for the others, since else that base would come as well.</summary>
        public static MonoBehaviour[] AddTo(GameObject thing, IEnumerable<Type> types)
        {
            var all = types.ToArray();
            bool Needs(Type type) => type.GetCustomAttributes<RequireComponent>()
                .Any(need => all.Any(one => one != type && need.m_Type0.IsAssignableFrom(one)));
            foreach (var type in all.OrderBy(Needs))
                if (thing.GetComponent(type) == null) thing.AddComponent(type);
            return all.Select(type => thing.GetComponent(type)).OfType<MonoBehaviour>().ToArray();
        }
    }
}
