"""Processes that do one job at a time, and can be killed.

    workers = Workers(4, {"count": Kind(count, most=10_000)})
    with closing(workers):
        if workers.ready():
            workers.start(goal)      a message with the values job, kind, count, text, done; its array is a checkpoint
        for job, news in workers.news().items(): ...           feedback, a result, or None if the process died

Python computes on one thread at a time, so threads would share one core, and no thread can be killed. A process is
started when there is work for it, and again after it died. It finds the work by the name of its module.

A thread reads the messages of a process, because not every system can poll a pipe together with a socket; the thread
then writes to a socket.
"""

import contextlib
import logging
import multiprocessing
import os
import signal
import sys
import threading
import time
from collections.abc import Iterator
from multiprocessing import resource_tracker
from multiprocessing.connection import Connection
from multiprocessing.reduction import ForkingPickler
from queue import SimpleQueue
from socket import socketpair

from netmq_example import check
from netmq_example.console import log_lines
from netmq_example.messages import EXACT, Message, MessageError, take
from netmq_example.work import Kind, Step, WorkError

MOST_WORKERS = 100
# Feedback is a state: nobody needs it more often. So a checkpoint is at most that old.
FEEDBACK_SECONDS = 0.1
# A new process, not a copy of this one: a copy made while a thread holds a lock would wait for that lock for ever.
SPAWN = multiprocessing.get_context("spawn")

log = logging.getLogger("netmq_example.jobs")


def send(pipe: Connection, message: Message) -> None:
    for frame in message.frames():
        pipe.send_bytes(frame)
    pipe.send_bytes(b"")


def receive(pipe: Connection) -> Message:
    return Message.read(list(iter(pipe.recv_bytes, b"")))


# In the worker's process


def run_worker(pipe: Connection, kinds: dict[str, Kind]) -> None:
    """Does one goal after the other, with `feedback` between two steps and then one `result`.

    A thread listens to the server meanwhile: it hears a cancel, for which the work looks between two steps, and the end
    of the server, which ends this process at once.
    """
    # Ctrl-C in a terminal reaches it too; the server says when to end.
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    goals = SimpleQueue[Message]()
    cancel = threading.Event()

    def listen() -> None:
        try:
            while True:
                message = receive(pipe)
                if message.kind == "cancel":
                    cancel.set()
                else:
                    # A cancel that came too late for the job before is none of this one.
                    cancel.clear()
                    goals.put(message)
        finally:
            # The server ended or was killed. Nobody waits for the work any more, and it may ignore a cancel.
            os._exit(1)

    threading.Thread(target=listen, daemon=True, name="netmq_example worker").start()
    # This process is a program of its own, unless a kind of work has set up its logs.
    if not log.hasHandlers():
        log_lines()
    while True:
        goal = goals.get()
        tell(pipe, perform(pipe, goal, kinds[goal.values["kind"]], cancel))


def tell(pipe: Connection, message: Message) -> None:
    try:
        send(pipe, message)
    except OSError:
        # Nobody reads it. That is no mistake of the work, which may be in the middle of it.
        os._exit(1)


def perform(pipe: Connection, goal: Message, kind: Kind, cancel: threading.Event) -> Message:
    facts = goal.values
    checkpoint = goal.arrays[0] if goal.arrays else None
    finished = bytes(checkpoint.data) if checkpoint else b""
    step = Step(facts["done"], facts["count"], checkpoint=checkpoint)
    told_at = 0.0
    new = None
    try:
        for new in kind.work(facts["count"], finished, facts["text"]):
            check_step(new)
            step = new
            if cancel.is_set():
                return about(goal, step, "result", status="canceled")
            if time.monotonic() >= told_at + FEEDBACK_SECONDS:
                told_at = time.monotonic()
                tell(pipe, about(goal, step, "feedback"))
        if new is None and step.done < step.total:
            raise WorkError("the work ended without a step: nothing was done")
        return about(goal, step, "result", status="succeeded")
    except WorkError as error:
        return about(goal, step, "result", status="aborted", text=f"{error!s:.200}")
    except Exception as error:
        # A mistake in the work is shown where it is written.
        log.error("a mistake in the work", exc_info=error)
        return about(goal, step, "result", status="aborted", text=f"{error!r:.200}")


def about(goal: Message, step: Step, kind: str, **more: str) -> Message:
    values = {"job": goal.values["job"], "done": step.done, "total": step.total, "text": step.text}
    return Message(kind, values=values | more, arrays=[step.checkpoint] if step.checkpoint else [])


