"""Lesson 17: strangers at the hub, who answer nonsense, take what is not theirs, or come by the thousand."""

import copy
import itertools
import json
import os
import time
from pathlib import Path

import pytest
import zmq

from netmq_example import messages
from netmq_example.fleet import pieces
from netmq_example.fleet.board import MOST_LINES, Board
from netmq_example.fleet.hub import Hub
from netmq_example.wire import records
from netmq_example.wire.records import ANSWERS, ASKS, NOTHING, SEEN, Record, Section, rewards
from tests.conftest import PYTHON
from tests.lessons.test_17_many_machines import KEY, Sent
from tests.programs import ROOT, Program

Array, Message = messages.Array, messages.Message


def asks(*orders):
    """A trainer with so many areas sends this."""
    values = bytes(8 * orders.count(records.STEP))
    return Record(ASKS, 0, [Section(0, bytes(8 * len(orders)), bytes(orders), values=values)])


def state(*rows):
    numbers, marks = rewards([1.0] * len(rows)), bytes([SEEN] * len(rows))
    return Record(ANSWERS, 0, [Section(0, numbers, marks, values=b"".join(rows))])


RESET, STEP = asks(records.RESET), asks(records.STEP)
STATE = state(bytes(4))
PIXEL = Array("uint8", (1, 1, 3), bytes(3))


def kinds(*agents):
    """The array in which a hello describes its kinds of agents. Their spaces the hub does not read."""
    names = list(map(pieces.text, agents))
    data = pieces.given({"kinds": [{"name": pieces.text("Pole"), "agents": names, "at_most": pieces.whole(1)}]})
    return Array("uint8", (len(data),), data)


ONE = kinds("Pole")
# A world of its own for each test: a hub brings together what has one name.
WORLDS = itertools.count()
SERVER = ROOT / "python" / KEY / "server.py"


class Peer:
    """It plays any part, frame by frame."""

    def __init__(self, socket, hub, world):
        self.socket, self.world, self.asked = socket, world, 0
        socket.connect(hub)

    def say(self, message, id=0):
        message = copy.copy(message)
        message.id = id
        self.socket.send_multipart(message.frames())

    def hear(self, *kinds):
        """The next message of one of these kinds; what the hub repeats is passed over."""
        end = time.monotonic() + 20
        while time.monotonic() < end and self.socket.poll(20_000):
            message = received(self.socket)
            if kind_of(message) in kinds and (message.id > self.asked or not message.id):
                self.asked = message.id
                return message
        raise AssertionError(f"heard none of {kinds}")

    def answer(self, request, answer):
        self.say(answer, request.id)

    def hello(self, described=ONE, *answers, **more):
        values = {"name": self.world, "dt": 0.02, "record": 2, "clock": "python", **more}
        self.say(Message("hello", 0, values, [described]))
        if answers:
            return self.hear(*answers)
        assert self.hear("welcome").values == {"silence": 3.0}
        return self

    def join(self, areas=1, wait=True):
        self.say(Message("join", 0, {"name": self.world, "areas": areas}))
        if wait:
            self.hear("hello")
        return self


def plays(trainer, simulator, id=1):
    """An episode of the trainer begins: its first state."""
    trainer.say(RESET, id)
    simulator.answer(simulator.hear("reset"), STATE)
    return trainer.hear("state")


def received(socket):
    frames = socket.recv_multipart()
    return records.read_frames(frames[0][0], frames)


def kind_of(message):
    if isinstance(message, Message):
        return message.kind
    if message.kind == ANSWERS:
        return "state"
    return "step" if message.has(records.STEP) else "reset"


def running(*words):
    hub = Program([PYTHON, SERVER, "--endpoint", "tcp://127.0.0.1:0", *words])
    try:
        yield hub
    finally:
        hub.kill()


@pytest.fixture(scope="module")
def hub():
    yield from running()


@pytest.fixture(scope="module")
def hasty():
    """One that does not wait long for anything."""
    yield from running("--timeout", "1", "--late", "0.3", "--idle", "0.3")


@pytest.fixture
def peer(context):
    """peer(hub): a new one, connected."""
    sockets, world = [], f"World {next(WORLDS)}"

    def one(hub):
        sockets.append(context.socket(zmq.DEALER))
        return Peer(sockets[-1], hub.endpoints()["endpoint"], world)

    yield one
    for each in sockets:
        each.close()


def picture(*arrays):
    return Message("picture", 0, {}, list(arrays))


NONSENSE = {
    "two states": ("step", state(b"", b"")),
    "another kind": ("step", Record(ANSWERS, 0, [Section(1, bytes(8), b"\0")])),
    "a picture for a reset": ("reset", picture(PIXEL)),
    "a kind of its own for a reset": ("reset", Message("fine")),
    "a state for a picture": ("render", STATE),
}
ASKED = {"step": STEP, "render": Message("render")}


