// The browser's own WebSocket, for a WebGL build: C# calls the few functions of BrowserConnection.jslib.
#if UNITY_WEBGL && !UNITY_EDITOR
using System.Runtime.InteropServices;

namespace NetMQExample
{
    /// <summary>A connection in a browser.</summary>
    public sealed class BrowserConnection : IWebConnection
    {
        private readonly int number;

        /// <summary>Begins to connect.</summary>
        /// <param name="address">A <c>ws://</c> or <c>wss://</c> address; a page of https needs the latter.</param>
        public BrowserConnection(string address) => number = KitWebOpen(WebText.Given("address", address));

        public bool IsOpen => KitWebIsOpen(number) != 0;
        public string Closed => KitWebClosed(number);

        public void Send(string text) => KitWebSend(number, text);
        public bool TryReceive(out string text) => (text = KitWebReceive(number)) != null;
        public void Dispose() => KitWebClose(number);

        [DllImport("__Internal")] private static extern int KitWebOpen(string address);
        [DllImport("__Internal")] private static extern int KitWebIsOpen(int number);
        [DllImport("__Internal")] private static extern string KitWebClosed(int number);
        [DllImport("__Internal")] private static extern void KitWebSend(int number, string text);
        [DllImport("__Internal")] private static extern string KitWebReceive(int number);
        [DllImport("__Internal")] private static extern void KitWebClose(int number);
    }
}
#endif
