// A component tells the rest of the game by the inspector, without a script, and by a C# event.
//
//     [SerializeField, Tooltip("With each reply")] private Arrival<string> replied = new();
//     public event Action<string> Replied { add => replied.Raised += value; remove => replied.Raised -= value; }
using System;
using UnityEngine.Events;

namespace NetMQExample
{
    /// <summary>An event that the inspector wires, and that scripts add themselves to.</summary>
    /// <typeparam name="T">What arrives.</typeparam>
    [Serializable]
    public sealed class Arrival<T> : UnityEvent<T>
    {
        public event Action<T> Raised;

        /// <summary>Calls what is wired, then the scripts. For the main thread.</summary>
        public void Raise(T value)
        {
            Invoke(value);
            Raised?.Invoke(value);
        }
    }
}
