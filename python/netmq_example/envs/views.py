"""The views of an environment's scene, which lesson 12's ViewRecorder sends: rendering.py says what becomes of them.

It needs numpy and Pillow, and av for an MP4.
"""

import importlib
import importlib.util
import math
import os
import tempfile
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from gymnasium import logger

from netmq_example.errors import Lost, Timeout
from netmq_example.video.game import ENDPOINT, side

__all__ = ["ENDPOINT", "Renderer"]
# For a ViewRecorder, whose game is there already.
WAIT_SECONDS = 10.0


class Renderer:
    """The views of one environment. `views` are the names that its user gave."""

    def __init__(self, mode: str, views: Sequence[str], endpoint: str) -> None:
        try:
            # Lesson 12's, whose Pillow nobody needs who has no render_mode.
            self.films: Any = importlib.import_module("netmq_example.video.films").Films(endpoint)
        except ModuleNotFoundError as error:
            raise ModuleNotFoundError(f"render_mode needs Pillow: pip install pillow ({error})") from None
        self.films.start()
        self.mode = mode
        self.views = list(dict.fromkeys(views))
        self.size = (0, 0)
        self.takes = {name: Take() for name in self.views}
        # The newest picture of each view in this episode.
        self.newest: dict[str, Any] = {}
        # A list is filled in every episode, as Gymnasium has it, until its user says when.
        self.by_itself = self.recording = mode == "rgb_array_list"
        self.moving = False

    def begin(self, width: int, height: int) -> None:
        sides = [side("screen_width", width), side("screen_height", height)]
        there = self.there()
        for view in self.names(there).values():
            if sides[0] > there[view][0] or sides[1] > there[view][1]:
                most = " x ".join(map(str, there[view]))
                raise ValueError(f"{view} is at most {most}: set Width and Height of its ViewRecorder, or leave -1")
        if self.mode == "video" and not importlib.util.find_spec("av"):
            logger.warn("av is not here: render_all can write a .gif, and no MP4")
        if self.size != (sides[0], sides[1]):
            self.films.end_all()
            self.size = (sides[0], sides[1])
        self.clear()
        self.by_itself = False
        self.recording = self.mode != "rgb_array"
        if self.moving and self.recording:
            self.keep()

    def end(self) -> None:
        self.by_itself = self.recording = False

    def moved(self, begins: bool) -> None:
        self.moving = True
        if begins:
            self.newest.clear()
        if begins and self.by_itself:
            self.clear()
        if self.recording:
            self.keep()

    def keep(self) -> None:
        for name, pixels in self.look(self.views).items():
            self.takes[name].add(pixels)

    def all_of(self, names: Sequence[str], paths: Mapping[str, Any], fps: float) -> dict[str, Any]:
        self.check_open()
        unknown = [name for name in paths if name not in self.views]
        if unknown:
            raise ValueError(f"video_paths has the view {unknown[0]!r}, but views is {self.views}")
        if self.mode == "rgb_array":
            return self.look(names)
        if self.mode == "rgb_array_list":
            return {name: self.takes[name].taken() for name in names}
        given = {name: paths[name] for name in names if paths.get(name) is not None}
        files = {name: film_writer().film_path("video_paths", path) for name, path in given.items()}
        for name in names:
            if not self.takes[name].shapes:
                raise ValueError(
                    f"no picture of view {name!r} is there: call begin_render before the steps to be filmed"
                )
        return {name: self.takes[name].film(files.get(name), fps) for name in names}

    def look(self, names: Sequence[str]) -> dict[str, Any]:
        """A new picture of each. A film goes on when the game is gone, with the picture before, and a line says so."""
        try:
            self.newest.update(self.see(names))
        except OSError as error:
            if self.newest.keys() >= set(names):
                self.films.trouble(f"trouble: {error}; the picture before is shown once more")
            elif isinstance(error, Lost):
                # It was that of the simulator before. The one that came in its place is waited for.
                self.newest.update(self.see(names))
            else:
                raise
        return {name: self.newest[name] for name in names}

    def see(self, names: Sequence[str]) -> dict[str, Any]:
        views = self.names(self.there())
        for view in views.values():
            # They stay begun until the game or the size is another one.
            if view not in self.films.films or self.films.films[view].over:
                self.films.begin_render(view, None, *self.size, fps=0)
        pictures = self.films.look({views[name] for name in names})
        return {name: pictures[views[name]] for name in names}

    def there(self) -> dict[str, tuple[int, int]]:
        """The game's views, and how large they are at most."""
        self.check_open()
        if not self.films.game.views and self.newest:
            raise Lost("the game is gone")
        try:
            views: dict[str, tuple[int, int]] = self.films.game.views or self.films.wait(WAIT_SECONDS)
            return views
        except TimeoutError:
            at = self.films.game.endpoint
            cure = (
                "let the scene draw itself (Render, in Python render),"
                " or add a ViewRecorder with a camera and this Endpoint to it"
            )
            raise Timeout(f"no view came to {at}: {cure}") from None

    def names(self, there: Mapping[str, Any]) -> dict[str, str]:
        unknown = [name for name in self.views if name not in ("", *there)]
        if unknown:
            raise ValueError(f"there is no view {unknown[0]!r}; the game has: {', '.join(there)}")
        return {name: name or next(iter(there)) for name in self.views}

    def clear(self) -> None:
        for take in self.takes.values():
            take.clear()

    def check_open(self) -> None:
        if self.films.over.is_set():
            raise ValueError("this environment is closed")

    def close(self) -> None:
        self.recording = False
        self.films.close()
        for take in self.takes.values():
            take.file.close()


class Take:
    """The pictures of a view, in a file without a name: those of a long film would fill the memory."""

    def __init__(self) -> None:
        self.file = tempfile.TemporaryFile()  # noqa: SIM115, close does it.
        self.shapes: list[tuple[int, ...]] = []

    def add(self, pixels: Any) -> None:
        self.file.seek(0, os.SEEK_END)
        self.file.write(pixels.tobytes())
        self.shapes.append(pixels.shape)

    def pictures(self) -> Iterator[Any]:
        self.file.seek(0)
        for shape in self.shapes:
            yield np.frombuffer(self.file.read(math.prod(shape)), np.uint8).reshape(shape).copy()

    def taken(self) -> list[Any]:
        """Each picture is given once, as Gymnasium has it."""
        pictures = list(self.pictures())
        self.clear()
        return pictures

    def film(self, path: Path | None, fps: float) -> Any:
        """The whole path of the file, or without a path its bytes. OSError: av is missing."""
        if not path:
            with tempfile.TemporaryDirectory() as folder:
                made = Path(folder) / f"film{film_writer().usual_ending()}"
                self.write(made, fps)
                return made.read_bytes()
        # Beside what it replaces, and so on the same disk: a film that fails leaves what was there under its name.
        made = path.with_name(f".{os.getpid()}-{path.name}")
        made.unlink(missing_ok=True)
        try:
            self.write(made, fps)
            os.replace(made, path)
        finally:
            made.unlink(missing_ok=True)
        return os.path.abspath(path)

    def write(self, path: Path, fps: float) -> None:
        film = film_writer().open_film(path, fps)
        try:
            for number, pixels in enumerate(self.pictures()):
                film.add(pixels, number / fps)
        finally:
            film.close(len(self.shapes) / fps)

    def clear(self) -> None:
        self.file.truncate(0)
        self.shapes = []


def film_writer() -> Any:
    """Lesson 12's, whose Pillow nobody needs who makes no film."""
    return importlib.import_module("netmq_example.video.film_writer")
