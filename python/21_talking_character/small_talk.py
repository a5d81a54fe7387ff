"""Application 21, words without a model: a keeper of a bridge, who says the same to the same prompt and seed.

for step in small_talk(100, b"", "Who are you?", delay=0.05, seed=0): ...
"""

import time
from collections.abc import Iterator
from zlib import crc32

from netmq_example.work import Step

OPENINGS = ("Good evening, traveller.", "Mind the third plank!", "Ah, a voice in the fog.", "You again?")
TALES = (
    "Nobody has crossed this bridge since the mill burned down.",
    "I count the boats, and they are fewer every year.",
    "They say that the river was a road once, and the road a river.",
    "On the other side they speak of us in the same way.",
    "My father kept it before me, and his father built it.",
)
ENDINGS = ("The toll is a story.", "Come back before the moon is up.", "Will you cross, or will you talk?")


def reply(prompt: str, seed: int) -> str:
    # hash() is another one in each process.
    number = crc32(f"{seed} {prompt}".encode(errors="replace"))
    opening = OPENINGS[number % len(OPENINGS)]
    ending = ENDINGS[number % len(ENDINGS)]
    tales = [TALES[(number + i) % len(TALES)] for i in range(3)]
    return " ".join([opening, f'You say "{prompt}", as they all do.', *tales, ending])


def small_talk(count: int, finished: bytes, prompt: str, *, delay: float, seed: int) -> Iterator[Step]:
    """At most count words, one after the other. It cannot go on in the middle, so it has no checkpoint."""
    words = reply(prompt, seed).split()[:count]
    for done in range(1, len(words) + 1):
        time.sleep(delay)
        yield Step(done, len(words), " ".join(words[:done]))
