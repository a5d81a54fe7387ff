"""A client for a game: it asks on a thread of its own, so that no frame ever waits.

    client = BackgroundClient("tcp://127.0.0.1:5554")     once
    client.request("hello", print, print)                 whenever you like, on any thread: for reply and error
    client.poll()                                         once a frame: the callbacks run here
    client.close()                                        at the end

The thread has a LazyPirate, whose bytes and retries are in lazy_pirate.py. In C# it is BackgroundClient.cs.
"""

import contextlib
import functools
import logging
import queue
import threading
import weakref
from collections import deque
from collections.abc import Callable

import zmq

from netmq_example import check
from netmq_example.finalizers import finalizer
from netmq_example.lazy_pirate import LazyPirate
from netmq_example.one_process import OneProcess
from netmq_example.program import Context

Callback = Callable[[str], object]
Waiting = queue.SimpleQueue[str | None]


class BackgroundClient(OneProcess):
    """Asks a server without ever making the calling thread wait. Each client has its own thread."""

    def __init__(self, endpoint: str, timeout: float = 1.0, tries: int = 3, capacity: int = 64) -> None:
        """`timeout` and `tries` are those of LazyPirate; at most `capacity` requests are under way."""
        self.capacity = check.count("capacity", capacity)
        self.context: Context = zmq.Context()
        # The thread knows its client by this alone: one that is forgotten is not held by it, and ends it.
        client = weakref.ref(self)
        self.pirate = LazyPirate(self.context, endpoint, timeout, tries, functools.partial(tell, client, "Retrying"))
        # State and last error, in one variable: a reader never gets those of two moments. Only a reply proves that the
        # server is there: Connecting, Connected, Retrying, Lost, Disposed.
        self.status = ("Connecting", "")
        # Together with what they guard: which text and which callbacks belong together is known by their order alone.
        self.gate = threading.Lock()
        # Callbacks, in the order of their requests, in which these end as well. The thread has none of them.
        self.calls: deque[tuple[Callback, Callback]] = deque()
        self.waiting: Waiting = queue.SimpleQueue()
        # Which of the two callbacks gets a text: 0 the reply, 1 the error.
        self.done: queue.SimpleQueue[tuple[int, str]] = queue.SimpleQueue()
        self.polled = False
        self.end = finalizer(self, end, self.pirate, self.waiting)
        self.end.atexit = False
        words = (self.context, self.pirate, self.waiting, client)
        self.thread = threading.Thread(target=talk, args=words, daemon=True)
        self.thread.start()

    def request(self, text: str, reply: Callback, error: Callback) -> bool:
        """Have one of the callbacks run in a later poll(). False if refused, because it is full or closed."""
        self.check_process()
        check.instance("text", text, str)
        call = (check.function("reply", reply), check.function("error", error))
        with self.gate:
            if self.pirate.stopped.is_set() or self.under_way == self.capacity:
                return False
            self.calls.append(call)
            self.waiting.put(text)
        return True

    @property
    def under_way(self) -> int:
        """Requests whose callback has not run yet."""
        return len(self.calls)

    def poll(self) -> None:
        """Run the callbacks of what has ended, on this thread. Call it once a frame."""
        self.polled = True
        # Only what is there now: callbacks that ask again must not make one frame last for ever.
        for _ in range(self.done.qsize()):
            with self.gate:
                # A callback that closed this client, or another thread, has run those after it already.
                if self.done.empty():
                    break
                which, text = self.done.get()
                call = self.calls.popleft()
            call[which](text)

    def close(self) -> None:
        """End the thread. The error callback of every request that has no reply yet runs before this returns."""
        # A request on another thread is behind it, and refused, or before it, and ended.
        with self.gate:
            self.end()
        self.thread.join(5)
        self.status = ("Disposed", self.status[1])
        try:
            self.poll()
        finally:
            # A callback raised: the others run all the same.
            if self.done.qsize():
                self.close()


Client = weakref.ref[BackgroundClient]


def talk(context: Context, pirate: LazyPirate, waiting: Waiting, client: Client) -> None:
    """The network thread. The socket is made, used and closed here."""
    with context, contextlib.closing(pirate):
        # Sleeps, which costs nothing, until request() or close() puts something there.
        for text in iter(functools.partial(following, waiting, client), None):
            try:
                tell(client, "Connected", None, (0, pirate.request(text)))
            # Whatever it is, this thread goes on, and the caller gets to know.
            except Exception as failure:
                tell(client, "Lost", str(failure), (1, str(failure)))


def following(waiting: Waiting, client: Client) -> str | None:
    """The next request. If nobody has fetched the first reply for a second, one warning says how."""
    with contextlib.suppress(queue.Empty):
        return waiting.get(timeout=1 if unpolled(client) else None)
    if unpolled(client, warned=True):
        words = "BackgroundClient: a reply waits, and nobody has called poll: callbacks run only in there"
        logging.getLogger("netmq_example").warning(words)
    return waiting.get()


def unpolled(client: Client, warned: bool = False) -> bool:
    """Whether a reply waits and nobody has called poll yet. A client that was warned counts as polled."""
    here = client()
    if here is None or here.polled or here.done.empty():
        return False
    if warned:
        here.polled = True
    return True


def tell(client: Client, state: str, trouble: str | None, done: tuple[int, str] | None = None) -> None:
    here = client()
    if here:
        here.status = (state, here.status[1] if trouble is None else trouble)
        if done:
            here.done.put(done)


def end(pirate: LazyPirate, waiting: Waiting) -> None:
    pirate.stop()
    waiting.put(None)
