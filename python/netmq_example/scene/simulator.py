"""A simulator: does in a simulation what an environment asks for, each request once, and the client that connects it.

    client = EnvironmentClient("tcp://127.0.0.1:5559", timeout=30)       ValueError for a bad endpoint
    client.run(Simulator(CartPole()))                                   until the environment is closed; or Timeout

The client says `hello` with the simulation's name, spaces and dt; then it answers resets and steps (records.py), and
`render`, until `close`. A request that comes again, because its answer was late or lost, gets the answer that was kept.
In C# they are Simulator.cs and EnvironmentClient.cs.
"""

import logging
import struct
import time
from abc import ABC, abstractmethod
from collections.abc import Callable
from typing import Any

import numpy as np
import zmq

from netmq_example import arguments, check
from netmq_example.beacon import BeaconSearch
from netmq_example.errors import Timeout
from netmq_example.former import positional
from netmq_example.launch import watch_launcher
from netmq_example.messages import LIMIT, Message, MessageError
from netmq_example.one_connection import NO_CONNECTION, TRY_SECONDS, connect_once
from netmq_example.program import SLICE_MS
from netmq_example.scene.answers import answer_to, hello_of, options_in, picture_of, unknown
from netmq_example.scene.simulation import Simulation
from netmq_example.trouble import longer
from netmq_example.wire import records
from netmq_example.wire.records import RESET, STEP, Record
from netmq_example.wire.space_bytes import Bytes
from netmq_example.wire.spaces import described
from netmq_example.wire.split_mix import draws

ENDPOINT = "tcp://127.0.0.1:5559"
# Without a request for so long, it says hello again: a trainer may be silent while it learns. Lesson 17's hub never is,
# and its welcome says for how long at most.
IDLE_SECONDS = 3600.0

log = logging.getLogger("netmq_example.envs")


class SimulatorBase(ABC):
    """Answers requests. The last answer is kept, and a request that comes again gets it again."""

    def __init__(self, name: str) -> None:
        self.name = arguments.text("name", name)
        self.episodes = 0
        self.steps = 0
        self.id = 0
        self.kept: list[Any] = []

    def hello(self) -> Message:
        """The hello, which tells an environment the spaces. Ids of requests start again."""
        self.id = 0
        hello = self.describe()
        self.kept = hello.frames()
        return hello

    def answer(self, request: Any) -> list[Any]:
        """The frames of the answer to a new id, or else of the last answer. A mistake is sent as an error."""
        if request.id > self.id:
            try:
                answer = self.do(request) if isinstance(request, Record) else self.say(request)
                self.kept = answer.frames()
            except Exception as error:
                if not isinstance(error, MessageError):
                    # A mistake in the simulation, whose author wants to see where it is.
                    log.error("a mistake in the simulation", exc_info=error)
                    error = MessageError("error-in-simulation", repr(error)[:200])
                self.kept = Message.refusal(error, request.id).frames()
            self.id = request.id
        return self.kept

    @abstractmethod
    def describe(self) -> Message:
        """A hello: name, dt and spaces."""

    @abstractmethod
    def do(self, request: Record) -> Record:
        """Reset or step, and say what is seen then."""

    @abstractmethod
    def say(self, request: Message) -> Message:
        """Answer what is asked in words, such as render."""


class Simulator(SimulatorBase):
    """Answers reset, step and render for one simulation, or for many areas of one kind."""

    def __init__(self, simulation: Simulation, *others: Simulation) -> None:
        self.areas = [check.instance("simulation", area, Simulation) for area in (simulation, *others)]
        super().__init__(simulation.name)
        self.simulation = simulation
        # For a person who must mend something.
        self.names = [f"{simulation.name}, area {at}" for at in range(len(self.areas))] if others else [simulation.name]
        self.observations = Bytes(simulation.observation)
        self.actions = Bytes(simulation.action)

    def describe(self) -> Message:
        simulation = self.simulation
        spaces = {"observation": described(simulation.observation), "action": described(simulation.action)}
        return hello_of(self.name, simulation.dt, spaces)

    def say(self, request: Message) -> Message:
        if request.kind != "render":
            raise unknown(request, "render")
        return picture_of(request, [area.render() for area in self.areas])

    def do(self, request: Record) -> Record:
        count = len(self.areas)
        if len(request.flags) != count:
            cure = f"make_vec(…, num_envs={count}), and a name that is registered with vector_entry_point"
            raise MessageError("wrong-areas", f"this simulator has {count} areas, not {len(request.flags)}: {cure}")
        # All actions are looked at before the first area moves: half a step would be none.
        orders = list(zip(self.areas, request.flags, request.rows, strict=True))
        actions = [self.actions.read(row) if order == STEP else None for _, order, row in orders]
        options = options_in(request) if RESET in request.flags else {}
        state = self.state_of(options.pop("state", []))
        seeds = struct.unpack(f"<{count}q", request.numbers)
        outcomes: list[dict[str, Any]] = []
        for at, (area, order, _) in enumerate(orders):
            outcomes.append({})
            if order == STEP:
                area.apply(actions[at])
                outcomes[at] = area.reward_and_end()
                self.steps += 1
            elif order == RESET:
                area.reset(draws(seeds[at]), options, state)
                self.episodes += 1
        seen = [self.observations.write(area.observe()) for area in self.areas]
        return answer_to(request, self.names, outcomes, seen)

    def state_of(self, given: Any) -> list[float]:
        """In which an episode begins; nothing, if it begins by chance."""
        try:
            items = np.asarray(given)
            if items.dtype.kind not in "biuf":
                raise MessageError("bad-state", "a state is numbers")
            # Counted before they are converted: a message may have millions.
            if items.size not in (0, self.simulation.size):
                raise MessageError("bad-state", f"a state is {self.simulation.size} numbers, not {items.size}")
            state: list[float] = items.astype(np.float64).ravel().tolist()
        except MessageError:
            raise
        except (ValueError, TypeError) as error:
            raise MessageError("bad-state", f"a state is numbers: {error!s:.80}") from None
        return state


