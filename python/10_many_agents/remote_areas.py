"""Lesson 10, the areas as Python sees them: begin some anew, step all, and one message each time.

Each area has a random generator for its seeds and a time limit of its own, as if it were an environment by itself.
"""

import contextlib
import sys
from pathlib import Path
from typing import Any

import numpy as np
from gymnasium.spaces import Box
from gymnasium.utils import seeding
from gymnasium.vector.utils import batch_space

# In its own lesson's folder; at home they lie beside this file.
sys.path += [str(Path(__file__).resolve().parents[1] / name) for name in ("05_messages", "09_environment")]
from connection import Lost
from infos import unpack
from messages import EXACT, LIMIT, Array, Message, MessageError, take
from simulators import Simulators
from spaces import from_array, offered, picture, sendable, to_array

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
