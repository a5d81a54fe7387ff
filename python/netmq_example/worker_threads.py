"""Threads that do a server's work, so that the thread with the socket never waits for it.

    workers = WorkerThreads(4, answer)
    while True:
        zmq.select([socket, workers], [], [], 0.2)      also wakes up when a reply is there
        for key, reply in workers.finished(): ...       replies as bytes, in the order in which they were done
        workers.begin(key, request)                     the key comes back with the reply

The workers never touch the ZeroMQ socket, which is not thread-safe. Threads are right for work that waits, for a file
or another server; Python computes on one of them at a time.
"""

from collections.abc import Callable, Iterator
from queue import SimpleQueue
from socket import socketpair
from threading import Thread
from typing import Generic, TypeVar

from netmq_example import check
from netmq_example.program import reply_to

Key = TypeVar("Key")
MOST_THREADS = 256


class WorkerThreads(Generic[Key]):
    """So many threads, each of which answers one request at a time. They live as long as the program."""

    def __init__(self, number: int, answer: Callable[[str], str]) -> None:
        """`answer` makes the reply; an exception in it becomes the reply `error: …`, and its traceback is printed."""
        number = check.count("number", number, most=MOST_THREADS)
        self.answer = check.instance("answer", answer, Callable)
        self.requests: SimpleQueue[tuple[Key, bytes]] = SimpleQueue()
        self.replies: SimpleQueue[tuple[Key, bytes]] = SimpleQueue()
        # One byte through this pair for each reply wakes the thread with the ZeroMQ socket, on every system.
        self.wake_reader, self.wake_writer = socketpair()
        for _ in range(number):
            # Ctrl-C ends these whatever they do. A ThreadPoolExecutor would first wait for what is at work.
            Thread(target=self._work, daemon=True).start()

    def begin(self, key: Key, request: bytes) -> None:
        """Have a worker answer this request; any number may wait for one."""
        self.requests.put((key, check.instance("request", request, bytes)))

    def finished(self) -> Iterator[tuple[Key, bytes]]:
        """The replies that are there, each with the key of its request."""
        while not self.replies.empty():
            self.wake_reader.recv(1)
            yield self.replies.get()

    def fileno(self) -> int:
        """What select and poll watch: readable when there is a reply."""
        return self.wake_reader.fileno()

    def _work(self) -> None:
        while True:
            key, request = self.requests.get()
            self.replies.put((key, reply_to(self.answer, request)))
            self.wake_writer.send(b"!")
