"""The exceptions of mlagents_envs.exception, with the same names; those that Python has a name for are that as well.

All of them are the kit's Error, and all can be pickled: a trainer's workers send them to each other.
"""

from netmq_example.errors import Error


class UnityException(Error):
    """Anything that ML-Agents, or a channel written for it, has to say in one line."""


class UnityEnvironmentException(UnityException, OSError):
    """A build does not start, or the environment is closed."""


class UnityWorkerInUseException(UnityException, OSError):
    """Nothing can listen on the port of this worker: mostly because another program does. `why` is more about it."""

    MESSAGE_TEMPLATE = "the port of worker {} is in use: close what has it, or give another worker_id or base_port"

    def __init__(self, worker_id: object, why: str = "") -> None:
        super().__init__(worker_id, why)

    def __str__(self) -> str:
        worker, why = self.args
        # Libraries make an error again of its text.
        if not isinstance(worker, int):
            return str(worker)
        return self.MESSAGE_TEMPLATE.format(worker) + (f" ({why})" if why else "")


class UnityTimeOutException(UnityException, TimeoutError):
    """No simulator came."""


class UnityCommunicationException(UnityException):
    """A message went the wrong way, such as settings that came from Unity, or the simulator refuses it, or is lost."""


class UnityCommunicatorStoppedException(UnityCommunicationException):
    """The simulator is lost."""


class UnityActionException(UnityException, ValueError):
    """An action of another shape, or for nobody."""


class UnityObservationException(UnityException):
    """An observation that ML-Agents' classes cannot have."""


class UnitySideChannelException(UnityException):
    """What is wrong with a message, a channel or a setting."""


class UnityPolicyException(UnityException):
    """There for a loop that catches it: trainers raise it."""


class NoSteps(UnityException, KeyError):
    """There are no steps of this agent, or none yet. ML-Agents has a bare KeyError."""

    # A KeyError's own shows its argument between quotation marks.
    __str__ = Exception.__str__


class NoRequest(UnityActionException, IndexError):
    """An action for an agent that wants none now. ML-Agents has a bare IndexError."""
