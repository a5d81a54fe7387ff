"""Lesson 14, one job that has not ended: its goal, and the newest message about it.

    accepted  ->  feedback, feedback, …  ->  result          whose status is succeeded, canceled or aborted
                             canceling   ->  result
"""

import sys
from dataclasses import dataclass, field
from pathlib import Path

# In its own lesson's folder; at home it lies beside this file.
sys.path.append(str(Path(__file__).resolve().parents[1] / "05_messages"))
from messages import Message


@dataclass
class Job:
    goal: Message
    news: Message
    # Who is told what is new, and until when.
    watchers: dict[bytes, float] = field(default_factory=dict)
    # When a worker that is deaf to cancel has had time enough, and how often one died.
    kill_at: float = 0
    deaths: int = 0

    @property
    def begun(self) -> bool:
        """It may have done something."""
        return self.news.kind != "accepted" or self.news.values["position"] == 0

    def canceling(self) -> Message:
        facts = {"done": 0, "total": self.goal.values["count"], "text": ""}
        return Message("canceling", values=facts | self.news.values, arrays=self.news.arrays)

    def result(self, status: str, why: str = "") -> Message:
        """Its end, as far as it is."""
        facts = self.canceling().values
        return Message("result", values=facts | {"status": status, "text": why}, arrays=self.news.arrays)
