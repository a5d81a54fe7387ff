// Lesson 13, mistakes in a message, a channel or a setting, and in an agent of ML-Agents' shape.
using System;

namespace NetMQExample.MLAgents
{
    /// <summary>A mistake of a script, in one line that says how to mend it.</summary>
    public class UnityAgentsException : Exception
    {
        public UnityAgentsException(string message) : base(message) { }
        public UnityAgentsException(string message, Exception innerException) : base(message, innerException) { }

        /// <summary>Returns a number, unless it is none: Python's trainers would learn nothing from it.</summary>
        internal static float Finite(float number, string method) =>
            float.IsNaN(number) || float.IsInfinity(number)
                ? throw new UnityAgentsException(
                    FormattableString.Invariant($"{method} was given {number}: look for a division by 0 in the script"))
                : number;
    }
}
