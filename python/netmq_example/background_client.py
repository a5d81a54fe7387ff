"""A client that never makes its caller wait: it asks on a thread of its own. For games, for threads and for asyncio.

    with BackgroundClient("tcp://127.0.0.1:5554") as client:
        client.request("hello", print, print)             a game, whenever it likes: callbacks for reply and error
        client.poll()                                     once a frame: the callbacks run here

        future = client.submit("hello")                   any thread: a concurrent.futures.Future
        reply = await client.ask("hello")                 any loop of asyncio

Each of its threads has a LazyPirate, whose bytes and retries are in lazy_pirate.py. In C# it is BackgroundClient.cs.
"""

import asyncio
import contextlib
import functools
import itertools
import logging
import math
import os
import queue
import threading
import time
import weakref
from collections.abc import Callable
from concurrent.futures import Future
from dataclasses import dataclass, field
from enum import StrEnum
from typing import NamedTuple

from netmq_example import arguments, check
from netmq_example.errors import Closed, Timeout
from netmq_example.finalizers import finalizer
from netmq_example.former import positional
from netmq_example.lazy_pirate import LazyPirate, refused
from netmq_example.one_process import Keys, OneProcess
from netmq_example.program import Context, encoded

Callback = Callable[[str], object]
MOST_CONNECTIONS = 256
# In less time nothing is asked.
LEAST_SECONDS = 0.001

log = logging.getLogger("netmq_example.client")


class ClientState(StrEnum):
    """Only a reply proves that the server is there."""

    CONNECTING = "Connecting"
    CONNECTED = "Connected"
    RETRYING = "Retrying"
    LOST = "Lost"
    DISPOSED = "Disposed"


class Status(NamedTuple):
    """Both of one moment: the state, and the last error's text, which a later reply leaves there."""

    state: ClientState
    error: str


@dataclass(eq=False)
class Asked:
    """A request that is under way: until when it may take, by time.monotonic(), and the future that gets its reply."""

    text: str
    until: float = math.inf
    future: "Future[str]" = field(default_factory=Future)
    # Whether a reply that begins with `error:` is an error.
    refusable: bool = True
    retried: bool = False


Waiting = queue.SimpleQueue[Asked | None]


class BackgroundClient(OneProcess):
    """Asks a server on threads of its own. `status` has the state and the last error, and compares with C#'s words:
    `client.status.state == "Connected"`.

    request(), submit() and ask() may be called on any thread. The callbacks of request() run in poll(), which one
    thread calls, and in close().
    """

    @positional("endpoint", "timeout", "tries", "capacity")
    def __init__(
        self,
        endpoint: str,
        *,
        timeout: float = 1.0,
        tries: int = 3,
        window: int = 1,
        capacity: int = 64,
        keys: Keys | None = None,
        context: Context | None = None,
    ) -> None:
        """`timeout` and `tries` are those of LazyPirate. `window` requests are asked at the same time, each over a
        connection of its own; the others wait in their order. At most `capacity` of request() are under way.
        """
        self.capacity = check.count("capacity", capacity)
        self.window = check.count("window", window, most=MOST_CONNECTIONS)
        # The threads know their client by this alone: one that is forgotten is not held by them, and ends them.
        client = weakref.ref(self)
        words = {"timeout": timeout, "tries": tries, "keys": keys, "context": context}
        self.pirates = [LazyPirate(endpoint, **words) for _ in range(self.window)]  # type: ignore[arg-type]
        self.endpoint = endpoint
        # In one variable: a reader never gets state and error of two moments.
        self.status: Status = Status(ClientState.CONNECTING, "")
        # A signal's handler may call close() while this thread has it.
        self.gate = threading.RLock()
        # The callbacks of each request by its number: the threads have none of them.
        self.calls: dict[int, tuple[Callback, Callback]] = {}
        self.numbers = itertools.count()
        # Those that ended: the number, which of the two callbacks, 0 the reply, 1 the error, and its text.
        self.done: queue.SimpleQueue[tuple[int, int, str]] = queue.SimpleQueue()
        self.waiting: Waiting = queue.SimpleQueue()
        self.polled = False
        self.end = finalizer(self, end, self.pirates, self.waiting)
        self.end.atexit = False
        self.threads = [
            threading.Thread(
                target=talk,
                args=(pirate, self.waiting, client),
                name=f"netmq_example.BackgroundClient {endpoint} {number}",
                daemon=True,
            )
            for number, pirate in enumerate(self.pirates, 1)
        ]
        for thread in self.threads:
            thread.start()

    def request(self, text: str, reply: Callback, error: Callback) -> bool:
        """Have one of the callbacks run in a later poll(). False if refused, because it is full or closed.

        Each callback gets a text. A reply that begins with `error:` is a reply, too.
        """
        self.check_process()
        asked = Asked(check.instance("text", text, str), refusable=False)
        call = (arguments.function("reply", reply), arguments.function("error", error))
        with self.gate:
            if not self.end.alive or self.under_way >= self.capacity:
                return False
            number = next(self.numbers)
            self.calls[number] = call
            asked.future.add_done_callback(functools.partial(hand_over, weakref.ref(self), number))
            self.waiting.put(asked)
        return True

    def submit(self, text: str, *, within: float | None = None) -> "Future[str]":
        """The reply as a future, whose cancel() takes the request back until it is sent.

        It raises Refused for a reply that begins with `error:`; Timeout if no try was answered, or not `within` so many
        seconds from now; Closed if the client was closed before. MessageError: the text is too long.
        """
        return self.enqueue(text, within).future

    async def ask(self, text: str, *, within: float | None = None) -> str:
        """The same on any loop of asyncio. Once its task is cancelled, as asyncio.timeout does it, no try follows."""
        asked = self.enqueue(text, within)
        try:
            return await asyncio.wrap_future(asked.future)
        except asyncio.CancelledError:
            asked.until = 0.0
            raise

    def enqueue(self, text: str, within: float | None) -> Asked:
        self.check_process()
        encoded(text)
        asked = Asked(text, time.monotonic() + (math.inf if within is None else check.seconds("within", within)))
        with self.gate:
            if self.end.alive:
                self.waiting.put(asked)
            # Asked again: a signal's handler may have closed it meanwhile.
            if not self.end.alive:
                raise Closed("this client is closed: make a new one")
        return asked

    @property
    def under_way(self) -> int:
        """Those of request() whose callback has not run yet."""
        return len(self.calls)

    def poll(self) -> None:
        """Run the callbacks of what has ended, on this thread. Call it once a frame."""
        self.polled = True
        # Only what is there now: callbacks that ask again must not make one frame last for ever.
        for _ in range(self.done.qsize()):
            try:
                number, which, text = self.done.get_nowait()
            except queue.Empty:
                # A callback that closed this client, or another thread, has run those after it already.
                break
            self.calls.pop(number)[which](text)

    def close(self) -> None:
        """End the threads. Each request without a reply ends by Closed, and its callback runs before this returns."""
        # After a fork the threads are the parent's.
        if os.getpid() != self.process_id:
            return
        # A request on another thread is behind it, and refused, or before it, and ended.
        with self.gate:
            self.end()
        end_by = time.monotonic() + 5
        for thread in self.threads:
            # A future's own callback may close the client, on its thread.
            if thread is not threading.current_thread():
                thread.join(max(0.0, end_by - time.monotonic()))
        self.status = Status(ClientState.DISPOSED, self.status.error)
        with contextlib.ExitStack() as stack:
            # So often: where a callback raises, the others run all the same.
            for _ in range(self.done.qsize()):
                stack.callback(self.poll)


