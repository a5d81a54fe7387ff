"""A scene: its agents, and a world of theirs, which no agent owns. It needs only Python.

    scene = Scene("Ball", [Ball("ball")], dt=0.02)
    scene = Scene("Fish", [Fish("fish"), Fish("fish")], dt=0.1, at_most={"fish": 5})        fish_0 and fish_1

Agents of one name are numbered in their order. They may come and go, by `add` and `remove`: `at_most` says how many of
a name there may ever be. What happens to the world itself stands in a class of your own that derives from Scene, such
as worlds/pursuit.py. In C# it is GymManager.cs.
"""

from collections.abc import Iterable, Mapping
from typing import Any

from netmq_example import arguments, check
from netmq_example.scene.agent import Agent, Infos, warn_of_slips
from netmq_example.wire.split_mix import Draws


class Scene:
    """`dt` is how many seconds a tick takes."""

    def __init_subclass__(cls, **words: Any) -> None:
        super().__init_subclass__(**words)
        warn_of_slips(cls, Scene)

    def __init__(
        self, name: str, agents: Iterable[Agent], dt: float = 0.02, at_most: Mapping[str, int] | None = None
    ) -> None:
        self.name = arguments.text("name", name)
        self.dt = check.seconds("dt", dt)
        if isinstance(agents, str | bytes | dict) or not isinstance(agents, Iterable):
            raise TypeError(f"agents takes a list of Agents, not {agents!r:.40}")
        self.agents = list(agents)
        for agent in self.agents:
            check_agent(agent)
        check.instance("at_most", at_most, Mapping, type(None))
        self.at_most = {name: check.count("at_most", most) for name, most in dict(at_most or {}).items()}
        self.infos = Infos()
        # How often somebody has come or left.
        self.changes = 0

    def add(self, agent: Agent) -> None:
        """It takes part from now on: with its on_reset, after this step."""
        self.agents.append(check_agent(agent))
        self.changes += 1

    def remove(self, agent: Agent) -> None:
        """It has left, and may come back by `add`."""
        # By identity: an agent that is a dataclass may be equal to another one.
        self.agents[:] = [one for one in self.agents if one is not agent]
        self.changes += 1

    def send_info(self, info: Any) -> None:
        """Tell Python something of the scene itself, with the next answer."""
        self.infos.send(info)

    def on_reset(self, rng: Draws, options: dict[str, Any]) -> None:
        """An episode of all agents begins; their own on_reset comes next."""

    def on_tick(self, dt: float) -> None:
        """So many seconds pass, after the agents' own on_tick."""

    def on_stepped(self) -> None:
        """A step is over, after the agents' own on_stepped."""

    def on_info(self, info: Any) -> None:
        """Python has sent something to the scene itself."""

    def render(self) -> Any:
        """A picture of the whole, uint8 [height, width, 3], the highest row first; None if agents draw their own."""


def check_agent(agent: Any) -> Agent:
    if not isinstance(agent, Agent):
        raise TypeError(f"agents takes Agents, not {agent!r:.40}")
    return agent
