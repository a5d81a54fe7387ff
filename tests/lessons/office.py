"""A scene in which everything that is asked of anybody is written down: `info["env"]` has it, in its order. Clerks do
what their action says, and see what was drawn and how many ticks passed. In C# it is tests/lessons/checks/Office.cs.

    simulator = SceneSimulator(office("ann bob:2 bob", clerk=3))          clerk=3: at most so many clerks
"""

from collections.abc import Iterable
from typing import Any

import numpy as np
from gymnasium.spaces import Box, Dict, Sequence, Text

from netmq_example.scene import Agent, Scene
from netmq_example.wire.split_mix import Draws

WORDS = Text(20, min_length=0, charset="abcdefghijklmnopqrstuvwxyz0123456789 .")
SEEN = Dict({"drawn": Box(0, 1, (2,), np.float64), "letters": Sequence(WORDS), "ticks": Box(0, 100, (1,))})
LONGEST = 'é"' * 20


class Clerk(Agent):
    observation: Any = SEEN
    action: Any = WORDS
    office: "Office"

    def __init__(self, name: str, office: "Office", period: int = 1) -> None:
        super().__init__(name)
        self.office = office
        self.period = period
        self.letters: list[str] = []
        # The agent that it ends when it begins next.
        self.foe: Agent | None = None

    def note(self, what: str) -> None:
        self.office.send_info(f"{self.name} {what}")

    def on_reset(self) -> None:
        self.note("begins")
        self.drawn = self.rng()
        self.ticks = 0
        self.plan = ""
        self.letters = []
        if self.foe:
            self.foe.terminated = True
        self.foe = None

    def on_action(self, action: Any) -> None:
        self.note(f"does {action}")
        self.plan = action
        match str(action).split():
            case ["end"]:
                self.terminated = True
            case ["earn", reward]:
                self.reward += float(reward)
            case ["say", *values]:
                for number, value in enumerate(values):
                    self.info[f"value{number}"] = VALUES[value]
            case ["shout"]:
                for number in range(1000):
                    self.send_info({"number": number, "text": LONGEST})
            case ["leave", *letter]:
                # A clerk that leaves with a letter has ended.
                self.letters += letter
                self.terminated |= bool(letter)
                self.office.remove(self)
                self.office.away.append(self)
            case ["hire", name]:
                self.office.add(Clerk(name, self.office))
            case ["swap", name]:
                self.reward += 1
                self.office.remove(self)
                self.office.add(Clerk(name, self.office))
            case ["doom", row]:
                self.foe = self.office.agents[int(row)]
                self.terminated = True
            case ["haunt"]:
                self.office.away[-1].reward += 1
                self.office.away[-1].terminated = True
            case ["recall"]:
                self.office.add(self.office.away.pop())

    def on_tick(self, dt: float) -> None:
        self.note("ticks" if dt == self.office.dt else "ticks wrongly")
        self.ticks += 1
        self.terminated |= self.plan == "end soon"

    def on_stepped(self) -> None:
        self.note("stepped")
        self.reward += 0.25
        self.terminated |= self.plan == "end late"
        if self.plan == "go late":
            self.office.remove(self)

    def observe(self) -> Any:
        self.note("sees")
        self.terminated |= self.plan == "end last"
        return {"drawn": [self.drawn, self.office.drawn], "letters": self.letters, "ticks": [self.ticks]}

    def on_info(self, info: Any) -> None:
        self.note("hears")
        self.send_info(info)


# The names under which a clerk may say something.
VALUES = {
    "nothing": 0,
    "part": 0.75,
    "false": False,
    "text": "abc",
    "none": np.zeros(0),
    "one": np.ones(1),
    "two": np.ones(2, np.int32),
    "list": [1, 2],
    "dict": {"a": 1},
}


class Office(Scene):
    def __init__(self, names: Iterable[str], **at_most: int) -> None:
        self.away: list[Agent] = []
        self.drawn = 0.0
        clerks = [Clerk(name, self, int(period or 1)) for name, _, period in (one.partition(":") for one in names)]
        super().__init__("Office", clerks, 0.5, at_most)

    def on_reset(self, rng: Draws, options: dict[str, Any]) -> None:
        self.send_info("office begins")
        self.drawn = rng()

    def on_tick(self, dt: float) -> None:
        self.send_info("office ticks")

    def on_stepped(self) -> None:
        self.send_info("office stepped")

    def on_info(self, info: Any) -> None:
        self.send_info(info)


def office(names: str, **at_most: int) -> Office:
    return Office(names.split(), **at_most)
