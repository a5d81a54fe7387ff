"""Lesson 09, the client of an environment: connects, says hello, and answers requests. In C#:
EnvironmentClient.cs.

It says `hello` with the simulation's name, spaces and dt; then it answers `reset`, `step` and `render`, until `close`.
Each try to connect has a new socket.

Lesson 09, the simulator: does in a simulation what an environment asks for, each request once. In C#:
Simulator.cs.
"""

import math
import time
import traceback
from abc import ABC, abstractmethod
from collections.abc import Callable
from typing import Any

import numpy as np
import zmq

from netmq_example.messages import LIMIT, Message, MessageError, read, take
from netmq_example.simulation.simulation import Simulation
from netmq_example.spaces import described, from_array, to_array
from netmq_example.split_mix import draws


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


# Seconds for a connection, and then for the answer to hello. Seconds without a request, until it says hello again: who
# learns may be silent for long. Lesson 17's hub never is, and its welcome says how long at most.
TRY, IDLE, NOTHING = 1.0, 3600.0, "no connection"


class EnvironmentClient:
    """Serves an environment, and after it the next one. What happens is told to `report`, line by line."""

    def __init__(
        self,
        endpoint: str,
        timeout: float,
        report: Callable[[str], None] = print,
        prepare: Callable[[zmq.Socket[bytes]], object] | None = None,
    ) -> None:
        """`prepare` gets each socket before it connects, such as lesson 15's `ClientKeys(folder).apply`."""
        self.endpoint, self.timeout, self.report, self.prepare = endpoint, timeout, report, prepare
        # When it last was in an environment, and why it is in none since then.
        self.heard, self.why = 0.0, NOTHING

    def run(self, simulator: SimulatorBase, count: int = 0) -> None:
        """Until it is closed, or asked for more than `count` episodes; 0 is no limit.

        TimeoutError says that there was no environment for `timeout` seconds.
        """
        self.heard, self.why = time.monotonic(), NOTHING
        while time.monotonic() < self.heard + self.timeout:
            with zmq.Context() as context, context.socket(zmq.DEALER) as socket:
                # Nothing can be sent while there is no connection, and this socket makes no second one: it might do so
                # between two looks, without a hello, and Python and simulator would wait for each other.
                socket.immediate, socket.reconnect_ivl = True, -1
                socket.linger, socket.maxmsgsize = 0, 4 * LIMIT
                # A pulled cable tells nobody: a silent peer is asked, and gone when 2.5 s bring no answer. After
                # less, a computer that learns on all its cores would be taken for gone.
                socket.heartbeat_ivl, socket.heartbeat_timeout = 500, 2500
                if self.prepare:
                    self.prepare(socket)
                socket.connect(self.endpoint)
                try:
                    return self.talk(socket, simulator, count)
                except zmq.Again:
                    pass
                except (MessageError, TimeoutError) as error:
                    # A refusal is told at once, and once; it says more than the silence that may come after it.
                    if isinstance(error, MessageError) and self.why != str(error):
                        self.report(f"trouble: {error}")
                    if isinstance(error, MessageError) or self.why == NOTHING:
                        self.why = str(error)
                    # Whoever refuses at once is not asked again at once.
                    time.sleep(min(TRY / 5, self.timeout))
        waited = f"no environment at {self.endpoint} within {self.timeout:g} s"
        keys = ", and has this simulator's key on its list" if self.prepare else ""
        raise TimeoutError(f"{waited}; is the server running{keys}? ({self.why})")

    def talk(self, socket: zmq.Socket[bytes], simulator: SimulatorBase, count: int) -> None:
        limit = min(TRY, self.timeout)
        socket.sndtimeo = int(1000 * limit)
        end = time.monotonic() + limit
        # In slices: on Windows Ctrl-C does not interrupt a longer wait.
        while not socket.poll(min(200, int(1000 * limit)), zmq.POLLOUT) and time.monotonic() < end:
            pass
        socket.send_multipart(simulator.hello().frames(), zmq.NOBLOCK)
        if (welcome := self.receive(socket, limit)).kind != "welcome":
            raise MessageError("no-welcome", "hello had another answer")
        self.report(f"simulating {simulator.name} for {self.endpoint}")
        silence = welcome.values.get("silence")
        idle = silence if isinstance(silence, float) and 0 < silence < IDLE else IDLE
        try:
            while (request := self.receive(socket, idle)).kind != "close":
                if request.kind == "reset" and 0 < count <= simulator.episodes:
                    return
                socket.send_multipart(simulator.answer(request))
            # So many milliseconds for the last answer; without them it would be dropped.
            socket.linger = 1000
            socket.send_multipart(Message("closed", request.id).frames())
        except TimeoutError as error:
            self.report(f"trouble: {error}")
            raise
        finally:
            self.heard, self.why = time.monotonic(), NOTHING

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
