"""Stable-Baselines3: many areas as its VecEnv, and a scene's spaces as its policies take them.

    from netmq_example.sb3 import Areas, PlainSpaces

    envs = gymnasium.make_vec("NetMQExample/CartPole-v0", 16, autoreset_mode="SameStep", launch=…)
    PPO("MlpPolicy", VecMonitor(Areas(envs))).learn(100_000)

    env = PlainSpaces(gymnasium.make("NetMQExample/Unity-v0", env_name="Coins", …))
    PPO("MultiInputPolicy", env).learn(100_000)

It needs stable-baselines3, which needs torch.
"""

from collections.abc import Callable
from typing import Any

import gymnasium
import numpy as np
from gymnasium import spaces
from gymnasium.spaces import Space
from gymnasium.vector import AutoresetMode
from stable_baselines3.common.vec_env import VecEnv

# How many items of a sequence a policy sees.
MOST_ITEMS = 8


class Areas(VecEnv):  # type: ignore[misc, unused-ignore]
    """All areas of a simulator, all agents of a scene, or all simulators of a fleet, as `make_vec` has made them."""

    def __init__(self, envs: Any) -> None:
        if envs.metadata["autoreset_mode"] != AutoresetMode.SAME_STEP:
            raise ValueError('Stable-Baselines3 wants the next episode at once: make_vec(…, autoreset_mode="SameStep")')
        self.envs = envs
        super().__init__(envs.num_envs, envs.single_observation_space, envs.single_action_space)

    def reset(self) -> Any:
        self.seen, _ = self.envs.reset(seed=self._seeds)
        self._reset_seeds()
        return self.seen

    def step_async(self, actions: Any) -> None:
        self.actions = np.asarray(actions, self.action_space.dtype)

    def step_wait(self) -> Any:
        before = self.seen
        self.seen, rewards, terminated, truncated, infos = self.envs.step(self.actions)
        over = terminated | truncated
        said: list[dict[str, Any]] = [{} for _ in range(self.num_envs)]
        known = infos.get("_final_obs", np.zeros(self.num_envs, bool))
        for area in np.flatnonzero(over):
            # The time was up, and not the world at its end: PPO then adds what it expects from the last observation.
            # Of an area that was lost while others began anew it is the one before.
            last = infos["final_obs"][area] if known[area] else of_one(before, int(area))
            by_time = bool(truncated[area] and not terminated[area])
            said[area] = {"terminal_observation": last, "TimeLimit.truncated": by_time}
        return self.seen, rewards.astype(np.float32), over, said

    def get_images(self) -> list[Any]:
        return list(self.envs.render() or [])

    def close(self) -> None:
        self.envs.close()

    def get_attr(self, name: str, indices: Any = None) -> list[Any]:
        values = self.envs.get_attr(name)
        return [values[area] for area in self._get_indices(indices)]

    def set_attr(self, name: str, value: Any, indices: Any = None) -> None:
        self.envs.set_attr(name, value)

    def env_method(self, name: str, *words: Any, indices: Any = None, **options: Any) -> list[Any]:
        values = self.envs.call(name, *words, **options)
        return [values[area] for area in self._get_indices(indices)]

    def env_is_wrapped(self, wrapper: Any, indices: Any = None) -> list[bool]:
        return [False for _ in self._get_indices(indices)]


def of_one(batch: Any, area: int) -> Any:
    return {key: part[area] for key, part in batch.items()} if isinstance(batch, dict) else batch[area]


