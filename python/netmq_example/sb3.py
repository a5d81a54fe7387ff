"""Stable-Baselines3: many areas as its VecEnv, and a scene's spaces as its policies take them.

    from netmq_example.sb3 import Areas, PlainSpaces

    envs = gymnasium.make_vec("NetMQExample/CartPole-v0", 16, autoreset_mode="SameStep", launch=…)
    PPO("MlpPolicy", VecMonitor(Areas(envs))).learn(100_000)

    env = PlainSpaces(gymnasium.make("NetMQExample/Unity-v0", env_name="Coins", …))
    PPO("MultiInputPolicy", env).learn(100_000)

Its policies take arrays, and a dict of arrays. Where a space has more in it, such as dicts in dicts, sequences or
texts, both make a plain one of it:

    what is seen becomes a dict of arrays. A part of a part has both keys, as last_push. Of a sequence of arrays the
    first 8 are seen, and zeros in place of those that are not there. Texts and graphs are left out.
    what is done becomes one array from -1 to 1. A number of a box goes from its lowest to its highest; of a discrete
    space there is a number for each choice, and the largest one is done.

It needs stable-baselines3, which needs torch.
"""

from collections.abc import Callable, Iterator
from typing import Any

from netmq_example.extras import without

try:
    import gymnasium
    import numpy as np
    from gymnasium import spaces
    from gymnasium.spaces import Space
    from gymnasium.utils.env_checker import data_equivalence
    from gymnasium.vector import AutoresetMode
    from gymnasium.vector.utils import iterate
    from stable_baselines3.common.vec_env import VecEnv
except ImportError as error:
    raise without(error) from None

from netmq_example.wire.space_bytes import together

__all__ = ["Areas", "PlainSpaces"]

# How many items of a sequence a policy sees.
MOST_ITEMS = 8
ARRAYS = (spaces.Box, spaces.Discrete, spaces.MultiDiscrete, spaces.MultiBinary)

Look = Callable[[Any], Any]


class Areas(VecEnv):  # type: ignore[misc, unused-ignore]
    """All areas of a simulator, all agents of a scene, or all simulators of a fleet, as `make_vec` has made them."""

    def __init__(self, envs: Any) -> None:
        if envs.metadata["autoreset_mode"] != AutoresetMode.SAME_STEP:
            raise ValueError('Stable-Baselines3 wants the next episode at once: make_vec(…, autoreset_mode="SameStep")')
        self.envs = envs
        # VecVideoRecorder takes its rate from here.
        self.metadata = envs.metadata
        self.plain = Plain(envs.single_observation_space, envs.single_action_space)
        super().__init__(envs.num_envs, self.plain.observation_space, self.plain.action_space)

    def reset(self) -> Any:
        options, *others = getattr(self, "_options", [{}])
        if not all(data_equivalence(options, other) for other in others):
            raise ValueError("the areas are one simulator: set_options takes one dict for all of them")
        seen, infos = self.envs.reset(seed=self._seeds, options=options)
        self.seen = self.look(seen)
        self.reset_infos = [said_of(infos, area) for area in range(self.num_envs)]
        # Both are for one reset.
        self._reset_seeds()
        self._options: list[dict[str, Any]] = [{}]
        return self.seen

    def step_async(self, actions: Any) -> None:
        self.actions = np.asarray(actions, self.action_space.dtype)
        if self.plain.numbers:
            chosen = [self.plain.choose(numbers) for numbers in self.actions]
            self.actions = together(self.envs.single_action_space, chosen)

    def step_wait(self) -> Any:
        before = self.seen
        seen, rewards, terminated, truncated, infos = self.envs.step(self.actions)
        self.seen = self.look(seen)
        over = terminated | truncated
        said = [said_of(infos, area) for area in range(self.num_envs)]
        for area in np.flatnonzero(over):
            ended = said[area].pop("final_info", {})
            last = said[area].pop("final_obs", None)
            self.reset_infos[area] = dict(said[area])
            # Of an area that was lost while others began anew it is the observation before.
            last = of_one(before, int(area)) if last is None else self.plain.look(last)
            # The time was up, and not the world at its end: PPO then adds what it expects from the last observation.
            by_time = bool(truncated[area] and not terminated[area])
            said[area] |= {**ended, "terminal_observation": last, "TimeLimit.truncated": by_time}
        return self.seen, rewards.astype(np.float32), over, said

    def look(self, batch: Any) -> Any:
        if not self.plain.parts:
            return batch
        each = [self.plain.look(seen) for seen in iterate(self.envs.observation_space, batch)]
        return {key: np.stack([one[key] for one in each]) for key in self.plain.parts}

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


