"""Lesson 13, a simulation that uses its channels; in C# SideChannelRounds.cs, with the same lines and numbers.

In each round it draws its parameters, records statistics and sets a property; the server's property says that it has
seen that.
"""

import struct
import time
import uuid
from collections.abc import Callable

from netmq_example.mlagents_envs.exception import UnitySideChannelException
from netmq_example.mlagents_envs.side_channel import IncomingMessage, OutgoingMessage, SideChannel
from netmq_example.mlagents_envs.side_channel.float_properties_channel import FloatPropertiesChannel
from netmq_example.mlagents_envs.side_channel.raw_bytes_channel import RawBytesChannel
from netmq_example.mlagents_envs.side_channel.side_channel_manager import SideChannelManager
from netmq_example.mlagents_envs.side_channel.stats_side_channel import StatsAggregationMethod
from netmq_example.mlagents_envs.unity_channels import EngineSettings, EnvironmentParameters, StatsRecorder, describe
from netmq_example.trouble import Trouble

# The errors that --trouble makes.
TROUBLES = ("none", "unknown", "cut", "throw")


class StringLogChannel(SideChannel):
    """The other end of server.py's, in C# StringLogChannel.cs: Python's lines come here, and errors go to Python."""

    def __init__(self, log: Callable[[str], None], throws: bool) -> None:
        super().__init__(uuid.UUID("621f0a70-4f87-11ea-a6bf-784f4387d1f7"))
        self.log = log
        self.throws = throws

    def on_message_received(self, msg: IncomingMessage) -> None:
        if self.throws:
            raise UnitySideChannelException("thrown on purpose")
        self.log(f"From Python : {msg.read_string()}")

    def send_debug_statement_to_python(self, text: str) -> None:
        msg = OutgoingMessage()
        msg.write_string(text, utf8=True)
        self.queue_message_to_send(msg)


class Rounds:
    """`limit` is how many seconds a round may take."""

    def __init__(self, count: int, trouble: str, limit: float, log: Callable[[str], None]) -> None:
        self.count = count
        self.trouble = trouble
        self.limit = limit
        self.log = log
        self.round = 0
        # For how long this round is not seen, and until when that was looked at.
        self.waited = 0.0
        self.looked_at = time.monotonic()
        self.string_log = StringLogChannel(log, throws=trouble == "throw")
        self.properties = FloatPropertiesChannel()
        settings = EngineSettings(lambda *setting: log(describe(*setting)))
        self.parameters = EnvironmentParameters()
        self.parameters.register_callback("gravity", lambda value: log(f"gravity is now {value:.2f}"))
        self.stats = StatsRecorder()
        channels = [self.string_log, self.properties, settings, self.parameters, self.stats]
        self.manager = SideChannelManager(channels, Trouble(log))

    @property
    def done(self) -> bool:
        return self.round >= self.count and self.seen

    @property
    def seen(self) -> bool:
        """Whether the server has said that it knows of this round; before the first one, that it is there."""
        return self.properties.get_property("seen") == self.round

    def exchange(self, received: list[bytes]) -> bytes:
        """Hands the received exchanges to the channels, and returns the exchange that they have queued."""
        for data in received:
            self.manager.take_in(data)
        now = time.monotonic()
        # A longer gap than a second was sleep.
        self.waited += min(now - self.looked_at, 1.0)
        self.looked_at = now
        if self.seen and self.round < self.count:
            self.round += 1
            self.waited = 0.0
            self.begin_round()
        elif not self.seen and self.waited > self.limit:
            raise TimeoutError(f"round {self.round} was not seen within {self.limit:g} s; is that lesson 13's server?")
        elif received and not self.seen:
            # A server that was started again has not heard of this round.
            self.properties.set_property("round", self.round)
        data = bytes(self.manager.generate_side_channel_messages())
        if self.trouble == "cut" and data:
            # Nine bytes are announced, and six come.
            self.trouble = "none"
            data += self.string_log.channel_id.bytes_le + struct.pack("<i", 9) + b"\5\0\0\0He"
        return data

    def begin_round(self) -> None:
        mass, wind, light = (self.parameters.get_with_default(key, 0.0) for key in ("mass", "wind", "light"))
        self.log(f"{self.round}: mass {mass:.4f}, wind {wind:.4f}, light {light:.4f}")
        self.stats.add("mass", mass)
        self.stats.add("rounds", 1, StatsAggregationMethod.SUM)
        if self.round == self.count:
            self.string_log.send_debug_statement_to_python("Error: a fake error in the last round")
        if self.trouble == "unknown":
            self.trouble = "none"
            stranger = RawBytesChannel(uuid.UUID("00112233-4455-6677-8899-aabbccddeeff"))
            self.manager.register_side_channel(stranger)
            stranger.send_raw_data(b"is anybody there?")
        self.properties.set_property("round", self.round)
