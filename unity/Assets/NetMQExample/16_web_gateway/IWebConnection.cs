// A WebSocket that carries text: by .NET in the editor, in a player and in a terminal, by the browser in a WebGL build.
using System;

namespace NetMQExample
{
    /// <summary>It is looked at once a frame, and nothing of it waits: a browser has no second thread.</summary>
    public interface IWebConnection : IDisposable
    {
        /// <summary>True from the moment at which the gateway has let us in, until either side leaves.</summary>
        bool IsOpen { get; }

        /// <summary>Why it is closed; null while it is open, or about to be.</summary>
        string Closed { get; }

        /// <summary>Sends a message; what can no longer be sent is dropped.</summary>
        void Send(string text);

        /// <summary>Takes a message that has come.</summary>
        /// <returns>False if there is none.</returns>
        bool TryReceive(out string text);
    }
}
