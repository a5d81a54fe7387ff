"""One film of one view, as films.py makes it: what came, what was skipped, and the file.

    film.frames, film.skipped, film.seconds, film.path         read by anybody, at any time
    print(film)                                                film drive.mp4: 125 frames, 5.0 s, 0 skipped

A game is not trusted: a picture of another size than was begun, or a time longer than it was filmed, ends the film with
a line that says why. It needs numpy and Pillow, and av for an MP4 or a WebM.
"""

import contextlib
import itertools
import os
import threading
from collections.abc import Callable
from pathlib import Path
from time import monotonic
from typing import Any

from netmq_example import check
from netmq_example.errors import Lost, Timeout
from netmq_example.messages import Message, MessageError, take
from netmq_example.video.film_writer import open_film, usual_ending


def free_path(view: str) -> Path:
    """VIEW_1.mp4 or VIEW_1.webm, or the next number that is free."""
    ending = usual_ending()
    paths = (Path(f"{view}_{number}{ending}") for number in itertools.count(1))
    return next(path for path in paths if not path.exists())


class ViewFilm:
    """Made by one thread, and then belongs to another one.

    The path "" is the next free one; None keeps the newest picture only, and writes no file.
    """

    def __init__(self, view: str, path: str | os.PathLike[str] | None, fps: float) -> None:
        self.view = check.instance("view", view, str)
        if path == "":
            path = free_path(view)
        self.file = None if path is None else open_film(path, fps)
        self.path = self.file.path if self.file else None
        # The id of its begin, and height and width; the game says both.
        self.id = 0
        self.size = (0, 0)
        self.frames = 0
        self.skipped = 0
        # How long it is, and by the game's clock when its first picture was seen.
        self.seconds = 0.0
        self.began = 0.0
        self.made = monotonic()
        # Why nothing is written any more, and whether it has come to its end.
        self.trouble = ""
        self.over = False
        self.newest: Any = None
        self.came = threading.Event()

    def __str__(self) -> str:
        name = self.path or self.view
        why = f"; {self.trouble}" if self.trouble else ""
        return f"film {name}: {self.frames} frames, {self.seconds:.1f} s, {self.skipped} skipped{why}"

    def begin(self, begun: Message, largest: tuple[int, int]) -> None:
        """The game has begun, and says how large its pictures are."""
        self.id = begun.id
        width = take(begun.values, "width", int)
        height = take(begun.values, "height", int)
        if not (0 < width <= largest[0] and 0 < height <= largest[1]):
            raise MessageError("bad-size", f"{self.view} has no pictures of {width} x {height}")
        self.size = (height, width)

    def attempt(self, report: Callable[[str], object], do: Callable[..., None], *args: Any) -> None:
        """A mistake in a film is reported once, and ends that film alone."""
        try:
            do(*args)
        except Exception as error:
            if not self.trouble:
                self.stop(str(error) or repr(error))
                report(f"trouble: {self}")

    def time_of(self, values: dict[str, Any]) -> float:
        """A time of the game, which cannot have filmed for longer than it was asked to; clocks differ a little."""
        time: float = take(values, "time", float)
        if not 0 <= time <= monotonic() - self.made + 60:
            raise MessageError("bad-time", f"{time:g} s is longer than it was filmed")
        return time

    def add(self, frame: Message) -> None:
        """The next picture. MessageError says why it is none, OSError why it cannot be written."""
        time = self.time_of(frame.values)
        number = take(frame.values, "number", int)
        shape = frame.arrays[0].shape if len(frame.arrays) == 1 else ()
        if shape[:2] != self.size or shape[2:] not in ((3,), (4,)) or frame.arrays[0].dtype != "uint8":
            raise MessageError("bad-picture", f"a picture is uint8 {[*self.size]} and 3 or 4, not {[*shape]}")
        # Without the alpha of graphics cards, and with the highest row first.
        pixels = frame.arrays[0].numpy()[:, :, :3]
        self.newest = pixels[::-1] if frame.values.get("bottom_up") is True else pixels
        self.came.set()
        if self.trouble:
            return
        if self.file:
            self.file.add(self.newest, time)
        if not self.frames:
            self.began = time
        self.frames += 1
        self.skipped = number - self.frames
        self.seconds = time - self.began

    def stop(self, why: str) -> None:
        """Nothing more is written."""
        self.trouble = f"its file has ended early: {why[:200]}"
        file = self.file
        self.file = None
        with contextlib.suppress(Exception):
            if file:
                file.close(self.began + self.seconds)

    def expect(self) -> None:
        """A picture is to be waited for, and it is not the newest one of now."""
        self.newest = None
        self.came.clear()

    def picture(self, timeout: float) -> Any:
        """The newest; the first one is waited for. Lost: the game is gone, and another one may be there."""
        came = self.came.wait(timeout)
        if came and self.over:
            raise Lost("the game is gone")
        if not came or self.newest is None:
            raise Timeout(f"no picture of {self.view} within {timeout:g} s; is the game paused, or gone?")
        return self.newest.copy()

    def end(self, ended: Message) -> None:
        """The game has taken the last picture, and says when it was over."""
        self.close(self.time_of(ended.values), take(ended.values, "skipped", int))

    def close(self, time: float | None = None, skipped: int | None = None) -> None:
        """Without a time it ends with its last picture: nobody knows how long that was seen."""
        if self.over:
            return
        self.over = True
        self.came.set()
        if self.trouble:
            return
        if skipped is not None:
            self.skipped = skipped
        if self.frames and time is not None:
            self.seconds = time - self.began
        if self.file:
            self.file.close(self.began + self.seconds)
