"""A vector environment: one simulator with many areas, and each step of all of them is one message.

    import gymnasium
    import netmq_example.envs

    envs = gymnasium.make_vec("NetMQExample/CartPole-v0", num_envs=16)    waits for a simulator with 16 areas

Arrays and infos are those of Gymnasium's SyncVectorEnv with as many environments. An area whose episode is over begins
anew as `autoreset_mode` says: in the next step, which is Gymnasium's default, in the same one, or when reset gets a
mask. A simulator that is lost ends all episodes: they are truncated, and `infos["lost"]` says why. The C# side is
AreaSimulator.cs.
"""

import contextlib
from typing import Any

import gymnasium
import numpy as np
from gymnasium.spaces import Box
from gymnasium.utils import seeding
from gymnasium.vector import AutoresetMode, VectorEnv
from gymnasium.vector.utils import batch_space

from netmq_example import check
from netmq_example.envs.connection import Lost, Simulators
from netmq_example.infos import unpack
from netmq_example.messages import EXACT, LIMIT, Array, Message, MessageError
from netmq_example.spaces import (
    copied,
    frames_per_second,
    from_array,
    gives_pictures,
    known_render_mode,
    offered,
    picture,
    sendable,
    shown,
    to_array,
)

ENDPOINT = "tcp://127.0.0.1:5560"


