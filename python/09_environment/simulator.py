"""Lesson 09, the simulator: does in a simulation what an environment asks for, each request once. In C#:
Simulator.cs.
"""

import math
import sys
import traceback
from abc import ABC, abstractmethod
from pathlib import Path
from typing import Any

import numpy as np

# In its own lesson's folder; at home it lies beside this file.
sys.path.append(str(Path(__file__).resolve().parents[1] / "05_messages"))
from messages import Message, MessageError, take
from simulation import Simulation, draws
from spaces import described, from_array, to_array


class SimulatorBase(ABC):
    """Answers requests. The last answer is kept, and a request that comes again gets it again."""

    def __init__(self, name: str) -> None:
        self.name, self.episodes, self.steps = name, 0, 0
        self.id, self.kept = 0, list[Any]()

    def hello(self) -> Message:
        """What an environment has to know. Its requests are counted anew."""
        self.id, hello = 0, self.describe()
        self.kept = hello.frames()
        return hello

    def answer(self, request: Message) -> list[Any]:
        """The answer to a new id, or what was answered last. What is wrong is told to the environment."""
        if request.id > self.id:
            try:
                self.kept = self.do(request).frames()
            except Exception as error:
                if not isinstance(error, MessageError):
                    # A mistake in the simulation: its place is for whoever writes it.
                    traceback.print_exc()
                    error = MessageError("error-in-simulation", repr(error)[:200])
                self.kept = Message("error", request.id, {"code": error.code, "text": error.text}).frames()
            self.id = request.id
        return self.kept

    @abstractmethod
    def describe(self) -> Message:
        """A hello: name, dt and spaces."""

    @abstractmethod
    def do(self, request: Message) -> Message:
        """Do what is asked for, and answer it."""


class Simulator(SimulatorBase):
    """Answers reset, step and render for one simulation."""

    def __init__(self, simulation: Simulation) -> None:
        super().__init__(simulation.name)
        self.simulation = simulation

    def describe(self) -> Message:
        (seen, see), (done, do) = described(self.simulation.observation), described(self.simulation.action)
        values = {"name": self.name, "dt": float(self.simulation.dt), "observation": seen, "action": done}
        return Message("hello", 0, values, see + do)

    def do(self, request: Message) -> Message:
        simulation, values = self.simulation, dict[str, Any]()
        if request.kind == "reset":
            state = [float(item) for array in request.arrays for item in array.numpy().flat]
            if len(state) not in (0, simulation.size):
                raise MessageError("bad-state", f"a state is {simulation.size} numbers, not {len(state)}")
            simulation.reset(draws(take(request.values, "seed", int)), request.values, state)
            self.episodes += 1
        elif request.kind == "step":
            simulation.apply(from_array(simulation.action, request.arrays))
            self.steps += 1
            values = dict(simulation.judge())
            # Whatever numpy or Python made them of.
            values["reward"] = float(values["reward"])
            values |= {name: bool(values[name]) for name in ("terminated", "truncated")}
            if not math.isfinite(values["reward"]):
                raise MessageError("bad-reward", f"the reward is {values['reward']}")
        elif request.kind == "render":
            return Message("picture", request.id, {}, [to_array(simulation.render(), np.uint8)])
        else:
            raise MessageError("unknown-kind", f"kind {request.kind!a:.40} is none of reset, step, render, close")
        return Message("state", request.id, values, [to_array(simulation.observe(), simulation.observation.dtype)])
