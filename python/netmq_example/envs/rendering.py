"""The pictures and films of an environment: a scene draws itself (Render in C#), or lesson 12's ViewRecorder does.

    env = gymnasium.make("NetMQExample/Unity-v0", …, render_mode="rgb_array")
    env.render()                                            what the scene or its agent draws, else its first view
    env = gymnasium.make("NetMQExample/Unity-v0", …, render_mode="video", views=["", "front"])
    env.reset()
    env.unwrapped.begin_render()                            a picture of now, then one of each reset and step
    env.step(action)
    env.unwrapped.end_render()
    env.unwrapped.render_all({"front": "front.mp4"})        {"": an MP4 in bytes, "front": the file's whole path}
    film = env.render()                                     that of the first view, in bytes

A film goes by the world's time and not by the real clock: a step is one picture, and `render_fps` of them are a second.
Without `render_fps` a picture is as long as a tick. With "rgb_array" each `render` is a new picture of now; with
"rgb_array_list" it is those that no `render` has returned yet, of this episode, or since `begin_render`.
A view "" is the game's first one.

ValueError names what was called wrongly, OSError says that there is no view or no av. It needs numpy and Pillow, and
av for an MP4.
"""

import importlib
import importlib.util
import os
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any

from gymnasium import logger

from netmq_example import arguments
from netmq_example.envs.common import gives_pictures
from netmq_example.envs.connection import FREE_PORT
from netmq_example.envs.remote import Remote
from netmq_example.envs.take import Take, film_writer
from netmq_example.errors import Lost, Timeout
from netmq_example.finalizers import finalizer
from netmq_example.messages import MessageError
from netmq_example.video.game import ENDPOINT, side

MODES = ["rgb_array", "rgb_array_list", "video"]
# For a ViewRecorder, whose game is there already.
WAIT_SECONDS = 10.0


