// All lessons but 16 are left out of a WebGL build, because NetMQ cannot work there. This says so in the browser's
// console, instead of a scene that does nothing.
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
            Debug.Log("NetMQExample needs its gateway in a browser, which has no sockets for NetMQ: lesson 16. "
                + "See docs/guide/devices.md.");
    }
}
#endif
