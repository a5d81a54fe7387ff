"""The connection of a simulator to an environment, which a trainer has made.

    run(scene, "tcp://127.0.0.1:5559", timeout=30)                       until the environment is closed; or Timeout

    client = EnvironmentClient("tcp://127.0.0.1:5559", timeout=30)       ValueError for a bad endpoint
    client.run(SceneSimulator(scene))                                    or any other simulator

In C# it is EnvironmentClient.cs.
"""

import logging
import sys
import time
from collections.abc import Callable
from typing import Any

import zmq

from netmq_example import arguments, check
from netmq_example.beacon import BeaconSearch
from netmq_example.errors import Timeout
from netmq_example.former import positional
from netmq_example.launch import watch_launcher
from netmq_example.messages import LIMIT, Message, MessageError
from netmq_example.one_connection import NO_CONNECTION, TRY_SECONDS, connect_once
from netmq_example.program import SLICE_MS
from netmq_example.scene.scene import Scene
from netmq_example.scene.simulator import SceneSimulator, SimulatorBase
from netmq_example.trouble import longer
from netmq_example.wire import records
from netmq_example.wire.records import RESET, Record

ENDPOINT = "tcp://127.0.0.1:5559"
# Without a request for so long, it says hello again: a trainer may be silent while it learns. Lesson 17's hub never is,
# and its welcome says for how long at most.
IDLE_SECONDS = 3600.0

log = logging.getLogger("netmq_example.envs")


def run(scene: Scene, endpoint: str = ENDPOINT, *, timeout: float = 30.0, count: int = 0) -> None:
    """Serves one environment with a scene; Timeout says that there was none for `timeout` seconds.

    An environment adds --endpoint to the words of what it launches: that one is taken then.
    """
    if "--endpoint" in sys.argv[1:-1]:
        endpoint = sys.argv[sys.argv.index("--endpoint") + 1]
    EnvironmentClient(endpoint, timeout=timeout).run(SceneSimulator(scene), count)


class EnvironmentClient:
    """Serves an environment, and after it the next one. It logs what happens.

    `prepare` gets each socket before it connects, such as lesson 15's `ClientKeys(folder).apply`.
    """

    @positional("endpoint", "timeout", "report", "prepare")
    def __init__(
        self, endpoint: str, *, timeout: float = 30.0, prepare: Callable[[zmq.Socket[bytes]], object] | None = None
    ) -> None:
        self.endpoint = check.endpoint(endpoint, ENDPOINT, beacon=True)
        self.search = BeaconSearch(endpoint)
        self.timeout = check.seconds("timeout", timeout)
        self.report = log.warning
        self.prepare = None if prepare is None else arguments.function("prepare", prepare)

    def run(self, simulator: SimulatorBase, count: int = 0) -> None:
        """Until it is closed, or asked for more than `count` episodes; 0 is no limit.

        Timeout says that there was no environment for `timeout` seconds.
        """
        check.instance("simulator", simulator, SimulatorBase)
        check.count("count", count, least=0)
        watch_launcher()
        # When it last was in an environment, why it is in none since then, and after how many tries in vain.
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
                    if self.why == NO_CONNECTION and str(error) != NO_CONNECTION:
                        # It may wait for so long, and nobody would know why.
                        self.why = str(error)
                        self.report(f"trouble: {error}")
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
        welcome = self.receive(socket, limit, "it is there and says nothing: has it another scene, or is it busy?")
        if welcome.kind != "welcome":
            raise MessageError("no-welcome", "hello had another answer")
        log.info("simulating %s for %s", simulator.name, self.endpoint)
        silence = welcome.values.get("silence")
        idle = silence if isinstance(silence, float) and 0 < silence < IDLE_SECONDS else IDLE_SECONDS
        try:
            while (request := self.receive(socket, idle)).kind != "close":
                if isinstance(request, Record) and request.has(RESET) and 0 < count <= simulator.episodes:
                    return
                socket.send_multipart(simulator.answer(request))
            # Milliseconds for the last answer, which would be dropped without them.
            socket.linger = 1000
            socket.send_multipart(Message("closed", request.id).frames())
        finally:
            self.heard = time.monotonic()
            self.why = NO_CONNECTION
            self.tries = 0

    def receive(
        self, socket: zmq.Socket[bytes], limit: float, silent: str = "the environment is gone, or silent"
    ) -> Any:
        """The next message or record within `limit` seconds; MessageError is the environment's refusal."""
        end = time.monotonic() + limit
        while not socket.poll(min(SLICE_MS, int(1000 * limit))):
            if time.monotonic() > end or not socket.poll(0, zmq.POLLOUT):
                raise Timeout(silent)
        message = records.read_frames(records.ASKS, socket.recv_multipart())
        if message.kind == "error":
            code, text = (str(message.values.get(name, "not said")) for name in ("code", "text"))
            raise MessageError(code[:40], text[:200])
        return message
