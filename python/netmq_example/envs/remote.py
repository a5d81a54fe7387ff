"""A scene as an environment sees it: its simulator, its agents, and the orders to them.

    remote = Remote("Ball", use, None, launch=…)                use(scene) looks at its agents, or raises ValueError
    remote.simulators.start(owner, remote.accept)
    answer = remote.begin(lambda lost: [section], options)      resets, in another simulator if one is lost
    answer = remote.ask([section])                              steps; Lost

All environments of this package ask by it. It needs gymnasium and numpy.
"""

import contextlib
import importlib
import os
import time
from collections.abc import Callable
from typing import Any

import numpy as np

from netmq_example import arguments, check
from netmq_example.envs.common import LONGEST_OPTIONS, checked_options
from netmq_example.envs.kinds import SceneHello, named, read_hello, same_scene
from netmq_example.envs.simulators import Simulators
from netmq_example.errors import Lost
from netmq_example.messages import EXACT, Message, MessageError
from netmq_example.wire import trees
from netmq_example.wire.records import ASKS, REAL_TIME, Record, Section
from netmq_example.wire.spaces import write_dict

# Bytes of an info.
LONGEST_INFO = 12_000
GONE = "it has left the scene"
# These names are the environment's own.
OWN = frozenset(("lost", "final_obs", "final_info", "final_observation"))
# Under this name is a mask, as Gymnasium's sample takes it: int8, or a tuple of several.
MASK = "action_mask"

Sections = Callable[[Lost | None], list[Section]]


class Remote:
    """`where` is what Simulators takes; `file_name` is gymize's name for its `launch`."""

    def __init__(
        self,
        env_name: str,
        use: Callable[[SceneHello], object],
        file_name: str | os.PathLike[str] | None,
        real_time: bool = False,
        **where: Any,
    ) -> None:
        self.name = arguments.text("env_name", env_name)
        self.use = use
        self.scene: SceneHello | None = None
        # Whether a request was left half way; seconds of a step, and in real time when the next one is due.
        self.interrupted = False
        self.dt = 0.0
        self.next = 0.0
        self.bits = REAL_TIME if check.instance("real_time", real_time, bool) else 0
        if file_name is not None:
            where = {"launch": arguments.path("file_name", file_name), **where}
        self.simulators = Simulators(**where)
        # Of a scene by its own clock.
        self.decisions: Any = None
        if real_time and self.simulators.fleet:
            raise ValueError("real_time takes one simulator: those of a fleet are asked anew, and so have no clock")

    def accept(self, hello: Message) -> Callable[[], None] | None:
        """Take a simulator; MessageError says why it is refused. A scene by its own clock is asked for its agents."""
        if hello.values.get("clock") == "scene" and (self.decisions or not self.scene):
            named(hello, self.name)
            self.decisions = self.decisions or decisions_of(self.simulators)
            return lambda: self.take(self.decisions.begin(hello))
        if self.decisions:
            raise MessageError("other-clock", "the simulator before this one had the scene's clock: start that again")
        self.take(read_hello(hello, self.name))
        return None

    def take(self, scene: SceneHello) -> None:
        scene = same_scene(scene, self.scene)
        try:
            self.use(scene)
        except MessageError:
            raise
        except ValueError as error:
            raise MessageError("wrong-scene", str(error)) from None
        self.scene = scene
        self.dt = scene.dt * max(kind.period for kind in scene.kinds)

    def ask(self, sections: list[Section], said: bytes = b"", bits: int = 0) -> Record:
        try:
            answer: Record = self.simulators.ask(Record(ASKS, 0, sections, self.bits | bits, said))
        except (Lost, MessageError):
            raise
        except BaseException:
            # A Ctrl-C, as a rule: the simulator may have done it, and its answer is read by nobody.
            self.interrupted = not self.simulators.connection.closed
            raise
        return answer

    def wait_for_tick(self) -> None:
        """In real time there is a step for each tick."""
        if self.bits:
            time.sleep(max(0.0, self.next - time.monotonic()))
            self.next = time.monotonic() + self.dt

    def begin(self, sections: Sections, options: dict[str, Any] | None, bits: int = 0) -> Record:
        """The answer of the simulator, or of the next one: `sections` gets the error that was raised before."""
        said = options_as_bytes(options)
        begun: Record = self.simulators.begin(self.accept, lambda lost: self.ask(sections(lost), said, bits))
        self.interrupted = False
        self.next = time.monotonic() + self.dt
        return begun

    def send_info(self, info: Any, agent: str) -> None:
        """To an agent's OnInfo; to "", the scene's."""
        if agent and self.scene:
            self.scene.kind_of(agent)
        try:
            data = trees.write([agent, info])
        except MessageError as error:
            raise ValueError(f"the info cannot be sent: {error}") from None
        if len(data) > LONGEST_INFO:
            raise ValueError(f"an info has at most {LONGEST_INFO} bytes, not {len(data)}")
        self.simulators.ask(Message("info", 0, {}, [trees.array_of(data)]))

    def pictures(self) -> list[Any]:
        """Those that the scene draws itself: one of all, or one of each agent. MessageError: it draws none."""
        arrays = self.simulators.ask(Message("render")).arrays
        if len(arrays) not in (1, len(self.scene.agents) if self.scene else 1):
            raise MessageError("bad-picture", f"{len(arrays)} pictures are neither one of all nor one of each agent")
        for array in arrays:
            if array.dtype != "uint8" or array.shape[2:] != (3,):
                raise MessageError("bad-picture", f"{array.dtype} {array.shape!s:.60} is not uint8 [height, width, 3]")
        return [array.numpy().copy() for array in arrays]


