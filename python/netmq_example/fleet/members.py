"""Simulators as the hub sees them: which it takes, and the episodes that they play.

    accept(hello, build="1", hello_here=None)              NotTaken if this simulator is not like the others
    member = Member(1, "CartPole", send)                   send(frames) is False if the simulator is gone
    episode = Episode(reset, ready)                        a Part
    member.lease(episode)                                  it gets the reset, and all later requests in turn
    episode.ask(step)                                      ready() is called when there is an answer

A seed and the actions after it make an episode. The hub keeps both, and gives them to another simulator when the first
one dies, or is late: the trainer never notices. So an episode belongs to no simulator. That holds for simulators that
compute alike, which is why the hub takes those of one build only.
"""

import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

from netmq_example.fleet import pieces
from netmq_example.messages import Message, MessageError
from netmq_example.wire import trees
from netmq_example.wire.records import AUTORESET, ENDED, FORM, SIZES, Record

# The hub is never silent for so long. See Member.
SILENCE_SECONDS = 3.0
# A hello is kept, one of each name. The spaces of most have some hundred bytes.
LARGEST_HELLO_BYTES = 16 * 1024 * 1024
# In memory a request takes so many bytes besides its own.
REQUEST_BYTES = 500
MOST_AREAS = 1024
# Of agents, in letters: a trainer's hello has it once for each area.
LONGEST_NAME = 1000
# Where the id stands in a record.
ID = slice(8, 16)
# The answer to a request in words.
WORDS = {"render": "picture", "info": "told"}


@dataclass(slots=True, eq=False)
class Part:
    """One simulator's part of a request, as bytes: these are kept, and none of the others'.

    `rows` are the kinds that are asked, and how many of each; `begins` says that an episode does.
    """

    frame: bytes
    rows: Sequence[tuple[int, int]]
    begins: bool

    def frames(self, id: int) -> list[bytes]:
        return [b"".join((self.frame[: ID.start], id.to_bytes(8, "little"), self.frame[ID.stop :]))]


class Episode:
    """Of one area: its requests so far, the reset first, and the answer to the last one when there is one."""

    def __init__(self, reset: Part, ready: Callable[[], object]) -> None:
        self.requests: list[Any] = [reset]
        self.size = size_of(reset)
        self.ready = ready
        self.runs: list[Member] = []
        self.answer: Any = None
        # The values of its last step; None until there is one.
        self.seen: list[Any] | None = None
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
        self.answer = answer
        if isinstance(answer, Record):
            self.seen = values_in(answer)
        elif answer.kind != "told" and len(self.requests) > 1:
            # A picture, or a refusal: the world has not changed.
            self.size -= size_of(self.requests.pop())
            by.done -= 1
        self.ready()

    def anew(self, reset: Part) -> None:
        """All that was before is over: whoever has done it has done the reset."""
        self.requests = [reset]
        self.size = size_of(reset)
        for run in self.runs:
            run.done = 1

    def differs(self, done: int, answer: Any) -> bool:
        """Whether a simulator that plays it again, and has come to what was seen last, sees something else."""
        again = done + 2 == len(self.requests) and self.seen is not None
        return again and isinstance(answer, Record) and values_in(answer) != self.seen

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

    def __init__(self, number: int, name: str, send: Callable[[list[Any]], bool]) -> None:
        self.number = number
        self.name = name
        self.send = send
        self.episode: Episode | None = None
        # How many of its episode's requests it has done, and whether one is under way.
        self.done = 0
        self.busy = False
        # A hub that is silent for longer was started anew, and does not know its simulators any more, since ZeroMQ can
        # have connected again so quickly that nobody noticed. So a simulator says hello again then.
        self.id = 0
        self.asking: Any = Message("welcome", 0, {"silence": SILENCE_SECONDS})
        self.last = self.asking.frames()
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
            self.id += 1
            request = self.asking = self.episode.requests[self.done]
            if isinstance(request, Part):
                self.last = request.frames(self.id)
            else:
                self.last = Message(request.kind, self.id, request.values, request.arrays).frames()
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
        return self.busy and answer.id == self.id

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


