"""Worlds of the scene's clock (tests/unity/play/MLAgentsWorlds.cs), driven by the kit's UnityEnvironment.

run = world("A period=2 numbers=1", "A act 3: add 1, end")
run.reset()
run.step(7)
assert run.told() == ["A init", …]
"""

import subprocess
from typing import NamedTuple

import numpy as np

from netmq_example.mlagents_envs.base_env import ActionTuple
from netmq_example.mlagents_envs.environment import UnityEnvironment
from tests.programs import Program, steady_port

BALL = "Ball?team=0"


class Row(NamedTuple):
    """Python is told this of one agent."""

    what: str
    id: int
    reward: float
    # The first number that it sees: as a rule how often it has been observed.
    seen: float


class Stage:
    """A program that plays one world after the other, in Plays that keep the statics; it begins anew after a fault."""

    def __init__(self, harness):
        self.harness = harness
        self.program: Program | None = None
        self.playing = False

    def begin(self, *words):
        if self.program is None or self.playing or self.program.ended:
            self.close()
            self.port = steady_port()
            command = ["dotnet", self.harness, "keep", "--mlagents-port", str(self.port)]
            self.program = Program(command, stdin=subprocess.PIPE)
            self.program.wait_for("^ready$")
        self.playing = True
        self.said = len(self.program.lines)
        self.program.process.stdin.write(f"{'|'.join(['clock', *words, '--mlagents-port', str(self.port)])}\n")
        self.program.process.stdin.flush()

    def end(self):
        """All that was printed in this Play."""
        self.program.wait_for("^ready$", start=self.said)
        self.playing = False
        return self.program.lines[self.said :]

    def close(self):
        if self.program:
            self.program.kill()
            self.program.process.stdin.close()


class World:
    def __init__(self, stage, *words, **environment):
        self.stage = stage
        # All that was printed, when Play is over.
        self.output = ""
        stage.begin(*words)
        self.env = UnityEnvironment(base_port=stage.port, **environment)

    def reset(self):
        self.env.reset()
        return self.rows()

    def step(self, *numbers, choices=(), name=BALL):
        """The same action for all that want one; without it zeros."""
        if (numbers or choices) and (count := len(self.env.get_steps(name)[0])):
            action = ActionTuple(
                np.tile(np.array(numbers, np.float32), (count, 1)), np.tile(np.array(choices, np.int32), (count, 1))
            )
            self.env.set_actions(name, action)
        self.env.step()
        return self.rows(name)

    def rows(self, name=BALL):
        """Those that have ended, then those that want an action."""
        if name not in self.env.behavior_specs:
            return []
        decisions, ended = self.env.get_steps(name)
        whats = [*(["interrupted" if cut else "ended" for cut in ended.interrupted]), *["wants"] * len(decisions)]
        ids = [*ended.agent_id, *decisions.agent_id]
        rewards = [*ended.reward, *decisions.reward]
        seen = [*self.firsts(ended), *self.firsts(decisions)]
        return [
            Row(what, int(number), float(reward), float(first))
            for what, number, reward, first in zip(whats, ids, rewards, seen, strict=True)
        ]

    @staticmethod
    def firsts(steps):
        return [row.flat[0] for row in steps.obs[0]] if steps.obs else [float("nan")] * len(steps)

    def told(self):
        """All that happened, when Play is over: Python's end ends it."""
        self.env.close()
        lines = self.stage.end()
        self.output = "\n".join(lines)
        return told(lines)


def alone(stage, *words):
    """What happens without Python, and all that was printed."""
    stage.begin(*words)
    lines = stage.end()
    return told(lines), "\n".join(lines)


def told(lines):
    return [line.removeprefix("| ") for line in lines if line.startswith("| ")]
