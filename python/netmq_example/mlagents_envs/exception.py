"""The exceptions of mlagents_envs.exception, with the same names; those that Python has a name for are that as well."""

__all__ = [
    "UnityActionException",
    "UnityCommunicationException",
    "UnityCommunicatorStoppedException",
    "UnityEnvironmentException",
    "UnityException",
    "UnityObservationException",
    "UnitySideChannelException",
    "UnityTimeOutException",
    "UnityWorkerInUseException",
]


class UnityException(Exception):
    """Anything that ML-Agents, or a channel written for it, has to say in one line."""


class UnityEnvironmentException(UnityException, OSError):
    """A build does not start."""


class UnityWorkerInUseException(UnityException, OSError):
    """Nothing can listen on this port: mostly because another program does."""


class UnityTimeOutException(UnityException, TimeoutError):
    """No simulator came."""


class UnityCommunicationException(UnityException):
    """A message went the wrong way, such as settings that came from Unity, or the simulator is lost."""


class UnityCommunicatorStoppedException(UnityCommunicationException):
    """The simulator is lost."""


class UnityActionException(UnityException, ValueError):
    """An action of another shape, or for nobody."""


class UnityObservationException(UnityException):
    """There for a loop that catches it: MessageError says what is wrong with an observation."""


class UnitySideChannelException(UnityException):
    """What is wrong with a message, a channel or a setting."""
