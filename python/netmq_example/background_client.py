"""Lesson 04, the background client in Python: the C# version is BackgroundClient.cs.

    client = BackgroundClient("tcp://127.0.0.1:5554")     once
    client.request("hello", print, print)                 whenever you like: callbacks for reply and error
    client.poll()                                         once a frame: the callbacks run here
    client.close()                                        at the end

Bytes: those of lesson 02, [id][text] each way, and it retries as the lazy pirate there does.
"""

import contextlib
import queue
import threading
import time
import uuid
from collections.abc import Callable

import zmq

Callback = Callable[[str], object]
LARGEST = 65_536


class BackgroundClient:
    """Asks a server without ever making the calling thread wait. Each client has its own thread."""

    def __init__(self, endpoint: str, timeout: float = 1.0, tries: int = 3, capacity: int = 64) -> None:
        """Timeout is for the first try; each one after it waits twice as long, up to 8 times."""
        self.endpoint, self.timeout, self.tries, self.capacity = endpoint, timeout, tries, capacity
        # State and last error, in one variable: a reader never gets those of two moments. Only a reply proves that the
        # server is there: Connecting, Connected, Retrying, Lost, Disposed.
        self.status, self.under_way = ("Connecting", ""), 0
        self.waiting: queue.SimpleQueue[tuple[bytes, Callback, Callback] | None] = queue.SimpleQueue()
        self.done: queue.SimpleQueue[tuple[Callback, str]] = queue.SimpleQueue()
        # An id must never come twice, whoever else asks and however often this program starts: hence the uuid.
        self.name, self.stop = uuid.uuid4().hex, threading.Event()
        self.socket: zmq.Socket[bytes] | None = None
        self.thread = threading.Thread(target=self._talk, daemon=True)
        self.thread.start()

    def request(self, text: str, reply: Callback, error: Callback) -> bool:
        """Have one of the callbacks run in a later poll(). False if refused, because it is full or closed."""
        if self.stop.is_set() or self.under_way == self.capacity:
            return False
        self.under_way += 1
        self.waiting.put((text.encode(errors="replace"), reply, error))
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
        self.stop.set()
        self.waiting.put(None)
        self.thread.join(5)
        self.status = "Disposed", self.status[1]
        try:
            self.poll()
        finally:
            # A callback raised: the others run all the same.
            if self.done.qsize():
                self.close()

    def _talk(self) -> None:
        """The network thread. The socket is made, used and closed here."""
        with zmq.Context() as context:
            # Sleeps, which costs nothing, until request() or close() puts something there.
            for number, (text, reply, error) in enumerate(iter(self.waiting.get, None), 1):
                try:
                    self.done.put((reply, self._ask(context, number, text)))
                except Exception as failure:
                    # Whatever it is, this thread goes on, and the caller gets to know.
                    self.status = "Lost", str(failure)
                    self.done.put((error, str(failure)))
            self._close_socket()

    def _ask(self, context: zmq.Context[zmq.Socket[bytes]], number: int, text: bytes) -> str:
        request = [f"{number}-{self.name}".encode(), text]
        if len(text) > LARGEST:
            raise ValueError(f"a text of more than {LARGEST} bytes")
        for attempt in range(1, self.tries + 1):
            if self.stop.is_set():
                raise InterruptedError("the client was disposed")
            if not self.socket:
                self.socket = context.socket(zmq.REQ)
                # What nobody fetched is dropped with the socket; waiting for its delivery could take for ever.
                self.socket.linger, self.socket.maxmsgsize = 0, LARGEST
                self.socket.connect(self.endpoint)
            # A new connection takes several round trips. On a slow line only a longer wait ever succeeds.
            timeout = self.timeout * min(2 ** (attempt - 1), 8)
            end, frames = time.monotonic() + timeout, list[bytes]()
            with contextlib.suppress(zmq.Again):
                # Without waiting: after a peer that broke the protocol there may be no connection to send on.
                self.socket.send_multipart(request, zmq.NOBLOCK)
                while not self.socket.poll(50) and time.monotonic() < end and not self.stop.is_set():
                    pass
                frames = self.socket.recv_multipart(zmq.NOBLOCK)
            if len(frames) == 2 and frames[0] == request[0]:
                self.status = "Connected", self.status[1]
                return frames[1].decode(errors="replace")
            trouble = "dropped a reply to another request" if frames else f"no reply within {timeout:g} s"
            # A REQ socket that waits for a reply refuses to send. A new one may, on a new connection.
            self._close_socket()
            if time.monotonic() < end:
                # It came at once, and so may the next: without a pause all tries are over in a millisecond.
                self.stop.wait(0.25)
            if attempt < self.tries:
                self.status = "Retrying", f"{number}: {trouble}; try {attempt + 1} of {self.tries}"
        what = f"{self.tries} tries to ask {self.endpoint}, the last: {trouble}"
        cure = "is the right server running, or the line slow?"
        raise TimeoutError(f"{what}; {cure} '{text.decode()}' may have been done or not")

    def _close_socket(self) -> None:
        if self.socket:
            self.socket.close()
        self.socket = None
