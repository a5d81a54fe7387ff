"""The simulators of an environment, one after the other: each comes by itself or is launched.

    simulators = Simulators(launch=["Build/Game"])              without launch it waits for Play
    simulators.find(accept)                                     accept(hello) raises MessageError to refuse a simulator
    answer = simulators.ask(Record(ASKS, 0, sections))          to a Record a Record, to a Message a Message; or Lost
    simulators.close()                                          ends what was launched, and all that it has started

A mistake in what is given is a ValueError, TypeError or FileNotFoundError, a port that is taken an OSError. It needs
only pyzmq.
"""

import os
import subprocess
import time
from collections.abc import Callable, Sequence
from typing import Any

import zmq

from netmq_example import check, one_connection
from netmq_example.envs.common import OtherSide, no_others
from netmq_example.envs.connection import Accept, Connection
from netmq_example.errors import Lost, Timeout
from netmq_example.finalizers import finalizer
from netmq_example.launch import END_SECONDS, QUIET, end_program, program, say_waiting, start_program, why_ended
from netmq_example.messages import Message, MessageError

ENDPOINT = "tcp://127.0.0.1:5559"
FREE_PORT = "tcp://127.0.0.1:*"


class Simulators:
    """`launch` is the path of a build, with its ending or without, or a list: a program and its first words.

    `--endpoint` follows them. `wait` is how many seconds for a simulator, `timeout` how many for each answer. `context`
    is the caller's own. `fleet` is lesson 17's FleetSocket in place of an endpoint, and `socket` a bound ROUTER socket;
    neither is closed.
    """

    def __init__(
        self,
        endpoint: str = "",
        launch: str | os.PathLike[str] | Sequence[str] | None = None,
        wait: float = 60,
        timeout: float = 10,
        context: zmq.Context[Any] | None = None,
        fleet: Any = None,
        socket: zmq.Socket[bytes] | None = None,
        **unknown: object,
    ) -> None:
        no_others(unknown)
        check.instance("context", context, zmq.Context, type(None))
        self.fleet = fleet is not None
        if self.fleet:
            if not isinstance(fleet, OtherSide):
                raise TypeError(f"fleet takes lesson 17's FleetSocket, not {fleet!r:.40}")
            other: Any = fleet
            socket = other
        self.wait = check.seconds("wait", wait)
        timeout = check.seconds("timeout", timeout)
        self.launch = program(launch)
        # Where what is launched sends its views, if they are wanted.
        self.views = ""
        self.owns_socket = socket is None
        self.owns_context = context is None
        if socket is None:
            # Each one that launches has a port of its own: several environments at once are no trouble.
            socket = bound(endpoint if endpoint != "" else FREE_PORT if self.launch else ENDPOINT, context)
        self.connection = Connection(socket, timeout)
        # Lesson 13's side channels stand in front of it.
        self.ask: Callable[[Any], Any] = self.connection.ask
        self.process: subprocess.Popen[bytes] | None = None

    def start(self, environment: object, accept: Accept) -> Callable[[], object]:
        """Find the first simulator. The function that is returned ends it, and is called once.

        It is called also when nobody does so: when the environment is forgotten, and at the end of the program.
        """
        close_once = finalizer(environment, self.close)
        try:
            self.find(accept)
        except BaseException:
            close_once()
            raise
        return close_once

    def find(self, accept: Accept, wait: float | None = None) -> None:
        endpoint = self.connection.endpoint
        if self.launch:
            # One that was lost may still be there, and hang.
            self.end()
            self.process = start_program([*self.launch, "--endpoint", endpoint], self.views)
        else:
            say_waiting(endpoint, self.connection.other_side.how_to_start)
        self.connection.wait(self.wait if wait is None else wait, accept, lambda: why_ended(self.process))
        QUIET.pop(endpoint, None)

    def begin(self, accept: Accept, ask: Callable[[Lost | None], Any]) -> Any:
        """Ask for a reset, and ask another simulator if one is lost; `ask` gets the error that was raised before.

        The next one may be lost as well: lesson 17's hub is started anew just then. Or each one ends of a reset, so
        that after three it is over.
        """
        lost = None
        end = time.monotonic() + self.wait
        for _ in range(2):
            try:
                return ask(lost)
            except Lost as why:
                lost = why
                self.find_after(lost, accept, end)
        return ask(lost)

    def find_after(self, lost: Lost, accept: Accept, end: float) -> None:
        """Timeout says as well why the one before was lost. One that is launched now has all of its time."""
        try:
            self.find(accept, None if self.launch else max(min(1.0, self.wait), end - time.monotonic()))
        except Timeout as error:
            raise Timeout(f"{error}; the one before is lost: {lost}") from None

    def end(self) -> None:
        if self.process:
            process, self.process = self.process, None
            end_program(process)

    def close(self) -> None:
        if self.connection.closed or os.getpid() != self.connection.process_id:
            # A process that was forked has a copy of this, and the simulator is not its own.
            return
        self.connection.timeout = min(END_SECONDS, self.connection.timeout)
        try:
            # It answers: a connection that ends right after a message may take the message with it.
            self.connection.ask(Message("close"))
        except (Lost, MessageError):
            pass
        finally:
            self.connection.closed = True
            self.end()
            if self.owns_socket:
                self.connection.socket.close()
                if self.owns_context:
                    self.connection.socket.context.destroy()


def bound(endpoint: str, given: zmq.Context[Any] | None = None) -> zmq.Socket[bytes]:
    cure = f"close() the environment that has it, or give this one its own endpoint, such as {FREE_PORT}"
    socket = one_connection.bound(endpoint, ENDPOINT, cure, given)
    # Milliseconds at its end for what it has sent last, such as why it refused a simulator.
    socket.linger = 500
    return socket
