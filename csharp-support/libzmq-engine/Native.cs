// libzmq itself: finds the library, loads it by its path, and turns its functions into delegates.
using System;
using System.Collections.Generic;
using System.IO;
using System.Reflection;
using System.Runtime.InteropServices;
using System.Text;

namespace NetMQ
{
    internal enum Option
    {
        Affinity = 4, RoutingId = 5, Subscribe = 6, Unsubscribe = 7, SendBuffer = 11, ReceiveBuffer = 12, Events = 15,
        Linger = 17, ReconnectInterval = 18, Backlog = 19, ReconnectIntervalMax = 21, MaxMsgSize = 22,
        SendHighWatermark = 23, ReceiveHighWatermark = 24, ReceiveTimeout = 27, SendTimeout = 28, LastEndpoint = 32,
        RouterMandatory = 33, TcpKeepalive = 34, TcpKeepaliveCount = 35, TcpKeepaliveIdle = 36,
        TcpKeepaliveInterval = 37, Immediate = 39, XPubVerbose = 40, IPv6 = 42, CurveServer = 47, CurvePublicKey = 48,
        CurveSecretKey = 49, CurveServerKey = 50, RequestCorrelate = 52, RequestRelaxed = 53, RouterHandover = 56,
        XPubWelcome = 72, HeartbeatInterval = 75, HeartbeatTtl = 76, HeartbeatTimeout = 77,
    }

    /// <summary>
    /// The functions of libzmq. There is no callback into managed code, so an assembly can be unloaded.
    /// </summary>
    internal sealed unsafe class Native
    {
        // SetLastError makes .NET's marshalling stub keep errno, which the runtime may overwrite right after the call.
        [UnmanagedFunctionPointer(CallingConvention.Cdecl, SetLastError = true)]
        internal delegate IntPtr NewContextCall();
        [UnmanagedFunctionPointer(CallingConvention.Cdecl, SetLastError = true)]
        internal delegate int HandleCall(IntPtr handle);
        [UnmanagedFunctionPointer(CallingConvention.Cdecl, SetLastError = true)]
        internal delegate int SetContextCall(IntPtr context, int option, int value);
        [UnmanagedFunctionPointer(CallingConvention.Cdecl, SetLastError = true)]
        internal delegate IntPtr NewSocketCall(IntPtr context, int type);
        [UnmanagedFunctionPointer(CallingConvention.Cdecl, SetLastError = true)]
        internal delegate int EndpointCall(IntPtr socket, byte* endpoint);
        [UnmanagedFunctionPointer(CallingConvention.Cdecl, SetLastError = true)]
        internal delegate int SetOptionCall(IntPtr socket, Option option, void* value, IntPtr size);
        [UnmanagedFunctionPointer(CallingConvention.Cdecl, SetLastError = true)]
        internal delegate int GetOptionCall(IntPtr socket, Option option, void* value, IntPtr* size);
        [UnmanagedFunctionPointer(CallingConvention.Cdecl, SetLastError = true)]
        internal delegate int SendCall(IntPtr socket, byte* data, IntPtr size, int flags);
        [UnmanagedFunctionPointer(CallingConvention.Cdecl, SetLastError = true)]
        internal delegate int ReceiveCall(byte* message, IntPtr socket, int flags);
        [UnmanagedFunctionPointer(CallingConvention.Cdecl, SetLastError = true)]
        internal delegate int PollCall(byte* items, int count, IntPtr timeout);
        [UnmanagedFunctionPointer(CallingConvention.Cdecl, SetLastError = true)]
        internal delegate int MonitorCall(IntPtr socket, byte* endpoint, int events);

        // These cannot fail in a way that errno would explain.
        [UnmanagedFunctionPointer(CallingConvention.Cdecl)]
        internal delegate int MessageCall(byte* message);
        [UnmanagedFunctionPointer(CallingConvention.Cdecl)]
        internal delegate byte* DataCall(byte* message);
        [UnmanagedFunctionPointer(CallingConvention.Cdecl)]
        internal delegate byte* ErrorTextCall(int error);
        [UnmanagedFunctionPointer(CallingConvention.Cdecl)]
        internal delegate int ErrorNumberCall();
        [UnmanagedFunctionPointer(CallingConvention.Cdecl)]
        internal delegate int KeysCall(byte* publicKey, byte* secretKey);
        [UnmanagedFunctionPointer(CallingConvention.Cdecl)]
        internal delegate byte* EncodeCall(byte* text, byte* data, IntPtr size);
        [UnmanagedFunctionPointer(CallingConvention.Cdecl)]
        internal delegate byte* DecodeCall(byte* data, byte* text);

        internal const int MessageSize = 64;
        internal const int DontWait = 1;
        internal const int SendMore = 2;
        internal const int Interrupted = 4;
        internal const int IOThreads = 1;
        internal const int MaxSockets = 2;

        internal static readonly bool IsWindows = RuntimeInformation.IsOSPlatform(OSPlatform.Windows);
        private static readonly bool isMac = RuntimeInformation.IsOSPlatform(OSPlatform.OSX);
        internal static readonly int Again = isMac ? 35 : 11;

