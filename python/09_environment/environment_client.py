"""Lesson 09, the client of an environment: connects, says hello, and answers requests. In C#:
EnvironmentClient.cs.

It says `hello` with the simulation's name, spaces and dt; then it answers `reset`, `step` and `render`, until `close`.
Each try to connect has a new socket.
"""

import sys
import time
from collections.abc import Callable
from pathlib import Path

import zmq

# In its own lesson's folder; at home it lies beside this file.
sys.path.append(str(Path(__file__).resolve().parents[1] / "05_messages"))
from messages import LIMIT, Message, MessageError, read
from simulator import SimulatorBase

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
