"""A publisher: it says what is new under a topic, to all that listen, and never waits for any of them.

    with Publisher("tcp://127.0.0.1:5553") as publisher:
        publisher.send("news/", "hello")

Bytes: a text is one frame, `news/ hello`, as TopicListener reads it. Bytes, and a Message of messages.py, follow their
topic as frames of their own. A listener that is late or too slow misses them.
"""

import contextlib
import logging

import zmq

from netmq_example import check
from netmq_example.messages import Message
from netmq_example.one_process import OneProcess
from netmq_example.program import Context, Socket, bind, encoded, limit, not_for_anyone

# Listeners send nothing but subscriptions, and those are short.
LARGEST_BYTES = 1000

log = logging.getLogger("netmq_example.publish")


class Publisher(OneProcess):
    """Publishes over a PUB socket. Use it on one thread."""

    def __init__(
        self, endpoint: str = "tcp://127.0.0.1:0", *, open_to_anyone: bool = False, context: Context | None = None
    ) -> None:
        """Port 0 takes a free one, and `endpoint` says which. ListenError: it is taken.

        Only programs of this machine may listen, unless it is `open_to_anyone`.
        """
        not_for_anyone(check.endpoint(endpoint, "tcp://127.0.0.1:5553", lowest_port=0), open_to_anyone)
        with contextlib.ExitStack() as stack:
            # The end of a context of its own waits until the port is free.
            context = stack.enter_context(zmq.Context()) if context is None else check.context(context)
            self.socket: Socket = stack.enter_context(context.socket(zmq.PUB))
            limit(self.socket, LARGEST_BYTES)
            self.endpoint = bind(self.socket, endpoint)
            self.stack = stack.pop_all()
        log.info("publishing on %s", self.endpoint)

    def send(self, topic: str, body: str | bytes | Message) -> None:
        """Send it to whoever listens to this topic. A text has at most 65,536 bytes with its topic."""
        self.check_process()
        check.not_closed("this publisher", self.socket)
        check.instance("topic", topic, str)
        check.instance("body", body, str, bytes, Message)
        if isinstance(body, str):
            frames = [encoded(f"{topic} {body}")]
        else:
            frames = [encoded(topic), *(body.frames() if isinstance(body, Message) else [body])]
        self.socket.send_multipart(frames)

    def close(self) -> None:
        """Give the port back. Twice is once."""
        self.stack.close()
