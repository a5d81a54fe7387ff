"""Lesson 12, one film of one view: what came, what was skipped, and the file."""

import contextlib
import itertools
import threading
from collections.abc import Callable
from pathlib import Path
from time import monotonic
from typing import Any

from netmq_example.messages import Message, MessageError, take
from netmq_example.video.film_writer import open_film


def free_path(view: str) -> Path:
    """VIEW_1.gif, or the next number that is free."""
    return next(path for i in itertools.count(1) if not (path := Path(f"{view}_{i}.gif")).exists())


class ViewFilm:
    """Made by one thread, and then belongs to another one; whoever has it may read how far it is."""

    def __init__(self, view: str, path: str | Path | None, fps: float) -> None:
        self.view, self.id, self.size = view, 0, (0, 0)
        self.path = free_path(view) if path == "" else Path(path) if path else None
        self.file = open_film(self.path, fps) if self.path else None
        self.made, self.began, self.seconds, self.frames, self.skipped = monotonic(), 0.0, 0.0, 0, 0
        # Why nothing is written any more. And whether it has come to its end.
        self.trouble, self.over = "", False
        self.newest: Any = None
        self.first = threading.Event()

    def __str__(self) -> str:
        name = self.path or self.view
        why = f"; {self.trouble}" if self.trouble else ""
        return f"film {name}: {self.frames} frames, {self.seconds:.1f} s, {self.skipped} skipped{why}"

    def begin(self, begun: Message, largest: tuple[int, int]) -> None:
        """The game has begun, and says how large its pictures are."""
        self.id, width, height = begun.id, take(begun.values, "width", int), take(begun.values, "height", int)
        if not (0 < width <= largest[0] and 0 < height <= largest[1]):
            raise MessageError("bad-size", f"{self.view} has no pictures of {width} x {height}")
        self.size = (height, width)

    def attempt(self, report: Callable[[str], object], do: Callable[..., None], *what: Any) -> None:
        """Whatever goes wrong with a film is said once, and ends that film alone."""
        try:
            do(*what)
        except Exception as error:
            if not self.trouble:
                self.stop(str(error) or repr(error))
                report(f"trouble: {self}")

    def seen(self, values: dict[str, Any]) -> float:
        """A time of the game, which cannot have filmed for longer than it was asked to; clocks differ a little."""
        time: float = take(values, "time", float)
        if not 0 <= time <= monotonic() - self.made + 60:
            raise MessageError("bad-time", f"{time:g} s is longer than it was filmed")
        return time

    def add(self, frame: Message) -> None:
        """The next picture. MessageError says why it is none, OSError why it cannot be written."""
        time, number = self.seen(frame.values), take(frame.values, "number", int)
        shape = frame.arrays[0].shape if len(frame.arrays) == 1 else ()
        if shape[:2] != self.size or shape[2:] not in ((3,), (4,)) or frame.arrays[0].dtype != "uint8":
            raise MessageError("bad-picture", f"a picture is uint8 {[*self.size]} and 3 or 4, not {[*shape]}")
        # Without the alpha of graphics cards, and with the highest row first.
        pixels = frame.arrays[0].numpy()[:, :, :3]
        self.newest = pixels[::-1] if frame.values.get("bottom_up") is True else pixels
        self.first.set()
        if self.trouble:
            return
        if self.file:
            self.file.add(self.newest, time)
        self.began = self.began if self.frames else time
        self.frames, self.skipped, self.seconds = self.frames + 1, number - self.frames - 1, time - self.began

    def stop(self, why: str) -> None:
        """Nothing more is written."""
        self.trouble, file, self.file = f"its file has ended early: {why[:200]}", self.file, None
        with contextlib.suppress(Exception):
            if file:
                file.close(self.began + self.seconds)

    def picture(self, timeout: float) -> Any:
        """The newest; the first one is waited for."""
        if not self.first.wait(timeout) or self.newest is None:
            raise TimeoutError(f"no picture of {self.view} within {timeout:g} s; is the game paused, or gone?")
        return self.newest.copy()

    def end(self, ended: Message) -> None:
        """The game has taken the last picture, and says when it was over."""
        self.close(self.seen(ended.values), take(ended.values, "skipped", int))

    def close(self, time: float | None = None, skipped: int | None = None) -> None:
        """Without a time it ends with its last picture: nobody knows how long that was seen."""
        if self.over:
            return
        self.over = True
        self.first.set()
        if self.trouble:
            return
        self.skipped = self.skipped if skipped is None else skipped
        if self.frames and time is not None:
            self.seconds = time - self.began
        if self.file:
            self.file.close(self.began + self.seconds)
