"""Environments of Gymnasium and PettingZoo whose world is simulated elsewhere, such as in a Unity scene.

    import gymnasium
    import netmq_example.envs                                                 registers what is in ENVIRONMENTS

    env = gymnasium.make("NetMQExample/CartPole-v0")
    envs = gymnasium.make_vec("NetMQExample/CartPole-v0", num_envs=16)
    env = gymnasium.make("netmq_example.envs:NetMQExample/CartPole-v0")       needs no import of this package

The last form is Gymnasium's own: it imports the module before the colon. Its versions before 1.0 also called what an
entry point names; today's do not.
A class is imported when it is first used, as in `from netmq_example.envs import UnityParallelEnv`. Only those for
several agents need pettingzoo. A type checker, which imports nothing, finds them as well.
"""

import contextlib
import warnings
from typing import TYPE_CHECKING, Any

from netmq_example.doors import door

if TYPE_CHECKING:
    from netmq_example.envs.gym_env import UnityGymEnv
    from netmq_example.envs.parallel_env import UnityAECEnv, UnityParallelEnv
    from netmq_example.envs.plain_spaces import PlainSpaces
    from netmq_example.envs.side_channels import carry
    from netmq_example.envs.vector_env import UnityVectorEnv

registration: Any = None
# ML-Agents' classes need modules of this package, and by the scene's clock no gymnasium. Others name what they lack.
with contextlib.suppress(ModuleNotFoundError):
    from gymnasium.envs import registration

__all__ = ["PlainSpaces", "UnityAECEnv", "UnityGymEnv", "UnityParallelEnv", "UnityVectorEnv", "carry", "register"]
UNITY = {"entry_point": f"{__name__}:UnityGymEnv", "vector_entry_point": f"{__name__}:UnityVectorEnv"}
ENVIRONMENTS: dict[str, dict[str, Any]] = {
    "NetMQExample/CartPole-v0": {**UNITY, "kwargs": {"env_name": "CartPole"}, "max_episode_steps": 500},
    "NetMQExample/Car-v0": {**UNITY, "kwargs": {"env_name": "Car"}, "max_episode_steps": 1000},
    "NetMQExample/Unity-v0": UNITY,
}


def register() -> None:
    """Called by the import of this module; once more it changes nothing."""
    for name, words in ENVIRONMENTS.items():
        if registration and name not in registration.registry:
            registration.register(name, **words)


# The names of version 0.3, for one version more.
FORMER = {"ZmqEnv": "UnityGymEnv", "ZmqVectorEnv": "UnityVectorEnv", "ZmqParallelEnv": "UnityParallelEnv"}

# Hidden from a type checker, to which any name would exist.
if not TYPE_CHECKING:
    ROOMS = {
        "gym_env": "UnityGymEnv",
        "parallel_env": "UnityAECEnv UnityParallelEnv",
        "plain_spaces": "PlainSpaces",
        "side_channels": "carry",
        "vector_env": "UnityVectorEnv",
    }
    load, __dir__ = door(__name__, ROOMS)

    def __getattr__(name):
        if name in FORMER:
            warnings.warn(f"{name} is {FORMER[name]} now, and its name= is env_name=", DeprecationWarning, stacklevel=2)
        return load(FORMER.get(name, name))


register()
