"""Lesson 17: strangers at the hub, who answer nonsense, take what is not theirs, or come by the thousand."""

import json

import pytest
import zmq

pytest.importorskip("numpy", reason="lesson 17 needs numpy: kit.py run 17 installs it")

from netmq_example.fleet.members import LONGEST_NAME
from netmq_example.messages import Array, Message
from netmq_example.wire.records import ANSWERS, NOTHING, RESET, STEP, Record, Section
from tests.lessons.fleets import STATE, Hall, asks, kind_of, kinds, state

PIXEL = Array("uint8", (1, 1, 3), bytes(3))
TRAINER = b"trainer"


@pytest.fixture
def hall(monkeypatch):
    """With a simulator, named 1, and a trainer that has it."""
    hall = Hall(monkeypatch)
    assert hall.simulator(b"1").last(b"1").values == {"silence": 3.0}
    assert hall.trainer() == "hello"
    return hall


PICTURE = Message("picture", 0, {}, [PIXEL])
NONSENSE = {
    "two states": ("step", state(b"", b"")),
    "another kind": ("step", Record(ANSWERS, 0, [Section(1, bytes(8), b"\0")])),
    "a picture for a reset": ("reset", PICTURE),
    "a kind of its own for a reset": ("reset", Message("fine")),
    "a state for a picture": ("render", STATE),
}
ASKED = {"step": asks(STEP), "render": Message("render")}


@pytest.mark.parametrize("what", NONSENSE)
def test_whoever_answers_nonsense_is_let_go_and_the_hub_stays(what, hall):
    asked, nonsense = NONSENSE[what]
    if asked == "reset":
        hall.say(TRAINER, asks(RESET), 1)
    else:
        hall.plays()
        hall.say(TRAINER, ASKED[asked], 2)
    hall.answer(b"1", nonsense, asked)
    assert hall.lines == ["simulator 1 is gone: its answer is not what it has announced"]
    hall.simulator(b"2").answer(b"2", STATE)
    if asked != "reset":
        hall.answer(b"2", PICTURE if asked == "render" else STATE, asked)
    assert kind_of(hall.last(TRAINER)) == ("picture" if asked == "render" else "state")


def test_a_request_that_overtakes_one_under_way_is_refused_and_nothing_else_changes(hall):
    hall.say(TRAINER, asks(RESET), 1)
    for id, overtaking in enumerate((Message("render"), Message("fly"), asks(STEP, STEP)), 2):
        assert hall.code(TRAINER, overtaking, id) == "one-at-a-time"
    hall.answer(b"1", STATE)
    assert hall.last(TRAINER).id == 1


def test_bytes_that_are_no_record_are_named_and_the_hub_stays(hall):
    for peer, first, code in (b"1", b"\4", "bad"), (TRAINER, b"\3", "bad"), (TRAINER, b"\1", "old"):
        hall.hub.take(peer, [first + b"\xff" * 40])
        assert hall.last(peer).values["code"] == f"{code}-record"
    # The hub of everybody would end of one frame of a stranger, whose id no error could name.
    assert hall.code(b"2", asks(RESET), 2**53) == "bad-record"
    assert kind_of(hall.plays()) == "state"


def test_simulators_of_one_name_have_the_same_spaces_as_long_as_one_is_here(hall):
    # Sent on, each of its letters becomes six.
    values = {"name": "é" * 20_000, "dt": 0.02}
    header = {"kind": "hello", "version": 1, "id": 0, "values": values, "arrays": [{"dtype": "uint8", "shape": [3]}]}
    hall.hub.take(b"2", [json.dumps(header, ensure_ascii=False).encode(), bytes(3)])
    assert hall.last(b"2").values["code"] == "too-big"
    for why, described, more in [
        ("bad-tree", PIXEL, {}),
        ("no-kinds", kinds("Pole", name="a" * (LONGEST_NAME + 1)), {}),
        ("no-kinds", kinds(), {}),
        ("old-record", kinds("Pole"), {"record": 1}),
        ("scenes-clock", kinds("Pole"), {"clock": "scene"}),
        ("other-build", kinds("Pole"), {"build": "2"}),
        ("other-spaces", kinds("Pole_0", "Pole_1"), {}),
    ]:
        assert hall.simulator(b"2", described, **more) == why
    assert hall.lines[-1] == "refused: other-spaces: 'Poles' has another dt here, or other spaces"
    # Nothing of them is kept once the hub has looked after that.
    hall.leave(b"1", TRAINER)
    hall.wait()
    assert not (hall.hub.members or hall.hub.trainers or hall.hub.hellos)
    assert hall.simulator(b"2", kinds("Pole_0", "Pole_1")) is hall


def test_a_trainer_that_was_not_admitted_gets_no_simulator(hall):
    assert hall.trainer(b"early", 2) == "alive"
    assert hall.code(b"early", asks(RESET, RESET), 1) == "unknown-peer"
    for areas in (0, 1025):
        join = Message("join", 0, {"name": "Poles", "areas": areas})
        assert hall.code(b"greedy", join) == "bad-areas"
    assert kind_of(hall.plays()) == "state"


