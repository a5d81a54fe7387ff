"""Numbers that Unity wants to see beside the trainer's own. From Unity to Python.

    stats = StatsSideChannel()
    for key, values in stats.get_and_reset_stats().items():
        for value, method in values: ...

Bytes: string key, float32 value, int32 how to aggregate. In C# it is StatsRecorder.cs.
"""

import uuid
from enum import IntEnum

from netmq_example.mlagents_envs.exception import UnitySideChannelException
from netmq_example.mlagents_envs.side_channel.side_channel import IncomingMessage, SideChannel


class StatsAggregationMethod(IntEnum):
    """How to combine the values of one key."""

    AVERAGE = 0
    MOST_RECENT = 1
    SUM = 2
    HISTOGRAM = 3


StatList = list[tuple[float, StatsAggregationMethod]]
EnvironmentStats = dict[str, StatList]


class StatsSideChannel(SideChannel):
    def __init__(self) -> None:
        super().__init__(uuid.UUID("a1d8f7b7-cec8-50f9-b78b-d3e165a78520"))
        self.stats: EnvironmentStats = {}

    def on_message_received(self, msg: IncomingMessage) -> None:
        key, value, method = msg.read_string(), msg.read_float32(), msg.read_int32()
        if method not in list(StatsAggregationMethod):
            raise UnitySideChannelException(f"statistics are aggregated by 0 to 3, not by {method}")
        self.stats.setdefault(key, []).append((value, StatsAggregationMethod(method)))

    def get_and_reset_stats(self) -> EnvironmentStats:
        stats = self.stats
        self.stats = {}
        return stats
