"""Lesson 12, a view of the game: what can be filmed, and the film that Python makes of it now. In C#: FilmView.cs.

    picture = view.due()            the game, in each of its frames: is a picture to be taken now?
    view.take(picture, pixels)      uint8 [height, width, 3], the lowest row first

Two pictures are on the way to Python at most, and two more are with a camera or wait. What would be the fifth one is
skipped and counted, so nothing piles up, and the game waits for nobody.
"""

import re
import sys
import time
from collections import deque
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, NamedTuple

# In its own lesson's folder; at home it lies beside this file.
sys.path.append(str(Path(__file__).resolve().parents[1] / "05_messages"))
from messages import LIMIT, Array, Message, MessageError, take

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