def check_step(step: Step) -> None:
    """A step that no message to a client can carry ends the job here, in the work's own process."""
    longest = Message("goal", values={"job": "x" * 64})
    message = about(longest, step, "canceling", status="succeeded")
    message.values["seq"] = EXACT - 1
    values = Message.read(message.frames()).values
    for name, kind in (("done", int), ("total", int), ("text", str)):
        take(values, name, kind)


# In the server's process


def check_kinds(kinds: dict[str, Kind]) -> dict[str, Kind]:
    """Each is handed to a new process, which has to find it by the name of its module."""
    for name, kind in check.instance("kinds", kinds, dict).items():
        check.instance(f"kinds[{name!r:.40}]", kind, Kind)
        try:
            # A new process makes the main module again, from its file. A notebook has none.
            main = getattr(sys.modules["__main__"], "__file__", "")
            if b"__main__" in bytes(ForkingPickler.dumps(kind)) and not os.path.isfile(main):
                raise TypeError
        except Exception:
            cure = "make it a function of a module, or functools.partial of one"
            raise TypeError(f"kind {name!r} cannot be handed to a worker: {cure}") from None
    return kinds


class Worker:
    def __init__(self, kinds: dict[str, Kind]) -> None:
        self.pipe, theirs = SPAWN.Pipe()
        self.process = SPAWN.Process(target=run_worker, args=(theirs, kinds), daemon=True)
        with interrupts_blocked():
            self.process.start()
        self.killed = False
        # Only the process itself has that end now, so that its death ends every wait at this one.
        theirs.close()


@contextlib.contextmanager
def interrupts_blocked() -> Iterator[None]:
    """A process that is started here inherits it: Ctrl-C in a terminal reaches it before it can say that it ignores
    it."""
    if not hasattr(signal, "pthread_sigmask"):
        yield
        return
    # It is started with the first process, and would end the blocking.
    resource_tracker.ensure_running()
    before = signal.pthread_sigmask(signal.SIG_BLOCK, [signal.SIGINT])
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)


class Workers:
    """Use it on one thread. `wake_socket` is to be polled: it is readable when there are news."""

    def __init__(self, workers: int, kinds: dict[str, Kind]) -> None:
        self.idle: list[Worker | None] = [None] * check.count("workers", workers, most=MOST_WORKERS)
        self.kinds = check_kinds(kinds)
        self.busy: dict[str, Worker] = {}
        self.received: SimpleQueue[tuple[Connection, Message | None]] = SimpleQueue()
        self.wake_socket, self.wake_sender = socketpair()
        self.wake_socket.setblocking(False)
        self.refused = False

    def ready(self) -> bool:
        """Is a worker idle? If need be its process is started; while the system has no room for it, jobs wait."""
        if not self.idle:
            return False
        try:
            if not self.idle[-1]:
                worker = Worker(self.kinds)
                name = f"netmq_example worker {worker.process.pid}"
                threading.Thread(target=self.listen, args=(worker,), daemon=True, name=name).start()
                self.idle[-1] = worker
        except (OSError, RuntimeError) as error:
            if not self.refused:
                log.warning("cannot start a worker: %s; jobs wait until that is over", error)
            self.refused = True
            return False
        self.refused = False
        return True

    def start(self, goal: Message) -> int:
        """Have an idle worker do it; the number of its process. `ready` has to be true."""
        check.instance("goal", goal, Message)
        worker = self.idle.pop()
        assert worker, "ready() has started it"
        self.busy[goal.values["job"]] = worker
        self.send(worker, goal)
        return worker.process.pid or 0

    def cancel(self, job: str) -> None:
        """Tell its worker, which hears it between two steps."""
        self.send(self.busy[job], Message("cancel"))

    def kill(self, job: str) -> None:
        self.busy[job].killed = True
        self.busy[job].process.kill()

    def news(self) -> dict[str, Message | None]:
        """Of each job the newest; None if its process died."""
        try:
            self.wake_socket.recv(4096)
        except BlockingIOError:
            # It was the server's socket that ended the wait, or nothing.
            pass
        found: dict[str, Message | None] = {}
        while not self.received.empty():
            pipe, message = self.received.get()
            if not message:
                # Its process has ended, although it may look alive for a moment.
                self.idle = [None if worker and worker.pipe is pipe else worker for worker in self.idle]
            for job in [job for job, worker in self.busy.items() if worker.pipe is pipe]:
                found[job] = message
                if not message or message.kind == "result":
                    worker = self.busy.pop(job)
                    self.idle.append(worker if message and not worker.killed else None)
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
                # It has ended, or what it sends is no message any more.
                worker.process.kill()
                message = None
            self.received.put((worker.pipe, message))
            self.wake_sender.send(b"!")

    def send(self, worker: Worker, message: Message) -> None:
        try:
            send(worker.pipe, message)
        except OSError:
            # It died. Its end is in the queue already, or will be.
            pass
