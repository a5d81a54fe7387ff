"""The exceptions of mlagents_envs.exception that a side channel raises or catches, with the same names."""


class UnityException(Exception):
    """Anything that ML-Agents, or a channel written for it, has to say in one line."""


class UnityCommunicationException(UnityException):
    """A message went the wrong way, such as settings that came from Unity."""


class UnitySideChannelException(UnityException):
    """What is wrong with a message, a channel or a setting."""
