"""An environment of one agent: Python decides when time passes in a world that a simulator has, such as a Unity scene.

    import gymnasium
    import netmq_example.envs

    env = gymnasium.make("NetMQExample/CartPole-v0")      prints: waiting for a simulator on tcp://…: press Play
    env = gymnasium.make("NetMQExample/CartPole-v0", launch=["Build/CartPole.exe"])         starts it by itself
    gymnasium.register("My/Ball-v0", "netmq_example.envs:ZmqEnv", kwargs={"name": "Ball"})

The spaces come from the simulator's hello, see spaces.py. A simulator that is lost ends the episode: `truncated` is
true, and `info["lost"]` says why; the next reset waits for another one, or launches it. What `options` has goes to the
simulator as it is, and `options["state"]`, an array, is where its world begins. A picture is uint8
[height, width, 3]. An environment belongs to one thread.

ValueError says what cannot be sent, MessageError what a simulator refuses or answers wrongly, TimeoutError that none
came. The C# side is Simulator.cs.
"""

import contextlib
from typing import Any

import gymnasium
import numpy as np

from netmq_example import check
from netmq_example.envs.connection import Lost, Simulators
from netmq_example.messages import Array, Message, take
from netmq_example.spaces import (
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


class ZmqEnv(gymnasium.Env[Any, Any]):
    """The world of one simulator. `where` is what Simulators takes: endpoint, launch, wait, timeout, socket."""

    metadata: dict[str, Any] = {"render_modes": ["rgb_array"], "render_fps": 50}  # noqa: RUF012, Gymnasium's own way.

    def __init__(self, name: str, render_mode: str | None = None, **where: Any) -> None:
        self.name = check.text("name", name)
        self.render_mode = known_render_mode(render_mode)
        self.spaces: list[Any] | None = None
        # What was seen last, as it came, and the last picture.
        self.seen: list[Array] = []
        self.picture = np.zeros((240, 320, 3), np.uint8)
        self.simulators = Simulators(**where)
        self.connection = self.simulators.connection
        self.close_once = self.simulators.start(self, self.accept)

    def accept(self, hello: Message) -> None:
        """Take the spaces from a simulator's hello; MessageError says why it is refused."""
        # A trainer has asked for them already: another simulator must have the same ones.
        self.spaces = offered(hello, self.name, self.spaces)
        self.observation_space, self.action_space = self.spaces
        self.metadata = {**self.metadata, "render_fps": frames_per_second(hello)}

    def reset(self, *, seed: int | None = None, options: dict[str, Any] | None = None) -> tuple[Any, dict[str, Any]]:
        super().reset(seed=seed)
        # The simulator gets a seed each time, so that an episode never depends on the one before.
        seed = int(self.np_random.integers(2**53)) if seed is None else seed
        values, arrays = sendable(options, seed=seed)
        state = self.simulators.begin(self.accept, lambda _: self.connection.ask("reset", values, arrays))
        seen = from_array(self.observation_space, state.arrays)
        self.seen = state.arrays
        return seen, state.values

    def step(self, action: Any) -> tuple[Any, float, bool, bool, dict[str, Any]]:
        if not self.seen:
            raise gymnasium.error.ResetNeeded("call reset before step")
        if action not in self.action_space:
            raise ValueError(f"action {shown(action)} is not in {shown(self.action_space)}")
        try:
            state = self.connection.ask("step", {}, [to_array(action, self.action_space.dtype)])
        except Lost as lost:
            # Nobody knows what came after this observation. It is read anew: its user may have changed what he got.
            return from_array(self.observation_space, self.seen), 0.0, False, True, {"lost": str(lost)}
        seen = from_array(self.observation_space, state.arrays)
        self.seen = state.arrays
        reward = take(state.values, "reward", float)
        terminated = take(state.values, "terminated", bool)
        truncated = take(state.values, "truncated", bool)
        rest = state.values.keys() - {"reward", "terminated", "truncated"}
        return seen, reward, terminated, truncated, {name: state.values[name] for name in rest}

    def render(self) -> Any:
        if not gives_pictures(self.render_mode):
            return None
        # A film goes on when the simulator is lost, with the picture before; step says that it is.
        with contextlib.suppress(Lost):
            self.picture = picture(self.connection.ask("render", {}, []).arrays)
        return self.picture

    def close(self) -> None:
        self.close_once()