def decisions_of(simulators: Simulators) -> Any:
    """By name: a copy of a lesson goes without."""
    try:
        return importlib.import_module("netmq_example.envs.decisions").Decisions(simulators)
    except ModuleNotFoundError as error:
        why = f"a scene that steps by its own clock needs {error.name}, which this copy lacks"
        raise MessageError("scene-clock", why) from None


def options_as_bytes(options: Any) -> bytes:
    """The options that reset sends. ValueError names a value that no simulator could read."""
    options = checked_options(options)
    try:
        data = write_dict(options, "option") if options else b""
    except MessageError as error:
        raise ValueError(error.text) from None
    if len(data) > LONGEST_OPTIONS:
        raise ValueError(f"options of {len(data)} bytes cannot be sent: at most {LONGEST_OPTIONS}")
    return data


def is_seed(seed: Any) -> bool:
    return isinstance(seed, int | np.integer) and not isinstance(seed, bool) and bool(0 <= seed < EXACT)


def checked_seed(seed: Any) -> int | None:
    if seed is None or is_seed(seed):
        return None if seed is None else int(seed)
    raise ValueError(f"a seed is a whole number from 0 to 2**53 - 1, not {seed!r:.40}")


@contextlib.contextmanager
def refused_reset(env: Any) -> Any:
    """A step after a refused reset would step half a world."""
    try:
        yield
    except MessageError:
        env.begun = False
        raise


def info_in(data: Any) -> dict[str, Any]:
    info = trees.read(data) if len(data) else {}
    if type(info) is not dict:
        raise MessageError("bad-info", f"an info is a dict, not {info!a:.40}")
    if not OWN.isdisjoint(info):
        raise MessageError("bad-info", f"these names are the environment's own: {', '.join(sorted(OWN & info.keys()))}")
    if MASK in info:
        info[MASK] = mask_of(info[MASK])
    return info


def mask_of(value: Any) -> Any:
    if isinstance(value, list) and any(isinstance(part, list | np.ndarray) for part in value):
        return tuple(map(mask_of, value))
    mask = np.asarray(value)
    return mask.astype(np.int8) if mask.dtype.kind in "biuf" else value


def scene_infos(said: Any) -> list[Any]:
    infos = trees.read(said) if len(said) else []
    if type(infos) is not list:
        raise MessageError("bad-info", f"the infos of a scene are a list, not {infos!a:.40}")
    return infos