def said_of(infos: dict[str, Any], area: int) -> dict[str, Any]:
    """The info of one area in a vector's infos, where _name beside each name says which areas have it."""
    said = {}
    for name, values in infos.items():
        if f"_{name}" in infos and infos[f"_{name}"][area]:
            said[name] = said_of(values, area) if isinstance(values, dict) else values[area]
    return said


class PlainSpaces(gymnasium.Wrapper[Any, Any, Any, Any]):
    """One environment, whose spaces are plain."""

    def __init__(self, env: gymnasium.Env[Any, Any]) -> None:
        super().__init__(env)
        self.plain = Plain(env.observation_space, env.action_space)
        self.observation_space = self.plain.observation_space
        self.action_space = self.plain.action_space

    def reset(self, *, seed: int | None = None, options: dict[str, Any] | None = None) -> Any:
        seen, info = self.env.reset(seed=seed, options=options)
        return self.plain.look(seen), info

    def step(self, action: Any) -> Any:
        seen, *rest = self.env.step(self.plain.choose(action))
        return self.plain.look(seen), *rest


class Plain:
    """Both ways between spaces and plain ones. A space that is plain already stays as it is."""

    def __init__(self, seen: Space[Any], done: Space[Any]) -> None:
        self.done = done
        self.observation_space = seen
        self.action_space = done
        # The look of each part of an observation, and the count of an action's numbers; none where a space stays.
        self.parts: dict[str, Look] = {}
        self.numbers = 0
        flat = isinstance(seen, spaces.Dict) and all(isinstance(part, ARRAYS) for part in seen.values())
        if not flat and not isinstance(seen, ARRAYS):
            parts = list(parts_of(seen, "", lambda value: value))
            self.parts = {key: look for key, _, look in parts}
            if not parts or len(self.parts) < len(parts):
                raise ValueError(f"nothing is left, or two parts have one name: {[key for key, *_ in parts]}")
            self.observation_space = spaces.Dict({key: space for key, space, _ in parts})
        if not isinstance(done, ARRAYS):
            self.numbers = numbers_of(done)
            self.action_space = spaces.Box(-1, 1, (self.numbers,), np.float32)

    def look(self, seen: Any) -> Any:
        return {key: look(seen) for key, look in self.parts.items()} if self.parts else seen

    def choose(self, action: Any) -> Any:
        if not self.numbers:
            return action
        return chosen(self.done, list(np.clip(np.asarray(action, np.float64), -1, 1)))


def parts_of(space: Space[Any], key: str, look: Look) -> Iterator[tuple[str, Space[Any], Look]]:
    """Keys, each with its space, and what takes it out of the whole."""
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
            yield key, many, lambda seen: filled(many, look(seen))
        case spaces.Box() | spaces.Discrete() | spaces.MultiDiscrete() | spaces.MultiBinary():
            yield key or "seen", space, look


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


def numbers_of(space: Space[Any]) -> int:
    """How many numbers what is done takes."""
    match space:
        case spaces.Dict():
            return sum(map(numbers_of, space.values()))
        case spaces.Tuple():
            return sum(map(numbers_of, space))
        case spaces.Box() | spaces.MultiBinary():
            return int(np.prod(space.shape))
        case spaces.Discrete():
            return int(space.n)
        case spaces.MultiDiscrete():
            return int(space.nvec.sum())
    raise ValueError(f"no policy of Stable-Baselines3 does what is in {space}")


def chosen(space: Space[Any], left: list[float]) -> Any:
    """Takes its numbers from the beginning of those that are left."""

    def take(count: Any) -> Any:
        numbers = np.array(left[: int(count)])
        del left[: int(count)]
        return numbers

    match space:
        case spaces.Dict():
            return {key: chosen(part, left) for key, part in space.items()}
        case spaces.Tuple():
            return tuple(chosen(part, left) for part in space)
        case spaces.Discrete():
            return space.start + np.argmax(take(space.n))
        case spaces.MultiDiscrete():
            most = np.reshape([np.argmax(take(count)) for count in space.nvec.flat], space.shape)
            return (space.start + most).astype(space.dtype)
        case spaces.MultiBinary():
            return (take(np.prod(space.shape)) > 0).astype(space.dtype).reshape(space.shape)
        case spaces.Box():
            low, high = space.low.astype(np.float64), space.high.astype(np.float64)
            numbers = take(np.prod(space.shape)).reshape(space.shape)
            if space.is_bounded():
                numbers = low + (numbers + 1) / 2 * (high - low)
            # As a float32 it may be a little more than its highest.
            return np.clip(numbers, low, high).astype(space.dtype).clip(space.low, space.high)
    raise ValueError(f"no policy of Stable-Baselines3 does what is in {space}")
