"""Stable-Baselines3: many agents as its VecEnv.

    from netmq_example.sb3 import PlainSpaces, UnityVecEnv

    envs = UnityVecEnv("NetMQExample/CartPole-v0", 16, launch=…)              what gymnasium.make_vec takes
    PPO("MlpPolicy", VecMonitor(envs)).learn(100_000)

It also takes an environment that `gymnasium.make_vec` has made, with autoreset_mode="SameStep". Its policies take
arrays, and a dict of arrays: other spaces become plain as in envs/plain_spaces.py, whose PlainSpaces is for one agent.

For MaskablePPO of sb3-contrib an agent has a part `action_mask` in its observation, or in its info. For hindsight
replay, `compute_reward` is one more word: a function of what was achieved, what was desired, and infos.

It needs stable-baselines3, which needs torch.
"""

import copy
import importlib
import warnings
from collections.abc import Callable
from typing import TYPE_CHECKING, Any

from netmq_example.extras import without

try:
    import gymnasium
    import numpy as np
    from gymnasium.utils.env_checker import data_equivalence
    from gymnasium.vector import AutoresetMode
    from stable_baselines3.common.vec_env import VecEnv
except ImportError as error:
    raise without(error) from None

from netmq_example.envs import UNITY
from netmq_example.envs.plain_spaces import Plain, PlainSpaces
from netmq_example.envs.vector_env import UnityVectorEnv

__all__ = ["PlainSpaces", "UnityVecEnv"]


class UnityVecEnv(VecEnv):  # type: ignore[misc, unused-ignore]
    """All agents of a scene, or all simulators of a fleet: an id and how many, or what `make_vec` has made."""

    def __init__(
        self, envs: Any, num_envs: int = 1, compute_reward: Callable[..., Any] | None = None, **words: Any
    ) -> None:
        self.envs = made(envs, num_envs, words) if isinstance(envs, str) else envs
        if self.envs.metadata["autoreset_mode"] != AutoresetMode.SAME_STEP:
            raise ValueError('Stable-Baselines3 wants the next episode at once: make_vec(…, autoreset_mode="SameStep")')
        self.plain = Plain(self.envs.single_observation_space, self.envs.single_action_space)
        # Each one's infos are those of an environment of this package as they were sent, and of a wrapper as it has
        # gathered them.
        self.exact = isinstance(self.envs, UnityVectorEnv)
        # What is seen now, as the scene has it, and what was said with it.
        self.seen: Any = None
        self.said: list[dict[str, Any]] = []
        if compute_reward:
            self.compute_reward = compute_reward
        super().__init__(self.envs.num_envs, self.plain.observation_space, self.plain.action_space)
        # VecVideoRecorder takes its rate from here.
        self.metadata = self.envs.metadata

    def reset(self) -> Any:
        options, *others = self._options
        if not all(data_equivalence(options, other) for other in others):
            raise ValueError("the agents are one simulator: set_options takes one dict for all of them")
        self.seen, infos = self.envs.reset(seed=self._seeds, options=options)
        self.said = self.reset_infos = self.each(infos)
        # Both are for one reset.
        self._reset_seeds()
        self._reset_options()
        return self.plain.look(self.seen, self.num_envs)

    def step_async(self, actions: Any) -> None:
        self.actions = self.plain.choose(np.asarray(actions, self.action_space.dtype))

    def step_wait(self) -> Any:
        self.seen, rewards, terminated, truncated, infos = self.envs.step(self.actions)
        over = terminated | truncated
        said = self.said = self.each(infos)
        if over.any():
            said = self.ended(infos, np.flatnonzero(over).tolist(), truncated & ~terminated)
        return self.plain.look(self.seen, self.num_envs), rewards.astype(np.float32), over, said

    def each(self, infos: dict[str, Any]) -> list[dict[str, Any]]:
        if self.exact:
            return self.envs.infos.listed()  # type: ignore[no-any-return]
        return [said_of(infos, agent) for agent in range(self.num_envs)]

    def ended(self, infos: dict[str, Any], agents: list[int], by_time: Any) -> list[dict[str, Any]]:
        """Infos of the last step of their episodes; those with the first observation of the next are in reset_infos."""
        said = list(self.said)
        self.reset_infos = list(self.reset_infos)
        for agent in agents:
            one = said[agent]
            final = self.envs.final_infos[agent] if self.exact else one.pop("final_info", {})
            self.reset_infos[agent] = one
            # The time was up, and not the world at its end: PPO then adds what it expects from the last observation.
            said[agent] = {
                # A wrapper, such as RecordEpisodeStatistics, has added its own.
                **({} if self.exact else one),
                **final,
                "terminal_observation": self.plain.look(infos["final_obs"][agent]),
                "TimeLimit.truncated": bool(by_time[agent]),
            }
        return said

    def action_masks(self) -> Any:
        """Of each agent what it may do now. AttributeError: nobody says it."""
        if isinstance(self.seen, dict) and "action_mask" in self.seen:
            return row_of(self.seen["action_mask"], (self.num_envs, -1))
        if not self.said:
            raise ValueError("nobody has said what may be done: call reset first")
        if not all("action_mask" in one for one in self.said):
            raise AttributeError("no action_mask is in what the agents see, and not in each one's info")
        return np.stack([row_of(one["action_mask"], (-1,)) for one in self.said])

    def get_images(self) -> list[Any]:
        return list(self.envs.render() or [])

    def close(self) -> None:
        self.envs.close()

    @property
    def simulators(self) -> Any:
        # Lesson 13's carry looks for it.
        return self.envs.unwrapped.simulators

    def is_own(self, name: str) -> bool:
        """Whether it is of this one or of a class derived from it, and not what each environment would have."""
        return hasattr(self, name) and not hasattr(VecEnv, name)

    def get_attr(self, attr_name: str, indices: Any = None) -> list[Any]:
        agents = list(self._get_indices(indices))
        if attr_name == "action_masks" and self.said:
            # Whether there are any: MaskablePPO asks so.
            self.action_masks()
        if self.is_own(attr_name):
            return [getattr(self, attr_name)] * len(agents)
        values = self.envs.unwrapped.get_attr(attr_name)
        return [values[agent] for agent in agents]

    def set_attr(self, attr_name: str, value: Any, indices: Any = None) -> None:
        if {*self._get_indices(indices)} != {*range(self.num_envs)}:
            raise ValueError(f"{attr_name} is the same for all agents: leave out indices")
        if self.is_own(attr_name):
            setattr(self, attr_name, value)
        else:
            self.envs.unwrapped.set_attr(attr_name, value)

    def env_method(self, method_name: str, *method_args: Any, indices: Any = None, **method_kwargs: Any) -> list[Any]:
        agents = list(self._get_indices(indices))
        if method_name == "action_masks":
            values = self.action_masks()
        elif self.is_own(method_name):
            values = [getattr(self, method_name)(*method_args, **method_kwargs)] * self.num_envs
        else:
            values = self.envs.unwrapped.call(method_name, *method_args, **method_kwargs)
        return [values[agent] for agent in agents]

    def env_is_wrapped(self, wrapper_class: Any, indices: Any = None) -> list[bool]:
        return [False for _ in self._get_indices(indices)]


