"""A client that asks again until it is answered: the lazy pirate of ZeroMQ's guide, https://zguide.zeromq.org.

    with LazyPirate("tcp://127.0.0.1:5552") as pirate:
        print(pirate.request("add 1"))

Bytes: UTF-8 text, two frames each way, [id][text], at most 65,536 bytes each. Every retry of a request carries the same
id, by which the server knows what it has done already (journal.py). In C# it is LazyPirateRequester.cs.
"""

import math
import time
import uuid
from collections.abc import Callable
from typing import Any

from netmq_example import arguments, check
from netmq_example.console import printable
from netmq_example.errors import Closed, Refused, Timeout
from netmq_example.former import positional
from netmq_example.one_process import Keys, one_at_a_time
from netmq_example.program import Context, encoded, text_of
from netmq_example.requester import Requester, log
from netmq_example.trouble import LOOK_UP_SECONDS, longer, tried


class LazyPirate(Requester):
    """Asks over one REQ socket at a time, on any thread, but on one at a time; stop() at any time."""

    @positional("context", "endpoint", "timeout", "tries", "report")
    def __init__(
        self,
        endpoint: str,
        *,
        timeout: float = 0.5,
        tries: int = 5,
        keys: Keys | None = None,
        context: Context | None = None,
    ) -> None:
        """The first try waits `timeout` seconds for its reply, and each one after it twice as long, up to 8 times.

        Each retry is logged as a warning. Without a context it takes pyzmq's own, zmq.Context.instance().
        """
        super().__init__(endpoint, "tcp://127.0.0.1:5552", timeout, tries, keys, context)
        # An id must never come twice, whoever else asks and however often this program starts: hence the uuid.
        self.name = uuid.uuid4().hex
        self.number = 0

    def request(self, text: str, *, within: float | None = None) -> str:
        """The reply, as it came: one that begins with `error:` is a reply, too.

        All tries together take at most `within` seconds. Timeout: no try was answered, but it may be done.
        MessageError: it is too long. Closed: stop() or close() ended it.
        """
        end = time.monotonic() + (math.inf if within is None else check.seconds("within", within))
        return self.request_until(text, lambda: end)

    @one_at_a_time
    def request_until(self, text: str, until: Callable[[], float]) -> str:
        """The same until a time of time.monotonic() that may come nearer meanwhile."""
        began = time.monotonic()
        if not self.stopped.is_set():
            arguments.not_closed("context", self.context)
        self.number += 1
        request = [f"{self.number}-{self.name}".encode(), encoded(text)]
        attempt = 1
        while not self.stopped.is_set():
            timeout = max(0.0, min(longer(self.timeout, attempt - 1), until() - time.monotonic()))
            frames = self.exchange(request, timeout, until)
            if self.is_reply(frames, request):
                log.debug("%s: %s", self.endpoint, frames)
                return text_of(frames[1])
            if self.stopped.is_set():
                break
            trouble = self.trouble(timeout)
            if frames:
                seen = printable(" ".join(map(text_of, frames)))
                trouble = f"dropped a reply to another request ({seen})"
            if attempt == self.tries or time.monotonic() >= until():
                cure = "is the right server running, the line slow, or the reply over 64 KB?"
                # To look up a name takes its time, which is none of whoever waits for less.
                if self.search.name or until() - began >= LOOK_UP_SECONDS:
                    cure = self.search.cure(cure)
                whole = until() - began
                within = f" within {round(whole, 2):g} s" if 0 < whole < math.inf else ""
                raise Timeout(
                    f"{tried(attempt)}{within} to ask {self.endpoint}, the last: {trouble}; "
                    f"{cure} '{text}' may have been done or not"
                )
            attempt += 1
            self.report(f"{self.number}: {trouble}; try {attempt} of {self.tries}")
        raise Closed("the client was closed")

    def is_reply(self, frames: list[Any], request: list[bytes]) -> bool:
        return len(frames) == 2 and bool(frames[0] == request[0])


def refused(reply: str) -> Refused | None:
    """The error in a text of the lessons' servers that begins with `error:`, or None for another text."""
    return Refused("error", reply[6:].strip()) if reply.startswith("error:") else None