def values_in(answer: Record) -> list[Any]:
    return [section.values for section in answer.sections if not section.columns & ENDED]


def size_of(request: Any) -> int:
    """The memory of a request or a hello, in bytes."""
    if isinstance(request, Part):
        return REQUEST_BYTES + len(request.frame)
    return REQUEST_BYTES + sum(memoryview(array.data).nbytes for array in request.arrays)


def kinds_in(hello: Message) -> list[dict[str, Any]]:
    tree = pieces.taken(hello.arrays[0].data) if hello.arrays else None
    kinds = tree.get("kinds") if isinstance(tree, dict) else None
    if not isinstance(kinds, list) or not all(isinstance(each, dict) and each.get("agents") for each in kinds):
        raise NotTaken("no-kinds", "a hello has one array, which says what kinds of agents there are")
    if any(len(pieces.text_in(each.get("name"))) > LONGEST_NAME for each in kinds):
        raise NotTaken("no-kinds", f"the name of an agent has at most {LONGEST_NAME} letters")
    return kinds


def offer(hello: Message, areas: int) -> Message:
    """The hello for a trainer: of several scenes with an agent each it is one scene with as many. Or MessageError."""
    if areas == 1:
        return Message("hello", 0, hello.values, hello.arrays)
    kinds = kinds_in(hello)
    agents = sum(len(kind["agents"]) for kind in kinds)
    if agents > 1:
        cure = "take FleetSocket(…, 1) for an environment of these agents, and several of both"
        raise MessageError("several-agents", f"a scene of {agents} agents is no row of {areas}: {cure}")
    names = [f"{kinds[0]['name']}_{number}" for number in range(areas)]
    tree = trees.write({"kinds": [{**kinds[0], "agents": names, "at_most": areas}]})
    return Message("hello", 0, hello.values, [trees.array_of(tree)])


def accept(hello: Message, build: str, hello_here: Message | None) -> None:
    """NotTaken unless it is of this build, and like those of its name that are here."""
    # A hello that no trainer could get fails now.
    offer(hello, 1).frames()
    if size_of(hello) > LARGEST_HELLO_BYTES:
        raise NotTaken("too-big", f"a hello of {size_of(hello)} bytes; the hub takes {LARGEST_HELLO_BYTES}")
    name, values = f"{hello.values['name']!a:.40}", hello.values
    if values.get("record") != 2:
        raise NotTaken("old-record", f"{name} speaks an older kit's record: update its kit, or the hub's")
    if values.get("clock") != "python":
        raise NotTaken("scenes-clock", f"{name} goes by its own clock, which no hub repeats: connect it to a trainer")
    kinds_in(hello)
    other = values.get("build", "1")
    if other != build:
        text = f"{name} of build {other!a:.20}, this hub takes {build!a:.20}"
        raise NotTaken("other-build", f"{text}: use one build everywhere")
    if hello_here and form(hello_here) != form(hello):
        raise NotTaken("other-spaces", f"{name} has another dt here, or other spaces")


def form(hello: Message) -> Any:
    """All simulators of one name must have the same dt and spaces."""
    return hello.values.get("dt"), [bytes(array.data) for array in hello.arrays]


def fits(answer: Any, request: Any) -> bool:
    """Whether it answers this request, be it by a refusal."""
    if not isinstance(answer, Record):
        return answer.kind == "error" or (not isinstance(request, Part) and answer.kind == WORDS.get(request.kind))
    if not isinstance(request, Part) or len(answer.sections) < len(request.rows):
        return False
    for section, rows in zip(answer.sections, request.rows, strict=False):
        if (section.kind, len(section.marks)) != rows or section.columns & ~(FORM | SIZES):
            return False
    ended = answer.sections[len(request.rows) :]
    return not ended or (bool(request.frame[1] & AUTORESET) and all(one.columns & ENDED for one in ended))