Client = weakref.ref[BackgroundClient]


def talk(pirate: LazyPirate, waiting: Waiting, client: Client) -> None:
    """A network thread. The socket is made, used and closed here."""
    with pirate:
        # It sleeps, which costs nothing, until there is something.
        while asked := following(waiting, client):
            # One that was taken back meanwhile is not sent.
            if asked.future.set_running_or_notify_cancel():
                try:
                    ask(pirate, asked, client)
                except BaseException as error:
                    # SystemExit, say, in a callback of the future's: it would end this thread, and nobody would hear.
                    log.error("a mistake in a future's callback", exc_info=error)


def ask(pirate: LazyPirate, asked: Asked, client: Client) -> None:
    try:
        pirate.report = functools.partial(retry, asked, client)
        if asked.until - time.monotonic() < LEAST_SECONDS and not pirate.stopped.is_set():
            raise Timeout(f"not sent to {pirate.endpoint} in time: the requests before it took too long")
        reply = pirate.request_until(asked.text, lambda: asked.until)
    # This thread goes on after any mistake, and the caller gets to know.
    except Exception as failure:
        # Of one that nobody waits for any more, nothing is to be told.
        if asked.until:
            tell(client, ClientState.LOST, str(failure))
        asked.future.set_exception(failure)
    else:
        if asked.refusable and asked.retried:
            log.info("%s answers again", pirate.endpoint)
        tell(client, ClientState.CONNECTED)
        if asked.refusable and (refusal := refused(reply)):
            asked.future.set_exception(refusal)
        else:
            asked.future.set_result(reply)


def retry(asked: Asked, client: Client, line: str) -> None:
    """A game sees it in the status; of a future nobody would."""
    asked.retried = True
    tell(client, ClientState.RETRYING, line)
    if asked.refusable:
        log.warning(line)


def following(waiting: Waiting, client: Client) -> Asked | None:
    """The next request. If nobody has fetched the first reply for a second, one warning says how."""
    with contextlib.suppress(queue.Empty):
        return waiting.get(timeout=1 if unpolled(client) else None)
    if unpolled(client, warned=True):
        log.warning("BackgroundClient: a reply waits, and nobody has called poll: callbacks run only in there")
    return waiting.get()


def unpolled(client: Client, warned: bool = False) -> bool:
    """Whether a reply waits and nobody has called poll yet. A client that was warned counts as polled."""
    here = client()
    if here is None or here.polled or here.done.empty():
        return False
    if warned:
        here.polled = True
    return True


def tell(client: Client, state: ClientState, trouble: str | None = None) -> None:
    here = client()
    if here:
        here.status = Status(state, here.status.error if trouble is None else trouble)


def hand_over(client: Client, number: int, future: "Future[str]") -> None:
    """Which callback runs in the next poll(), and its text."""
    here = client()
    if here:
        failure = future.exception()
        here.done.put((number, 0, future.result()) if failure is None else (number, 1, str(failure)))


def end(pirates: list[LazyPirate], waiting: Waiting) -> None:
    for pirate in pirates:
        pirate.stop()
        waiting.put(None)
