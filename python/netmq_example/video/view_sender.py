"""The game's side of a film: offers views to Python, and sends the pictures that it asks for.

    view = FilmView("front", 320, 240)                       the largest size that Python may ask for
    sender = ViewSender("tcp://127.0.0.1:5562", timeout=30)  gives up after 30 s without Python
    threading.Thread(target=sender.run, args=([view], stop)).start()          until stop.set()

    picture = view.due()                in each frame of the game: is a picture to be taken now?
    if picture:
        view.take(picture, pixels)      uint8 [height, width, 3], the lowest row first, as large as picture.film says

Two pictures are on the way to Python at most, and two more are with a camera or wait. What would be the fifth one is
skipped and counted, so nothing piles up, and the game never waits. When Python is gone no more pictures are taken; the
game goes on, and when Python is back it is offered the views again. The messages are in films.py. In C# it is
ViewSender.cs and FilmView.cs. It needs only pyzmq.
"""

import logging
import math
import threading
import time
from collections import deque
from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import Any, NamedTuple

import zmq

from netmq_example import check
from netmq_example.errors import Lost, Refused, Timeout
from netmq_example.former import positional
from netmq_example.messages import LIMIT, Array, Message, MessageError, take
from netmq_example.one_connection import NO_CONNECTION, TRY_SECONDS, connect_once, poll
from netmq_example.program import limit
from netmq_example.trouble import cure, longer
from netmq_example.video.game import ENDPOINT, NAME

# Pictures that were sent and are not acknowledged by Python yet, and pictures at all.
MOST_SENT = 2
MOST_PICTURES = 4

log = logging.getLogger("netmq_example.video")


@dataclass
class Film:
    """A film that Python has asked for, and how far it is. Its pictures are counted from 1."""

    id: int
    width: int
    height: int
    interval: float
    began: float = field(default_factory=time.monotonic)
    # The second of the next picture, and the number of the last one that was due.
    next: float = 0.0
    number: int = 0
    skipped: int = 0
    sent: int = 0
    # Whether Python has asked for one more picture.
    wanted: bool = False
    # Those that are sent and not acknowledged, and those that are to be sent.
    away: set[Any] = field(default_factory=set)
    ready: deque[Message] = field(default_factory=deque)
    # The request to end it, and when that came.
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
        if not isinstance(name, str) or not NAME.fullmatch(name):
            raise ValueError(f"a view cannot be {name!a:.50}: give it a name of letters, digits, - and _")
        whole = all(check.is_number(side) and side == int(side) and side > 0 for side in (width, height))
        if not whole or 4 * int(width) * int(height) > LIMIT:
            raise ValueError(f"a view of {width!a:.20} x {height!a:.20} is too small, or too large for a message")
        self.name = name
        self.width = int(width)
        self.height = int(height)
        self.film: Film | None = None

    # The game's half.

    def due(self) -> Picture | None:
        """The picture that is to be taken now, if there is one."""
        film = self.film
        if not film or film.ending:
            return None
        now = film.now()
        if now < film.next and not film.wanted:
            return None
        # As often as it was asked for, whenever the game has its frames; more than one is not made up for.
        film.next = max(film.next + film.interval, now - film.interval)
        film.number += 1
        if film.number - film.skipped - film.sent + len(film.away) > MOST_PICTURES:
            film.skipped += 1
            return None
        film.wanted = False
        return Picture(film, {"view": self.name, "number": film.number, "time": now, "bottom_up": True})

    def take(self, picture: Picture, pixels: Any) -> None:
        """The pixels of this picture, now or some frames later: uint8 [height, width, 3 or 4], the lowest row first."""
        film = picture.film
        shape = tuple(getattr(pixels, "shape", ()))
        if shape[:2] != (film.height, film.width) or shape[2:] not in ((3,), (4,)) or str(pixels.dtype) != "uint8":
            given = f"{pixels.dtype} {[*shape]}" if shape else f"{pixels!r:.40}"
            raise ValueError(f"pixels takes uint8 [{film.height}, {film.width}, 3 or 4], not {given}")
        film.ready.append(Message("frame", film.id, picture.values, [Array("uint8", shape, pixels)]))

    # The network's half.

    def begin(self, request: Message) -> Message:
        if self.film:
            raise MessageError("busy-view", f"{self.name} is being filmed already: end that film first")
        width = take(request.values, "width", int) or self.width
        height = take(request.values, "height", int) or self.height
        fps = take(request.values, "fps", float)
        if not (0 < width <= self.width and 0 < height <= self.height):
            raise MessageError("bad-size", f"{self.name} is at most {self.width} x {self.height}")
        if not 0 <= fps <= 1000:
            raise MessageError("bad-rate", "fps is at most 1000, and 0 for pictures on demand alone")
        self.film = Film(request.id, width, height, 1 / fps if fps else math.inf, next=0 if fps else math.inf)
        return Message("begun", request.id, {"view": self.name, "width": width, "height": height})

    def look(self, request: Message) -> None:
        self.running().wanted = True

    def end(self, request: Message) -> None:
        film = self.running()
        film.seconds = film.now()
        film.ending = request

    def running(self) -> Film:
        if not self.film or self.film.ending:
            raise MessageError("not-filmed", f"{self.name} is not being filmed: begin a film first")
        return self.film

    def took(self, request: Message) -> None:
        if self.film and self.film.id == request.id:
            self.film.away.discard(request.values.get("number"))

    def outgoing(self) -> Iterator[Message]:
        """The pictures that are there, and the answer to `end` after the last one."""
        film = self.film
        if not film:
            return
        while film.ready and len(film.away) < MOST_SENT:
            picture = film.ready.popleft()
            film.sent += 1
            film.away.add(picture.values["number"])
            yield picture
        # A picture that a camera still has is waited for, but not for ever.
        if film.ending and (film.sent + film.skipped == film.number or film.now() > film.seconds + 1):
            values = {"view": self.name, "frames": film.sent, "skipped": film.skipped, "time": film.seconds}
            yield Message("ended", film.ending.id, values)
            # Not before it is sent: a game may end when it is not filmed any more.
            self.film = None