        // On Windows libzmq's C runtime has an errno of its own, and Mono's stub for delegates keeps none.
        private static readonly bool keepsError
            = !IsWindows && RuntimeInformation.FrameworkDescription.StartsWith(".NET", StringComparison.Ordinal);

        // One failure has another number on each system: Linux, macOS, Windows.
        private static readonly (ErrorCode Code, int Linux, int Mac, int Windows)[] errors =
        {
            (ErrorCode.TryAgain, 11, 35, 11), (ErrorCode.InProgress, 115, 36, 112),
            (ErrorCode.ProtocolNotSupported, 93, 43, 135), (ErrorCode.AddressAlreadyInUse, 98, 48, 100),
            (ErrorCode.AddressNotAvailable, 99, 49, 101), (ErrorCode.NetworkDown, 100, 50, 116),
            (ErrorCode.NoBufferSpaceAvailable, 105, 55, 119), (ErrorCode.NotConnected, 107, 57, 126),
            (ErrorCode.ConnectionRefused, 111, 61, 107), (ErrorCode.HostUnreachable, 113, 65, 110),
            (ErrorCode.MessageSize, 90, 40, 115), (ErrorCode.AddressFamilyNotSupported, 97, 47, 102),
            (ErrorCode.NetworkUnreachable, 101, 51, 118), (ErrorCode.ConnectionAborted, 103, 53, 106),
            (ErrorCode.ConnectionReset, 104, 54, 108), (ErrorCode.TimedOut, 110, 60, 138),
            (ErrorCode.NetworkReset, 102, 52, 117), (ErrorCode.TooManyOpenSockets, 24, 24, 24),
        };

        private static Native? loaded;

        internal readonly NewContextCall NewContext;
        internal readonly HandleCall ShutdownContext;
        internal readonly HandleCall TerminateContext;
        internal readonly SetContextCall SetContext;
        internal readonly NewSocketCall NewSocket;
        internal readonly HandleCall Close;
        internal readonly EndpointCall Bind;
        internal readonly EndpointCall Connect;
        internal readonly EndpointCall Disconnect;
        internal readonly SetOptionCall SetOption;
        internal readonly GetOptionCall GetOption;
        internal readonly SendCall Send;
        internal readonly ReceiveCall Receive;
        internal readonly MessageCall InitMessage;
        internal readonly MessageCall CloseMessage;
        internal readonly MessageCall HasMore;
        internal readonly DataCall Data;
        internal readonly PollCall Poll;
        internal readonly MonitorCall Monitor;
        internal readonly KeysCall CurveKeys;
        internal readonly KeysCall CurvePublicKey;
        internal readonly EncodeCall EncodeZ85;
        internal readonly DecodeCall DecodeZ85;
        private readonly ErrorNumberCall errorNumber;
        private readonly ErrorTextCall errorText;

        private Native(IntPtr library)
        {
            NewContext = Find<NewContextCall>(library, "zmq_ctx_new");
            ShutdownContext = Find<HandleCall>(library, "zmq_ctx_shutdown");
            TerminateContext = Find<HandleCall>(library, "zmq_ctx_term");
            SetContext = Find<SetContextCall>(library, "zmq_ctx_set");
            NewSocket = Find<NewSocketCall>(library, "zmq_socket");
            Close = Find<HandleCall>(library, "zmq_close");
            Bind = Find<EndpointCall>(library, "zmq_bind");
            Connect = Find<EndpointCall>(library, "zmq_connect");
            Disconnect = Find<EndpointCall>(library, "zmq_disconnect");
            SetOption = Find<SetOptionCall>(library, "zmq_setsockopt");
            GetOption = Find<GetOptionCall>(library, "zmq_getsockopt");
            Send = Find<SendCall>(library, "zmq_send");
            Receive = Find<ReceiveCall>(library, "zmq_msg_recv");
            InitMessage = Find<MessageCall>(library, "zmq_msg_init");
            CloseMessage = Find<MessageCall>(library, "zmq_msg_close");
            HasMore = Find<MessageCall>(library, "zmq_msg_more");
            Data = Find<DataCall>(library, "zmq_msg_data");
            Poll = Find<PollCall>(library, "zmq_poll");
            Monitor = Find<MonitorCall>(library, "zmq_socket_monitor");
            CurveKeys = Find<KeysCall>(library, "zmq_curve_keypair");
            CurvePublicKey = Find<KeysCall>(library, "zmq_curve_public");
            EncodeZ85 = Find<EncodeCall>(library, "zmq_z85_encode");
            DecodeZ85 = Find<DecodeCall>(library, "zmq_z85_decode");
            errorNumber = Find<ErrorNumberCall>(library, "zmq_errno");
            errorText = Find<ErrorTextCall>(library, "zmq_strerror");
            // A first call is compiled, and compiling changes errno.
            errorNumber();
        }

