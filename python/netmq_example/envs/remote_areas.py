"""Areas as messages: what a vector environment asks of its simulator, and what it makes of the answers.

vector_env.py is made of it; unity_vector_env.py has agents in place of areas.
"""

import contextlib
from collections.abc import Sequence
from typing import Any

import numpy as np
from gymnasium.utils import seeding

from netmq_example import arguments, check
from netmq_example.envs.common import (
    frames_per_second,
    hello_from,
    info_in,
    no_picture,
    observation_and_action,
    options_as_bytes,
    picture,
    same,
)
from netmq_example.envs.connection import Simulators
from netmq_example.errors import Lost
from netmq_example.messages import EXACT, LIMIT, Message, MessageError
from netmq_example.wire.records import ABSENT, ASKS, NOTHING, RESET, STEP, TERMINATED, TRUNCATED, Record, seeds
from netmq_example.wire.space_bytes import Bytes

ENDPOINT = "tcp://127.0.0.1:5560"
# In an info these names are the environment's own.
OWN = ("lost", "final_obs", "final_info")
GONE = "it has left the scene"


class RemoteAreas:
    """The areas as messages: one message resets some of them, or steps all.

    Each area has a random generator for its seeds and a time limit of its own, as if it were an environment by itself.
    `where` is what Simulators takes: endpoint, launch, wait, timeout, socket.
    """

    def __init__(
        self, num_envs: int, name: str, max_episode_steps: int | None = None, default: str = ENDPOINT, **where: Any
    ) -> None:
        self.count = check.count("num_envs", num_envs)
        self.name = arguments.text("name", name)
        # Gymnasium's make takes -1 for no limit as well.
        unlimited = max_episode_steps is None or max_episode_steps == -1
        self.limit = np.inf if unlimited else check.count("max_episode_steps", max_episode_steps)
        self.spaces: list[Any] | None = None
        self.fps = 0
        # Generators, each with the seed that it was made of.
        self.random = [seeding.np_random() for _ in range(self.count)]
        self.steps = np.zeros(self.count, int)
        # Each area's last observation, as bytes, and the last pictures.
        self.seen: list[Any] = []
        self.pictures = [no_picture()] * self.count
        self.simulators = Simulators(default=default, **where)
        self.ask = self.simulators.connection.ask

    def accept(self, hello: Message) -> None:
        described = hello_from(hello, self.name)
        areas = hello.values.get("areas", 1)
        if areas != self.count:
            cure = f"put {self.count} areas below it, in lesson 10 by --world {self.name} --areas {self.count}"
            raise MessageError("wrong-areas", f"num_envs is {self.count}, the simulator has {areas!a:.20}: {cure}")
        self.spaces = same(observation_and_action(described), self.spaces)
        self.observations, self.actions = map(Bytes, self.spaces)
        most = self.count * (self.observations.size or 0)
        if most > LIMIT:
            raise MessageError("too-big", f"{most} bytes of {self.count} areas are more than a message has, {LIMIT}")
        self.fps = frames_per_second(hello)

    def options(self, options: Any = None) -> bytes:
        """The options of each reset."""
        return options_as_bytes(options)

    def action_rows(self, actions: Any) -> list[bytes]:
        return self.actions.write_all(self.count, actions)

    def forget(self, mask: Any) -> None:
        """Forget what these areas saw before they reset."""

    def look(self, rows: Sequence[Any]) -> Any:
        """The observations of these rows, as one batch."""
        seen = self.observations.read_all(rows)
        self.seen = list(rows)
        return seen

    def look_again(self) -> Any:
        """The last observations, read again: the user may have changed those that he got."""
        return self.look(self.seen)

    def info(self, data: Any) -> dict[str, Any]:
        """An area's info, or the value that stands for none."""
        return info_in(data)

    def begin(self, mask: Any, seed: Any = None, options: Any = None) -> tuple[Any, list[Any]]:
        """The observations and the infos. In another simulator all areas reset: those not asked to are lost."""
        data = self.options(options)
        new = mask
        why = ""

        def ask(lost: Lost | None) -> Record:
            nonlocal new, why
            if lost:
                new = np.ones(self.count, bool)
                why = str(lost)
            orders = np.where(new, RESET, NOTHING).tolist()
            rows = [b""] * self.count
            answer: Record = self.ask(Record(ASKS, 0, self.seeds_for(new, seed), orders, rows, options=data))
            return answer

        answer = self.simulators.begin(self.accept, ask)
        self.forget(new)
        seen, *_, infos = self.read(answer)
        self.steps[new] = 0
        infos = [info if asked else {} for info, asked in zip(infos, new, strict=True)]
        for area in np.flatnonzero(new & ~mask):
            infos[area]["lost"] = why
        return seen, infos

    def step(self, actions: Any, again: Any) -> tuple[Any, Any, Any, Any, list[dict[str, Any]]]:
        """One step of all areas, and those of `again` are reset in place of it."""
        rows = self.action_rows(actions)
        orders = [STEP] * self.count
        data = b""
        if again.any():
            rows = [b"" if new else row for row, new in zip(rows, again, strict=True)]
            orders = np.where(again, RESET, STEP).tolist()
            data = self.options()
        try:
            answer = self.ask(Record(ASKS, 0, self.seeds_for(again), orders, rows, options=data))
        except Lost as lost:
            # The last observations stand for unknown ones.
            nothing = np.zeros(self.count)
            infos = [{**self.info(b""), "lost": str(lost)} for _ in range(self.count)]
            return self.look_again(), nothing, nothing > 0, nothing == 0, infos
        self.forget(again)
        self.steps = np.where(again, 0, self.steps + 1)
        seen, rewards, terminated, truncated, infos = self.read(answer)
        return seen, rewards, terminated, truncated | (self.steps >= self.limit), infos

    def render(self) -> list[Any]:
        """The picture of each area, or the one before when the simulator is lost, which step says."""
        with contextlib.suppress(Lost):
            self.pictures = [picture([array]) for array in self.ask(Message("render")).arrays]
        return self.pictures

    def seeds_for(self, mask: Any, seed: Any = None) -> bytes:
        """The seed of an area's next episode: the given one, or one that its generator draws."""
        if not mask.any():
            return bytes(8 * self.count)
        each = self.one_each(seed)
        for area in np.flatnonzero(mask):
            if each[area] is None:
                each[area] = int(self.random[area][0].integers(2**53))
            else:
                self.random[area] = seeding.np_random(int(each[area]))
        return seeds([one or 0 for one in each])

    def one_each(self, seed: Any) -> list[Any]:
        """A seed for each area, None where its generator draws one."""
        if seed is None:
            return [None] * self.count
        if isinstance(seed, int | np.integer):
            seed = [int(seed) + area for area in range(self.count)]
        each = list(seed) if np.iterable(seed) else [seed]
        known = all(one is None or (isinstance(one, int | np.integer) and 0 <= one < EXACT) for one in each)
        if len(each) != self.count or not known:
            raise ValueError(f"{len(each)} seeds are not one for each of {self.count} areas, below 2**53: {each!r:.80}")
        return each

    def read(self, state: Record) -> tuple[Any, Any, Any, Any, list[dict[str, Any]]]:
        """Observations, rewards, terminated, truncated and infos, of each area."""
        seen = self.look(state.rows)
        rewards = np.frombuffer(state.numbers, np.float64).copy()
        if not np.isfinite(rewards).all():
            raise MessageError("bad-reward", f"the rewards are {rewards!s:.80}")
        ends = np.frombuffer(state.flags, np.uint8)
        infos = [self.info(data) for data in state.infos]
        if not all(info.keys().isdisjoint(OWN) for info in infos):
            raise MessageError("bad-info", f"these names are the environment's own: {', '.join(OWN)}")
        for area in np.flatnonzero(ends == ABSENT):
            infos[area]["lost"] = GONE
        truncated = ((ends & TRUNCATED) > 0) | (ends == ABSENT)
        return seen, rewards, (ends & TERMINATED) > 0, truncated, infos
