// Lesson 04 with await: var reply = await client.RequestAsync("hello", destroyCancellationToken);
//
// The main thread goes on in a later Poll, so call Poll in Update as before.
using System;
using System.Threading;
using System.Threading.Tasks;

namespace NetMQExample
{
    /// <summary>A request to await instead of callbacks.</summary>
    public static class BackgroundClientAsync
    {
        /// <summary>Sends a request. Its task ends inside Poll, and what awaits it goes on there.</summary>
        /// <param name="text">The request, sent as UTF-8.</param>
        /// <param name="cancel">Ends the wait at once. The server may do the request all the same.</param>
        /// <exception cref="TimeoutException">No try was answered; the request may have been done all the
        /// same.</exception>
        /// <exception cref="GaveUpException">Refused: too many requests are under way.</exception>
        /// <exception cref="ObjectDisposedException">The client was disposed.</exception>
        /// <exception cref="ArgumentException">The text is too long, or the endpoint's host unknown.</exception>
        public static async Task<string> RequestAsync(this BackgroundClient client, string text,
            CancellationToken cancel = default)
        {
            cancel.ThrowIfCancellationRequested();
            // Not RunContinuationsAsynchronously: that would go on in a thread of the pool.
            var answer = new TaskCompletionSource<string>();
            Action<Exception> error = why => answer.TrySetException(why);
            if (!client.Begin(text, reply => answer.TrySetResult(reply), error))
                throw client.State == ClientState.Disposed
                    ? (Exception)new ObjectDisposedException(null, "the client was disposed")
                    : new GaveUpException("refused: too many requests are under way");
            using (cancel.Register(() => answer.TrySetCanceled(cancel))) return await answer.Task;
        }

#if UNITY_6000_0_OR_NEWER
        /// <summary>The same as Unity 6 has it: an Awaitable, which can be awaited once.</summary>
        public static async UnityEngine.Awaitable<string> RequestAwaitable(this BackgroundClient client, string text,
            CancellationToken cancel = default) => await client.RequestAsync(text, cancel);
#endif
    }
}
