"""Lesson 14, progress: what to say of a message about a job, and a bar on a terminal.

    progress = Progress()
    progress.show("job 4f2a93bc: 40 of 100", 0.4)              a bar; where no terminal is, a line at each tenth
    progress.show("job 4f2a93bc: canceling")                   a line of its own
"""

import sys
from pathlib import Path

# In its own lesson's folder; at home it lies beside this file.
sys.path.append(str(Path(__file__).resolve().parents[1] / "05_messages"))
from messages import Message

WIDTH = 30


def words(news: Message) -> str:
    """In words; job_client.py has looked whether it is whole."""
    if news.kind == "accepted":
        position = news.values["position"]
        return "accepted" + (f", number {position} of those that wait" if position else "")
    if news.kind not in ("feedback", "result"):
        return news.kind
    text, place = news.values["text"], f"{news.values['done']} of {news.values['total']}"
    return (f"{news.values['status']} at {place}" if news.kind == "result" else place) + (f", {text}" if text else "")


def share(news: Message) -> float | None:
    """How much of it is done; only feedback moves the bar."""
    if news.kind != "feedback":
        return None
    return float(min(max(news.values["done"] / max(news.values["total"], 1), 0.0), 1.0))


class Progress:
    def __init__(self) -> None:
        self.tenth, self.bar = -1, sys.stdout.isatty()

    def show(self, line: str, share: float | None = None) -> None:
        if not self.bar:
            if share is None or int(share * 10) != self.tenth:
                print(line, flush=True)
        elif share is None:
            # Over the bar, of which nothing is left.
            print(f"\r{line}\x1b[K", flush=True)
        else:
            bar = "#" * int(share * WIDTH)
            print(f"\r[{bar:{WIDTH}}] {line}\x1b[K", end="", flush=True)
        self.tenth = -1 if share is None else int(share * 10)
