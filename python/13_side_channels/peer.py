"""Lesson 13, one simulator as the carrier knows it: its channels, and what is on the way from it and to it.
"""

import struct
from collections import deque
from collections.abc import Callable, Iterator

from side_channel import LARGEST_EXCHANGE, UnitySideChannelException
from side_channel_manager import SideChannelManager

# A part of an exchange, in bytes: it ends with the message that makes it so large.
PART = 65_536
# What may wait of one that sends faster than this side reads.
MOST_UNREAD = 4 * LARGEST_EXCHANGE


class Peer:
    def __init__(self, manager: SideChannelManager) -> None:
        self.manager = manager
        self.unread, self.unsent = deque[bytes](), deque[bytes]()
        # It has said "I am here", and has to be told something; and when it said anything.
        self.greeted, self.heard = False, 0.0

    def take_in(self, exchange: bytes) -> bool:
        """False if that is too much."""
        self.unread += parts(exchange)
        return sum(map(len, self.unread)) <= MOST_UNREAD

    def deliver(self, report: Callable[[str], None]) -> None:
        """What it has sent, a part in each turn of the server: nobody waits for all that another one has to say."""
        size = 0
        while self.unread and size < PART:
            size += len(self.unread[0])
            try:
                self.manager.process_side_channel_message(self.unread.popleft())
            except UnitySideChannelException as error:
                report(str(error))


def parts(exchange: bytes) -> Iterator[bytes]:
    """Several smaller exchanges in place of a large one, which would take its time."""
    begin = end = 0
    while len(exchange) - end >= 20:
        (length,) = struct.unpack_from("<i", exchange, end + 16)
        if not 0 <= length <= len(exchange) - end - 20:
            break
        end += 20 + length
        if end - begin >= PART:
            yield exchange[begin:end]
            begin = end
    if begin < len(exchange):
        yield exchange[begin:]
