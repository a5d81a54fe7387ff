"""Environments of Gymnasium and PettingZoo whose world is simulated elsewhere, such as in a Unity scene.

    import gymnasium
    import netmq_example.envs                                                 registers what is in ENVIRONMENTS

    env = gymnasium.make("NetMQExample/CartPole-v0")
    envs = gymnasium.make_vec("NetMQExample/CartPole-v0", num_envs=16)
    env = gymnasium.make("netmq_example.envs:NetMQExample/CartPole-v0")       needs no import of this package

The last form is Gymnasium's own: it imports the module before the colon. Its versions before 1.0 also called what an
entry point names; today's do not.
A class is imported when it is first used, as in `from netmq_example.envs import ZmqParallelEnv`. Only those for several
agents need pettingzoo. A type checker, which imports nothing, finds them as well.
"""

from typing import TYPE_CHECKING, Any

from netmq_example.doors import door
from netmq_example.extras import without

if TYPE_CHECKING:
    from netmq_example.envs.gym_env import ZmqEnv
    from netmq_example.envs.parallel_env import ZmqParallelEnv
    from netmq_example.envs.unity_env import UnityGymEnv
    from netmq_example.envs.unity_parallel_env import UnityAECEnv, UnityParallelEnv
    from netmq_example.envs.unity_vector_env import UnityVectorEnv
    from netmq_example.envs.vector_env import ZmqVectorEnv

try:
    from gymnasium.envs import registration
except ImportError as error:
    raise without(error) from None

__all__ = [
    "UnityAECEnv",
    "UnityGymEnv",
    "UnityParallelEnv",
    "UnityVectorEnv",
    "ZmqEnv",
    "ZmqParallelEnv",
    "ZmqVectorEnv",
    "register",
]
WORLD = {
    "entry_point": "netmq_example.envs.gym_env:ZmqEnv",
    "vector_entry_point": "netmq_example.envs.vector_env:ZmqVectorEnv",
}
ENVIRONMENTS: dict[str, dict[str, Any]] = {
    "NetMQExample/CartPole-v0": {**WORLD, "kwargs": {"name": "CartPole"}, "max_episode_steps": 500},
    "NetMQExample/Car-v0": {**WORLD, "kwargs": {"name": "Car"}, "max_episode_steps": 1000},
    "NetMQExample/Unity-v0": {
        "entry_point": "netmq_example.envs.unity_env:UnityGymEnv",
        "vector_entry_point": "netmq_example.envs.unity_vector_env:UnityVectorEnv",
    },
}


def register() -> None:
    """Called by the import of this module; once more it changes nothing."""
    for name, words in ENVIRONMENTS.items():
        if name not in registration.registry:
            registration.register(name, **words)


# Hidden from a type checker, to which any name would exist.
if not TYPE_CHECKING:
    ROOMS = {
        "gym_env": "ZmqEnv",
        "parallel_env": "ZmqParallelEnv",
        "unity_env": "UnityGymEnv",
        "unity_parallel_env": "UnityAECEnv UnityParallelEnv",
        "unity_vector_env": "UnityVectorEnv",
        "vector_env": "ZmqVectorEnv",
    }
    __getattr__, __dir__ = door(__name__, ROOMS)


register()
