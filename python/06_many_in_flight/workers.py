"""Lesson 06, the workers: threads that do one request at a time, or have a process of their own do it.

    workers = Workers(work, 4)                      four threads: for work that waits, for a file, a database, a sleep
    workers = Workers(work, 4, processes=True)      four processes: for work that computes, or may crash

Python computes on one thread at a time, so threads share one core and processes have one each. A process that dies
takes one request with it, which is answered with an error, and the next one has a new process.
Take home: this file, router.py, server_processes.py and server.py.
"""

import multiprocessing
import random
import socket
import threading
import time
import traceback
from collections.abc import Callable, Iterator
from multiprocessing.connection import Connection
from queue import SimpleQueue

Work = Callable[[bytes], bytes]
# Whose request it is, its id, and its text, or later its reply.
Job = tuple[bytes, bytes, bytes]
# A new process, not a copy of this one: a copy made while a thread holds a lock would wait for that lock for ever.
SPAWN = multiprocessing.get_context("spawn")


def printable(text: str) -> str:
    """What a peer sent, fit for one line of a terminal: no control characters, cut to a readable length."""
    return "".join(c if c.isprintable() else "?" for c in text[:200]) + ("…" if len(text) > 200 else "")


def attempt(work: Work, text: bytes) -> bytes:
    """An exception is an answer too: the worker lives on, and the place is shown to whoever writes `work`."""
    try:
        # No copy where it is bytes, and an exception here where it is text or nothing.
        return bytes(work(text))
    except Exception as error:
        traceback.print_exc()
        return printable(f"error: {type(error).__name__}: {error}").encode()


def labour(pipe: Connection, work: Work) -> None:
    """What a process does until the other end of its pipe is closed, even by a server that was killed."""
    try:
        while True:
            pipe.send_bytes(attempt(work, pipe.recv_bytes()))
    except (EOFError, OSError, KeyboardInterrupt):
        pass


class Process:
    """Does work in a process, and can be called like the work itself."""

    def __init__(self, work: Work) -> None:
        self.work = work
        self.start()

    def start(self) -> None:
        self.pipe, theirs = SPAWN.Pipe()
        self.process = SPAWN.Process(target=labour, args=(theirs, self.work), daemon=True)
        self.process.start()
        # Only the process itself has that end now, so that its death ends every wait at this one.
        theirs.close()

    def __call__(self, text: bytes) -> bytes:
        if not self.process.is_alive():
            self.start()
        try:
            self.pipe.send_bytes(text)
            return self.pipe.recv_bytes()
        except (EOFError, OSError):
            self.process.kill()
            self.process.join()
            return b"error: the worker died over this request, which may have been done or not"


class Workers:
    """`take` a job while `free` is above 0; `bell` becomes readable when `finished` has something."""

    def __init__(self, work: Work, size: int, processes: bool = False) -> None:
        self.free = size
        self.jobs: SimpleQueue[Job] = SimpleQueue()
        self.done: SimpleQueue[Job] = SimpleQueue()
        # A socket pair wakes a poll on every system. The threads own no ZeroMQ socket, which would keep the server
        # from ending while one of them is at work.
        self.bell, self.rope = socket.socketpair()
        self.bell.setblocking(False)
        self.workers = [Process(work) if processes else work for _ in range(size)]
        for worker in self.workers:
            threading.Thread(target=self.run, args=(worker,), daemon=True).start()

    def run(self, work: Work) -> None:
        while True:
            client, request_id, text = self.jobs.get()
            self.done.put((client, request_id, attempt(work, text)))
            self.rope.send(b"!")

    def take(self, job: Job) -> None:
        self.free -= 1
        self.jobs.put(job)

    def finished(self) -> Iterator[Job]:
        try:
            self.bell.recv(4096)
        except BlockingIOError:
            pass
        while not self.done.empty():
            self.free += 1
            yield self.done.get()

    def kill_at_random(self, every: float) -> None:
        """Trouble on command: every so many seconds one of the processes dies, whatever it is doing."""
        while True:
            time.sleep(every)
            victim = random.choice(self.workers)
            if isinstance(victim, Process):
                victim.process.kill()
                print(f"killed worker {victim.process.pid}", flush=True)
