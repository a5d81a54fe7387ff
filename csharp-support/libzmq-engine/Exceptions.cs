// NetMQ's exceptions: one type for each failure that a program may want to tell apart.
using System;

namespace NetMQ
{
    /// <summary>The base of what a socket throws; <see cref="ErrorCode"/> says why.</summary>
    [Serializable]
    public class NetMQException : Exception
    {
        /// <summary>An exception without a message.</summary>
        public NetMQException() { }

        /// <summary>An exception with a message.</summary>
        public NetMQException(string message) : base(message) { }

        /// <summary>An exception with a message and a cause.</summary>
        public NetMQException(string message, Exception innerException) : base(message, innerException) { }

        /// <summary>An exception with a number.</summary>
        protected NetMQException(Exception? innerException, string? message, ErrorCode errorCode)
            : base(message, innerException) => ErrorCode = errorCode;

        /// <summary>Why the operation failed.</summary>
        public ErrorCode ErrorCode { get; }

        /// <summary>The exception that belongs to a number.</summary>
        public static NetMQException Create(ErrorCode errorCode) => Create(errorCode, null, null);

        /// <summary>The exception that belongs to a number, with a cause.</summary>
        public static NetMQException Create(ErrorCode errorCode, Exception? innerException)
            => Create(errorCode, null, innerException);

        /// <summary>The exception that belongs to a number, with a message.</summary>
        public static NetMQException Create(string? message, ErrorCode errorCode) => Create(errorCode, message, null);

        private static NetMQException Create(ErrorCode code, string? message, Exception? cause) => code switch
        {
            ErrorCode.ContextTerminated => new TerminatingException(cause, message),
            ErrorCode.Invalid => new InvalidException(cause, message),
            ErrorCode.EndpointNotFound => new EndpointNotFoundException(cause, message),
            ErrorCode.AddressAlreadyInUse => new AddressAlreadyInUseException(cause, message),
            ErrorCode.ProtocolNotSupported => new ProtocolNotSupportedException(cause, message),
            ErrorCode.HostUnreachable => new HostUnreachableException(cause, message),
            ErrorCode.FiniteStateMachine => new FiniteStateMachineException(cause, message),
            ErrorCode.Fault => new FaultException(cause, message),
            _ => new NetMQException(cause, message, code),
        };
    }

    /// <summary>Another socket, in this process or another, has the address.</summary>
    [Serializable]
    public class AddressAlreadyInUseException : NetMQException
    {
        /// <summary>With a cause.</summary>
        public AddressAlreadyInUseException(Exception? innerException, string? message)
            : base(innerException, message, ErrorCode.AddressAlreadyInUse) { }

        /// <summary>With a message.</summary>
        public AddressAlreadyInUseException(string? message) : this(null, message) { }
    }

    /// <summary>Nothing is bound or connected to that address.</summary>
    [Serializable]
    public class EndpointNotFoundException : NetMQException
    {
        /// <summary>With a cause.</summary>
        public EndpointNotFoundException(Exception? innerException, string? message)
            : base(innerException, message, ErrorCode.EndpointNotFound) { }

        /// <summary>With a message.</summary>
        public EndpointNotFoundException(string? message) : this(null, message) { }

        /// <summary>Without a message.</summary>
        public EndpointNotFoundException() : this(null) { }
    }

    /// <summary>NetMQConfig.Cleanup was called while the socket was in use.</summary>
    [Serializable]
    public class TerminatingException : NetMQException
    {
        internal TerminatingException(Exception? innerException, string? message)
            : base(innerException, message, ErrorCode.ContextTerminated) { }

        /// <summary>With a message.</summary>
        public TerminatingException(string? message) : this(null, message) { }
    }

    /// <summary>A value that the operation cannot work with.</summary>
    [Serializable]
    public class InvalidException : NetMQException
    {
        /// <summary>With a cause.</summary>
        public InvalidException(Exception? innerException, string? message)
            : base(innerException, message, ErrorCode.Invalid) { }

        /// <summary>With a message.</summary>
        public InvalidException(string? message) : this(null, message) { }

        /// <summary>Without a message.</summary>
        public InvalidException() : this(null, null) { }
    }

    /// <summary>A message that was never initialised, or was closed.</summary>
    [Serializable]
    public class FaultException : NetMQException
    {
        internal FaultException(Exception? innerException, string? message)
            : base(innerException, message, ErrorCode.Fault) { }

        internal FaultException(string? message) : this(null, message) { }

        /// <summary>Without a message.</summary>
        public FaultException() : this(null, null) { }
    }

    /// <summary>The address begins with a protocol that does not exist here.</summary>
    [Serializable]
    public class ProtocolNotSupportedException : NetMQException
    {
        internal ProtocolNotSupportedException(Exception? innerException, string? message)
            : base(innerException, message, ErrorCode.ProtocolNotSupported) { }

        internal ProtocolNotSupportedException(string? message) : this(null, message) { }

        /// <summary>Without a message.</summary>
        public ProtocolNotSupportedException() : this(null, null) { }
    }

    /// <summary>A ROUTER with RouterMandatory has no peer with that identity.</summary>
    [Serializable]
    public class HostUnreachableException : NetMQException
    {
        internal HostUnreachableException(Exception? innerException, string? message)
            : base(innerException, message, ErrorCode.HostUnreachable) { }

        /// <summary>Without a message.</summary>
        public HostUnreachableException() : this(null, null) { }
    }

    /// <summary>A REQ or REP socket was used out of turn.</summary>
    [Serializable]
    public class FiniteStateMachineException : NetMQException
    {
        internal FiniteStateMachineException(Exception? innerException, string? message)
            : base(innerException, message, ErrorCode.FiniteStateMachine) { }

        /// <summary>Without a message.</summary>
        public FiniteStateMachineException() : this(null, null) { }
    }
}
