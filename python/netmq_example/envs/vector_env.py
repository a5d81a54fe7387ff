"""Lesson 10, the vector environment: one simulator with many areas, and each step of all of them is one message.

    import vector, gymnasium
    envs = gymnasium.make_vec("NetMQExample/CartPole-v0", num_envs=16)    waits for a simulator with 16 areas

An area whose episode is over begins anew as `autoreset_mode` says: in the next step, which is Gymnasium's default, in
the same one, or when reset gets a mask. A simulator that is lost ends all episodes: they are truncated, and
`infos["lost"]` says why.

Lesson 10, the areas as Python sees them: begin some anew, step all, and one message each time.

Each area has a random generator for its seeds and a time limit of its own, as if it were an environment by itself.
"""

import contextlib
import weakref
from typing import Any

import gymnasium
import numpy as np
from gymnasium.spaces import Box
from gymnasium.utils import seeding
from gymnasium.vector import AutoresetMode, VectorEnv
from gymnasium.vector.utils import batch_space

import netmq_example.envs  # noqa: F401, it registers the environments.
from netmq_example.envs.connection import Lost, Simulators
from netmq_example.messages import EXACT, LIMIT, Array, Message, MessageError, take
from netmq_example.spaces import drawn, from_array, gives_pictures, offered, picture, sendable, shown, to_array, unpack

ENDPOINT = "tcp://127.0.0.1:5560"


class RemoteAreas:
    """`where` is what Simulators takes: endpoint, launch, wait, timeout, socket."""

    def __init__(self, count: int, name: str, limit: float, **where: Any) -> None:
        self.count, self.name, self.limit = count, name, limit
        # With the seed that each was made of.
        self.random, self.seen = [seeding.np_random() for _ in range(count)], list[Array]()
        self.steps, self.spaces, self.fps = np.zeros(count, int), list[Any](), 0
        self.pictures = count * [np.zeros((240, 320, 3), np.uint8)]
        most = np.finfo(np.float64).max
        self.rewards, self.flags = Box(-most, most, (count,), np.float64), Box(0, 1, (count,), np.uint8)
        self.simulators = Simulators(default=ENDPOINT, **where)
        self.ask = self.simulators.connection.ask

    def accept(self, hello: Message) -> None:
        if (areas := hello.values.get("areas", 1)) != self.count:
            cure = f"start it with --areas {self.count}, or put {self.count} areas below it"
            raise MessageError("wrong-areas", f"num_envs is {self.count}, the simulator has {areas!a:.20}: {cure}")
        # Whoever learns has asked for them already: another simulator must have the same ones.
        dt, self.spaces = take(hello.values, "dt", float), offered(hello, self.name, self.spaces)
        if (most := self.count * max(len(array.data) for array in hello.arrays)) > LIMIT:
            raise MessageError("too-big", f"{most} bytes of {self.count} areas are more than a message has, {LIMIT}")
        self.fps, self.seen_space = round(1 / max(1e-3, dt)), batch_space(self.spaces[0], self.count)

    def begin(self, mask: Any, seed: Any = None, options: Any = None) -> tuple[Any, list[Any]]:
        """What is seen, and the infos. In another simulator all areas begin anew: those not asked to were lost."""
        values, state = sendable(options)
        new, why = mask, ""

        def ask(lost: Lost | None) -> Message:
            nonlocal new, why
            if lost:
                new, why = mask | True, str(lost)
            return self.ask("reset", values, self.lots(new, seed) + state)

        seen, *_, infos = self.read(self.simulators.begin(self.accept, ask))
        self.steps[new] = 0
        for area in np.flatnonzero(new & ~mask):
            infos[area]["lost"] = why
        return seen, infos

    def step(self, actions: Any, again: Any) -> tuple[Any, Any, Any, Any, list[dict[str, Any]]]:
        """One step of all areas, and those of `again` are reset in place of it."""
        lots = self.lots(again) if again.any() else []
        try:
            answer = self.ask("step", {}, [to_array(actions, self.spaces[1].dtype), *lots])
        except Lost as lost:
            # Nobody knows what came after what was seen last; it is read anew, as who got it may have changed it.
            infos, none = [{"lost": str(lost)} for _ in range(self.count)], np.zeros(self.count)
            return from_array(self.seen_space, self.seen), none, none > 0, none == 0, infos
        self.steps = np.where(again, 0, self.steps + 1)
        seen, rewards, terminated, truncated, infos = self.read(answer)
        return seen, rewards, terminated, truncated | (self.steps >= self.limit), infos

    def render(self) -> list[Any]:
        """The picture of each area, or the one before when the simulator is lost, which step says."""
        with contextlib.suppress(Lost):
            self.pictures = [picture([array]) for array in self.ask("render", {}, []).arrays]
        return self.pictures

    def lots(self, mask: Any, seed: Any = None) -> list[Array]:
        """Which areas begin anew, and by which chance: the seed that is given, or what its generator draws."""
        seeds = [seed + i for i in range(self.count)] if isinstance(seed, int) else list(seed or [None] * self.count)
        if len(seeds) != self.count or any(isinstance(one, int) and one >= EXACT for one in seeds):
            raise ValueError(f"{len(seeds)} seeds are not one for each of {self.count} areas, below 2**53: {seeds}")
        for i in np.flatnonzero(mask):
            if seeds[i] is None:
                seeds[i] = int(self.random[i][0].integers(2**53))
            else:
                self.random[i] = seeding.np_random(seeds[i])
        return [to_array(mask, np.uint8), to_array([seed or 0 for seed in seeds], np.int64)]

    def read(self, state: Message) -> tuple[Any, Any, Any, Any, list[dict[str, Any]]]:
        last, reward, *flags = ([array] for array in state.arrays) if len(state.arrays) == 4 else ([], [], [], [])
        seen, rewards = from_array(self.seen_space, last), from_array(self.rewards, reward)
        terminated, truncated = (from_array(self.flags, flag).astype(bool) for flag in flags)
        self.seen, infos = last, [dict[str, Any]() for _ in range(self.count)]
        for area, info in unpack(state.values.get("infos", "[]"), int, ("lost", "final_obs", "final_info")):
            if area not in range(self.count):
                raise MessageError("bad-infos", f"an info for area {area!a:.40}, but there are {self.count}")
            infos[area].update(info)
        return seen, rewards, terminated, truncated, infos


