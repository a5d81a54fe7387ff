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
from typing import Any

from gymnasium import logger

from netmq_example import arguments
from netmq_example.envs.kinds import SceneHello
from netmq_example.envs.remote import Remote
from netmq_example.envs.simulators import FREE_PORT, Simulators
from netmq_example.errors import Lost
from netmq_example.finalizers import finalizer
from netmq_example.messages import MessageError

MODES = ["rgb_array", "rgb_array_list", "video"]


class Rendered:
    """The base of an environment that renders. Its `render_mode` and `metadata` are Gymnasium's."""

    render_mode: str | None
    metadata: dict[str, Any]
    remote: Remote
    simulators: Simulators
    use: Callable[[SceneHello], None]
    close_once: Callable[[], object]
    # Of views.py.
    renderer: Any = None
    views: tuple[Sequence[str], str] = (("",), "")
    # Whether the scene draws itself; None until it was asked.
    draws: bool | None = None
    newest: Any = None

    def find(
        self,
        env_name: str,
        file_name: str | os.PathLike[str] | None = None,
        render_mode: str | None = None,
        views: Sequence[str] = ("",),
        render_fps: float | None = None,
        view_endpoint: str = "",
        real_time: bool = False,
        **where: Any,
    ) -> None:
        """Its simulator, of which `use` looks at the agents. `where` is what Simulators takes: endpoint, launch, wait,
        timeout, context, fleet; `file_name` is gymize's name for launch. With `real_time` the world goes on while
        Python thinks, and a step waits for its tick.

        A mistake is named before anybody is waited for. What is launched is told where its views go; if none comes,
        their port is free at once.
        """
        if render_mode not in (None, *MODES):
            raise ValueError(f"render_mode takes None or one of {', '.join(MODES)}, not {render_mode!r:.40}")
        if not isinstance(views, list | tuple) or not views or not all(isinstance(view, str) for view in views):
            raise ValueError(f'views takes a list of names, such as ["", "front"], not {views!r:.80}')
        if render_fps is not None:
            arguments.number("render_fps", render_fps, least=0.01, most=1000)
        self.render_mode = render_mode
        self.render_fps = render_fps
        self.views = views, view_endpoint
        remote = self.remote = Remote(env_name, self.use, file_name, real_time, **where)
        self.simulators = remote.simulators
        try:
            # Libraries always ask for rgb_array, also where there is no Pillow, or the views' port is another one's.
            launches = remote.simulators.launch and importlib.util.find_spec("PIL")
            if self.render_mode not in (None, "rgb_array") or (self.render_mode and launches):
                self.open_views(remote)
            # Also when nobody calls close: at garbage collection, and at the end of the program. And only once.
            self.close_once = remote.simulators.start(self, remote.accept)
        except BaseException:
            self.end_films()
            remote.simulators.close()
            raise

    def open_views(self, remote: Remote) -> None:
        views, endpoint = self.views
        launch = remote.simulators.launch
        # By name: a copy of a lesson that takes no views goes without.
        module = importlib.import_module("netmq_example.envs.views")
        self.renderer = module.Renderer(self.render_mode, views, endpoint or (FREE_PORT if launch else module.ENDPOINT))
        if launch:
            remote.simulators.views = self.renderer.films.game.endpoint
        # Also when nobody calls close, and when no simulator comes.
        finalizer(self, self.renderer.close)

    def viewed(self) -> Any:
        """With views, which "rgb_array" opens only where they are wanted."""
        if not self.renderer:
            if self.remote.simulators.connection.closed:
                raise ValueError("this environment is closed")
            self.open_views(self.remote)
        return self.renderer

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
        return pictures[0]

    def gives_pictures(self) -> bool:
        """Where there are none it warns, as Gymnasium's own environments do."""
        if self.render_mode is None:
            logger.warn('render gives no picture: make the environment with render_mode="rgb_array"')
        return self.render_mode is not None

    def begin_render(self, screen_width: int = -1, screen_height: int = -1, fullscreen: bool = False) -> None:
        """Begin a film of each view, in place of the one before. -1 is the largest size that the game allows.

        The screen stays as it is. It is always the pictures that are so large.
        """
        if self.gives_pictures():
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
        if not self.gives_pictures():
            return {}
        renderer = self.viewed()
        films: dict[str, Any] = renderer.all_of(renderer.views, video_paths or {}, self.metadata["render_fps"])
        return films

    def render(self) -> Any:
        """The same of the first view alone; or the picture that the scene draws itself."""
        if not self.gives_pictures():
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

    def send_info(self, info: Any, agent: str | None = None) -> None:
        """To an agent, or to the scene itself: what a value is, trees.py says. `bytes` are C#'s `byte[]`."""
        self.remote.send_info(info, agent or "")

    def close(self) -> None:
        self.end_films()
        self.close_once()
