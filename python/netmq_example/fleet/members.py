"""Simulators as the hub sees them: which it takes, and the episodes that they play.

    accept(hello, build="1", hello_here=None)              NotTaken if this simulator is not like the others
    member = Member(1, "CartPole", send)                   send(message) is False if the simulator is gone
    episode = Episode(reset, ready)                        a Record of one row
    member.lease(episode)                                  it gets the reset, and all later requests in turn
    episode.ask(step)                                      ready() is called when there is an answer

A seed and the actions after it make an episode. The hub keeps both, and gives them to another simulator when the first
one dies, or is late: the trainer never notices. So an episode belongs to no simulator. That holds for simulators that
compute alike, which is why the hub takes those of one build only.
"""

import copy
import time
from collections.abc import Callable
from typing import Any

from netmq_example.messages import LIMIT, Message, MessageError
from netmq_example.wire.records import Record

# The hub is never silent for so long. See Member.
SILENCE_SECONDS = 3.0
# A hello is kept, one of each name. The spaces of most have some hundred bytes.
LARGEST_HELLO_BYTES = 16 * 1024 * 1024
# In memory a request takes so many bytes besides those of its row.
REQUEST_BYTES = 500
MOST_AREAS = 1024


class Episode:
    """Of one area: its requests so far, the reset first, and the answer to the last one when there is one."""

    def __init__(self, reset: Record, ready: Callable[[], object], most: int = LIMIT) -> None:
        """An answer has at most so many bytes."""
        self.requests: list[Any] = [reset]
        self.size = size_of(reset)
        self.ready = ready
        self.most = most
        self.runs: list[Member] = []
        self.answer: Any = None
        self.seen = b""
        self.leased = False
        # How many simulators were lost in a row, each when it had done `lost_at` requests.
        self.lost = 0
        self.lost_at = 0
        # Of its last request, or of the loss of the simulator that was to answer it.
        self.since = time.monotonic()

    def ask(self, request: Any) -> None:
        self.requests.append(request)
        self.size += size_of(request)
        self.answer = None
        self.since = time.monotonic()
        for run in self.runs:
            run.go_on()

    def answered(self, by: "Member", answer: Any) -> None:
        """The first answer counts; another simulator that was asked is free again once it has answered too."""
        for run in self.runs:
            run.episode = self if run is by else None
        self.runs = [by]
        self.lost = 0
        if size_of(answer) > self.most + REQUEST_BYTES:
            text = f"an answer of {size_of(answer)} bytes is more than one area's part of a message, {self.most}"
            answer = Message.refusal(MessageError("too-big", text))
            # Its world has gone on, and nobody has seen it: the episode is over.
            self.seen = b""
        self.answer = answer
        if isinstance(answer, Record):
            self.seen = bytes(answer.rows[0])
        elif len(self.requests) > 1:
            # A picture, or a refusal: the world has not changed.
            self.size -= size_of(self.requests.pop())
            by.done -= 1
        self.ready()

    def differs(self, done: int, answer: Any) -> bool:
        """Whether a simulator that plays it again, and has come to what was seen last, sees something else."""
        again = done + 2 == len(self.requests)
        return again and isinstance(answer, Record) and answer.rows[0] != self.seen

    def lost_by(self, run: "Member") -> None:
        self.runs.remove(run)
        run.episode = None
        self.since = time.monotonic()
        # Simulators that die by chance do so anywhere, also while they play the episode again.
        self.lost = self.lost + 1 if run.done == self.lost_at else 1
        self.lost_at = run.done

    def release(self) -> None:
        for run in self.runs:
            run.episode = None
        self.runs = []


