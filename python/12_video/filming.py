"""Lesson 12, filming: the thread that hears a game, keeps what its views show, and says that it was taken.

Take home: this file, game.py, view_film.py, film_writer.py, film_formats.py and mp4_film.py, with messages.py of
lesson 05.
"""

import itertools
import queue
import threading
from collections.abc import Callable
from concurrent.futures import Future
from typing import Any

import zmq
from game import Game, Lost
from messages import Message, MessageError, take
from view_film import ViewFilm


class Filming:
    """The socket belongs to the thread; others ask it to say something."""

    def __init__(self, socket: zmq.Socket[bytes], patience: float, report: Callable[[str], object]) -> None:
        self.patience, self.report, self.ids = patience, report, itertools.count(1)
        self.game = Game(socket, self.lose)
        # What is to be said to the game, who waits for an answer, and the newest film of each view.
        self.requests, self.films = queue.SimpleQueue[Message](), dict[str, ViewFilm]()
        self.asked = dict[int, tuple[Future[None], ViewFilm | None]]()
        self.over = threading.Event()
        self.thread = threading.Thread(target=self.run, daemon=True)

    def start(self) -> None:
        """Not before it is needed: by then there is somebody who will call close."""
        if not self.thread.is_alive():
            self.thread.start()

    def ask(self, kind: str, values: dict[str, Any], film: ViewFilm | None = None) -> None:
        """For any thread: ask the game for something, and wait until it is done. MessageError is its refusal."""
        request, done = Message(kind, next(self.ids), values), Future[None]()
        self.asked[request.id] = done, film
        self.start()
        self.requests.put(request)
        try:
            done.result(self.patience)
        except TimeoutError:
            raise TimeoutError(f"no answer to {kind} within {self.patience:g} s; does the game hang?") from None
        finally:
            self.asked.pop(request.id, None)

    def run(self) -> None:
        while not self.over.is_set():
            while not self.requests.empty():
                request = self.requests.get()
                if not (self.game.peer and self.game.send(request.kind, request.id, request.values)):
                    self.answer(request.id, Lost("there is no game, or it is gone"))
            try:
                if message := self.game.receive():
                    self.hear(message)
            except MessageError as error:
                self.game.refuse(self.game.peer, error)

    def hear(self, message: Message) -> None:
        if message.kind == "error":
            code, text = str(message.values.get("code")), str(message.values.get("text"))
            self.answer(message.id, MessageError(code[:40], text[:200]))
            return
        view = take(message.values, "view", str)
        if message.kind == "begun" and (film := self.asked.get(message.id, (None, None))[1]):
            film.begin(message)
            self.films[view] = film
            self.answer(message.id)
        elif (film := self.films.get(view)) and message.kind == "frame" and message.id == film.id:
            self.keep(film, message)
            self.game.send("took", film.id, {"view": view, "number": film.number})
        elif film and message.kind == "ended":
            self.attempt(film, lambda: film.end(message))
            if film.path:
                self.report(str(film))
            self.answer(message.id)

    def keep(self, film: ViewFilm, frame: Message) -> None:
        """A picture that came; until this returns it counts as one on its way."""
        self.attempt(film, lambda: film.add(frame))

    def attempt(self, film: ViewFilm, do: Callable[[], None]) -> None:
        """What goes wrong with a file is said once, and the game goes on."""
        try:
            do()
        except (OSError, ValueError, MessageError) as error:
            if not film.trouble:
                film.stop(str(error))
                self.report(f"trouble: {film}")

    def answer(self, id: int, error: Exception | None = None) -> None:
        if waiting := self.asked.pop(id, None):
            waiting[0].set_exception(error) if error else waiting[0].set_result(None)

    def lose(self) -> None:
        """The game is gone: what came is a film."""
        for film in self.films.values():
            if not film.over:
                self.attempt(film, film.close)
                self.report(f"trouble: the game is gone; {film}")
        for id in list(self.asked):
            self.answer(id, Lost("the game is gone"))
