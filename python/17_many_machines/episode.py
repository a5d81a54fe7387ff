"""Lesson 17, an episode: what was asked of it so far, and so it belongs to no simulator.

A seed and the actions after it make an episode. The hub keeps both, and gives them to another simulator when the first
one dies, or is late: the trainer never notices. That holds for simulators that compute alike, which is why the hub
takes those of one version only.
"""

import sys
import time
from collections.abc import Callable
from pathlib import Path

# In its own lesson's folder; at home it lies beside this file.
sys.path.append(str(Path(__file__).resolve().parents[1] / "05_messages"))
from messages import Array, Message, MessageError

# An episode is kept, so that it can be done again, and so it must end.
LONGEST = 100_000


class Episode:
    """Of one area: its requests so far, the reset first, and the answer to the last one when there is one."""

    def __init__(self, reset: Message, ready: Callable[[], object]) -> None:
        self.requests, self.ready, self.runs = [reset], ready, list["Member"]()
        self.answer: Message | None = None
        # `lost`: how many simulators in a row, each when it had done `lost_at` requests.
        self.leased, self.lost, self.lost_at, self.seen = False, 0, 0, list[Array]()
        # Of its last request, or of the loss of who was to answer it.
        self.since = time.monotonic()

    def ask(self, request: Message) -> None:
        self.requests.append(request)
        self.answer, self.since = None, time.monotonic()
        for run in self.runs:
            run.go_on()

    def answered(self, by: "Member", answer: Message) -> None:
        """The first answer counts; whoever else was asked is free again once it has answered too."""
        for run in self.runs:
            run.episode = self if run is by else None
        self.runs, self.answer, self.lost = [by], answer, 0
        if answer.kind == "state":
            self.seen = answer.arrays
        elif len(self.requests) > 1:
            # A picture, or a refusal: the world has not changed.
            self.requests.pop()
            by.done -= 1
        self.ready()

    def differs(self, done: int, answer: Message) -> bool:
        """Whether who does it again, and has come to what was seen last, sees something else."""
        again = done + 2 == len(self.requests)
        return again and [bytes(array.data) for array in answer.arrays] != [bytes(array.data) for array in self.seen]

    def lost_by(self, run: "Member") -> None:
        self.runs.remove(run)
        run.episode, self.since = None, time.monotonic()
        # Simulators that die by chance do so anywhere, also while they do the episode again.
        self.lost, self.lost_at = self.lost + 1 if run.done == self.lost_at else 1, run.done

    def release(self) -> None:
        for run in self.runs:
            run.episode = None
        self.runs = []


class Member:
    """A simulator of the fleet. One request at a time is under way, and an episode takes all of it."""

    def __init__(self, number: int, name: str, send: Callable[[Message], bool]) -> None:
        self.number, self.name, self.send = number, name, send
        self.episode: Episode | None = None
        # How many of its episode's requests it has done, and whether one is under way. The hub is never silent for
        # three seconds: one that is was started anew, and knows nothing of who was there before, since ZeroMQ can have
        # connected again so quickly that nobody noticed. So a simulator says hello again then.
        self.done, self.busy, self.last = 0, False, Message("welcome", 0, {"silence": 3.0})
        self.heard = self.told = self.asked = self.free_since = self.wanted = time.monotonic()
        self.there = send(self.last)

    def free(self) -> bool:
        return self.there and not self.episode and not self.busy

    def lease(self, episode: Episode) -> None:
        self.episode, self.done = episode, 0
        episode.runs.append(self)
        episode.leased = True
        self.go_on()

    def go_on(self) -> None:
        """The next request of its episode. A new simulator does all of them again, one after the other."""
        if self.episode and not self.busy and self.done < len(self.episode.requests):
            request = self.episode.requests[self.done]
            self.last = Message(request.kind, self.last.id + 1, request.values, request.arrays)
            self.busy, self.asked = True, time.monotonic()
            self.tell()

    def silence(self) -> float:
        return time.monotonic() - self.heard

    def tell(self) -> None:
        """The last request, or welcome, perhaps once more."""
        self.told, self.there = time.monotonic(), self.send(self.last)

    def hears(self, answer: Message) -> bool:
        """Another id is one that came twice: it says no more than that the simulator is there."""
        self.heard = time.monotonic()
        return self.busy and answer.id == self.last.id

    def take(self, answer: Message) -> None:
        self.busy, self.free_since = False, self.heard
        if self.episode:
            self.done += 1
            if self.done == len(self.episode.requests):
                self.episode.answered(self, answer)
            self.go_on()


def check(episodes: list[Episode | None], parts: dict[int, Message]) -> None:
    """Before anything is begun: half a step would be none."""
    for area, episode in enumerate(episodes):
        part = parts.get(area)
        if not episode and (not part or part.kind != "reset"):
            raise MessageError("no-episode", f"area {area} was never reset")
        if episode and part and part.kind == "step" and len(episode.requests) > LONGEST:
            raise MessageError("too-long", f"an episode has at most {LONGEST} steps: set max_episode_steps")
