"""Application 21, a character's words on a terminal: a line for each sentence, which grows. In C# it is Speech.cs.

    with Speech() as speech:
        for news in client.watch(ask(client, "Who are you?", most=200)):
            speech.hear(news)                                             she: Good evening, trav
                                                                          she: Good evening, traveller.
        speech.say(speech.outcome(news))                                  done: 3 words

Its end, also by an error, ends a line that still grows.
"""

import logging
import re
from typing import Any

from netmq_example.errors import Error
from netmq_example.jobs.client import JobClient
from netmq_example.messages import Message, take

MOST_CHARACTERS = 1000


def ask(client: JobClient, prompt: str, most: int) -> Message:
    """The request, for `client.watch`, with which the character begins to speak: `most` words at most."""
    return client.goal("talk", most, a_prompt("prompt", prompt))


def a_prompt(name: str, value: Any) -> str:
    """A prompt that a character takes."""
    if isinstance(value, str) and 1 <= len(value) <= MOST_CHARACTERS:
        return value
    raise ValueError(f"{name} takes 1 to {MOST_CHARACTERS} characters, not {value!r:.40}")


class Speech:
    """Of a newer text only the end is new, however many were lost in between."""

    def __init__(self) -> None:
        # How many there were so far.
        self.words = 0
        self.shown = ""
        self.line_is_open = False

    def __enter__(self) -> "Speech":
        return self

    def __exit__(self, *error: object) -> None:
        self.end_line()

    def hear(self, news: Message) -> None:
        """Print what is new of it."""
        # At another end the text says why there is no more.
        if news.kind != "feedback" and news.values.get("status") != "succeeded":
            return
        words = take(news.values, "text", str).split()
        line = "".join(c if c.isprintable() else "?" for c in " ".join(words))
        lines = re.sub(r"(?<=[.!?]) ", "\nshe: ", f"she: {line}") if words else ""
        if new := lines[len(self.shown) :]:
            print(new, end="", flush=True)
            self.line_is_open = True
        self.words = len(words)
        self.shown = lines

    def say(self, line: str) -> None:
        """A line of its own."""
        self.end_line()
        print(line, flush=True)

    def make_way(self, record: logging.LogRecord) -> bool:
        """The filter of a logger, whose lines are of their own, too."""
        self.end_line()
        return True

    def end_line(self) -> None:
        if self.line_is_open:
            print(flush=True)
        self.line_is_open = False

    def outcome(self, result: Message) -> str:
        """The last line. Error if the job was aborted."""
        status = take(result.values, "status", str)
        if status == "aborted":
            raise Error(f"the answer broke off: {take(result.values, 'text', str)}; ask again")
        left = ", and you walked away" if status == "canceled" else ""
        return f"done: {self.words} words{left}"
