"""A client for a game: it asks on a thread of its own, so that no frame ever waits.

    client = BackgroundClient("tcp://127.0.0.1:5554")     once
    client.request("hello", print, print)                 whenever you like: callbacks for reply and error
    client.poll()                                         once a frame: the callbacks run here
    client.close()                                        at the end

The thread has a LazyPirate, whose bytes and retries are in lazy_pirate.py. In C# it is BackgroundClient.cs.
"""

import contextlib
import queue
import threading
from collections.abc import Callable

import zmq

from netmq_example import check
from netmq_example.lazy_pirate import LazyPirate
from netmq_example.program import Context

Callback = Callable[[str], object]


class BackgroundClient:
    """Asks a server without ever making the calling thread wait. Each client has its own thread."""

    def __init__(self, endpoint: str, timeout: float = 1.0, tries: int = 3, capacity: int = 64) -> None:
        """`timeout` and `tries` are those of LazyPirate; at most `capacity` requests are under way."""
        self.capacity = check.count("capacity", capacity)
        self.context: Context = zmq.Context()
        self.pirate = LazyPirate(self.context, endpoint, timeout, tries, self._retrying)
        # State and last error, in one variable: a reader never gets those of two moments. Only a reply proves that the
        # server is there: Connecting, Connected, Retrying, Lost, Disposed.
        self.status = ("Connecting", "")
        self.under_way = 0
        self.waiting: queue.SimpleQueue[tuple[str, Callback, Callback] | None] = queue.SimpleQueue()
        self.done: queue.SimpleQueue[tuple[Callback, str]] = queue.SimpleQueue()
        self.thread = threading.Thread(target=self._talk, daemon=True)
        self.thread.start()

    def request(self, text: str, reply: Callback, error: Callback) -> bool:
        """Have one of the callbacks run in a later poll(). False if refused, because it is full or closed."""
        call = (
            check.instance("text", text, str),
            check.function("reply", reply),
            check.function("error", error),
        )
        if self.pirate.stopped.is_set() or self.under_way == self.capacity:
            return False
        self.under_way += 1
        self.waiting.put(call)
        return True

    def poll(self) -> None:
        """Run the callbacks of what has ended. Call it once a frame, on the thread that calls request()."""
        # Only what is there now: callbacks that ask again must not make one frame last for ever.
        for _ in range(self.done.qsize()):
            # A callback that closed this client has run those after it already.
            if self.done.empty():
                break
            callback, text = self.done.get()
            self.under_way -= 1
            callback(text)

    def close(self) -> None:
        """End the thread. The error callback of every request that has no reply yet runs before this returns."""
        self.pirate.stop()
        self.waiting.put(None)
        self.thread.join(5)
        self.status = ("Disposed", self.status[1])
        try:
            self.poll()
        finally:
            # A callback raised: the others run all the same.
            if self.done.qsize():
                self.close()

    def _talk(self) -> None:
        """The network thread. The socket is made, used and closed here."""
        with self.context, contextlib.closing(self.pirate):
            # Sleeps, which costs nothing, until request() or close() puts something there.
            for text, reply, error in iter(self.waiting.get, None):
                try:
                    answer = self.pirate.request(text)
                    self.status = ("Connected", self.status[1])
                    self.done.put((reply, answer))
                # Whatever it is, this thread goes on, and the caller gets to know.
                except Exception as failure:
                    self.status = ("Lost", str(failure))
                    self.done.put((error, str(failure)))

    def _retrying(self, trouble: str) -> None:
        self.status = ("Retrying", trouble)
