"""Lesson 12, filming: the thread that hears a game, keeps what its views show, and says that it was taken.
"""

import contextlib
import itertools
import queue
import threading
from collections.abc import Callable
from concurrent.futures import Future
from typing import Any

import zmq
from game import Game, Lost
from messages import Message, MessageError
from view_film import ViewFilm


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
