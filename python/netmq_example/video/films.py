"""Films of the views of a running game, on command.

    films = Films()                                     the game comes to tcp://127.0.0.1:5562
    films.wait()                                        its views: {"front": (320, 240), "map": (320, 240)}
    films.begin_render("front", "drive.mp4", fps=25)    or .webm, .gif
    ...                                                 whatever else Python does with the game
    film = films.end_render("front")                    logs: film drive.mp4: 125 frames, 5.0 s, 0 skipped
    pictures = films.render_all()                       {"front": uint8 [240, 320, 3], "map": …}
    films.close()                                       or: with Films() as films

A thread of its own receives and writes. The game sends at most two pictures that were not acknowledged: when writing is
slow, it skips the others, and says how many they were. ValueError and OSError say why there can be no file.
Refused is the game's refusal, Timeout its silence, and Lost says that it is gone.

The messages are those of lesson 05. The game sends `hello` with its `views`, names with commas between them, and their
largest widths and heights as int32 [n, 2]; the reply is `welcome`. A `begin` has `view`, `width`, `height` and `fps`;
it is answered by `begun`. From then on each `frame` has the id of that begin, `view`, `number`, `time`, in seconds
since it began, and one array, uint8 [height, width, 3 or 4], with `bottom_up` the lowest row first; the reply is
`took`. A `look` at a `view` asks for one more frame, of now; with an `fps` of 0 there are no others. An `end` of a
`view` is answered by `ended`, with `frames`, `skipped` and `time`. Python leaves with a
`close`, answered by `closed`.

The game's side is view_sender.py; in C# it is ViewSender.cs. It needs numpy and Pillow, and av for an MP4 or a WebM.
"""

import contextlib
import itertools
import logging
import math
import os
import queue
import threading
import time
from collections.abc import Callable, Iterable
from concurrent.futures import Future
from typing import Any

import zmq

from netmq_example import arguments, check
from netmq_example.errors import Error, Lost, Refused, Timeout
from netmq_example.former import positional
from netmq_example.messages import Message
from netmq_example.one_process import OneProcess
from netmq_example.video.game import ENDPOINT, Game, bound, side
from netmq_example.video.view_film import ViewFilm

log = logging.getLogger("netmq_example.video")


