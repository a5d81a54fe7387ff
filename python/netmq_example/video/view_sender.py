"""Lesson 12, the sender of views: offers them to Python, and sends what it asks for. In C#: ViewSender.cs.

Each try to connect has a new socket. When Python is gone no more pictures are taken; the game goes on, and when Python
is back it is offered the views again.

Lesson 12, a view of the game: what can be filmed, and the film that Python makes of it now. In C#: FilmView.cs.

    picture = view.due()            the game, in each of its frames: is a picture to be taken now?
    view.take(picture, pixels)      uint8 [height, width, 3], the lowest row first

Two pictures are on the way to Python at most, and two more are with a camera or wait. What would be the fifth one is
skipped and counted, so nothing piles up, and the game waits for nobody.
"""

import itertools
import re
import threading
import time
from collections import deque
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from typing import Any, NamedTuple

import zmq

from netmq_example.messages import LIMIT, Array, Message, MessageError, read, take

# Pictures that were sent and are not yet with Python, and pictures at all.
CREDIT, ROOM = 2, 4


@dataclass
class Film:
    """What Python has asked for, and how far it is."""

    id: int
    width: int
    height: int
    interval: float
    began: float = field(default_factory=time.monotonic)
    next: float = 0.0
    number: int = 0
    skipped: int = 0
    sent: int = 0
    away: set[Any] = field(default_factory=set)
    ready: deque[Message] = field(default_factory=deque)
    ending: Message | None = None
    seconds: float = 0.0

    def now(self) -> float:
        return time.monotonic() - self.began


class Picture(NamedTuple):
    """One that is to be taken now."""

    film: Film
    values: dict[str, Any]


class FilmView:
    """Half of it is for the game's thread, half for the network's."""

    def __init__(self, name: str, width: int, height: int) -> None:
        # It becomes the name of a file.
        if not re.fullmatch(r"[A-Za-z0-9_ -]{1,40}", name):
            raise ValueError(f"a view cannot be {name!a:.50}: give it a name of letters, digits, - and _")
        if not (width > 0 and height > 0 and 4 * width * height <= LIMIT):
            raise ValueError(f"a view of {width} x {height} is too small, or too large for a message")
        self.name, self.width, self.height = name, int(width), int(height)
        self.film: Film | None = None

    # The game's half.

    def due(self) -> Picture | None:
        film = self.film
        if not film or film.ending or (now := film.now()) < film.next:
            return None
        # As often as it was asked for, whenever the game has its frames; more than one is not made up for.
        film.next = max(film.next + film.interval, now - film.interval)
        film.number += 1
        if film.number - film.skipped - film.sent + len(film.away) > ROOM:
            film.skipped += 1
            return None
        return Picture(film, {"view": self.name, "number": film.number, "time": now, "bottom_up": True})

    def take(self, picture: Picture, pixels: Any) -> None:
        film, pictures = picture.film, [Array("uint8", pixels.shape, pixels)]
        film.ready.append(Message("frame", film.id, picture.values, pictures))

    # The network's half.

    def begin(self, request: Message) -> Message:
        if self.film:
            raise MessageError("busy-view", f"{self.name} is being filmed already: end that film first")
        width = take(request.values, "width", int) or self.width
        height, fps = take(request.values, "height", int) or self.height, take(request.values, "fps", float)
        if not (0 < width <= self.width and 0 < height <= self.height):
            raise MessageError("bad-size", f"{self.name} is at most {self.width} x {self.height}")
        if not 0 < fps <= 1000:
            raise MessageError("bad-rate", "fps is more than 0, and at most 1000")
        self.film = Film(request.id, width, height, 1 / fps)
        return Message("begun", request.id, {"view": self.name, "width": width, "height": height})

    def end(self, request: Message) -> None:
        if not (film := self.film) or film.ending:
            raise MessageError("not-filmed", f"{self.name} is not being filmed: begin a film first")
        film.seconds, film.ending = film.now(), request

    def took(self, request: Message) -> None:
        if self.film and self.film.id == request.id:
            self.film.away.discard(request.values.get("number"))

    def outgoing(self) -> Iterator[Message]:
        """The pictures that are there, and the answer to `end` after the last one."""
        film = self.film
        while film and film.ready and len(film.away) < CREDIT:
            film.sent += 1
            film.away.add(film.ready[0].values["number"])
            yield film.ready.popleft()
        # What a camera still has is waited for, but not for ever.
        if film and film.ending and (film.sent + film.skipped == film.number or film.now() > film.seconds + 1):
            values = {"view": self.name, "frames": film.sent, "skipped": film.skipped, "time": film.seconds}
            yield Message("ended", film.ending.id, values)
            # Not before it is sent: a game may end when it is not filmed any more.
            self.film = None


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