class ViewSender:
    """Logs each connection and film. `run` is for a thread of its own."""

    @positional("endpoint", "timeout", "report")
    def __init__(self, endpoint: str, *, timeout: float = 30.0) -> None:
        self.endpoint = check.endpoint(endpoint, ENDPOINT)
        self.timeout = check.seconds("timeout", timeout)
        self.report = log.warning
        # When Python was last there, and whether it is now.
        self.heard = 0.0
        self.connected = False

    def run(self, views: list[FilmView], stop: threading.Event) -> None:
        """Until `stop`. Timeout says that Python was not there for `timeout` seconds."""
        names = [view.name for view in views]
        if not names or len({*names}) < len(names):
            raise ValueError(f"each view needs a name of its own: {', '.join(names) or 'none'}")
        self.heard = time.monotonic()
        why = NO_CONNECTION
        tries = 0
        while not stop.is_set():
            left = self.heard + self.timeout - time.monotonic()
            if left < 0:
                waited = f"nobody films at {self.endpoint} within {self.timeout:g} s"
                raise Timeout(f"{waited}; {cure(self.endpoint, 'is the server running?')} ({why})")
            with zmq.Context() as context, context.socket(zmq.DEALER) as socket:
                limit(socket, LIMIT)
                socket.sndtimeo = int(1000 * TRY_SECONDS)
                wait = min(longer(TRY_SECONDS, tries), left)
                try:
                    connect_once(socket, self.endpoint, wait, stop)
                    self.talk(socket, views, stop, wait)
                except (Refused, MessageError, ConnectionError, TimeoutError, zmq.Again) as error:
                    why = str(error)
                    # Where nobody listens yet, a short try is enough.
                    tries = 0 if self.connected or isinstance(error, ConnectionRefusedError) else tries + 1
                    # A peer that refuses at once is not asked again at once.
                    stop.wait(min(TRY_SECONDS / 5, self.timeout))
                finally:
                    self.connected = False
                    for view in views:
                        view.film = None

    def talk(self, socket: zmq.Socket[bytes], views: list[FilmView], stop: threading.Event, wait: float) -> None:
        sizes = b"".join(side.to_bytes(4, "little") for view in views for side in (view.width, view.height))
        names = {"views": ",".join(view.name for view in views)}
        socket.send_multipart(Message("hello", 0, names, [Array("int32", (len(views), 2), sizes)]).frames())
        poll(socket, zmq.POLLIN, wait, stop)
        welcome = self.receive(socket, 0)
        if not welcome or welcome.kind != "welcome":
            raise MessageError("no-welcome", "no answer to hello")
        shown = ", ".join(f"{view.name} {view.width} x {view.height}" for view in views)
        log.info("%s can film %s", self.endpoint, shown)
        self.connected = True
        try:
            while not stop.is_set() and self.serve(socket, views):
                pass
            # So many milliseconds for what was sent last; without them it would be dropped.
            socket.linger = 200
            # One that leaves behind each welcome is not asked again at once.
            stop.wait(TRY_SECONDS)
        except (Refused, MessageError, ConnectionError, zmq.Again) as error:
            self.report(f"trouble: {error}: no more pictures are taken")
            raise
        finally:
            self.heard = time.monotonic()

    def serve(self, socket: zmq.Socket[bytes], views: list[FilmView]) -> bool:
        """A moment of it: what Python asks for, and what there is to send. False if Python leaves."""
        request = self.receive(socket)
        answer = self.do(views, request) if request else None
        if answer:
            socket.send_multipart(answer.frames())
        for view in views:
            for message in view.outgoing():
                socket.send_multipart(message.frames())
                if message.kind == "ended":
                    values = message.values
                    log.info("%s: %s pictures, %s skipped", view.name, values["frames"], values["skipped"])
        return answer is None or answer.kind != "closed"

    def do(self, views: list[FilmView], request: Message) -> Message | None:
        """The answer to a request that has one."""
        if request.kind not in ("begin", "look", "took", "end"):
            return Message("closed", request.id) if request.kind == "close" else None
        try:
            name = take(request.values, "view", str)
            there = {view.name: view for view in views}
            if name not in there:
                raise MessageError("unknown-view", f"there is no view {name!a:.40}; there are: {', '.join(there)}")
            # The method has the name of what is asked for.
            answer: Message | None = getattr(there[name], request.kind)(request)
        except MessageError as error:
            return Message("error", request.id, {"code": error.code, "text": error.text})
        return answer

    def receive(self, socket: zmq.Socket[bytes], seconds: float = 0.01) -> Message | None:
        if not socket.poll(int(1000 * seconds)):
            if not socket.poll(0, zmq.POLLOUT):
                raise Lost("Python is gone")
            return None
        message = Message.read(socket.recv_multipart())
        if message.kind == "error":
            raise Refused(str(message.values.get("code"))[:40], str(message.values.get("text"))[:200])
        return message