@pytest.mark.parametrize("what", NONSENSE)
def test_whoever_answers_nonsense_is_let_go_and_the_hub_stays(what, hub, peer):
    asked, nonsense = NONSENSE[what]
    begin = len(hub.lines)
    liar, trainer = peer(hub).hello(), peer(hub).join()
    trainer.say(RESET, 1)
    if asked != "reset":
        liar.answer(liar.hear("reset"), STATE)
        trainer.hear("state")
        trainer.say(ASKED[asked], 2)
    liar.answer(liar.hear(asked), nonsense)
    hub.wait_for(r"^simulator \d+ is gone: its answer is not what it has announced$", start=begin)
    honest = peer(hub).hello()
    honest.answer(honest.hear("reset"), STATE)
    if asked != "reset":
        honest.answer(honest.hear(asked), picture(PIXEL) if asked == "render" else STATE)
    assert kind_of(trainer.hear("state", "picture", "error")) == ("picture" if asked == "render" else "state")


def test_a_request_that_overtakes_one_under_way_is_refused_and_nothing_else_changes(hub, peer):
    simulator, trainer = peer(hub).hello(), peer(hub).join()
    trainer.say(RESET, 1)
    reset = simulator.hear("reset")
    for id, overtaking in enumerate((Message("render"), Message("fly"), asks(records.STEP, records.STEP)), 2):
        trainer.say(overtaking, id)
        assert trainer.hear("error").values["code"] == "one-at-a-time"
    simulator.answer(reset, STATE)
    trainer.asked = 0
    assert trainer.hear("state").id == 1


def test_a_hello_that_would_grow_too_large_for_a_trainer_is_refused(hub, peer):
    """Sent on, each of its letters becomes six."""
    values = {"name": "é" * 20_000, "dt": 0.02}
    header = {"kind": "hello", "version": 1, "id": 0, "values": values, "arrays": [{"dtype": "uint8", "shape": [3]}]}
    simulator = peer(hub)
    simulator.socket.send_multipart([json.dumps(header, ensure_ascii=False).encode(), bytes(3)])
    assert simulator.hear("error").values["code"] == "too-big"


def test_bytes_that_are_no_record_are_named_and_the_hub_stays(hub, peer):
    simulator, trainer = peer(hub).hello(), peer(hub).join()
    for one, first in (simulator, b"\4"), (trainer, b"\3"), (trainer, b"\1"):
        one.socket.send(first + b"\xff" * 40)
        assert one.hear("error").values["code"] == ("old-record" if first == b"\1" else "bad-record")
    plays(trainer, simulator)


def test_an_id_that_no_error_could_name_is_refused(hub, peer):
    """The hub of everybody would end of one frame of a stranger."""
    stranger = peer(hub)
    stranger.say(RESET, 2**53)
    assert stranger.hear("error").values["code"] == "bad-record"


def test_simulators_of_one_name_have_the_same_spaces_as_long_as_one_is_here(hub, peer):
    stranger, begin = peer(hub), len(hub.lines)
    for described, more, why in [
        (PIXEL, {}, "bad-tree"),
        (ONE, {"record": 1}, "old-record"),
        (ONE, {"clock": "scene"}, "scenes-clock"),
        (ONE, {"build": "2"}, "other-build"),
    ]:
        assert stranger.hello(described, "welcome", "error", **more).values["code"] == why
    hub.wait_for(r"^refused: scenes-clock: .+ goes by its own clock, which no hub repeats: connect it ", start=begin)
    first, wider = peer(hub).hello(), kinds("Pole_0", "Pole_1")
    assert peer(hub).hello(wider, "error").values["code"] == "other-spaces"
    first.socket.close()
    hub.wait_for(r"^simulator \d+ is gone: its connection is$", start=begin)
    # Nothing of them is kept once the hub has looked after that.
    while peer(hub).hello(wider, "welcome", "error").kind == "error":
        time.sleep(0.05)


def test_a_trainer_that_was_not_admitted_gets_no_simulator(hub, peer):
    simulator, early = peer(hub).hello(), peer(hub).join(2, wait=False)
    early.say(asks(records.RESET, records.RESET), 1)
    assert early.hear("error").values["code"] == "unknown-peer"
    trainer = peer(hub).join()
    plays(trainer, simulator)


def test_a_trainer_that_has_closed_or_died_leaves_its_simulators_to_the_next(hub, peer):
    peer(hub).hello()
    first = peer(hub).join()
    first.say(Message("close"), 1)
    first.hear("closed")
    second = peer(hub).join()
    second.say(RESET, 1)
    second.socket.close()
    peer(hub).join()


WRONG_REQUESTS = [
    (STEP, "no-episode"),
    (asks(NOTHING), "no-episode"),
    (Message("render"), "no-episode"),
    (Message("jump"), "unknown-kind"),
    (Message("info"), "bad-info"),
    (picture(PIXEL), "unknown-kind"),
]


def test_what_a_trainer_cannot_ask_is_named_and_it_may_go_on(hub, peer):
    simulator, trainer = peer(hub).hello(), peer(hub).join()
    for number, (request, code) in enumerate(WRONG_REQUESTS, 1):
        trainer.say(request, number)
        assert trainer.hear("error").values["code"] == code, kind_of(request)
    plays(trainer, simulator, 20)
    for areas in (0, 1025):
        greedy = peer(hub).join(areas, wait=False)
        assert greedy.hear("error").values["code"] == "bad-areas"


