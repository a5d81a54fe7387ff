"""A simulator does what an environment asks for, each request once; this one does it in a scene.

    simulator = SceneSimulator(Scene("Ball", [Ball("ball")], dt=0.02))
    EnvironmentClient("tcp://127.0.0.1:5559", timeout=30).run(simulator)

It says `hello` with the scene's kinds of agents and their spaces; then it answers resets and steps (wire/records.py),
`render` and `info`. A step is, in this order:

    on_action of those that step, after all actions were looked at
    for `period` ticks on_tick of those that are not over, and then of the scene
    on_stepped of those that stepped, and then of the scene; who has ended is observed a last time
    on_reset of those that are to begin: first of the scene if all of them do
    observe of all that were asked

A request that comes again, because its answer was late or lost, gets the answer that was kept. In C# they are
SimulatorBase.cs and SceneSimulator.cs.
"""

import logging
import time
from abc import ABC, abstractmethod
from collections.abc import Callable
from typing import Any

import numpy as np

from netmq_example import arguments, check
from netmq_example.messages import Array, Message, MessageError
from netmq_example.scene.exchange import Exchange
from netmq_example.scene.real_time import RealTime
from netmq_example.scene.roster import Roster
from netmq_example.scene.scene import Scene
from netmq_example.scene.steps import Asked
from netmq_example.wire import trees
from netmq_example.wire.records import ANSWERS, REAL_TIME, SCENE_CLOCK, Record
from netmq_example.wire.spaces import exactly

log = logging.getLogger("netmq_example.envs")


class SimulatorBase(ABC):
    """Answers requests. The last answer is kept, and a request that comes again gets it again."""

    def __init__(self, name: str) -> None:
        self.name = arguments.text("name", name)
        self.episodes = 0
        self.steps = 0
        self.id = 0
        self.kept: list[Any] = []

    def hello(self) -> Message:
        """The hello, which tells an environment the spaces. Ids of requests start again."""
        self.id = 0
        hello = self.describe()
        self.kept = hello.frames()
        return hello

    def answer(self, request: Any) -> list[Any]:
        """The frames of the answer to a new id, or else of the last answer. A mistake is sent as an error."""
        if request.id > self.id:
            try:
                answer = self.do(request) if isinstance(request, Record) else self.say(request)
                self.kept = answer.frames()
            except Exception as error:
                if not isinstance(error, MessageError):
                    # A mistake in the simulation, whose author wants to see where it is.
                    log.error("a mistake in the simulation", exc_info=error)
                    error = MessageError("error-in-simulation", repr(error)[:200])
                self.kept = Message.refusal(error, request.id).frames()
            self.id = request.id
        return self.kept

    @abstractmethod
    def describe(self) -> Message:
        """A hello: name, dt and kinds of agents."""

    @abstractmethod
    def do(self, request: Record) -> Record:
        """Reset or step, and say what is seen then."""

    @abstractmethod
    def say(self, request: Message) -> Message:
        """Answer what is asked in words, such as render."""


class SimulatorDecorator(SimulatorBase):
    """Around any simulator: a class of its own changes the hello, or the resets and steps."""

    def __init__(self, simulator: SimulatorBase) -> None:
        super().__init__(check.instance("simulator", simulator, SimulatorBase).name)
        self.simulator = simulator

    def describe(self) -> Message:
        return self.simulator.describe()

    def say(self, request: Message) -> Message:
        return self.simulator.say(request)

    def do(self, request: Record) -> Record:
        state = self.simulator.do(request)
        self.episodes = self.simulator.episodes
        self.steps = self.simulator.steps
        return state


class SceneSimulator(SimulatorBase):
    """For a scene. ValueError says which agents cannot be in one; `clock` is that of real time."""

    def __init__(self, scene: Scene, clock: Callable[[], float] = time.monotonic) -> None:
        self.scene = check.instance("scene", scene, Scene)
        super().__init__(scene.name)
        self.roster = Roster(scene)
        self.real_time = RealTime(scene.dt, arguments.function("clock", clock))
        # The last seed of agent 0, for those that come later; and whether the idle ones were named.
        self.seed = 0
        self.warned = False

    def describe(self) -> Message:
        self.roster = Roster(self.scene, self.roster)
        self.warned = False
        self.real_time.switched(False)
        data = trees.write({"kinds": [kind.described() for kind in self.roster]})
        values = {"name": self.name, "dt": self.scene.dt, "record": 2, "clock": "python", "channels": False}
        return Message("hello", 0, values, [trees.array_of(data)])

    def do(self, request: Record) -> Record:
        if request.bits & SCENE_CLOCK:
            raise MessageError("wrong-clock", "this simulator goes by Python's clock, and not by the scene's")
        self.roster.sync()
        exchange = Exchange(self.scene, self.roster, request, self.seed)
        self.warn(exchange.asked)
        if self.real_time.switched(bool(request.bits & REAL_TIME)):
            self.steps += self.real_time.step(exchange)
        elif exchange.acting:
            self.steps += exchange.step()
        exchange.end()
        self.episodes += exchange.begin()
        self.seed = exchange.seed
        sections = exchange.sections()
        infos = self.scene.infos.take()
        return Record(ANSWERS, request.id, sections, said=trees.write(infos) if infos else b"")

    def warn(self, asked: list[Asked]) -> None:
        if not self.warned and len(asked) < len(self.roster.kinds):
            self.warned = True
            kinds = [one.kind for one in asked]
            idle = ", ".join(kind.name for kind in self.roster if kind not in kinds)
            log.warning("nobody asks for %s: they stand still", idle)

    def say(self, request: Message) -> Message:
        self.roster.sync()
        if request.kind == "render":
            return self.picture(request)
        if request.kind != "info":
            raise MessageError("unknown-kind", f"kind {request.kind!a:.40} is none of reset, step, info, render, close")
        to, info = info_of(request)
        (self.roster.find(to) if to else self.scene).on_info(info)
        return Message("told", request.id)

    def picture(self, request: Message) -> Message:
        whole = self.scene.render()
        pictures = [whole]
        if whole is None:
            # One of each row: whoever is away, or draws nothing, is black.
            each = [agent.render() if agent else None for kind in self.roster for agent in kind.present]
            drawn = next((picture for picture in each if picture is not None), None)
            if drawn is None:
                cure = "write a render of the scene or its agents"
                raise MessageError("no-picture", f"{self.name} draws no pictures: {cure}")
            pictures = [np.zeros_like(drawn) if picture is None else picture for picture in each]
        try:
            arrays = [exactly(picture, np.dtype(np.uint8)) for picture in pictures]
        except (ArithmeticError, TypeError) as error:
            raise MessageError("bad-picture", f"a picture is uint8 [height, width, 3]: {error!s:.100}") from None
        return Message("picture", request.id, {}, [Array("uint8", one.shape, one.tobytes()) for one in arrays])


def info_of(request: Message) -> tuple[str, Any]:
    """An info: the agent that it is for, or "" for the scene, and its value."""
    pair = trees.read(request.arrays[0].data) if len(request.arrays) == 1 else None
    if type(pair) is not list or len(pair) != 2 or not isinstance(pair[0], str):
        raise MessageError("bad-info", f"{pair!a:.40} is no name with an info")
    return pair[0], pair[1]
