"""A simulator's hello: its agents, by kind, with what each sees and does.

    scene = read_hello(hello, "Pursuit")
    scene.kinds[0].agents                       ["hunter_0", "hunter_1", "hunter_2"]
    scene.kinds[0].observation                  a space, or None where the trainer says what is seen

Agents of a kind have one space, and a row each in every record: row i is agent i. All agents of a scene are numbered,
one kind after the other, and a seed is that of agent 0; agent i has the seed + i. MessageError says what is wrong.
"""

from collections.abc import Container
from dataclasses import dataclass, replace
from typing import Any

from gymnasium.spaces import Space

from netmq_example.messages import Message, MessageError, take
from netmq_example.wire import trees
from netmq_example.wire.records import NOTHING, Section
from netmq_example.wire.sections import seeds
from netmq_example.wire.spaces import space_of


@dataclass(frozen=True)
class Kind:
    """`first` is the number of its first agent, `period` how many ticks a step has."""

    at: int
    name: str
    agents: tuple[str, ...]
    first: int
    period: int
    observation: Space[Any] | None
    action: Space[Any] | None
    # Whether what is seen comes as locators and values, also where the scene says the space.
    located: bool

    def marks(self, order: int, rows: Container[int]) -> bytes:
        """An order to some of its agents, and to the others none."""
        return bytes(order if row in rows else NOTHING for row in range(len(self.agents)))

    def section(self, seed: int, marks: bytes) -> Section:
        """Orders to its agents; the seed is that of agent 0 of the scene."""
        return Section(self.at, seeds([seed + self.first + row for row in range(len(self.agents))]), marks)


@dataclass(frozen=True)
class SceneHello:
    """`dt` is how many seconds a tick takes."""

    name: str
    dt: float
    kinds: tuple[Kind, ...]
    channels: bool

    @property
    def agents(self) -> list[str]:
        return [agent for kind in self.kinds for agent in kind.agents]

    def kind_of(self, agent: str) -> Kind:
        """ValueError says which agents there are."""
        for kind in self.kinds:
            if agent in kind.agents:
                return kind
        raise ValueError(f"no agent is named {agent!r:.40}; {self.shown()}")

    def shown(self) -> str:
        names = self.agents
        few = ", ".join(names[:10]) + (", …" if len(names) > 10 else "")
        return f"the scene has {len(names)} agents named {few}" if len(names) > 1 else f"the scene has the agent {few}"

    def frames_per_second(self, kind: Kind) -> float:
        """As many steps as there are in a second of the world's own time."""
        rate = 1 / (max(1e-3, self.dt) * kind.period)
        # A whole number, as films like it, where that is near.
        return round(rate) if abs(rate - round(rate)) < rate / 20 else rate


def read_hello(hello: Message, name: str) -> SceneHello:
    """The scene of this name; MessageError says why its hello is refused."""
    named(hello, name)
    if hello.values.get("clock") == "scene":
        raise MessageError("other-clock", "the simulator before this one had Python's clock: start that again")
    if len(hello.arrays) != 1:
        raise MessageError("no-spaces", f"a hello of {name} has one array, which describes its agents")
    described = trees.read(hello.arrays[0].data)
    if type(described) is not dict or type(described.get("kinds")) is not list:
        raise MessageError("no-spaces", "what describes the agents is no dict with their kinds")
    kinds: list[Kind] = []
    for one in described["kinds"]:
        first = kinds[-1].first + len(kinds[-1].agents) if kinds else 0
        kinds.append(read_kind(len(kinds), first, one))
    scene = SceneHello(name, take(hello.values, "dt", float), tuple(kinds), hello.values.get("channels") is True)
    names = scene.agents
    if not names:
        raise MessageError("no-agents", f"{name} has no agents: put one into the scene")
    if len({*names}) < len(names):
        twice = next(agent for agent in names if names.count(agent) > 1)
        raise MessageError("two-agents", f"two agents are named {twice!a:.40}: each needs a name of its own")
    return scene


def named(hello: Message, name: str) -> None:
    found = take(hello.values, "name", str)
    if found != name:
        raise MessageError("wrong-name", f"this environment is {name}, the simulator's is {found!a:.40}")


def read_kind(at: int, first: int, described: Any) -> Kind:
    if type(described) is not dict:
        raise MessageError("bad-kind", f"a kind of agents is a dict, not {described!a:.40}")
    agents = take(described, "agents", list)
    if not agents or not all(isinstance(agent, str) and agent for agent in agents):
        raise MessageError("bad-kind", f"the agents of a kind are names, not {agents!a:.40}")
    period = take(described, "period", int)
    if not 0 < period < 2**31:
        raise MessageError("bad-kind", f"a step has at least one tick, not {period}")
    spaces = [None if described.get(key) is None else space_of(described[key]) for key in ("observation", "action")]
    located = spaces[0] is None or described.get("located") is True
    return Kind(at, take(described, "name", str), tuple(agents), first, period, spaces[0], spaces[1], located)


def same_scene(scene: SceneHello, before: SceneHello | None) -> SceneHello:
    """Another simulator must have what the one before had.

    The spaces stay the same objects for ever, because whoever draws actions by chance has seeded them.
    """
    if before is None:
        return scene
    if replace(scene, channels=False, dt=0.0) != replace(before, channels=False, dt=0.0):
        raise MessageError("other-spaces", f"the simulator before this one had {before!s:.200}, not {scene!s:.200}")
    return replace(before, channels=scene.channels, dt=scene.dt)


def agreed(kind: Kind, which: str, given: Space[Any] | None) -> Space[Any]:
    """The space that both sides mean: one of them says it, or both the same. ValueError names where they differ."""
    said: Space[Any] | None = getattr(kind, which)
    if said is None and given is None:
        cure = f"give {which}_space here, or let the scene say it: {which.capitalize()} in C#, {which} in Python"
        raise ValueError(f"nobody says what the {which} of {kind.name} is: {cure}")
    if said is not None and given is not None and said != given:
        raise ValueError(f"the {which} of {kind.name} is {first_difference(said, given, '')}")
    return given if said is None else said  # type: ignore[return-value]


def first_difference(said: Any, given: Any, place: str) -> str:
    """Goes into parts as long as both sides have the same ones."""
    parts, others = getattr(said, "spaces", None), getattr(given, "spaces", None)
    if isinstance(parts, dict) and isinstance(others, dict) and parts.keys() == others.keys():
        pairs: Any = [(key, parts[key], others[key]) for key in parts]
    elif isinstance(parts, tuple | list) and isinstance(others, tuple | list) and len(parts) == len(others):
        pairs = [(at, *pair) for at, pair in enumerate(zip(parts, others, strict=True))]
    else:
        pairs = []
    for key, one, other in pairs:
        if one != other:
            return first_difference(one, other, f"{place}[{key!r}]")
    return f"{said!s:.100} in the scene and {given!s:.100} here{f', at {place}' if place else ''}"