class Rendered:
    """The base of an environment that renders. Its `render_mode` and `metadata` are Gymnasium's."""

    render_mode: str | None
    metadata: dict[str, Any]
    remote: Remote
    renderer: "Renderer | None" = None
    views: tuple[Sequence[str], str] = (("",), "")
    # Whether the scene draws itself; None until it was asked.
    draws: bool | None = None
    newest: Any = None

    def show(self, remote: Remote, mode: str | None, views: Sequence[str], view_endpoint: str) -> None:
        """Before the simulator is found: one that is launched is told where its views go."""
        self.render_mode = mode
        self.views = views, view_endpoint
        if mode is None or (mode == "rgb_array" and not self.wants_views(remote)):
            return
        try:
            self.open_views(remote)
        except BaseException:
            remote.simulators.close()
            raise

    def wants_views(self, remote: Remote) -> bool:
        """Whether views may be needed, and can be taken. Libraries always ask for rgb_array, also where there is no
        Pillow, and where the views' port is another environment's."""
        return bool(remote.simulators.launch) and importlib.util.find_spec("PIL") is not None

    def open_views(self, remote: Remote) -> None:
        views, endpoint = self.views
        launch = remote.simulators.launch
        self.renderer = Renderer(self.render_mode or "", views, endpoint or (FREE_PORT if launch else ENDPOINT))
        if launch:
            remote.simulators.views = self.renderer.films.game.endpoint
        # Also when nobody calls close, and when no simulator comes.
        finalizer(self, self.renderer.close)

    def viewed(self) -> "Renderer":
        """With views, which "rgb_array" opens only where they are wanted."""
        if not self.renderer:
            if self.remote.simulators.connection.closed:
                raise ValueError("this environment is closed")
            self.open_views(self.remote)
        assert self.renderer
        return self.renderer

    def started(self, remote: Remote) -> Callable[[], object]:
        """Find a simulator, and return the function that ends it. If none comes, the views' port is free at once."""
        try:
            return remote.simulators.start(self, remote.accept)
        except BaseException:
            self.end_films()
            raise

    def drawn(self) -> list[Any] | None:
        """The pictures that the scene draws itself; None if it draws none."""
        if self.draws is False:
            return None
        try:
            self.newest = self.remote.pictures()
            self.draws = True
        except MessageError as error:
            if error.code != "no-picture":
                raise
            self.draws = False
            return None
        except Lost:
            # A film goes on when the simulator is lost, with the picture before; step says that it is.
            if self.newest is None:
                raise
        pictures: list[Any] = self.newest
        return pictures

    def own_picture(self, pictures: list[Any]) -> Any:
        """That of this environment."""
        raise NotImplementedError

    def begin_render(self, screen_width: int = -1, screen_height: int = -1, fullscreen: bool = False) -> None:
        """Begin a film of each view, in place of the one before. -1 is the largest size that the game allows.

        The screen stays as it is. It is always the pictures that are so large.
        """
        if gives_pictures(self.render_mode):
            if fullscreen:
                logger.warn("fullscreen changes nothing: begin_render leaves the screen as it is")
            self.viewed().begin(screen_width, screen_height)

    def end_render(self) -> None:
        """Take no more pictures. Those that came stay until the next begin_render."""
        if self.renderer:
            self.renderer.end()

    def render_all(self, video_paths: Mapping[str, str | os.PathLike[str] | None] | None = None) -> dict[str, Any]:
        """By view what its render_mode says: a picture, a list of them, or a film.

        A film whose path is None or missing is an MP4 in bytes, else a file, which replaces one of that name; its whole
        path is returned. What the path ends in decides what it becomes, see film_writer.py.
        """
        if not gives_pictures(self.render_mode):
            return {}
        renderer = self.viewed()
        return renderer.all_of(renderer.views, video_paths or {}, self.metadata["render_fps"])

    def render(self) -> Any:
        """The same of the first view alone; or the picture that the scene draws itself."""
        if not gives_pictures(self.render_mode):
            return None
        if self.render_mode == "rgb_array":
            pictures = self.drawn()
            if pictures is not None:
                return self.own_picture(pictures)
        renderer = self.viewed()
        first = renderer.views[0]
        return renderer.all_of([first], {}, self.metadata["render_fps"])[first]

    def filmed(self, begins: bool) -> None:
        """Called after each reset, which begins an episode, and after each step."""
        if self.renderer:
            self.renderer.moved(begins)

    def end_films(self) -> None:
        if self.renderer:
            self.renderer.close()


class Renderer:
    """The views of one environment. `views` are the names that its user gave."""

    def __init__(self, mode: str, views: Sequence[str], endpoint: str) -> None:
        self.films = films_at(endpoint)
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
        files = {name: film_path(paths.get(name)) for name in names}
        for name in names:
            if not self.takes[name].shapes:
                raise ValueError(
                    f"no picture of view {name!r} is there: call begin_render before the steps to be filmed"
                )
        return {name: self.takes[name].film(files[name], fps) for name in names}

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
            cure = "add a ViewRecorder with this Endpoint, and a camera, to the scene"
            raise Timeout(f"no view came to {at}: {cure}") from None

    def names(self, there: Mapping[str, Any]) -> dict[str, str]:
        """The game's names of the views."""
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


def check_words(mode: Any, views: Any, render_fps: Any) -> None:
    """A mistake is named before anybody is waited for."""
    if mode not in (None, *MODES):
        raise ValueError(f"render_mode takes None or one of {', '.join(MODES)}, not {mode!r:.40}")
    if not isinstance(views, list | tuple) or not views or not all(isinstance(view, str) for view in views):
        raise ValueError(f'views takes a list of names, such as ["", "front"], not {views!r:.80}')
    if render_fps is not None:
        arguments.number("render_fps", render_fps, least=0.01, most=1000)


def films_at(endpoint: str) -> Any:
    """Lesson 12's, whose Pillow nobody needs who has no render_mode."""
    try:
        return importlib.import_module("netmq_example.video.films").Films(endpoint)
    except ModuleNotFoundError as error:
        raise ModuleNotFoundError(f"render_mode needs Pillow: pip install pillow ({error})") from None


def film_path(path: Any) -> Path | None:
    return None if path is None else film_writer().film_path("video_paths", path)
