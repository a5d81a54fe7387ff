"""Lesson 09, the environment: Python decides when time passes in a simulation that somebody else owns.

    import environment, gymnasium
    env = gymnasium.make("NetMQExample/CartPole-v0")      prints: waiting for a simulator on tcp://…: press Play
    env = gymnasium.make("NetMQExample/CartPole-v0", launch=["Build/CartPole.exe"])         starts it by itself

The spaces come from the simulator's hello. A simulator that is lost ends the episode: `truncated` is true, and
`info["lost"]` says why; the next reset waits for another one, or launches it. What `options` has goes to the
simulator as it is, and `options["state"]`, an array, is where its world begins. One thread has it, and no other.
They need
gymnasium.
"""

import contextlib
import sys
import weakref
from typing import Any

from netmq_example.envs.connection import Lost, Simulators
from netmq_example.messages import Array, Message, take
from netmq_example.spaces import drawn, from_array, gives_pictures, offered, picture, sendable, shown, to_array

try:
    import gymnasium
    import numpy as np
except ImportError:
    sys.exit("this lesson needs gymnasium: pip install gymnasium, or let kit.py run 9 do it")


class ZmqEnv(gymnasium.Env[Any, Any]):
    """The world of one simulator. `where` is what Simulators takes: endpoint, launch, wait, timeout, socket."""

    metadata: dict[str, Any] = {"render_modes": ["rgb_array"], "render_fps": 50}  # noqa: RUF012, Gymnasium's own way.
    spaces: list[Any] | None = None

    def __init__(self, name: str, render_mode: str | None = None, **where: Any) -> None:
        self.name, self.render_mode = name, drawn(render_mode)
        self.simulators = Simulators(**where)
        self.connection = self.simulators.connection
        self.seen, self.picture = list[Array](), np.zeros((240, 320, 3), np.uint8)
        # Also when nobody calls close: at garbage collection, and at the end of the program. And only once.
        self.close_once = weakref.finalize(self, self.simulators.close)
        try:
            self.simulators.find(self.accept)
        except BaseException:
            self.close()
            raise

    def accept(self, hello: Message) -> None:
        """Take the spaces from a simulator's hello; MessageError says why it is refused."""
        # Whoever learns has asked for them already: another simulator must have the same ones.
        self.spaces = offered(hello, self.name, self.spaces)
        self.observation_space, self.action_space = self.spaces
        self.metadata = {**self.metadata, "render_fps": round(1 / max(1e-3, take(hello.values, "dt", float)))}

    def reset(self, *, seed: int | None = None, options: dict[str, Any] | None = None) -> tuple[Any, dict[str, Any]]:
        super().reset(seed=seed)
        # The simulator gets a seed each time, so that an episode never depends on the one before.
        seed = int(self.np_random.integers(2**53)) if seed is None else seed
        values, arrays = sendable(options, seed=seed)
        state = self.simulators.begin(self.accept, lambda _: self.connection.ask("reset", values, arrays))
        seen, self.seen = from_array(self.observation_space, state.arrays), state.arrays
        return seen, state.values

    def step(self, action: Any) -> tuple[Any, float, bool, bool, dict[str, Any]]:
        if not self.seen:
            raise gymnasium.error.ResetNeeded("call reset before step")
        if action not in self.action_space:
            raise ValueError(f"action {shown(action)} is not in {shown(self.action_space)}")
        try:
            state = self.connection.ask("step", {}, [to_array(action, self.action_space.dtype)])
        except Lost as lost:
            # Nobody knows what came after this observation; it is read anew, as who got it may have changed it.
            return from_array(self.observation_space, self.seen), 0.0, False, True, {"lost": str(lost)}
        seen, self.seen = from_array(self.observation_space, state.arrays), state.arrays
        reward = take(state.values, "reward", float)
        terminated, truncated = (take(state.values, name, bool) for name in ("terminated", "truncated"))
        rest = state.values.keys() - {"reward", "terminated", "truncated"}
        return seen, reward, terminated, truncated, {name: state.values[name] for name in rest}

    def render(self) -> Any:
        if not gives_pictures(self.render_mode):
            return None
        # Who films goes on when the simulator is lost, which step says, with the picture before.
        with contextlib.suppress(Lost):
            self.picture = picture(self.connection.ask("render", {}, []).arrays)
        return self.picture

    def close(self) -> None:
        self.close_once()


for name, steps in ("CartPole", 500), ("Car", 1000):
    id = f"NetMQExample/{name}-v0"
    gymnasium.register(id, f"{__name__}:ZmqEnv", max_episode_steps=steps, kwargs={"name": name})
