// For a client whose socket belongs to one call at a time: two would read each other's replies.
//
//     private readonly OneAtATime calls = new OneAtATime(nameof(ManyRequester));
//     …
//     using var alone = calls.Begin();
using System;
using System.Threading;

namespace NetMQExample
{
    /// <summary>Refuses a call beside another one, on the same thread or not.</summary>
    internal sealed class OneAtATime : IDisposable
    {
        private readonly string name;
        private int underWay;

        /// <param name="name">The client's class, for whoever is refused.</param>
        public OneAtATime(string name) => this.name = name;

        /// <summary>Dispose what this returns at the end of the call.</summary>
        /// <exception cref="InvalidOperationException">Another one has not ended.</exception>
        public IDisposable Begin()
        {
            if (Interlocked.Exchange(ref underWay, 1) == 0) return this;
            throw new InvalidOperationException(
                $"this {name} has not ended what it does: wait for that, or make a second {name}");
        }

        public void Dispose() => Volatile.Write(ref underWay, 0);
    }
}
