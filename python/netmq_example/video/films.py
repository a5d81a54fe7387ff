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

Lesson 12, filming: the thread that hears a game, keeps what its views show, and says that it was taken.
"""

import contextlib
import itertools
import queue
import threading
import time
from collections.abc import Callable
from concurrent.futures import Future
from operator import index
from pathlib import Path
from typing import Any, Self

import zmq

from netmq_example.messages import Message, MessageError
from netmq_example.video.game import Game, Lost, bound
from netmq_example.video.view_film import ViewFilm


class Filming:
    """The socket belongs to the thread; others ask it to say something."""

    def __init__(self, socket: zmq.Socket[bytes], timeout: float, report: Callable[[str], object]) -> None:
        self.timeout, self.tell, self.ids = timeout, report, itertools.count(1)
        self.game = Game(socket, self.lose)
        # What is to be said to the game, who waits for an answer, and the newest film of each view.
        self.requests, self.films = queue.SimpleQueue[Message](), dict[str, ViewFilm]()
        self.asked = dict[int, tuple[Future[None], ViewFilm | None]]()
        self.over, self.thread = threading.Event(), threading.Thread(target=self.run, daemon=True)

    def start(self) -> None:
        """Not before it is needed: by then there is somebody who will call close."""
        if self.over.is_set():
            raise ValueError("these films are closed: make new ones")
        if not self.thread.is_alive():
            self.thread.start()

    def report(self, line: str) -> None:
        """What cannot be told, as into a pipe that is closed, ends no film."""
        with contextlib.suppress(Exception):
            self.tell(line)

    def ask(self, kind: str, values: dict[str, Any], film: ViewFilm | None = None) -> None:
        """For any thread: ask the game for something, and wait until it is done. MessageError is its refusal."""
        self.start()
        request, done = Message(kind, next(self.ids), values), Future[None]()
        self.asked[request.id] = done, film
        self.requests.put(request)
        try:
            done.result(self.timeout)
        except TimeoutError:
            # Without it a game that is only slow would be filmed for ever.
            self.requests.put(Message("end", next(self.ids), {"view": values["view"]}))
            raise TimeoutError(f"no answer to {kind} within {self.timeout:g} s; does the game hang?") from None
        finally:
            self.asked.pop(request.id, None)

    def run(self) -> None:
        while not self.over.is_set():
            try:
                while not self.requests.empty():
                    self.say(self.requests.get())
                if message := self.game.receive():
                    self.hear(message)
            except Exception as error:
                # Unforeseen. It ends the films, and not this thread: whoever asks would wait for nothing.
                self.report(f"trouble: {error!r:.200}")
                self.game.forget()

    def say(self, request: Message) -> None:
        try:
            if not self.game.peer:
                raise Lost("there is no game, or it is gone")
            self.game.send(request.kind, request.id, request.values)
        except Exception as error:
            self.answer(request.id, error)

    def hear(self, message: Message) -> None:
        values, view = message.values, str(message.values.get("view"))
        if message.kind == "error":
            self.answer(message.id, MessageError(str(values.get("code"))[:40], str(values.get("text"))[:200]))
        elif message.kind == "begun" and (film := self.asked.get(message.id, (None, None))[1]):
            film.attempt(self.report, film.begin, message, self.game.views.get(film.view, (0, 0)))
            self.films[film.view] = film
            self.answer(message.id)
        elif (film := self.films.get(view)) and message.kind == "frame" and message.id == film.id:
            film.attempt(self.report, film.add, message)
            self.game.send("took", film.id, {"view": view, "number": values.get("number", 0)})
        elif film and message.kind == "ended" and not film.over:
            film.attempt(self.report, film.end, message)
            if film.path:
                self.report(str(film))
            self.answer(message.id)

    def answer(self, id: int, error: Exception | None = None) -> None:
        if waiting := self.asked.pop(id, None):
            waiting[0].set_exception(error) if error else waiting[0].set_result(None)

    def lose(self) -> None:
        """The game is gone: what came is a film."""
        for film in [film for film in list(self.films.values()) if not film.over]:
            film.attempt(self.report, film.close)
            self.report(f"trouble: the game is gone; {film}")
        for id in list(self.asked):
            self.answer(id, Lost("the game is gone"))


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
