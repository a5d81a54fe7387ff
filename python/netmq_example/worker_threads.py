"""Threads that do a server's work, so that the thread with the socket never waits for it.

    workers = WorkerThreads(4, answer)
    while True:
        zmq.select([socket, workers], [], [], 0.2)      also wakes up when a reply is there
        for key, reply in workers.finished(): ...       replies as bytes, in the order in which they were done
        workers.begin(key, request)                     the key comes back with the reply
    workers.close()

The workers never touch the ZeroMQ socket, which is not thread-safe. Threads are right for work that waits, for a file
or another server; Python computes on one of them at a time.
"""

import contextlib
from collections.abc import Callable, Iterator
from queue import SimpleQueue
from socket import socketpair
from threading import Thread
from typing import Any, Generic, TypeVar

from netmq_example import arguments, check
from netmq_example.program import reply_to

Key = TypeVar("Key")
MOST_THREADS = 256


class WorkerThreads(Generic[Key]):
    """So many threads, each of which answers one request at a time."""

    def __init__(
        self, workers: int, answer: Callable[..., Any], reply: Callable[[Callable[..., Any], Any], Any] = reply_to
    ) -> None:
        """`answer` makes the reply; an exception in it becomes the reply `error: …`, and its traceback is logged.

        `reply` calls it with a request of another form than bytes.
        """
        self.number = check.count("workers", workers, most=MOST_THREADS)
        self.answer = arguments.function("answer", answer)
        self.reply = reply
        self.closed = False
        self.requests: SimpleQueue[tuple[Key, Any] | None] = SimpleQueue()
        self.replies: SimpleQueue[tuple[Key, Any]] = SimpleQueue()
        # One byte through this pair for each reply wakes the thread with the ZeroMQ socket, on every system.
        self.wake_reader, self.wake_writer = socketpair()
        for _ in range(self.number):
            # Ctrl-C ends these whatever they do. A ThreadPoolExecutor would first wait for what is at work.
            Thread(target=self._work, name="netmq_example worker", daemon=True).start()

    def begin(self, key: Key, request: Any) -> None:
        """Have a worker answer this request; any number may wait for one."""
        arguments.not_closed("this pool of workers", self)
        self.requests.put((key, check.instance("request", request, bytes if self.reply is reply_to else object)))

    def finished(self) -> Iterator[tuple[Key, Any]]:
        """The replies that are there, each with the key of its request."""
        arguments.not_closed("this pool of workers", self)
        while not self.replies.empty():
            self.wake_reader.recv(1)
            yield self.replies.get()

    def at_once(self, request: bytes) -> bytes:
        """The reply, made on this thread: for what takes no longer than to hand it over."""
        return reply_to(self.answer, request)

    def fileno(self) -> int:
        """The descriptor for select and poll: readable when there is a reply."""
        return self.wake_reader.fileno()

    def _work(self) -> None:
        while (entry := self.requests.get()) and not self.closed:
            key, request = entry
            self.replies.put((key, self.reply(self.answer, request)))
            # Closed meanwhile, nobody wants it.
            with contextlib.suppress(OSError):
                self.wake_writer.send(b"!")

    def close(self) -> None:
        """End the threads, each after what it does now; what waits is dropped. It does not wait for them."""
        self.closed = True
        for _ in range(self.number):
            self.requests.put(None)
        self.wake_reader.close()
        self.wake_writer.close()
