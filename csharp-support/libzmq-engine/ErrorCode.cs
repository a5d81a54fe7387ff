// NetMQ's error numbers, with its values.
namespace NetMQ
{
    /// <summary>Why an operation failed.</summary>
    public enum ErrorCode
    {
        /// <summary>No such endpoint.</summary>
        EndpointNotFound = 2,
        /// <summary>Not permitted.</summary>
        AccessDenied = 13,
        /// <summary>A bad pointer or an uninitialised message.</summary>
        Fault = 14,
        /// <summary>An invalid argument.</summary>
        Invalid = 22,
        /// <summary>Not now.</summary>
        TryAgain = 35,
        /// <summary>Already under way.</summary>
        InProgress = 36,
        /// <summary>No such protocol.</summary>
        ProtocolNotSupported = 43,
        /// <summary>Another socket has this address.</summary>
        AddressAlreadyInUse = 48,
        /// <summary>This machine has no such address.</summary>
        AddressNotAvailable = 49,
        /// <summary>The network is down.</summary>
        NetworkDown = 50,
        /// <summary>The system has no buffer left.</summary>
        NoBufferSpaceAvailable = 55,
        /// <summary>Not connected.</summary>
        NotConnected = 57,
        /// <summary>The peer refused.</summary>
        ConnectionRefused = 61,
        /// <summary>No peer with that identity.</summary>
        HostUnreachable = 65,
        /// <summary>Where ZeroMQ's own numbers begin.</summary>
        BaseErrorNumber = 156384712,
        /// <summary>The message is too large.</summary>
        MessageSize = BaseErrorNumber + 10,
        /// <summary>No such address family.</summary>
        AddressFamilyNotSupported = BaseErrorNumber + 11,
        /// <summary>No route to that network.</summary>
        NetworkUnreachable = BaseErrorNumber + 12,
        /// <summary>The connection was aborted.</summary>
        ConnectionAborted = BaseErrorNumber + 13,
        /// <summary>The peer reset the connection.</summary>
        ConnectionReset = BaseErrorNumber + 14,
        /// <summary>Took too long.</summary>
        TimedOut = BaseErrorNumber + 16,
        /// <summary>The network dropped the connection.</summary>
        NetworkReset = BaseErrorNumber + 18,
        /// <summary>Not allowed in the socket's present state.</summary>
        FiniteStateMachine = BaseErrorNumber + 51,
        /// <summary>The context was terminated.</summary>
        ContextTerminated = BaseErrorNumber + 53,
        /// <summary>No I/O thread.</summary>
        EmptyThread = BaseErrorNumber + 54,
        /// <summary>No further socket possible.</summary>
        TooManyOpenSockets = BaseErrorNumber + 107,
    }
}