class Member:
    """A simulator of the fleet. One request at a time is under way, and an episode takes all of it."""

    def __init__(self, number: int, name: str, send: Callable[[Any], bool]) -> None:
        self.number = number
        self.name = name
        self.send = send
        self.episode: Episode | None = None
        # How many of its episode's requests it has done, and whether one is under way.
        self.done = 0
        self.busy = False
        # A hub that is silent for longer was started anew, and does not know its simulators any more, since ZeroMQ can
        # have connected again so quickly that nobody noticed. So a simulator says hello again then.
        self.last: Any = Message("welcome", 0, {"silence": SILENCE_SECONDS})
        self.heard = self.sent = self.asked = self.free_since = self.wanted = time.monotonic()
        self.there = send(self.last)

    def free(self) -> bool:
        return self.there and not self.episode and not self.busy

    def lease(self, episode: Episode) -> None:
        self.episode = episode
        self.done = 0
        episode.runs.append(self)
        episode.leased = True
        self.go_on()

    def go_on(self) -> None:
        """The next request of its episode. A new simulator does all of them again, one after the other."""
        if self.episode and not self.busy and self.done < len(self.episode.requests):
            number = self.last.id + 1
            self.last = copy.copy(self.episode.requests[self.done])
            self.last.id = number
            self.busy = True
            self.asked = time.monotonic()
            self.send_last()

    def send_last(self) -> None:
        """The last request, or welcome, perhaps once more."""
        self.sent = time.monotonic()
        self.there = self.send(self.last)

    def hears(self, answer: Any) -> bool:
        """Another id is one that came twice: it says no more than that the simulator is there."""
        self.heard = time.monotonic()
        return self.busy and answer.id == self.last.id

    def take(self, answer: Any) -> None:
        self.busy = False
        self.free_since = self.heard
        if self.episode:
            self.done += 1
            if self.done == len(self.episode.requests):
                self.episode.answered(self, answer)
            self.go_on()


class NotTaken(MessageError):
    """A simulator that the hub does not take; the hub reports it as well."""


def size_of(message: Any) -> int:
    """The memory of a request or an answer, in bytes."""
    if isinstance(message, Record):
        parts = [*message.rows, *message.infos, message.options, message.exchange or b""]
    else:
        parts = [memoryview(array.data).cast("B") for array in message.arrays]
    return REQUEST_BYTES + sum(map(len, parts))


def offer(hello: Message, areas: int) -> Message:
    """The hello for a trainer."""
    return Message("hello", 0, {**hello.values, "areas": areas}, hello.arrays)


def accept(hello: Message, build: str, hello_here: Message | None) -> None:
    """NotTaken unless it is of this build, and like those of its name that are here."""
    # A hello that no trainer could get fails now.
    offer(hello, MOST_AREAS).frames()
    if size_of(hello) > LARGEST_HELLO_BYTES:
        raise NotTaken("too-big", f"a hello of {size_of(hello)} bytes; the hub takes {LARGEST_HELLO_BYTES}")
    if not hello.arrays:
        raise NotTaken("no-spaces", "a hello has the arrays of its spaces")
    if "areas" in hello.values:
        raise NotTaken("areas-here", "a simulator of the hub is one world, and not many areas")
    name = hello.values["name"]
    other = hello.values.get("build", "1")
    if other != build:
        text = f"{name!a:.40} of build {other!a:.20}, this hub takes {build!a:.20}"
        raise NotTaken("other-build", f"{text}: use one build everywhere")
    if hello_here and form(hello_here) != form(hello):
        raise NotTaken("other-spaces", f"{name!a:.40} has another dt here, or other spaces")


def form(hello: Message) -> Any:
    """All simulators of one name must have the same dt and spaces."""
    return hello.values.get("dt"), [bytes(array.data) for array in hello.arrays]


def fits(answer: Any, request: Any) -> bool:
    """Whether it answers this request, be it by a refusal."""
    if isinstance(answer, Record):
        return isinstance(request, Record) and len(answer.flags) == 1
    picture = answer.kind == "picture" and len(answer.arrays) == 1
    return answer.kind == "error" or (picture and not isinstance(request, Record))