def made(name: str, num_envs: int, words: dict[str, Any]) -> Any:
    module, _, name = name.rpartition(":")
    if module:
        importlib.import_module(module)
    spec = copy.deepcopy(gymnasium.spec(name))
    if spec.entry_point == UNITY["entry_point"]:
        # Also where it was registered without that.
        spec.vector_entry_point = UNITY["vector_entry_point"]
    words = {"vectorization_mode": "vector_entry_point", "autoreset_mode": AutoresetMode.SAME_STEP, **words}
    return gymnasium.make_vec(spec, num_envs, **words)


def said_of(infos: dict[str, Any], agent: int) -> dict[str, Any]:
    """The info of one agent in a vector's infos, where _name beside a name says who has one."""
    said = {}
    for name, values in infos.items():
        mask = infos.get(f"_{name}")
        is_mask = name[:1] == "_" and name[1:] in infos
        if name != "final_obs" and not is_mask and (mask is None or mask[agent]):
            said[name] = said_of(values, agent) if isinstance(values, dict) else values[agent]
    return said


def row_of(mask: Any, shape: tuple[int, ...]) -> Any:
    """Those of several choices stand one after the other."""
    parts = mask if isinstance(mask, tuple | list) else [mask]
    return np.concatenate([np.reshape(part, shape) for part in parts], axis=-1) > 0


# The name of version 0.3, for one version more.
if not TYPE_CHECKING:

    def __getattr__(name):
        if name != "Areas":
            raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
        warnings.warn("Areas is UnityVecEnv now, which also takes an id", DeprecationWarning, stacklevel=2)
        return UnityVecEnv
