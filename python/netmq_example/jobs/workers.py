"""Lesson 14, the workers: processes that do one job at a time, and can be killed.

    workers = Workers(4)
    if workers.ready():
        workers.start(goal)         a message with the values job, kind, count, text and done; its array is a checkpoint
    for job, news in workers.news().items(): ...            feedback, a result, or None if the process died

Python computes on one thread at a time, so threads would share one core, and no thread can be killed. What a process
says is read by a thread, because a pipe cannot be polled together with a socket on every system; it then rings a bell
that can.

Lesson 14, a worker: what its process does, from a goal to a result.

It sends `feedback` between two steps, and then one `result`. A thread of its own listens to the server: it hears a
cancel, for which the work looks between two steps, and the end of the server, which ends the process at once.

Lesson 14, a worker's process: how it is started, so that it can be told to stop, be killed, and end with the server.
"""

import multiprocessing
import os
import signal
import sys
import threading
import time
import traceback
from contextlib import suppress
from multiprocessing import resource_tracker
from multiprocessing.connection import Connection
from multiprocessing.reduction import ForkingPickler
from queue import SimpleQueue
from socket import socketpair
from threading import Thread

from netmq_example.jobs.work import KINDS, Kind, Step, WorkError
from netmq_example.messages import EXACT, Message, MessageError, read, take

# Feedback is a state: nobody needs it more often. So a checkpoint is at most so many seconds old.
INTERVAL = 0.1


def send(pipe: Connection, message: Message) -> None:
    for frame in message.frames():
        pipe.send_bytes(frame)
    pipe.send_bytes(b"")


def receive(pipe: Connection) -> Message:
    return read(list(iter(pipe.recv_bytes, b"")))


def labour(pipe: Connection, kinds: dict[str, Kind]) -> None:
    """What a worker's process does. It has the kinds of work that the server has."""
    KINDS.update(kinds)
    # Ctrl-C in a terminal reaches it too; when to end, the server says.
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    goals, cancel = SimpleQueue[Message](), threading.Event()

    def listen() -> None:
        try:
            while True:
                if (message := receive(pipe)).kind == "cancel":
                    cancel.set()
                else:
                    # A cancel that came too late for the job before is none of this one.
                    cancel.clear()
                    goals.put(message)
        finally:
            # The server ended or was killed. Nobody waits for the work any more, and it may be deaf.
            os._exit(1)

    threading.Thread(target=listen, daemon=True).start()
    while True:
        goal = goals.get()
        try:
            send(pipe, perform(pipe, goal, cancel))
        except OSError:
            # Nobody reads it.
            os._exit(1)


def check(step: Step) -> None:
    """What cannot be told to clients, whatever is said with it, ends the job here, where the work is written."""
    facts = {"job": "x" * 64, "seq": EXACT - 1, "status": "succeeded", "text": step.text}
    arrays = [step.checkpoint] if step.checkpoint else []
    told = read(Message("canceling", values=facts | {"done": step.done, "total": step.total}, arrays=arrays).frames())
    for name, kind in (("done", int), ("total", int), ("text", str)):
        take(told.values, name, kind)


def perform(pipe: Connection, goal: Message, cancel: threading.Event) -> Message:
    """Does the job, and returns its result."""
    job, total, text = goal.values["job"], goal.values["count"], goal.values["text"]
    finished = bytes(goal.arrays[0].data) if goal.arrays else b""
    told, step = 0.0, Step(goal.values["done"], total, checkpoint=goal.arrays[0] if goal.arrays else None)

    def said(step: Step, kind: str, **values: str) -> Message:
        facts = {"job": job, "done": step.done, "total": step.total, "text": step.text}
        return Message(kind, values=facts | values, arrays=[step.checkpoint] if step.checkpoint else [])

    try:
        for new in KINDS[goal.values["kind"]].work(total, finished, text):
            check(new)
            step = new
            if cancel.is_set():
                return said(step, "result", status="canceled")
            if time.monotonic() >= told + INTERVAL:
                told = time.monotonic()
                send(pipe, said(step, "feedback"))
        return said(step, "result", status="succeeded")
    except WorkError as error:
        return said(step, "result", status="aborted", text=f"{error!s:.200}")
    except Exception as error:
        # A mistake in the work: its place is for whoever writes it.
        traceback.print_exc()
        return said(step, "result", status="aborted", text=f"{error!r:.200}")


