"""Lesson 14, progress: how far a job is, in words and as a bar on a terminal.

    progress = Progress()
    for news in client.watch(goal):
        progress.show(f"job {client.job:.8}: {words(news)}", share(news))
    progress.show("left at 40")                                        a line of its own

Where no terminal is, there is a line for each tenth instead of the bar.
"""

import sys

from netmq_example.messages import Message

BAR_CHARACTERS = 30


def words(news: Message) -> str:
    """A message that JobClient.watch has yielded, in words."""
    values = news.values
    if news.kind == "accepted" and values["position"]:
        return f"accepted, number {values['position']} of those that wait"
    if news.kind not in ("feedback", "result"):
        return news.kind
    place = f"{values['done']} of {values['total']}"
    if news.kind == "result":
        place = f"{values['status']} at {place}"
    return f"{place}, {values['text']}" if values["text"] else place


def share(news: Message) -> float | None:
    """How much of it is done, from 0 to 1; only feedback moves the bar."""
    if news.kind != "feedback":
        return None
    return float(min(max(news.values["done"] / max(news.values["total"], 1), 0.0), 1.0))


class Progress:
    def __init__(self) -> None:
        self.has_bar = sys.stdout.isatty()
        # The tenth that was printed last.
        self.tenth = -1

    def show(self, line: str, share: float | None = None) -> None:
        tenth = -1 if share is None else int(share * 10)
        if share is None:
            # Over the bar, of which nothing is left.
            print(f"\r{line}\x1b[K" if self.has_bar else line, flush=True)
        elif self.has_bar:
            bar = "#" * int(share * BAR_CHARACTERS)
            print(f"\r[{bar:{BAR_CHARACTERS}}] {line}\x1b[K", end="", flush=True)
        elif tenth != self.tenth:
            print(line, flush=True)
        self.tenth = tenth