        /// <summary>
        /// The library, loaded at the first use. Not a static constructor: its exception would be wrapped.
        /// </summary>
        internal static Native Instance => loaded ??= new Native(Load());

        /// <summary>The error of the last call on this thread.</summary>
        internal int Error => keepsError ? Marshal.GetLastWin32Error() : errorNumber();

        internal string ErrorText(int error) => Marshal.PtrToStringAnsi((IntPtr)errorText(error)) ?? "";

        internal static ErrorCode ToErrorCode(int error)
        {
            foreach (var (code, linux, mac, windows) in errors)
            {
                if (error == (IsWindows ? windows : isMac ? mac : linux)) return code;
            }
            // The remaining ones have the same number everywhere, among them libzmq's own.
            return (ErrorCode)error;
        }

        /// <summary>Text as C wants it: UTF-8 with a zero at the end.</summary>
        internal static byte[] CString(string text) => Encoding.UTF8.GetBytes(text + "\0");

        private static IntPtr Load()
        {
            foreach (var path in Candidates())
            {
                var library = Open(path);
                if (library != IntPtr.Zero) return library;
            }
            throw new DllNotFoundException("libzmq not found: " + (IsWindows
                ? "pyzmq 26 and later brings no DLL on Windows; take NetMQ from NuGet (--engine netmq), or set LIBZMQ "
                    + "to a libzmq.dll"
                : "pip install pyzmq, or set LIBZMQ to the library's path"));
        }

        private static IEnumerable<string> Candidates()
        {
            var chosen = Environment.GetEnvironmentVariable("LIBZMQ");
            if (!string.IsNullOrEmpty(chosen))
            {
                // Who names a library wants that one: a quiet fallback would hide the mistake.
                if (!File.Exists(chosen)) throw new DllNotFoundException($"LIBZMQ names no file: {chosen}");
                yield return chosen;
                yield break;
            }
            foreach (var note in typeof(Native).Assembly.GetCustomAttributes<AssemblyMetadataAttribute>())
            {
                if (note.Key == "libzmq" && note.Value is string path) yield return path;
            }
            var names = IsWindows ? new[] { "libzmq.dll", "libzmq-mt-4_3_5.dll", "libzmq-v142-mt-4_3_5.dll" }
                : isMac ? new[] { "libzmq.5.dylib", "/opt/homebrew/lib/libzmq.5.dylib",
                    "/usr/local/lib/libzmq.5.dylib" }
                : new[] { "libzmq.so.5", "libzmq.so" };
            foreach (var name in names) yield return name;
        }

        private static IntPtr Open(string path)
        {
            const int now = 2;
            const int alteredSearchPath = 8;
            try
            {
                // The altered search path lets a DLL find the ones beside it; elsewhere the library's RPATH does that.
                if (IsWindows) return LoadLibraryEx(path, IntPtr.Zero, Path.IsPathRooted(path) ? alteredSearchPath : 0);
                return isMac ? DlopenMac(CString(path), now) : DlopenLinux(CString(path), now);
            }
            catch (DllNotFoundException)
            {
                // A C library without a libdl of its own, such as musl.
                return DlopenC(CString(path), now);
            }
        }

        private static T Find<T>(IntPtr library, string name) where T : Delegate
        {
            IntPtr symbol;
            try
            {
                symbol = IsWindows ? GetProcAddress(library, name)
                    : isMac ? DlsymMac(library, CString(name)) : DlsymLinux(library, CString(name));
            }
            catch (DllNotFoundException)
            {
                symbol = DlsymC(library, CString(name));
            }
            if (symbol == IntPtr.Zero) throw new EntryPointNotFoundException($"libzmq is too old: it has no {name}");
            return Marshal.GetDelegateForFunctionPointer<T>(symbol);
        }

        [DllImport("kernel32", EntryPoint = "LoadLibraryExW", CharSet = CharSet.Unicode, ExactSpelling = true)]
        private static extern IntPtr LoadLibraryEx(string path, IntPtr reserved, int flags);
        [DllImport("kernel32", CharSet = CharSet.Ansi, ExactSpelling = true)]
        private static extern IntPtr GetProcAddress(IntPtr library, string name);
        [DllImport("libdl.so.2", EntryPoint = "dlopen")]
        private static extern IntPtr DlopenLinux(byte[] path, int flags);
        [DllImport("libdl.so.2", EntryPoint = "dlsym")]
        private static extern IntPtr DlsymLinux(IntPtr library, byte[] name);
        [DllImport("/usr/lib/libSystem.B.dylib", EntryPoint = "dlopen")]
        private static extern IntPtr DlopenMac(byte[] path, int flags);
        [DllImport("/usr/lib/libSystem.B.dylib", EntryPoint = "dlsym")]
        private static extern IntPtr DlsymMac(IntPtr library, byte[] name);
        [DllImport("libc", EntryPoint = "dlopen")]
        private static extern IntPtr DlopenC(byte[] path, int flags);
        [DllImport("libc", EntryPoint = "dlsym")]
        private static extern IntPtr DlsymC(IntPtr library, byte[] name);
    }
}
