"""A publisher: it says what is new under a topic, to all that listen, and never waits for any of them.

    with Publisher("tcp://127.0.0.1:5553") as publisher:
        publisher.send("news/", "hello")

Bytes: a text is one frame, `news/ hello`, as TopicListener reads it. Bytes, and a Message of messages.py, follow their
topic as frames of their own. A listener that is late or too slow misses them.
"""

import contextlib
import logging

import zmq

from netmq_example import arguments, check
from netmq_example.errors import MessageError
from netmq_example.messages import Message
from netmq_example.one_process import OneProcess
from netmq_example.program import LARGEST_BYTES, Context, Socket, bind, limit, not_for_anyone

# Listeners send nothing but subscriptions, and those are short.
SUBSCRIPTION_BYTES = 1000

log = logging.getLogger("netmq_example.publish")


class Publisher(OneProcess):
    """Publishes over a PUB socket. Use it on one thread."""

    def __init__(
        self,
        endpoint: str = "tcp://127.0.0.1:0",
        *,
        largest: int = LARGEST_BYTES,
        open_to_anyone: bool = False,
        context: Context | None = None,
    ) -> None:
        """Port 0 takes a free one, and `endpoint` says which. ListenError: it is taken. A frame has at most `largest`
        bytes: give a TopicListener the same, which hangs up on a larger one.

        Only programs of this machine may listen, unless it is `open_to_anyone`.
        """
        self.largest = check.count("largest", largest)
        not_for_anyone(check.endpoint(endpoint, "tcp://127.0.0.1:5553", lowest_port=0), open_to_anyone)
        with contextlib.ExitStack() as stack:
            # The end of a context of its own waits until the port is free.
            context = stack.enter_context(zmq.Context()) if context is None else arguments.context(context)
            self.socket: Socket = stack.enter_context(context.socket(zmq.PUB))
            limit(self.socket, SUBSCRIPTION_BYTES)
            self.endpoint = bind(self.socket, endpoint)
            self.stack = stack.pop_all()
        log.info("publishing on %s", self.endpoint)

    def send(self, topic: str, body: str | bytes | Message) -> None:
        """Send it to whoever listens to this topic. MessageError: it has a frame that listeners do not take."""
        self.check_process()
        arguments.not_closed("this publisher", self.socket)
        check.instance("topic", topic, str)
        check.instance("body", body, str, bytes, Message)
        if isinstance(body, str):
            frames = [f"{topic} {body}".encode(errors="replace")]
        else:
            frames = [topic.encode(errors="replace"), *(body.frames() if isinstance(body, Message) else [body])]
        if (size := max(memoryview(frame).nbytes for frame in frames)) > self.largest:
            cure = "give publisher and listeners a larger `largest`"
            raise MessageError("too-big", f"a frame of {size} bytes, more than {self.largest}: {cure}")
        self.socket.send_multipart(frames)

    def close(self) -> None:
        """Give the port back. Twice is once."""
        self.stack.close()
