"""The environments of this package share how they are copied, what they send, and what they refuse."""

from collections.abc import Mapping
from typing import Any, Self

import numpy as np
from gymnasium import logger
from gymnasium.spaces import Space

from netmq_example.messages import Array, Message, MessageError, take
from netmq_example.wire import trees
from netmq_example.wire.spaces import space_of, write_dict

# At most of a dict that a reset takes, in bytes; a state of a million numbers fits.
LONGEST_OPTIONS = 16 * 1024 * 1024
# gymize's words, each with what is written today.
GYMIZES = {
    "agent_names": "several agents are the keys of observation_spaces, and a single one is agent_name",
    "update_seconds": "leave it out",
    "reward_range": "leave it out",
}


class OtherSide:
    """The words for it in what an environment reports. A socket that leads to more than one simulator has its own."""

    # While an environment waits, and once it has waited in vain.
    how_to_start = ": press Play"
    state = "is it running?"
    gone = "the simulator is gone"


class MadeAnew:
    """A copy, or what comes out of a pickle, is an environment of its own, made of the same words.

    Libraries copy environments: SuperSuit and RLlib make several of one. A copy launches a simulator of its own.
    """

    words: tuple[tuple[Any, ...], dict[str, Any]] = ((), {})

    def __new__(cls, *args: Any, **kwargs: Any) -> Self:
        made = super().__new__(cls)
        made.words = (args, kwargs)
        return made

    def __reduce__(self) -> Any:
        args, kwargs = self.words
        if kwargs.get("socket") is not None:
            raise TypeError(f"{type(self).__name__} has a socket that it was given: no second one can have it as well")
        # gymnasium.make has written down there how it was made.
        spec = vars(self).get("spec")
        return make, (type(self), args, kwargs), {"spec": spec} if spec else None


def make(kind: Any, args: tuple[Any, ...], kwargs: dict[str, Any]) -> Any:
    return kind(*args, **kwargs)


def hello_from(hello: Message, name: str) -> dict[str, Any]:
    """The spaces that a simulator of this name describes; MessageError says why its hello is refused."""
    found = take(hello.values, "name", str)
    if found != name:
        raise MessageError("wrong-name", f"this environment is {name}, the simulator's is {found!a:.40}")
    take(hello.values, "dt", float)
    if len(hello.arrays) != 1:
        raise MessageError("no-spaces", f"a hello of {name} has one array, which describes its spaces")
    spaces = trees.read(hello.arrays[0].data)
    if type(spaces) is not dict:
        raise MessageError("no-spaces", "what describes the spaces is no dict")
    return spaces


def same(spaces: Any, before: Any) -> Any:
    """A trainer has asked for the spaces already: another simulator must have the same ones.

    They are the same objects for ever, because whoever draws actions by chance has seeded them.
    """
    if before and spaces != before:
        raise MessageError("other-spaces", f"the simulator before this one had {before!s:.200}, not {spaces!s:.200}")
    return before or spaces


def observation_and_action(described: Any) -> list[Space[Any]]:
    if type(described) is dict and described.keys() <= {"agents"}:
        # Lesson 10's simulator lists them; to lesson 11's Python says what spaces they have.
        cure = "take ZmqParallelEnv for lesson 10's, NetMQExample/Unity-v0 for lesson 11's"
        raise MessageError("several-agents", f"this simulator is one of agents: {cure}")
    return [space_of(take(described, which, list)) for which in ("observation", "action")]


def frames_per_second(hello: Message) -> int:
    """As many steps as there are in a second of the world's own time, or one: no film has fewer pictures."""
    dt: float = take(hello.values, "dt", float)
    return max(1, round(1 / max(1e-3, dt)))


def no_others(words: dict[str, object]) -> None:
    """An environment takes no words but its own."""
    known = "where its simulator is, say endpoint, launch, wait, timeout and socket"
    cures = dict.fromkeys(GYMIZES.get(word, known) for word in words)
    if cures:
        raise TypeError(f"an environment takes no {', '.join(words)}; {'; '.join(cures)}")


def options_as_bytes(options: Any, **others: Any) -> bytes:
    """The options that reset sends, beside these others. ValueError names a value that no simulator could read."""
    options = checked_options(options)
    try:
        data = write_dict({**options, **others}, "option") if options or others else b""
    except MessageError as error:
        raise ValueError(error.text) from None
    if len(data) > LONGEST_OPTIONS:
        raise ValueError(f"options of {len(data)} bytes cannot be sent: at most {LONGEST_OPTIONS}")
    return data


def checked_options(options: Any) -> dict[str, Any]:
    options = {} if options is None else options
    if not isinstance(options, Mapping) or "seed" in options:
        raise ValueError(f"options must be a dict, without seed, which is reset's own: {options!r:.80}")
    return dict(options)


def info_in(data: Any) -> dict[str, Any]:
    """A simulator's info of one row."""
    info = trees.read(data) if data else {}
    if type(info) is not dict:
        raise MessageError("bad-info", f"an info is a dict, not {info!a:.40}")
    return info


def picture(arrays: list[Array]) -> Any:
    """The one array as a picture, uint8 [height, width, 3]."""
    if [(array.dtype, array.shape[2:]) for array in arrays] != [("uint8", (3,))]:
        forms = [(array.dtype, array.shape) for array in arrays]
        raise MessageError("no-picture", f"{forms!s:.80} is not one array uint8 [height, width, 3]")
    return arrays[0].numpy().copy()


def no_picture() -> Any:
    return np.zeros((240, 320, 3), np.uint8)


def known_render_mode(mode: Any) -> Any:
    """None, or the one that has pictures."""
    if mode not in (None, "rgb_array"):
        raise ValueError(f"render_mode takes 'rgb_array' or None, not {mode!r:.40}; lesson 12 makes films")
    return mode


def gives_pictures(mode: Any) -> bool:
    """Whether render has pictures to give; where it has none it warns, as Gymnasium's own environments do."""
    if mode is None:
        logger.warn('render gives no picture: make the environment with render_mode="rgb_array"')
    return mode is not None