class RemoteAreas:
    """The areas as messages: some begin anew, or all step, one message each time.

    Each area has a random generator for its seeds and a time limit of its own, as if it were an environment by itself.
    `where` is what Simulators takes: endpoint, launch, wait, timeout, socket.
    """

    def __init__(self, num_envs: int, name: str, max_episode_steps: int | None = None, **where: Any) -> None:
        self.count = check.count("num_envs", num_envs)
        self.name = check.text("name", name)
        # Gymnasium's make takes -1 for no limit as well.
        unlimited = max_episode_steps is None or max_episode_steps == -1
        self.limit = np.inf if unlimited else check.count("max_episode_steps", max_episode_steps)
        self.spaces: list[Any] = []
        self.fps = 0
        # Generators, each with the seed that it was made of.
        self.random = [seeding.np_random() for _ in range(self.count)]
        self.steps = np.zeros(self.count, int)
        # What was seen last, as it came, and the last pictures.
        self.seen: list[Array] = []
        self.pictures = [np.zeros((240, 320, 3), np.uint8)] * self.count
        most = np.finfo(np.float64).max
        self.rewards = Box(-most, most, (self.count,), np.float64)
        self.flags = Box(0, 1, (self.count,), np.uint8)
        self.simulators = Simulators(default=ENDPOINT, **where)
        self.ask = self.simulators.connection.ask

    def accept(self, hello: Message) -> None:
        areas = hello.values.get("areas", 1)
        if areas != self.count:
            cure = f"put {self.count} areas below it, in lesson 10 by --world CartPole --areas {self.count}"
            raise MessageError("wrong-areas", f"num_envs is {self.count}, the simulator has {areas!a:.20}: {cure}")
        # A trainer has asked for the spaces already: another simulator must have the same ones.
        spaces = offered(hello, self.name, self.spaces)
        most = self.count * max(len(array.data) for array in hello.arrays)
        if most > LIMIT:
            raise MessageError("too-big", f"{most} bytes of {self.count} areas are more than a message has, {LIMIT}")
        self.fps = frames_per_second(hello)
        self.spaces = spaces
        self.seen_space = batch_space(spaces[0], self.count)

    def begin(self, mask: Any, seed: Any = None, options: Any = None) -> tuple[Any, list[Any]]:
        """What is seen, and the infos. In another simulator all areas begin anew: those not asked to were lost."""
        values, state = sendable(options)
        new = mask
        why = ""

        def ask(lost: Lost | None) -> Message:
            nonlocal new, why
            if lost:
                new = np.ones(self.count, bool)
                why = str(lost)
            return self.ask("reset", values, self.mask_and_seeds(new, seed) + state)

        seen, *_, infos = self.read(self.simulators.begin(self.accept, ask))
        self.steps[new] = 0
        for area in np.flatnonzero(new & ~mask):
            infos[area]["lost"] = why
        return seen, infos

    def step(self, actions: Any, again: Any) -> tuple[Any, Any, Any, Any, list[dict[str, Any]]]:
        """One step of all areas, and those of `again` are reset in place of it."""
        begin = self.mask_and_seeds(again) if again.any() else []
        try:
            answer = self.ask("step", {}, [to_array(actions, self.spaces[1].dtype), *begin])
        except Lost as lost:
            # Nobody knows what came after these observations. They are read anew: their user may have changed them.
            seen = from_array(self.seen_space, self.seen)
            nothing = np.zeros(self.count)
            return seen, nothing, nothing > 0, nothing == 0, [{"lost": str(lost)} for _ in range(self.count)]
        self.steps = np.where(again, 0, self.steps + 1)
        seen, rewards, terminated, truncated, infos = self.read(answer)
        return seen, rewards, terminated, truncated | (self.steps >= self.limit), infos

    def render(self) -> list[Any]:
        """The picture of each area, or the one before when the simulator is lost, which step says."""
        with contextlib.suppress(Lost):
            self.pictures = [picture([array]) for array in self.ask("render", {}, []).arrays]
        return self.pictures

    def mask_and_seeds(self, mask: Any, seed: Any = None) -> list[Array]:
        """Which areas begin anew, and by which chance: the seed that is given, or what its generator draws."""
        seeds = self.one_each(seed)
        for area in np.flatnonzero(mask):
            if seeds[area] is None:
                seeds[area] = int(self.random[area][0].integers(2**53))
            else:
                self.random[area] = seeding.np_random(int(seeds[area]))
        return [to_array(mask, np.uint8), to_array([seed or 0 for seed in seeds], np.int64)]

    def one_each(self, seed: Any) -> list[Any]:
        """A seed for each area, None where its generator draws one."""
        if seed is None:
            return [None] * self.count
        if isinstance(seed, int | np.integer):
            seed = [int(seed) + area for area in range(self.count)]
        seeds = list(seed) if np.iterable(seed) else [seed]
        known = all(one is None or (isinstance(one, int | np.integer) and 0 <= one < EXACT) for one in seeds)
        if len(seeds) != self.count or not known:
            raise ValueError(
                f"{len(seeds)} seeds are not one for each of {self.count} areas, below 2**53: {seeds!r:.80}"
            )
        return seeds

    def read(self, state: Message) -> tuple[Any, Any, Any, Any, list[dict[str, Any]]]:
        """Observations, rewards, terminated, truncated and infos, of each area."""
        parts = [[array] for array in state.arrays] if len(state.arrays) == 4 else [[], [], [], []]
        last, rewards, terminated, truncated = parts
        infos: list[dict[str, Any]] = [{} for _ in range(self.count)]
        result = (
            from_array(self.seen_space, last),
            from_array(self.rewards, rewards),
            from_array(self.flags, terminated).astype(bool),
            from_array(self.flags, truncated).astype(bool),
            infos,
        )
        self.seen = last
        for area, info in unpack(state.values.get("infos", "[]"), int, ("lost", "final_obs", "final_info")):
            if area not in range(self.count):
                raise MessageError("bad-infos", f"an info for area {area!a:.40}, but there are {self.count}")
            infos[area].update(info)
        return result