def test_what_is_asked_again_is_answered_again_and_done_once(hub, peer):
    simulator, trainer = peer(hub).hello(), peer(hub).join()
    first = plays(trainer, simulator)
    trainer.asked = 0
    trainer.say(RESET, 1)
    assert trainer.hear("state").frames() == first.frames()
    trainer.say(STEP, 2)
    assert kind_of(simulator.hear("reset", "step")) == "step"


def test_an_episode_waits_from_the_death_of_its_simulator_on(hasty, peer):
    dying, trainer = peer(hasty).hello(), peer(hasty).join()
    trainer.say(RESET, 1)
    begin = len(hasty.lines)
    # It is asked again each half second: longer than the timeout for a simulator.
    for _ in range(4):
        assert kind_of(received(dying.socket)) in ("welcome", "reset")
    spare = peer(hasty)
    dying.socket.close()
    hasty.wait_for(r"^simulator \d+ is gone", start=begin)
    spare.hello()
    spare.answer(spare.hear("reset"), STATE)
    assert kind_of(trainer.hear("state", "error")) == "state"
    spare.socket.close()
    trainer.say(STEP, 2)
    why = "no simulator for an episode within 1 s: 0 are here, start more"
    assert trainer.hear("state", "error").values == {"code": "no-simulator", "text": why}


def test_what_a_straggler_is_late_with_is_asked_for_elsewhere(hasty, peer):
    straggler, trainer = peer(hasty).hello(), peer(hasty).join()
    trainer.say(RESET, 1)
    late = straggler.hear("reset")
    other = peer(hasty).hello()
    other.answer(other.hear("reset"), STATE)
    trainer.hear("state")
    # It is free again once it has answered, too, and the other one has the episode.
    straggler.answer(late, STATE)
    trainer.say(STEP, 2)
    other.answer(other.hear("step"), STATE)
    trainer.hear("state")
    hasty.wait_for(r"[1-9]\d* asked elsewhere$")
    other.socket.close()
    trainer.say(STEP, 3)
    for kind in ("reset", "step", "step"):
        straggler.answer(straggler.hear(kind), STATE)
    trainer.hear("state")


def test_a_spare_simulator_is_not_sent_home_while_a_trainer_may_need_it(hasty, peer):
    trainer, spare = peer(hasty).join(2, wait=False), peer(hasty).hello()
    assert trainer.hear("alive").values["taken"] == 0
    for _ in range(3):
        # Said once more each half second.
        spare.hear("welcome")
    trainer.socket.close()
    spare.hear("close")


def test_an_episode_that_ends_each_simulator_is_given_up(hub, peer):
    first, trainer = peer(hub).hello(), peer(hub).join()
    trainer.say(RESET, 1)
    for victim in [first, *(peer(hub).hello() for _ in range(9))]:
        victim.answer(victim.hear("reset"), Message("state"))
    error = trainer.hear("error")
    assert error.values == {
        "code": "no-simulator",
        "text": "10 simulators, one after the other, were lost at request 1 of an episode: see what they say",
    }


def test_a_simulator_that_goes_another_way_is_told_of(hub, peer):
    first, trainer = peer(hub).hello(), peer(hub).join()
    plays(trainer, first)
    first.socket.close()
    trainer.say(STEP, 2)
    begin, other = len(hub.lines), peer(hub).hello()
    other.answer(other.hear("reset"), state(b"abcd"))
    hub.wait_for(r"^simulator \d+ goes another way than the one before it: use one build everywhere$", start=begin)
    other.answer(other.hear("step"), STATE)
    trainer.hear("state")


@pytest.mark.skipif(not Path("/proc/self/fd").exists(), reason="counts what is open in /proc")
def test_simulators_that_join_and_leave_leave_nothing_behind(hub, peer):
    folder, counts = Path(f"/proc/{hub.process.pid}/fd"), []
    for times in (3, 30):
        for _ in range(times):
            begin, one = len(hub.lines), peer(hub).hello()
            one.socket.close()
        hub.wait_for(r"^simulator \d+ is gone: its connection is$", start=begin)
        counts.append(sum("socket" in os.readlink(file) for file in folder.iterdir()))
    assert counts[1] <= counts[0] + 5


# How it is shown


def test_the_board_says_what_has_changed_and_makes_no_flood_of_lines(caplog):
    caplog.set_level("INFO", "netmq_example")
    board, hub = Board(), Hub(Sent())
    for number in range(MOST_LINES + 7):
        board.report(f"line {number}")
        board.report(f"line {number}")
    assert caplog.messages == [f"line {number}" for number in range(MOST_LINES)]
    for changed in (False, True, False):
        hub.count["begun anew"] += changed
        caplog.clear()
        board.show(hub)
        assert not caplog.messages
        board.shown -= 1.1
        board.show(hub)
        said = "0 simulators, 0 free, 0 trainers, 0 at work, 0 episodes, 1 begun anew, 0 asked elsewhere"
        more, board.last_line = board.last_line and "7 lines more", ""
        assert caplog.messages == [line for line in (more, said * changed) if line]
