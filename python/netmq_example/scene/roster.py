"""The rows of a scene, and who has them. Names are decided at the hello; agents come and go. It needs gymnasium."""

import re
from collections.abc import Iterator
from operator import is_
from typing import Any

from netmq_example.messages import MessageError
from netmq_example.scene.agent import Agent, declared
from netmq_example.scene.kind import Kind
from netmq_example.scene.scene import Scene, check_agent

# The row of an agent that has come in the step in which its row's last one has left: until that is told, it waits.
WAITS = -1


def parted(name: str) -> tuple[str, int | None]:
    """fish_3 is number 3 of fish."""
    found = re.fullmatch(r"(.+)_(0|[1-9]\d{0,8})", name)
    return (found[1], int(found[2])) if found else (name, None)


class Roster:
    """The kinds of a scene, in the order of its agents; ValueError says which agents cannot be in one scene."""

    def __init__(self, scene: Scene, before: "Roster | None" = None) -> None:
        self.scene = scene
        self.kinds: list[Kind] = []
        self.places: dict[int, tuple[Kind, int]] = {}
        self.sources: dict[int, list[tuple[str, Agent, str]]] = {}
        self.now: list[Agent] = []
        self.changes = -1
        # Also those that have left, and may come back.
        known = [agent for kind in before.kinds for agent in kind.last if agent] if before else []
        agents = known + [agent for agent in scene.agents if not any(one is agent for one in known)]
        if not agents:
            raise ValueError(f"{scene.name} has no agents: give its Scene one at least")
        groups: dict[str, list[Agent]] = {}
        for agent in agents:
            groups.setdefault(parted(agent.name)[0], []).append(agent)
        for name in scene.at_most:
            if name not in groups:
                raise ValueError(f"at_most takes names of agents, and {name!r:.40} is none of {', '.join(groups)}")
        first = 0
        for name, members in groups.items():
            self.kinds.append(kind_of(len(self.kinds), name, members, first, scene.at_most.get(name, 0)))
            first += len(self.kinds[-1].names)
        self.sync()
        for kind in self.kinds:
            # They are there from the beginning, and have come from nowhere.
            kind.fresh.clear()
        self.check_sources()

    def __iter__(self) -> Iterator[Kind]:
        return iter(self.kinds)

    def is_known(self) -> bool:
        """Whether nobody has come or left since it was looked."""
        return self.changes == self.scene.changes and len(self.scene.agents) == len(self.now)

    def sync(self) -> None:
        """Looks who is there. MessageError says why somebody cannot be."""
        agents = self.scene.agents
        if len(agents) == len(self.now) and all(map(is_, agents, self.now)):
            return
        here = {id(check_agent(agent)) for agent in agents}
        if len(here) < len(agents):
            twice = next(one for at, one in enumerate(agents) if any(one is other for other in agents[:at]))
            raise MessageError("two-agents", f"{twice.name} is in the scene twice: each row is an agent of its own")
        for kind in self.kinds:
            for row, agent in enumerate(kind.present):
                if agent is not None and id(agent) not in here:
                    kind.present[row] = None
                    kind.fresh.discard(row)
        placed: set[int] = set()
        # Those with a number of their own first: the others take what is left.
        for agent in sorted(agents, key=lambda one: parted(one.name)[1] is None):
            kind, row = self.place(agent)
            if row == WAITS:
                continue
            placed.add(id(agent))
            if kind.present[row] is not agent:
                # An agent that was away between two answers has missed nothing.
                if kind.last[row] is not agent or kind.told[row] or not kind.begun[row]:
                    kind.begun[row] = False
                    kind.fresh.add(row)
                kind.present[row] = kind.last[row] = agent
                kind.told[row] = False
                agent.name = kind.names[row]
                self.places[id(agent)] = kind, row
        # Those without a place yet are looked at again.
        self.now = [agent for agent in agents if id(agent) in placed]
        self.changes = self.scene.changes
        self.sources = {}

    def place(self, agent: Agent) -> tuple[Kind, int]:
        place = self.places.get(id(agent))
        if place and place[0].last[place[1]] is agent:
            return place
        base, _ = parted(agent.name)
        for kind in self.kinds:
            if kind.name == base:
                break
        else:
            known = ", ".join(kind.name for kind in self.kinds) or "none"
            raise MessageError("no-space", f"nobody has a row for {agent.name!a:.40}: at the hello there were {known}")
        try:
            kind.like(agent)
        except ValueError as error:
            raise MessageError("two-kinds", str(error)) from None
        if agent.name in kind.names:
            row = kind.names.index(agent.name)
            if kind.present[row] is None:
                return kind, row if kind.is_free(row) else WAITS
            # An agent that has had a row has its name from there, and takes another one.
            if not place:
                raise MessageError("two-agents", f"2 agents are named {agent.name!r}: each needs a name of its own")
        # The next free number; that of one who has left only where there is no other.
        empty = [row for row, one in enumerate(kind.present) if one is None]
        for row in sorted(empty, key=lambda row: kind.last[row] is not None):
            if kind.is_free(row):
                return kind, row
        if empty:
            return kind, WAITS
        most = len(kind.names)
        cure = f"at_most={{{kind.name!r}: {most + 1}}}, in Unity raise At Most in GymManager"
        raise MessageError("no-space", f"there are {most} agents of {kind.name} already, and no more may come: {cure}")

    def check_sources(self) -> None:
        """Nothing goes by attributes into what somebody else's code says."""
        in_code = {name for kind in self.kinds if kind.in_code for name in kind.names}
        for agent in self.scene.agents:
            for one in declared(type(agent), agent.name):
                for name in sorted(in_code & one.named()):
                    where = f"{type(agent).__name__}.{one.field} goes into what {name} sees"
                    raise ValueError(f"{where}, whose own observe says that: leave out the one or the other")
        for kind in self.kinds:
            if kind.observation and not kind.in_code and not any(map(self.pairs, filter(None, kind.present))):
                raise ValueError(
                    f"nothing says what {kind.names[0]} sees: write its observe, or mark fields with Obs()"
                )

    def find(self, name: str) -> Agent:
        for kind in self.kinds:
            if name in kind.names and (agent := kind.present[kind.names.index(name)]):
                return agent
        known = ", ".join(agent.name for agent in self.scene.agents) or "none"
        raise MessageError("unknown-agent", f"no agent is named {name!r:.40}; there are: {known}")

    def pairs(self, agent: Agent) -> list[tuple[str, Any]]:
        """Locators, and what stands there now: the whole of a thing before its parts, the same in every language."""
        sources = self.sources.get(id(agent))
        if sources is None:
            sources = self.sources[id(agent)] = [
                (text, other, one.field)
                for other in self.scene.agents
                for one in declared(type(other), other.name)
                if (text := one.text_for(agent.name))
            ]
            # As C# sorts by StringComparer.Ordinal.
            sources.sort(key=lambda one: one[0].encode("utf-16-be", "surrogatepass"))
        return [(text, getattr(other, field)) for text, other, field in sources]


def kind_of(number: int, base: str, members: list[Agent], first: int, at_most: int) -> Kind:
    """Its names: one agent alone keeps its own, several are numbered."""
    most = max(at_most, len(members))
    if 0 < at_most < len(members):
        raise ValueError(f"no-space: there are {len(members)} agents of {base}: write at_most={{{base!r}: {most}}}")
    taken = [found for agent in members if (found := parted(agent.name)[1]) is not None]
    if len(set(taken)) < len(taken):
        all_names = ", ".join(repr(agent.name) for agent in members)
        raise ValueError(f"two agents have one name: {all_names}; each needs a name of its own")
    free = (each for each in range(most + len(taken)) if each not in taken)
    numbers = sorted(taken + [next(free) for _ in range(most - len(taken))])
    names = [f"{base}_{each}" for each in numbers] if most > 1 or taken else [base]
    kind = Kind(number, base, names, first, members[0])
    for agent in members:
        kind.like(agent)
    return kind
