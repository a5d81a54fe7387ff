// The lessons are left out of a WebGL build, because NetMQ cannot work there. This says so in the browser's console,
// instead of a scene that does nothing.
#if UNITY_WEBGL && !UNITY_EDITOR
using UnityEngine;

// Nothing refers to this assembly, so the linker would drop it.
[assembly: UnityEngine.Scripting.AlwaysLinkAssembly]

namespace NetMQExample
{
    internal static class NotInABrowser
    {
        [RuntimeInitializeOnLoadMethod(RuntimeInitializeLoadType.BeforeSceneLoad)]
        private static void Say() =>
            Debug.LogError("NetMQExample does not run in a browser: it has no TCP sockets and no threads for NetMQ. See docs/guide/devices.md.");
    }
}
#endif