class Films(OneProcess):
    """For any thread. Each film is logged. A socket that is given is not closed."""

    @positional("endpoint", "socket", "timeout", "report")
    def __init__(
        self, endpoint: str = ENDPOINT, *, socket: zmq.Socket[bytes] | None = None, timeout: float = 10.0
    ) -> None:
        """The game has `timeout` seconds for each answer."""
        self.timeout = check.seconds("timeout", timeout)
        arguments.blocking("socket", socket, zmq.Socket, type(None))
        self.report = log.warning
        self.owns_socket = socket is None
        self.game = Game(bound(endpoint) if socket is None else socket, self.lose)
        self.endpoint = self.game.endpoint
        # Which of the games that came wait has returned.
        self.returned = 0
        # The newest film of each view.
        self.films: dict[str, ViewFilm] = {}
        # What is to be sent to the game, and by id who waits for the answer.
        self.requests = queue.SimpleQueue[Message]()
        self.ids = itertools.count(1)
        self.waiting: dict[int, tuple[Future[None], ViewFilm | None]] = {}
        self.over = threading.Event()
        self.thread = threading.Thread(target=self.run, daemon=True, name="netmq_example films")

    def wait(self, seconds: float = 60) -> dict[str, tuple[int, int]]:
        """The next game's views, with their largest width and height. Timeout says that none came."""
        if seconds != math.inf:
            check.seconds("seconds", seconds, zero=True)
        self.start()
        end = time.monotonic() + seconds
        while self.game.count == self.returned or not self.game.views:
            if time.monotonic() > end:
                raise Timeout(f"no game came within {seconds:g} s; is it running, with a ViewRecorder in it?")
            time.sleep(0.02)
        self.returned = self.game.count
        return self.game.views

    def begin_render(
        self,
        view: str = "",
        path: str | os.PathLike[str] | None = "",
        width: int = 0,
        height: int = 0,
        fps: float = 25,
    ) -> None:
        """Begin a film of a view, or of the first one. 0 or -1 is the view's largest width or height.

        Without a path it becomes VIEW_1.mp4, or the next number that is free; where av has no H.264 it is a .webm. None
        writes no file; fps may then be 0, and all pictures are those that `look` asks for.
        """
        view = a_view(view) or next(iter(self.game.views), "")
        size = {"width": side("width", width), "height": side("height", height)}
        film = ViewFilm(view, path, fps)
        try:
            self.ask("begin", {"view": view, **size, "fps": float(fps)}, film)
        except BaseException:
            film.close()
            raise
        if film.path and not film.trouble:
            self.say(log.info, f"begin {view} {film.size[1]} x {film.size[0]}")

    def end_render(self, view: str = "") -> ViewFilm:
        """The film, whole. Of a game that is gone it is what came."""
        view = a_view(view) or next(iter(self.films), "")
        film = self.films.get(view)
        if not film or not film.over:
            try:
                self.ask("end", {"view": view})
            except Lost:
                if not film:
                    raise
        return self.films.pop(view)

    def end_all(self) -> None:
        """End each film, whatever goes wrong with another one; that is reported."""
        for view in list(self.films):
            try:
                self.end_render(view)
            except (OSError, Error) as error:
                self.trouble(f"trouble: {str(error)!a:.200}")

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

    def look(self, views: Iterable[str]) -> dict[str, Any]:
        """A picture of now of each of these views, which are being filmed with fps=0."""
        films = {view: self.films[view] for view in views}
        for view, film in films.items():
            film.expect()
            self.requests.put(Message("look", next(self.ids), {"view": view}))
        return {view: film.picture(self.timeout) for view, film in films.items()}

    def close(self) -> None:
        """End all films, and leave the game. Twice is once."""
        self.timeout = min(1, self.timeout)
        for view in [view for view, film in list(self.films.items()) if not film.over]:
            with contextlib.suppress(OSError, Error):
                self.end_render(view)
        if self.thread.is_alive() and self.game.peer:
            with contextlib.suppress(OSError, Error):
                self.ask("close", {})
        self.over.set()
        if self.thread.is_alive():
            self.thread.join()
        self.lose()
        if self.owns_socket:
            self.game.socket.context.destroy()

    def start(self) -> None:
        """Not before it is needed: by then there is somebody who will call close."""
        self.check_process()
        if self.over.is_set():
            raise ValueError("these films are closed: make new ones")
        with self.at_work:
            if not self.thread.is_alive():
                self.thread.start()

    def ask(self, kind: str, values: dict[str, Any], film: ViewFilm | None = None) -> None:
        """Ask the game for something, and wait until it is done. Refused is its refusal."""
        self.start()
        request = Message(kind, next(self.ids), values)
        done = Future[None]()
        self.waiting[request.id] = done, film
        self.requests.put(request)
        try:
            done.result(self.timeout)
        except TimeoutError:
            # Without it a game that is only slow would be filmed for ever.
            self.requests.put(Message("end", next(self.ids), {"view": values.get("view", "")}))
            raise Timeout(f"no answer to {kind} within {self.timeout:g} s; does the game hang?") from None
        finally:
            self.waiting.pop(request.id, None)

    def say(self, log: Callable[[str], object], line: str) -> None:
        """A line that cannot be written, as into a pipe that is closed, ends no film."""
        with contextlib.suppress(Exception):
            log(line)

    def trouble(self, line: str) -> None:
        self.say(self.report, line)

    # The thread, to which the socket belongs

    def run(self) -> None:
        while not self.over.is_set():
            try:
                while not self.requests.empty():
                    self.send(self.requests.get())
                message = self.game.receive()
                if message:
                    self.hear(message)
            except Exception as error:
                # Unforeseen. It ends the films, and not this thread: a caller would wait for nothing.
                self.trouble(f"trouble: {error!r:.200}")
                self.game.forget()

    def send(self, request: Message) -> None:
        try:
            if not self.game.peer:
                raise Lost("there is no game, or it is gone")
            self.game.send(request.kind, request.id, request.values)
        except Exception as error:
            self.answer(request.id, error)

    def hear(self, message: Message) -> None:
        """Act on a message of the game."""
        values = message.values
        view = str(values.get("view"))
        _, begun = self.waiting.get(message.id, (None, None))
        film = self.films.get(view)
        if message.kind == "error":
            self.answer(message.id, Refused(str(values.get("code"))[:40], str(values.get("text"))[:200]))
        elif message.kind == "begun" and begun:
            begun.attempt(self.trouble, begun.begin, message, self.game.views.get(begun.view, (0, 0)))
            self.films[begun.view] = begun
            self.answer(message.id)
        elif message.kind == "frame" and film and message.id == film.id:
            film.attempt(self.trouble, film.add, message)
            self.game.send("took", film.id, {"view": view, "number": values.get("number", 0)})
        elif message.kind == "ended" and film and not film.over:
            film.attempt(self.trouble, film.end, message)
            if film.path:
                self.say(log.info, str(film))
            self.answer(message.id)
        elif message.kind == "closed":
            self.answer(message.id)

    def answer(self, id: int, error: Exception | None = None) -> None:
        waiter = self.waiting.pop(id, None)
        if waiter is None:
            return
        done, _ = waiter
        if error:
            done.set_exception(error)
        else:
            done.set_result(None)

    def lose(self) -> None:
        """The game is gone: what came is a film."""
        for film in [film for film in list(self.films.values()) if not film.over]:
            film.attempt(self.trouble, film.close)
            if film.path:
                self.trouble(f"trouble: the game is gone; {film}")
        for id in list(self.waiting):
            self.answer(id, Lost("the game is gone"))
        # The next game is not asked what this one was.
        while not self.requests.empty():
            self.requests.get()


def a_view(name: Any) -> str:
    if isinstance(name, str):
        return name
    raise ValueError(f"view takes the name of a view, not {name!r:.40}")