# A new process, not a copy of this one: a copy made while a thread holds a lock would wait for that lock for ever.
SPAWN = multiprocessing.get_context("spawn")


def check_kinds() -> None:
    """Each is handed to a new process, which has to find it by the name of its module."""
    for name, kind in KINDS.items():
        try:
            ForkingPickler.dumps(kind)
        except Exception:
            cure = "make it a function of a module, or functools.partial of one"
            sys.exit(f"kind {name!r} cannot be handed to a worker: {cure}")


class Worker:
    """A process, and the pipe to it."""

    def __init__(self) -> None:
        self.pipe, theirs = SPAWN.Pipe()
        self.process = SPAWN.Process(target=labour, args=(theirs, KINDS), daemon=True)
        self.begin()
        self.doomed = False
        # Only the process itself has that end now, so that its death ends every wait at this one.
        theirs.close()

    def begin(self) -> None:
        """Ctrl-C in a terminal reaches it too, and before it can say that it ignores it. So it inherits that."""
        if not hasattr(signal, "pthread_sigmask"):
            return self.process.start()
        # What is started with the first process, and ends the holding back.
        resource_tracker.ensure_running()
        before = signal.pthread_sigmask(signal.SIG_BLOCK, [signal.SIGINT])
        try:
            self.process.start()
        finally:
            signal.pthread_sigmask(signal.SIG_SETMASK, before)


class Workers:
    """Use it on one thread. `bell` is a socket to poll: it is readable when there are news."""

    def __init__(self, size: int) -> None:
        check_kinds()
        # A process is started when there is work for it, and again after it died.
        self.idle: list[Worker | None] = [None] * size
        self.busy: dict[str, Worker] = {}
        self.said: SimpleQueue[tuple[Connection, Message | None]] = SimpleQueue()
        self.bell, self.rope = socketpair()
        self.bell.setblocking(False)
        self.refused = False

    def ready(self) -> bool:
        """Is a worker idle? If need be its process is started; while the system has no room for it, jobs wait."""
        if not self.idle:
            return False
        try:
            if not self.idle[-1]:
                worker = Worker()
                Thread(target=self.listen, args=(worker,), daemon=True).start()
                self.idle[-1] = worker
        except (OSError, RuntimeError) as error:
            if not self.refused:
                print(f"cannot start a worker: {error}; jobs wait until that is over", flush=True)
            self.refused = True
            return False
        self.refused = False
        return True

    def start(self, goal: Message) -> int:
        """Have an idle worker do it; the number of its process."""
        worker = self.idle.pop()
        assert worker, "ready() has said so"
        self.busy[goal.values["job"]] = worker
        self.say(worker, goal)
        return worker.process.pid or 0

    def cancel(self, job: str) -> None:
        """Tell its worker, which hears it between two steps."""
        self.say(self.busy[job], Message("cancel"))

    def kill(self, job: str) -> None:
        self.busy[job].doomed = True
        self.busy[job].process.kill()

    def news(self) -> dict[str, Message | None]:
        """Of each job the newest."""
        with suppress(BlockingIOError):
            self.bell.recv(4096)
        found: dict[str, Message | None] = {}
        while not self.said.empty():
            pipe, message = self.said.get()
            if not message:
                # Its process has ended, although it may look alive for a moment.
                self.idle = [None if worker and worker.pipe is pipe else worker for worker in self.idle]
            for job in [job for job, worker in self.busy.items() if worker.pipe is pipe]:
                found[job] = message
                if not message or message.kind == "result":
                    worker = self.busy.pop(job)
                    self.idle.append(worker if message and not worker.doomed else None)
        return found

    def close(self) -> None:
        """At once, also those that were stopped: nobody waits for them."""
        for worker in [*self.idle, *self.busy.values()]:
            if worker:
                worker.process.kill()

    def listen(self, worker: Worker) -> None:
        message: Message | None = Message("")
        while message:
            try:
                message = receive(worker.pipe)
            except (EOFError, OSError, MessageError):
                # It has ended, or nobody could understand it any more.
                worker.process.kill()
                message = None
            self.said.put((worker.pipe, message))
            self.rope.send(b"!")

    def say(self, worker: Worker, message: Message) -> None:
        # To one that died: its end is in the queue already, or will be.
        with suppress(OSError):
            send(worker.pipe, message)
