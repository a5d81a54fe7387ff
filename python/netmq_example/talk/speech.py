"""Application 21, what a character has said so far: the C# version is Speech.cs.

speech = Speech()
for news in client.watch(client.goal("talk", 200, "Who are you?")):
    speech.hear(news)                                                 she: Good evening, trav
                                                                      she: Good evening, traveller.
speech.say(speech.outcome(news))                                      done: 3 words
"""

import re

from netmq_example.messages import Message, take


class Speech:
    """Of a newer text only the end is new, however many were lost in between."""

    words, shown = 0, ""

    def hear(self, news: Message) -> None:
        """Prints what is new of it: a line for each sentence, which grows."""
        # At another end the text says why there is no more.
        if news.kind == "feedback" or news.values.get("status") == "succeeded":
            words = take(news.values, "text", str).split()
            line = "".join(c if c.isprintable() else "?" for c in " ".join(words))
            lines = re.sub(r"(?<=[.!?]) ", "\nshe: ", f"she: {line}") if words else ""
            print(lines[len(self.shown) :], end="", flush=True)
            self.words, self.shown = len(words), lines

    def say(self, line: str) -> None:
        """A line of its own."""
        print(f"\n{line}" if self.shown else line, flush=True)

    def outcome(self, result: Message) -> str:
        """What to say at the end. TimeoutError if it was aborted."""
        status = take(result.values, "status", str)
        if status == "aborted":
            raise TimeoutError(f"the answer broke off: {take(result.values, 'text', str)}; ask again")
        return f"done: {self.words} words{', and you walked away' if status == 'canceled' else ''}"