class PlainSpaces(gymnasium.Wrapper[Any, Any, Any, Any]):
    """What is seen becomes a Dict of arrays, and what is done one array from -1 to 1.

    A part of a part has both keys, as `last_push`. Of a sequence of arrays the first 8 are seen, and zeros in place of
    those that are not there. Texts and graphs are left out. Of what is done, a number of a box goes from its lowest to
    its highest; of a discrete space there is a number for each choice, and the largest one is done.
    """

    def __init__(self, env: gymnasium.Env[Any, Any]) -> None:
        super().__init__(env)
        parts = list(parts_of(env.observation_space, "", lambda value: value))
        self.seen = dict(parts)
        if not parts or len(self.seen) < len(parts):
            raise ValueError(f"nothing is left, or two parts have one name: {[key for key, _ in parts]}")
        self.observation_space = spaces.Dict({key: space for key, (space, _) in self.seen.items()})
        self.numbers = sum(count for count, _ in done_by(env.action_space))
        self.action_space = spaces.Box(-1, 1, (self.numbers,), np.float32)

    def reset(self, *, seed: int | None = None, options: dict[str, Any] | None = None) -> Any:
        seen, info = self.env.reset(seed=seed, options=options)
        return self.plain(seen), info

    def step(self, action: Any) -> Any:
        seen, *rest = self.env.step(self.action(action))
        return self.plain(seen), *rest

    def plain(self, seen: Any) -> dict[str, Any]:
        return {key: look(seen) for key, (_, look) in self.seen.items()}

    def action(self, numbers: Any) -> Any:
        left = list(np.clip(np.asarray(numbers, np.float64), -1, 1))
        return chosen(self.env.action_space, left)


Look = Callable[[Any], Any]


def parts_of(space: Space[Any], key: str, look: Look) -> Any:
    """Pairs of a key with its space, and with what takes it out of the whole."""
    match space:
        case spaces.Dict():
            for name, part in space.items():
                yield from parts_of(part, joined(key, name), part_of(look, name))
        case spaces.Tuple():
            for at, part in enumerate(space):
                yield from parts_of(part, joined(key, str(at)), part_of(look, at))
        case spaces.Sequence() if isinstance(space.feature_space, spaces.Box):
            box = space.feature_space
            many = spaces.Box(
                np.minimum(0, np.broadcast_to(box.low, (MOST_ITEMS, *box.shape))),
                np.maximum(0, np.broadcast_to(box.high, (MOST_ITEMS, *box.shape))),
                dtype=box.dtype.type,
            )
            yield key, (many, lambda seen: filled(many, look(seen)))
        case spaces.Box() | spaces.Discrete() | spaces.MultiDiscrete() | spaces.MultiBinary():
            yield key or "seen", (space, look)


def part_of(look: Look, key: str | int) -> Look:
    return lambda seen: look(seen)[key]


def joined(key: str, name: str) -> str:
    # torch takes no point in the name of a part.
    return f"{key}_{name}" if key else name


def filled(many: spaces.Box, items: Any) -> Any:
    array = np.zeros(many.shape, many.dtype)
    for at, item in enumerate(list(items)[:MOST_ITEMS]):
        array[at] = item
    return array


def done_by(space: Space[Any]) -> Any:
    """How many numbers each part takes."""
    match space:
        case spaces.Dict():
            for part in space.values():
                yield from done_by(part)
        case spaces.Tuple():
            for part in space:
                yield from done_by(part)
        case spaces.Box():
            yield int(np.prod(space.shape)), space
        case spaces.Discrete():
            yield int(space.n), space
        case _:
            raise ValueError(f"no policy of Stable-Baselines3 does what is in {space}")


def chosen(space: Space[Any], left: list[float]) -> Any:
    """Takes its numbers from the beginning of those that are left."""
    match space:
        case spaces.Dict():
            return {key: chosen(part, left) for key, part in space.items()}
        case spaces.Tuple():
            return tuple(chosen(part, left) for part in space)
        case spaces.Discrete():
            choices = [left.pop(0) for _ in range(int(space.n))]
            return space.start + int(np.argmax(choices))
        case spaces.Box():
            numbers = np.array([left.pop(0) for _ in range(int(np.prod(space.shape)))]).reshape(space.shape)
            if space.is_bounded():
                numbers = space.low + (numbers + 1) / 2 * (space.high - space.low)
            return numbers.astype(space.dtype)
    raise ValueError(f"no policy of Stable-Baselines3 does what is in {space}")
