"""Lesson 12, films: what the views of a running game show becomes films, on command.

    films = Films()                                     the game comes to tcp://127.0.0.1:5562
    films.wait()                                        its views: {"front": (320, 240), "map": (320, 240)}
    films.begin_render("front", "drive.gif", fps=25)    or .png, .webp, .mp4
    ...                                                 whatever else Python does with the game
    film = films.end_render("front")                    prints: film drive.gif: 125 frames, 5.0 s, 0 skipped
    pictures = films.render_all()                       {"front": uint8 [240, 320, 3], "map": …}

A thread of its own receives and writes. The game sends at most two pictures that were not taken: when writing is slow,
it skips the others, and says how many they were.
They need numpy and Pillow.
"""

import contextlib
import time
from collections.abc import Callable
from operator import index
from pathlib import Path
from typing import Any, Self

import zmq
from filming import Filming
from game import Lost, bound
from messages import MessageError
from view_film import ViewFilm

ENDPOINT = "tcp://127.0.0.1:5562"


class Films(Filming):
    """For any thread. `report` gets a line about each film. A socket that is given is not closed."""

    def __init__(
        self,
        endpoint: str = ENDPOINT,
        socket: zmq.Socket[bytes] | None = None,
        timeout: float = 10,
        report: Callable[[str], object] = print,
    ) -> None:
        self.own, self.seen = socket is None, 0
        super().__init__(socket or bound(endpoint), timeout, report)

    def wait(self, seconds: float = 60) -> dict[str, tuple[int, int]]:
        """The next game's views, with their largest width and height. TimeoutError says that none came."""
        self.start()
        end = time.monotonic() + seconds
        while self.game.count == self.seen or not self.game.views:
            if time.monotonic() > end:
                raise TimeoutError(f"no game came within {seconds:g} s; is it running, with a ViewRecorder in it?")
            time.sleep(0.02)
        self.seen = self.game.count
        return self.game.views

    def begin_render(
        self, view: str = "", path: str | Path | None = "", width: int = 0, height: int = 0, fps: float = 25
    ) -> None:
        """Begin a film of a view, or of the first one. 0 is the view's largest width or height.

        Without a path it becomes VIEW_1.gif, or the next number that is free; None writes no file. ValueError and
        OSError say why there can be no file, MessageError is the game's refusal.
        """
        view = view or next(iter(self.game.views), "")
        film = ViewFilm(view, path, fps)
        try:
            self.ask("begin", {"view": view, "width": index(width), "height": index(height), "fps": float(fps)}, film)
        except BaseException:
            film.close()
            raise
        if film.path and not film.trouble:
            self.report(f"begin {view} {film.size[1]} x {film.size[0]}")

    def end_render(self, view: str = "") -> ViewFilm:
        """The film, whole. Of a game that is gone it is what came."""
        view = view or next(iter(self.films), "")
        film = self.films.get(view)
        if not film or not film.over:
            try:
                self.ask("end", {"view": view})
            except Lost:
                if not film:
                    raise
        return self.films.pop(view)

    def render_all(self) -> dict[str, Any]:
        """The newest picture of each view; of one that is not filmed a new one."""
        views = list(self.game.views)
        idle = [view for view in views if view not in self.films or self.films[view].over]
        for view in idle:
            self.begin_render(view, None)
        try:
            return {view: self.films[view].picture(self.timeout) for view in views}
        finally:
            for view in idle:
                self.end_render(view)

    def close(self) -> None:
        """End all films, and leave the game."""
        self.timeout = min(1, self.timeout)
        for view in [view for view, film in list(self.films.items()) if not film.over]:
            with contextlib.suppress(OSError, MessageError):
                self.end_render(view)
        self.over.set()
        if self.thread.is_alive():
            self.thread.join()
        self.lose()
        if self.own:
            self.game.socket.context.destroy()

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *error: object) -> None:
        self.close()
