// It is thrown when something will not be done, though nobody waited too long for it: that is a TimeoutException.
// In Python: errors.py.
using System.IO;

namespace NetMQExample
{
    /// <summary>It was refused or aborted. The message says by whom and why.</summary>
    public sealed class GaveUpException : IOException
    {
        public GaveUpException(string message) : base(message) { }
    }
}
