"""What stands around lesson 05's `answer`: listen, read, answer whatever comes, and end at Ctrl-C.

    run("tcp://127.0.0.1:5555", answer)

Take home: this file and messages.py.
"""

from __future__ import annotations

import errno
import signal
import sys
import time
import traceback
from collections.abc import Callable
from contextlib import suppress

import zmq
from messages import LIMIT, Message, MessageError, printable, read

Answer = Callable[[Message], Message]


def run(where: str, answer: Answer, delay: float = 0.0, quiet: bool = False) -> None:
    """Listen, and answer until Ctrl-C."""
    # SIGTERM, which kill and process managers send, ends the server as Ctrl-C does.
    signal.signal(signal.SIGTERM, signal.default_int_handler)
    with suppress(KeyboardInterrupt), zmq.Context() as context, context.socket(zmq.REP) as socket:
        # A reply that nobody fetches is dropped at the end; waiting for its delivery could take for ever.
        socket.linger = 0
        # Above the limit of messages.py a sender is told so. Above this one libzmq takes no more of it and hangs up.
        socket.maxmsgsize = 4 * LIMIT
        try:
            socket.bind(where)
        except zmq.ZMQError as error:
            causes = {zmq.EADDRINUSE: "the port is taken", errno.EACCES: "the system reserves this port"}
            cause = causes.get(error.errno or 0, "this machine has no such address")
            sys.exit(f"cannot listen on {where}: {cause}; try --endpoint tcp://127.0.0.1:0, which takes a free one")
        print(f"listening on {socket.getsockopt_string(zmq.LAST_ENDPOINT)}", flush=True)
        serve(socket, answer, delay, quiet)


class Complaints:
    """Prints at most one line of bad input a second: a flood of it makes no flood of lines."""

    next, left_out = 0.0, 0

    def add(self, line: str) -> None:
        if time.monotonic() < self.next:
            self.left_out += 1
            return
        if self.left_out:
            print(f"… {self.left_out:,} more in the last second", flush=True)
        print(line, flush=True)
        self.next, self.left_out = time.monotonic() + 1, 0


def refusal(error: Exception, id: int) -> Message:
    """The reply to a request that could not be answered."""
    if not isinstance(error, MessageError):
        # A mistake in `answer`: the place is for whoever writes it, the reason for the client too.
        traceback.print_exception(error)
        error = MessageError("error-in-answer", f"{type(error).__name__}: {error}")
    return Message("error", error.id or id, {"code": error.code, "text": printable(error.text)})


def serve(socket: zmq.Socket[bytes], answer: Answer, delay: float, quiet: bool) -> None:
    """Answer for ever."""
    # Waits with a limit in milliseconds, because on Windows Ctrl-C does not interrupt one without.
    socket.rcvtimeo = socket.sndtimeo = 200
    complaints = Complaints()
    while True:
        try:
            received = socket.recv_multipart(copy=False)
        except zmq.Again:
            continue
        request = Message("")
        try:
            request = read([frame.buffer for frame in received])
            reply = answer(request)
            # What cannot be sent is found out here, before a part of it is on its way.
            frames = [zmq.Frame(part, copy=False) for part in reply.frames()]
        except Exception as error:
            reply = refusal(error, request.id)
            frames = [zmq.Frame(part) for part in reply.frames()]
        if delay:
            time.sleep(delay)
        socket.send_multipart(frames, copy=False)
        if quiet:
            continue
        if reply.kind != "error":
            print(f"sent {reply.kind}", flush=True)
        else:
            complaints.add(f"sent error {reply.values.get('code')}")
