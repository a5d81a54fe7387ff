"""Lesson 12, the sender of views: offers them to Python, and sends what it asks for. In C#: ViewSender.cs.

Each try to connect has a new socket. When Python is gone no more pictures are taken; the game goes on, and when Python
is back it is offered the views again.
"""

import itertools
import threading
import time
from collections.abc import Callable

import zmq
from film_view import FilmView
from messages import LIMIT, Array, Message, MessageError, read, take

# Seconds for a connection, and then for the answer to hello.
TRY = 1.0


class ViewSender:
    """What happens is told to `report`, line by line."""

    def __init__(self, endpoint: str, timeout: float, report: Callable[[str], None] = print) -> None:
        self.endpoint, self.timeout, self.report, self.heard = endpoint, timeout, report, 0.0
        # Whether Python is there.
        self.connected = False

    def run(self, views: list[FilmView], stop: threading.Event) -> None:
        """Until `stop`. TimeoutError says that Python was not there for `timeout` seconds."""
        if not 0 < len({view.name for view in views}) == len(views):
            raise ValueError(f"each view needs a name of its own: {', '.join(view.name for view in views) or 'none'}")
        self.heard, why = time.monotonic(), "no connection"
        while not stop.is_set():
            if time.monotonic() > self.heard + self.timeout:
                waited = f"nobody films at {self.endpoint} within {self.timeout:g} s"
                raise TimeoutError(f"{waited}; is the server running? ({why})")
            with zmq.Context() as context, context.socket(zmq.DEALER) as socket:
                # Nothing can be sent while there is no connection, and none comes without a hello: lesson 09 says why.
                socket.linger, socket.maxmsgsize, socket.immediate, socket.reconnect_ivl = 0, LIMIT, True, -1
                socket.sndtimeo = int(1000 * min(TRY, self.timeout))
                socket.connect(self.endpoint)
                try:
                    self.talk(socket, views, stop)
                except zmq.Again:
                    pass
                except (MessageError, TimeoutError) as error:
                    why = str(error)
                    # Whoever refuses at once is not asked again at once.
                    stop.wait(min(TRY / 5, self.timeout))
                finally:
                    self.connected = False
                    for view in views:
                        view.film = None

    def talk(self, socket: zmq.Socket[bytes], views: list[FilmView], stop: threading.Event) -> None:
        sizes = b"".join(side.to_bytes(4, "little") for view in views for side in (view.width, view.height))
        names = {"views": ",".join(view.name for view in views)}
        socket.send_multipart(Message("hello", 0, names, [Array("int32", (len(views), 2), sizes)]).frames())
        welcome = self.receive(socket, min(TRY, self.timeout))
        if not welcome or welcome.kind != "welcome":
            raise MessageError("no-welcome", "no answer to hello")
        shown = ", ".join(f"{view.name} {view.width} x {view.height}" for view in views)
        self.report(f"{self.endpoint} can film {shown}")
        self.connected = True
        try:
            while not stop.is_set():
                self.serve(socket, views)
            # So many milliseconds for what was sent last; without them it would be dropped.
            socket.linger = 200
        except (MessageError, TimeoutError, zmq.Again) as error:
            self.report(f"trouble: {error}: no more pictures are taken")
            raise
        finally:
            self.heard = time.monotonic()

    def serve(self, socket: zmq.Socket[bytes], views: list[FilmView]) -> None:
        request = self.receive(socket)
        answers = [self.do(views, request)] if request and request.kind in ("begin", "end", "took") else []
        for message in filter(None, itertools.chain(answers, *(view.outgoing() for view in views))):
            socket.send_multipart(message.frames())
            if message.kind == "ended":
                view, frames, skipped = (message.values[name] for name in ("view", "frames", "skipped"))
                self.report(f"{view}: {frames} pictures, {skipped} skipped")

    def do(self, views: list[FilmView], request: Message) -> Message | None:
        try:
            wanted, there = take(request.values, "view", str), {view.name: view for view in views}
            if wanted not in there:
                raise MessageError("unknown-view", f"there is no view {wanted!a:.40}; there are: {', '.join(there)}")
            view = there[wanted]
            return {"begin": view.begin, "end": view.end, "took": view.took}[request.kind](request)
        except MessageError as error:
            return Message("error", request.id, {"code": error.code, "text": error.text})

    def receive(self, socket: zmq.Socket[bytes], seconds: float = 0.01) -> Message | None:
        if not socket.poll(int(1000 * seconds)):
            if not socket.poll(0, zmq.POLLOUT):
                raise TimeoutError("Python is gone")
            return None
        message = read(socket.recv_multipart())
        if message.kind == "error":
            raise MessageError(str(message.values.get("code"))[:40], str(message.values.get("text"))[:200])
        return message
