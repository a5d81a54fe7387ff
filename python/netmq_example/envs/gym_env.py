"""An environment of one agent: Python decides when time passes in a world that a simulator has, such as a Unity scene.

    import gymnasium
    import netmq_example.envs

    env = gymnasium.make("NetMQExample/CartPole-v0")      prints: waiting for a simulator on tcp://…: press Play
    env = gymnasium.make("NetMQExample/CartPole-v0", launch=["Build/CartPole.exe"])         starts it by itself
    gymnasium.register("My/Ball-v0", "netmq_example.envs:ZmqEnv", kwargs={"name": "Ball"})

The spaces come from the simulator's hello, see spaces.py, and any of Gymnasium's will do. A simulator that is lost ends
the episode: `truncated` is true, and `info["lost"]` says why; the next reset waits for another one, or launches it.
The simulator gets `options` as they are; `options["state"]`, an array, is the first state of its world. A picture is
uint8 [height, width, 3]. An environment belongs to one thread. A copy of it is a new environment.

ValueError says what cannot be sent, MessageError what a simulator refuses or answers wrongly, TimeoutError that none
came. The C# side is Simulator.cs.
"""

import contextlib
from typing import Any

import gymnasium

from netmq_example import arguments
from netmq_example.envs.common import (
    MadeAnew,
    frames_per_second,
    gives_pictures,
    hello_from,
    info_in,
    known_render_mode,
    no_picture,
    observation_and_action,
    options_as_bytes,
    picture,
    same,
)
from netmq_example.envs.connection import Simulators
from netmq_example.errors import Lost
from netmq_example.messages import Message, MessageError
from netmq_example.wire.records import ABSENT, ASKS, RESET, STEP, TERMINATED, TRUNCATED, Record, rewards_in, seeds
from netmq_example.wire.space_bytes import Bytes
from netmq_example.wire.spaces import shown

NO_SEED = seeds([0])


class ZmqEnv(MadeAnew, gymnasium.Env[Any, Any]):
    """The world of one simulator. `where` is what Simulators takes: endpoint, launch, wait, timeout, socket."""

    metadata: dict[str, Any] = {"render_modes": ["rgb_array"], "render_fps": 50}  # noqa: RUF012, Gymnasium's own way.

    def __init__(self, name: str, render_mode: str | None = None, **where: Any) -> None:
        self.name = arguments.text("name", name)
        self.render_mode = known_render_mode(render_mode)
        self.spaces: list[Any] | None = None
        # The last observation, as bytes, and the last picture.
        self.seen: Any = None
        self.picture = no_picture()
        self.simulators = Simulators(**where)
        self.connection = self.simulators.connection
        self.close_once = self.simulators.start(self, self.accept)

    def accept(self, hello: Message) -> None:
        """Take the spaces from a simulator's hello; MessageError says why it is refused."""
        self.spaces = same(observation_and_action(hello_from(hello, self.name)), self.spaces)
        self.observation_space, self.action_space = self.spaces
        self.observations, self.actions = map(Bytes, self.spaces)
        self.metadata = {**self.metadata, "render_fps": frames_per_second(hello)}

    def reset(self, *, seed: int | None = None, options: dict[str, Any] | None = None) -> tuple[Any, dict[str, Any]]:
        super().reset(seed=seed)
        # The simulator gets a seed each time, so that an episode never depends on the one before.
        seed = int(self.np_random.integers(2**53)) if seed is None else seed
        request = Record(ASKS, 0, seeds([seed]), [RESET], [b""], options=options_as_bytes(options))
        try:
            state = self.simulators.begin(self.accept, lambda _: self.connection.ask(request))
        except MessageError:
            # A step after a refused reset would step half a world.
            self.seen = None
            raise
        return self.look(state), info_in(state.infos[0])

    def step(self, action: Any) -> tuple[Any, float, bool, bool, dict[str, Any]]:
        if self.seen is None:
            raise gymnasium.error.ResetNeeded("no episode is under way: call reset before step")
        if action not in self.action_space:
            raise ValueError(f"action {shown(action)} is not in {shown(self.action_space)}")
        try:
            state = self.connection.ask(Record(ASKS, 0, NO_SEED, [STEP], [self.actions.write(action)]))
        except Lost as lost:
            # The last observation stands for an unknown one. It is read again: its user may have changed it.
            return self.observations.read(self.seen), 0.0, False, True, {"lost": str(lost)}
        seen = self.look(state)
        (reward,) = rewards_in(state)
        ends = state.flags[0]
        if ends:
            # Steps beyond the end would be of no episode, and seldom in the space.
            self.seen = None
        return seen, reward, bool(ends & TERMINATED), bool(ends & (TRUNCATED | ABSENT)), info_in(state.infos[0])

    def look(self, state: Record) -> Any:
        seen = self.observations.read(state.rows[0])
        self.seen = state.rows[0]
        return seen

    def render(self) -> Any:
        if not gives_pictures(self.render_mode):
            return None
        # A film goes on when the simulator is lost, with the picture before; step says that it is.
        with contextlib.suppress(Lost):
            self.picture = picture(self.connection.ask(Message("render")).arrays)
        return self.picture

    def close(self) -> None:
        self.close_once()
