"""Lesson 09, the simulator: does in a simulation what an environment asks for. The twin of EnvironmentClient.cs.

It connects and says `hello` with the simulation's name, spaces and dt; then it answers `reset`, `step` and `render`,
until `close`. The last answer is kept, and a request that comes again gets it again: nothing is done twice. Each try
to connect has a new socket.
Take home: this file, simulation.py and spaces.py, with messages.py of lesson 05.
"""

import math
import sys
import time
import traceback
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import zmq

# In its own lesson's folder; at home it lies beside this file.
sys.path.append(str(Path(__file__).resolve().parents[1] / "05_messages"))
from messages import LIMIT, Message, MessageError, read, take
from simulation import Simulation, draws
from spaces import described, from_array, to_array

# Seconds for a connection, and then for the answer to hello. Seconds without a request, until it says hello again.
TRY, IDLE = 1.0, 3600.0


class Simulator:
    """Serves an environment, and after it the next one. What happens is told to `report`, line by line."""

    def __init__(self, simulation: Simulation, report: Callable[[str], None] = print) -> None:
        self.simulation, self.report, self.episodes, self.steps = simulation, report, 0, 0
        self.id, self.kept, self.heard = 0, list[Any](), time.monotonic()

    def run(self, endpoint: str, patience: float, count: int = 0) -> None:
        """Until it is closed, or asked for more than `count` episodes; 0 is no limit.

        TimeoutError says that there was no environment for `patience` seconds.
        """
        self.heard, why = time.monotonic(), ""
        while time.monotonic() < self.heard + patience:
            with zmq.Context() as context, context.socket(zmq.DEALER) as socket:
                # Nothing can be sent while there is no connection: so it is known whether there is one.
                socket.linger, socket.maxmsgsize, socket.immediate = 0, 4 * LIMIT, True
                socket.connect(endpoint)
                try:
                    return self.talk(socket, endpoint, min(TRY, patience), count)
                except zmq.Again:
                    pass
                except (MessageError, TimeoutError) as error:
                    why = f" ({error})"
                    # Whoever refuses at once is not asked again at once.
                    time.sleep(min(0.2, patience))
        raise TimeoutError(f"no environment at {endpoint} within {patience:g} s; is the server running?{why}")

    def talk(self, socket: zmq.Socket[bytes], endpoint: str, limit: float, count: int) -> None:
        socket.sndtimeo = int(1000 * limit)
        socket.send_multipart(self.hello().frames())
        if (welcome := self.receive(socket, limit)).kind != "welcome":
            raise MessageError("no-welcome", f"hello was answered with {welcome.kind!a:.40}")
        self.report(f"simulating {self.simulation.name} for {endpoint}")
        self.id = 0
        try:
            while (request := self.receive(socket, IDLE)).kind != "close":
                if request.kind == "reset" and 0 < count <= self.episodes:
                    return
                socket.send_multipart(self.answer(request))
            # So many milliseconds for the last answer; without them it would be dropped.
            socket.linger = 1000
            socket.send_multipart(Message("closed", request.id).frames())
        except (MessageError, TimeoutError) as error:
            self.report(f"trouble: {error}")
            raise
        finally:
            self.heard = time.monotonic()

    def hello(self) -> Message:
        (seen, see), (done, do) = described(self.simulation.observation), described(self.simulation.action)
        values = {"name": self.simulation.name, "dt": self.simulation.dt, "observation": seen, "action": done}
        return Message("hello", 0, values, see + do)

    def receive(self, socket: zmq.Socket[bytes], limit: float) -> Message:
        end = time.monotonic() + limit
        # In slices: on Windows Ctrl-C does not interrupt a longer wait.
        while not socket.poll(min(200, int(1000 * limit))):
            if time.monotonic() > end or not socket.poll(0, zmq.POLLOUT):
                raise TimeoutError("the environment is gone, or silent")
        message = read(socket.recv_multipart())
        if message.kind == "error":
            code, text = (str(message.values.get(name, "not said")) for name in ("code", "text"))
            raise MessageError(code[:40], text[:200])
        return message

    def answer(self, request: Message) -> list[Any]:
        """What this id got already, or the answer to a new one. What is wrong is told to the environment."""
        if request.id != self.id:
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
            values = simulation.judge()
            if not math.isfinite(values["reward"]):
                raise MessageError("bad-reward", f"the reward is {values['reward']}")
        elif request.kind == "render":
            return Message("picture", request.id, {}, [to_array(simulation.render(), np.uint8)])
        else:
            raise MessageError("unknown-kind", f"kind {request.kind!a:.40} is none of reset, step, render, close")
        return Message("state", request.id, values, [to_array(simulation.observe(), simulation.observation.dtype)])
