"""Lesson 14, the workers: processes that do one job at a time, and can be killed.

    workers = Workers(4)
    if workers.ready():
        workers.start(goal)         a message with the values job, kind, count, text and done; its array is a checkpoint
    for job, news in workers.news().items(): ...            feedback, a result, or None if the process died

Python computes on one thread at a time, so threads would share one core, and no thread can be killed. What a process
says is read by a thread, because a pipe cannot be polled together with a socket on every system; it then rings a bell
that can.
"""

import sys
from contextlib import suppress
from multiprocessing.connection import Connection
from pathlib import Path
from queue import SimpleQueue
from socket import socketpair
from threading import Thread

# In its own lesson's folder; at home it lies beside this file.
sys.path.append(str(Path(__file__).resolve().parents[1] / "05_messages"))
from messages import Message, MessageError
from worker import receive, send
from worker_process import Worker, check_kinds


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