class ZmqVectorEnv(VectorEnv[Any, Any, Any]):
    """The areas of one simulator. `where` is what Simulators takes: endpoint, launch, wait, timeout, socket."""

    metadata: dict[str, Any] = {"render_modes": ["rgb_array"]}  # noqa: RUF012, Gymnasium's own way.

    def __init__(
        self,
        num_envs: int,
        name: str,
        max_episode_steps: int | None = None,
        autoreset_mode: AutoresetMode | str = AutoresetMode.NEXT_STEP,
        render_mode: str | None = None,
        **where: Any,
    ) -> None:
        self.num_envs, self.mode, self.render_mode = num_envs, AutoresetMode(autoreset_mode), drawn(render_mode)
        self.areas = RemoteAreas(num_envs, name, max_episode_steps or np.inf, **where)
        self.over = np.ones(num_envs, bool)
        # Also when nobody calls close: at garbage collection, and at the end of the program. And only once.
        self.close_once = weakref.finalize(self, self.areas.simulators.close)
        try:
            self.areas.simulators.find(self.areas.accept)
        except BaseException:
            self.close()
            raise
        self.single_observation_space, self.single_action_space = self.areas.spaces
        self.observation_space, self.action_space = (batch_space(space, num_envs) for space in self.areas.spaces)
        self.metadata = {**self.metadata, "autoreset_mode": self.mode, "render_fps": self.areas.fps}

    def reset(self, *, seed: Any = None, options: dict[str, Any] | None = None) -> tuple[Any, dict[str, Any]]:
        options = dict(options or {})
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
        """Whose episode is over begins the next one, and what it ended with is in its info."""
        seen, infos = self.areas.begin(self.over)
        for area, over in enumerate(self.over):
            final = {"final_obs": last[area], "final_info": ends[area]} if over else ends[area]
            infos[area] = {**final, **infos[area]}
            truncated[area] |= not over and "lost" in infos[area]
        self.over = np.zeros(self.num_envs, bool)
        return seen, infos

    def gathered(self, infos: list[dict[str, Any]]) -> dict[str, Any]:
        """As Gymnasium has them: an array for each name, and beside it one that says whose value is meant."""
        all_of_them = dict[str, Any]()
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


for name in "CartPole", "Car":
    gymnasium.registry[f"NetMQExample/{name}-v0"].vector_entry_point = f"{__name__}:ZmqVectorEnv"