class EnvironmentClient:
    """Serves an environment, and after it the next one. It logs what happens.

    `prepare` gets each socket before it connects, such as lesson 15's `ClientKeys(folder).apply`.
    """

    @positional("endpoint", "timeout", "report", "prepare")
    def __init__(
        self,
        endpoint: str,
        *,
        timeout: float = 30.0,
        prepare: Callable[[zmq.Socket[bytes]], object] | None = None,
    ) -> None:
        self.endpoint = check.endpoint(endpoint, ENDPOINT, beacon=True)
        self.search = BeaconSearch(endpoint)
        self.timeout = check.seconds("timeout", timeout)
        self.report = log.warning
        self.prepare = None if prepare is None else arguments.function("prepare", prepare)
        # When it last was in an environment, why it is in none since then, and after how many tries in vain.
        self.heard = 0.0
        self.why = NO_CONNECTION
        self.tries = 0

    def run(self, simulator: SimulatorBase, count: int = 0) -> None:
        """Until it is closed, or asked for more than `count` episodes; 0 is no limit.

        Timeout says that there was no environment for `timeout` seconds.
        """
        check.instance("simulator", simulator, SimulatorBase)
        check.count("count", count, least=0)
        watch_launcher()
        self.heard = time.monotonic()
        self.why = NO_CONNECTION
        self.tries = 0
        while (left := self.heard + self.timeout - time.monotonic()) > 0:
            # Each try has a new socket.
            with zmq.Context() as context, context.socket(zmq.DEALER) as socket:
                limit = min(longer(TRY_SECONDS, self.tries), left)
                try:
                    self.connect(socket, limit)
                    return self.talk(socket, simulator, count, limit)
                except zmq.Again:
                    pass
                except MessageError as error:
                    # A refusal is reported at once, and once; it says more than the silence that may come after it.
                    if self.why != str(error):
                        self.report(f"trouble: {error}")
                    self.why = str(error)
                    self.pause()
                except (TimeoutError, ConnectionRefusedError) as error:
                    # Where nobody listens yet, a short try is enough.
                    self.tries = 0 if isinstance(error, ConnectionRefusedError) else self.tries + 1
                    if self.why == NO_CONNECTION:
                        self.why = str(error)
                    self.pause()
        waited = f"no environment at {self.endpoint} within {self.timeout:g} s"
        keys = ", and has this simulator's key on its list" if self.prepare else ""
        cure = self.search.cure(f"is the server running{keys}? ({self.why})")
        self.search.close()
        raise Timeout(f"{waited}; {cure}")

    def connect(self, socket: zmq.Socket[bytes], limit: float) -> None:
        socket.linger = 0
        socket.maxmsgsize = 4 * LIMIT
        socket.sndtimeo = int(1000 * TRY_SECONDS)
        if self.prepare:
            self.prepare(socket)
        where = self.search.find(min(TRY_SECONDS, limit))
        if not where:
            # Nobody answers to the name: nothing is known about the line.
            raise ConnectionRefusedError(NO_CONNECTION)
        connect_once(socket, where, limit)

    def pause(self) -> None:
        """A peer that refuses at once is not asked again at once."""
        time.sleep(min(TRY_SECONDS / 5, self.timeout))

    def talk(self, socket: zmq.Socket[bytes], simulator: SimulatorBase, count: int, limit: float) -> None:
        socket.send_multipart(simulator.hello().frames(), zmq.NOBLOCK)
        welcome = self.receive(socket, limit)
        if welcome.kind != "welcome":
            raise MessageError("no-welcome", "hello had another answer")
        log.info("simulating %s for %s", simulator.name, self.endpoint)
        silence = welcome.values.get("silence")
        idle = silence if isinstance(silence, float) and 0 < silence < IDLE_SECONDS else IDLE_SECONDS
        try:
            while (request := self.receive(socket, idle)).kind != "close":
                if isinstance(request, Record) and RESET in request.flags and 0 < count <= simulator.episodes:
                    return
                socket.send_multipart(simulator.answer(request))
            # Milliseconds for the last answer, which would be dropped without them.
            socket.linger = 1000
            socket.send_multipart(Message("closed", request.id).frames())
        except TimeoutError as error:
            self.report(f"trouble: {error}")
            raise
        finally:
            self.heard = time.monotonic()
            self.why = NO_CONNECTION
            self.tries = 0

    def receive(self, socket: zmq.Socket[bytes], limit: float) -> Any:
        """The next message or record within `limit` seconds; MessageError is the environment's refusal."""
        end = time.monotonic() + limit
        while not socket.poll(min(SLICE_MS, int(1000 * limit))):
            if time.monotonic() > end or not socket.poll(0, zmq.POLLOUT):
                raise Timeout("the environment is gone, or silent")
        message = records.read_frames(records.ASKS, socket.recv_multipart())
        if message.kind == "error":
            code, text = (str(message.values.get(name, "not said")) for name in ("code", "text"))
            raise MessageError(code[:40], text[:200])
        return message
