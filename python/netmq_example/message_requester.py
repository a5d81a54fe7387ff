"""A client for messages of messages.py: it asks and waits. In C# it is MessageRequester.cs.

with MessageRequester("tcp://127.0.0.1:5555") as requester:
    reply = requester.request(Message("frame", 1, {"bottom_up": True}, [Array.of(picture)]))
    print(reply.values)
"""

from netmq_example import check
from netmq_example.messages import LIMIT, Message
from netmq_example.one_process import Keys, one_at_a_time
from netmq_example.program import Context
from netmq_example.requester import Requester


class MessageRequester(Requester):
    """Asks over one REQ socket at a time, on any thread, but on one at a time."""

    # Above LIMIT a reply is refused by name. Above four times as much libzmq takes no more of it and hangs up.
    largest = 4 * LIMIT
    copies = False

    def __init__(
        self,
        endpoint: str,
        *,
        timeout: float = 2.5,
        tries: int = 1,
        keys: Keys | None = None,
        context: Context | None = None,
    ) -> None:
        """The first try waits `timeout` seconds for its reply, and each one after it twice as long, up to 8 times.

        With more than one of the `tries` the server may do it more than once.
        """
        super().__init__(endpoint, "tcp://127.0.0.1:5555", timeout, tries, keys, context)

    @one_at_a_time
    def request(self, request: Message) -> Message:
        """The reply. Refused: the server says why there is none. MessageError: request or reply is no message.

        Timeout: no try was answered, but it may be done. Closed: it was closed before.
        """
        frames = check.instance("request", request, Message).frames()
        return Message.read_reply(self.ask(frames, request.kind, f"{LIMIT >> 20} MB"))
