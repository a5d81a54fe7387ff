"""Lesson 14, news: what a message about a job has to have, so that whoever gets it may rely on it.

    check(news)                         MessageError says what is missing, or is not what it should be

The C# side is JobNews.cs.
"""

import sys
from pathlib import Path

# In its own lesson's folder; at home it lies beside this file.
sys.path.append(str(Path(__file__).resolve().parents[1] / "05_messages"))
from messages import Message, MessageError, take

STATUSES = ("succeeded", "canceled", "aborted")
# What a message about a job has, besides the job.
STATE = {"seq": int, "done": int, "total": int, "text": str}
NEWS: dict[str, dict[str, type]] = {
    "accepted": {"seq": int, "position": int},
    "feedback": STATE,
    "canceling": STATE,
    "result": {**STATE, "status": str},
    "forgotten": {},
}


def check(news: Message) -> None:
    """What a message about a job must have; MessageError says what it has not."""
    if news.kind not in NEWS:
        raise MessageError("unknown-kind", f"kind {news.kind!a:.40} is none of {', '.join(NEWS)}")
    for name, kind in NEWS[news.kind].items():
        take(news.values, name, kind)
    if news.kind == "result" and news.values["status"] not in STATUSES:
        status = news.values["status"]
        raise MessageError("bad-status", f"status {status!a:.40} is none of {', '.join(STATUSES)}")
