"""Lesson 17's hub without a network, for tests: who says what, what is said to them, and how time passes."""

import copy
import types
from collections import defaultdict

import zmq

from netmq_example.fleet import hub, members, trainers
from netmq_example.messages import Array, Message
from netmq_example.wire import records, trees
from netmq_example.wire.records import ANSWERS, ASKS, RESET, SEEN, STEP, Record, Section
from netmq_example.wire.sections import rewards


def asks(*orders, size=8, id=0):
    """A trainer with so many areas sends this."""
    values = bytes(size * orders.count(STEP))
    return Record(ASKS, id, [Section(0, bytes(8 * len(orders)), bytes(orders), values=values)])


def state(*rows):
    numbers, marks = rewards([1.0] * len(rows)), bytes([SEEN] * len(rows))
    return Record(ANSWERS, 0, [Section(0, numbers, marks, values=b"".join(rows))])


def kinds(*agents, name="Pole", space=""):
    """The array in which a hello describes its kinds of agents. Their spaces the hub does not read."""
    data = trees.write({"kinds": [{"name": name, "agents": [*agents], "observation": space}]})
    return Array("uint8", (len(data),), data)


ONE, STATE = kinds("Pole"), state(bytes(4))
HELLO = {"name": "Poles", "dt": 0.02, "record": 2, "clock": "python"}


def kind_of(message):
    if isinstance(message, Message):
        return message.kind
    return "state" if message.kind == ANSWERS else "step" if message.has(STEP) else "reset"


class Hall:
    """`said` are the messages that the hub has sent, by peer; `lines` is what it reports."""

    def __init__(self, monkeypatch, **words):
        self.said, self.lines, self.gone, self.now = defaultdict(list), [], set(), 1000.0
        clock = types.SimpleNamespace(monotonic=lambda: self.now)
        for module in (hub, members, trainers):
            monkeypatch.setattr(module, "time", clock)
        self.hub = hub.Hub(self, report=self.lines.append, **words)

    def send_multipart(self, frames, flags=0):
        peer, *message = frames
        if peer in self.gone:
            raise zmq.ZMQError(zmq.EHOSTUNREACH)
        self.said[peer].append(records.read_frames(message[0][0], message))

    def wait(self, seconds=0.6):
        """Never so long at once that the hub takes itself for asleep."""
        while seconds > 0:
            self.now += min(0.6, seconds)
            seconds -= 0.6
            self.hub.tick()

    def leave(self, *peers):
        self.gone.update(peers)
        self.wait()

    def say(self, peer, message, id=0):
        """The hub's words to it then."""
        self.said.pop(peer, None)
        message = copy.copy(message)
        message.id = id
        self.hub.take(peer, message.frames())
        return self.last(peer)

    def last(self, peer):
        return self.said[peer][-1] if self.said[peer] else None

    def code(self, peer, message, id=0):
        """Of the error with which that is refused."""
        answer = self.say(peer, message, id)
        return answer.values["code"] if isinstance(answer, Message) and answer.kind == "error" else None

    def answer(self, peer, answer, kind="reset"):
        """To the last request, which is of this kind."""
        request = self.last(peer)
        assert kind_of(request) == kind
        self.say(peer, answer, request.id)

    def simulator(self, peer, described=ONE, **more):
        answer = self.say(peer, Message("hello", 0, {**HELLO, **more}, [described]))
        return answer.values["code"] if answer.kind == "error" else self

    def trainer(self, peer=b"trainer", areas=1, **more):
        self.say(peer, Message("join", 0, {"name": "Poles", "areas": areas, **more}))
        self.wait()
        return kind_of(self.last(peer))

    def plays(self, peer=b"trainer", simulator=b"1", id=1):
        """An episode of the trainer begins: its first state."""
        self.say(peer, asks(RESET), id)
        self.answer(simulator, STATE)
        return self.last(peer)