def test_a_trainer_that_has_closed_or_died_leaves_its_simulators_to_the_next(hall):
    assert kind_of(hall.say(TRAINER, Message("close"), 1)) == "closed"
    assert hall.trainer(b"second") == "hello"
    hall.say(b"second", asks(RESET), 1)
    hall.leave(b"second")
    hall.answer(b"1", STATE)
    assert hall.trainer(b"third") == "hello"
    assert kind_of(hall.plays(b"third")) == "state"


def test_what_a_trainer_cannot_ask_is_named_and_it_may_go_on(hall):
    for number, (request, code) in enumerate(
        [
            (asks(STEP), "no-episode"),
            (asks(NOTHING), "no-episode"),
            (Message("render"), "no-episode"),
            (Message("jump"), "unknown-kind"),
            (Message("info"), "bad-info"),
            (PICTURE, "unknown-kind"),
        ],
        1,
    ):
        assert hall.code(TRAINER, request, number) == code
    first = hall.plays(id=20)
    # What is asked again is answered again, and done once.
    assert hall.say(TRAINER, asks(RESET), 20).frames() == first.frames()
    hall.say(TRAINER, asks(STEP), 21)
    assert kind_of(hall.last(b"1")) == "step"


def test_an_episode_waits_from_the_death_of_its_simulator_on(hall):
    hall.say(TRAINER, asks(RESET), 1)
    # It is asked again each half second: longer than the timeout for a simulator.
    hall.wait(40)
    assert {kind_of(each) for each in hall.said[b"1"][1:]} == {"reset"}
    hall.leave(b"1")
    hall.simulator(b"2").answer(b"2", STATE)
    assert kind_of(hall.last(TRAINER)) == "state"
    hall.leave(b"2")
    hall.say(TRAINER, asks(STEP), 2)
    hall.wait(31)
    why = "no simulator for an episode within 30 s: 0 are here, start more"
    assert hall.last(TRAINER).values == {"code": "no-simulator", "text": why}


def test_what_a_straggler_is_late_with_is_asked_for_elsewhere(hall):
    hall.say(TRAINER, asks(RESET), 1)
    hall.simulator(b"2").wait(6)
    hall.answer(b"2", STATE)
    assert kind_of(hall.last(TRAINER)) == "state" and hall.hub.count["asked elsewhere"] == 1
    # It is free again once it has answered, too, and the other one has the episode.
    hall.answer(b"1", STATE)
    hall.say(TRAINER, asks(STEP), 2)
    hall.answer(b"2", STATE, "step")
    hall.leave(b"2")
    hall.say(TRAINER, asks(STEP), 3)
    for kind in ("reset", "step", "step"):
        hall.answer(b"1", STATE, kind)
    assert kind_of(hall.last(TRAINER)) == "state"


def test_a_spare_simulator_is_not_sent_home_while_a_trainer_may_need_it(hall):
    hall.simulator(b"2")
    for _ in range(30):
        hall.wait()
        # Said once more each half second.
        assert kind_of(hall.last(b"2")) == "welcome"
        hall.say(b"2", Message("closed"))
    hall.leave(TRAINER)
    hall.wait(14)
    assert b"2" in hall.hub.members
    hall.wait(3)
    assert not hall.hub.members and kind_of(hall.last(b"2")) == "close"


def test_an_episode_that_ends_each_simulator_is_given_up(hall):
    hall.say(TRAINER, asks(RESET), 1)
    for number in range(1, 11):
        hall.answer(b"%d" % number, Message("state"))
        hall.simulator(b"%d" % (number + 1))
    hall.wait()
    where = "request 1 of an episode: see what they say"
    text = f"10 simulators, one after the other, were lost at {where}"
    assert hall.last(TRAINER).values == {"code": "no-simulator", "text": text}


def test_the_hub_was_away_or_stopped(hall):
    """Its trainers are told first what is missing, and its simulators are not sent home: all were asleep."""
    hall.say(b"early", Message("join", 0, {"name": "Poles", "areas": 2}))
    hall.now += 100
    hall.hub.tick()
    assert hall.last(b"early").values == {"simulators": 1, "taken": 1}
    assert hall.hub.members and kind_of(hall.last(b"1")) == "welcome"
    hall.wait(61)
    assert not hall.hub.members and hall.lines[-1] == "simulator 1 is gone: no answer for 60 s"


def test_a_message_that_a_full_pipe_does_not_take_is_sent_again(hall, monkeypatch):
    def full(frames, flags):
        raise zmq.ZMQError(zmq.EAGAIN)

    with monkeypatch.context() as patch:
        patch.setattr(hall, "send_multipart", full)
        hall.say(TRAINER, asks(RESET), 1)
    hall.wait()
    assert kind_of(hall.last(b"1")) == "reset"