class ZmqVectorEnv(VectorEnv[Any, Any, Any]):
    """The areas of one simulator. `where` is what Simulators takes: endpoint, launch, wait, timeout, socket."""

    metadata: dict[str, Any] = {"render_modes": ["rgb_array"]}  # noqa: RUF012, Gymnasium's own way.
    # Until it is made: Gymnasium closes what is forgotten, also when there is nothing yet to be closed.
    closed = True

    def __init__(
        self,
        num_envs: int,
        name: str,
        max_episode_steps: int | None = None,
        autoreset_mode: AutoresetMode | str = AutoresetMode.NEXT_STEP,
        render_mode: str | None = None,
        **where: Any,
    ) -> None:
        self.mode = AutoresetMode(autoreset_mode)
        self.render_mode = known_render_mode(render_mode)
        self.areas = RemoteAreas(num_envs, name, max_episode_steps, **where)
        self.num_envs = self.areas.count
        self.over = np.ones(self.num_envs, bool)
        self.close_once = self.areas.simulators.start(self, self.areas.accept)
        self.single_observation_space, self.single_action_space = self.areas.spaces
        self.observation_space = self.areas.seen_space
        self.action_space = batch_space(self.single_action_space, self.num_envs)
        self.metadata = {**self.metadata, "autoreset_mode": self.mode, "render_fps": self.areas.fps}
        self.closed = False

    def reset(self, *, seed: Any = None, options: dict[str, Any] | None = None) -> tuple[Any, dict[str, Any]]:
        options = copied(options)
        mask = np.asarray(options.pop("reset_mask", np.ones(self.num_envs, bool)))
        if mask.shape != (self.num_envs,) or mask.dtype != bool or not mask.any():
            raise ValueError(f"reset_mask must be {self.num_envs} times true or false, one of them true: {mask!r:.80}")
        seen, infos = self.areas.begin(mask, seed, options)
        self.over[mask] = False
        return seen, self.gathered(infos)

    def step(self, actions: Any) -> tuple[Any, Any, Any, Any, dict[str, Any]]:
        if not self.areas.seen:
            raise gymnasium.error.ResetNeeded("call reset before step")
        if actions not in self.action_space:
            raise ValueError(f"actions {shown(actions)} are not in {shown(self.action_space)}")
        if self.mode == AutoresetMode.DISABLED and self.over.any():
            raise ValueError(f"areas {np.flatnonzero(self.over)} are over: reset(options={{'reset_mask': …}}) first")
        if self.over.all():
            # All were lost, perhaps: then it is another simulator that they begin in.
            seen, infos = self.areas.begin(self.over)
            rewards, terminated, truncated = np.zeros(self.num_envs), ~self.over, ~self.over
        else:
            seen, rewards, terminated, truncated, infos = self.areas.step(actions, self.over)
        self.over = terminated | truncated
        if self.mode == AutoresetMode.SAME_STEP and self.over.any():
            seen, infos = self.begin_at_once(seen, truncated, infos)
        return seen, rewards, terminated, truncated, self.gathered(infos)

    def begin_at_once(self, last: Any, truncated: Any, ends: list[Any]) -> tuple[Any, list[Any]]:
        """Where an episode is over, the next one begins, and what it ended with is in its info."""
        seen, infos = self.areas.begin(self.over)
        for area, over in enumerate(self.over):
            final = {"final_obs": last[area], "final_info": ends[area]} if over else ends[area]
            infos[area] = {**final, **infos[area]}
            if not over and "lost" in infos[area]:
                truncated[area] = True
        self.over = np.zeros(self.num_envs, bool)
        return seen, infos

    def gathered(self, infos: list[dict[str, Any]]) -> dict[str, Any]:
        """As Gymnasium has them: an array for each name, and beside it one that says whose value is meant."""
        all_of_them: dict[str, Any] = {}
        for area, info in enumerate(infos):
            all_of_them = self._add_info(all_of_them, info, area)
        return all_of_them

    def render(self) -> tuple[Any, ...] | None:
        return tuple(self.areas.render()) if gives_pictures(self.render_mode) else None

    # As Gymnasium has them: one for each area.
    np_random = property(lambda self: tuple(random for random, _ in self.areas.random))
    np_random_seed = property(lambda self: tuple(seed for _, seed in self.areas.random))

    def close_extras(self, **kwargs: Any) -> None:
        self.close_once()
