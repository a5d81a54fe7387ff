// Unity's Mono can abort a thread, and .NET cannot.
using System.Threading;
using UnityEngine;

/// <summary>In no namespace: `kit.py play` calls it wherever a script calls Abort of a thread.</summary>
public static class MonoThreads
{
    /// <summary>Says that the thread goes on, where .NET would throw. It keeps no process, as one that was
    /// aborted.</summary>
    public static void AbortAsOnMono(this Thread thread)
    {
        try
        {
            thread.IsBackground = true;
            Debug.LogWarning(
                "Thread.Abort: Unity's Mono can end a thread so, .NET cannot: "
                + "first close the socket that it waits for, and let it end");
        }
        catch (ThreadStateException) { /* It has ended. */ }
    }
}
