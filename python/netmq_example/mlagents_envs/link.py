"""The simulator of a UnityEnvironment: found, asked, lost and found again, with ML-Agents' exceptions.

It needs pyzmq; and numpy, as its clocks do.
"""

import importlib
from collections.abc import Mapping
from typing import Any, NamedTuple

from netmq_example.envs.side_channels import StepCarrier
from netmq_example.envs.simulators import Simulators
from netmq_example.errors import Lost
from netmq_example.messages import Message, MessageError
from netmq_example.mlagents_envs.clock import Clock
from netmq_example.mlagents_envs.exception import (
    UnityActionException,
    UnityCommunicationException,
    UnityCommunicatorStoppedException,
    UnityEnvironmentException,
    UnityException,
    UnityTimeOutException,
    UnityWorkerInUseException,
)
from netmq_example.mlagents_envs.scene_clock import SceneClock
from netmq_example.mlagents_envs.side_channel.side_channel_manager import SideChannelManager
from netmq_example.mlagents_envs.specs import ActionTuple
from netmq_example.wire.records import Record


class Capabilities(NamedTuple):
    """With the names of ML-Agents' message: the kit has no analytics."""

    baseRLCapabilities: bool = True
    concatenatedPngObservations: bool = True
    compressedChannelMapping: bool = True
    hybridActions: bool = True
    trainingAnalytics: bool = False
    variableLengthObservation: bool = True
    multiAgentGroups: bool = True


class Link:
    """`where` is what Simulators takes, `words` are PythonClock's."""

    def __init__(
        self, manager: SideChannelManager, where: dict[str, Any], worker_id: int, words: dict[str, Any]
    ) -> None:
        self.manager = manager
        self.worker_id = worker_id
        self.words = words
        self.clock: Clock | None = None
        # A request that was interrupted, such as by Ctrl-C, and whether it was a reset.
        self.pending: tuple[Record, bool] | None = None
        self.launched = "launch" in where
        try:
            self.simulators = Simulators(**where)
        except (OSError, MessageError) as error:
            raise self.named(error, UnityEnvironmentException) from None
        if manager.channels:
            self.simulators.ask = StepCarrier(self.simulators.ask, manager).ask

    def start(self, owner: object) -> Clock:
        try:
            self.close = self.simulators.start(owner, self.accept)
        except (OSError, MessageError) as error:
            raise self.named(error, UnityEnvironmentException) from None
        assert self.clock
        return self.clock

    def accept(self, hello: Message) -> None:
        by_scene = hello.values.get("clock") == "scene"
        if self.clock is None:
            self.clock = self.clock_of(by_scene)
        if isinstance(self.clock, SceneClock) != by_scene:
            raise MessageError("other-clock", "the simulator before this one had another clock: start that one again")
        self.clock.connected(hello)
        self.pending = None

    def clock_of(self, by_scene: bool) -> Clock:
        if not by_scene:
            # By name: it needs gymnasium.
            made: Clock = importlib.import_module("netmq_example.mlagents_envs.python_clock").PythonClock(**self.words)
            return made
        if self.words["limit"] or self.words["given"] != (None, None):
            cure = "its agents have Max Step and spaces of their own in the scene"
            raise MessageError("scene-clock", f"max_episode_steps and spaces are for Python's clock: {cure}")
        return SceneClock(self.words["seed"], self.words["channels_first"])

    def reset(self, clock: Clock) -> None:
        def ask(_: Lost | None) -> Record:
            if self.pending:
                self.finish(clock)
            return self.asked(self.simulators.ask, clock.reset(), True)

        try:
            clock.read(self.simulators.begin(self.accept, ask), True)
        except (OSError, MessageError) as error:
            raise self.named(error) from None

    def step(self, clock: Clock, actions: Mapping[str, ActionTuple]) -> None:
        try:
            if self.pending:
                self.finish(clock)
            else:
                clock.read(self.ask_step(clock, actions), False)
        except (OSError, MessageError) as error:
            raise self.named(error) from None
        except ValueError as error:
            raise UnityActionException(str(error)) from None

    def ask_step(self, clock: Clock, actions: Mapping[str, ActionTuple]) -> Record:
        request = clock.step(actions)
        try:
            return self.asked(self.simulators.ask, request, False)
        except MessageError as error:
            near = clock.limited() if error.code == "not-in-space" else None
            if near is None:
                raise
        return self.asked(self.simulators.ask, near, False)

    def asked(self, ask: Any, request: Record, begins: bool) -> Record:
        try:
            answer: Record = ask(request)
        except (Lost, MessageError):
            raise
        except BaseException:
            # The simulator may have done it. It has kept the answer, and gives it when it is asked again.
            if request.id and not self.simulators.connection.closed:
                self.pending = request, begins
            raise
        return answer

    def finish(self, clock: Clock) -> None:
        """Ask once more what was interrupted, by the same id."""
        assert self.pending
        (request, begins), self.pending = self.pending, None
        self.simulators.connection.id = request.id - 1
        answer = self.asked(self.simulators.connection.ask, request, begins)
        if answer.exchange is not None:
            self.manager.take_in(answer.exchange)
        clock.read(answer, begins)

    def named(self, error: Exception, kind: type[UnityException] = UnityCommunicationException) -> Exception:
        """The same error by ML-Agents' name."""
        match error:
            case UnityException():
                return error
            case Lost():
                why = f"the simulator is lost: {error}; reset waits for another one"
                return UnityCommunicatorStoppedException(why)
            case TimeoutError():
                return UnityTimeOutException(str(error))
            case OSError() if not self.launched:
                return UnityWorkerInUseException(self.worker_id, str(error))
            case OSError():
                return UnityEnvironmentException(str(error))
        return kind(str(error))
