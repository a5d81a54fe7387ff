"""The environments of this package share how they are copied, what they send, and what they refuse."""

import functools
from collections.abc import Mapping
from typing import Any, Self

# At most of a dict that a reset takes, in bytes; a state of a million numbers fits.
LONGEST_OPTIONS = 16 * 1024 * 1024
# Words of gymize and of this kit before 0.4, each with what is written today.
OTHERS = {
    "name": "it is env_name",
    "agent_names": "several agents are the keys of observation_spaces, and a single one is agent_name",
    "autoreset_mode": "register this id with vector_entry_point, or leave it out",
    "update_seconds": "leave it out",
    "reward_range": "leave it out",
}


class OtherSide:
    """The words for it in what an environment reports. A socket that leads to more than one simulator has its own."""

    # A request without an answer is sent again, at first after a second, and at most so many seconds after the last
    # time. A simulator that waits for its scene, or is paused, reads none of them: ZeroMQ keeps 64, and hears no
    # heartbeat then.
    longest_pause = 16.0

    # While an environment waits, and once it has waited in vain.
    how_to_start = ": press Play"
    state = "is it running, or does it need a longer wait?"
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
        given = next((word for word in ("fleet", "socket", "context") if kwargs.get(word) is not None), None)
        if given:
            raise TypeError(f"{type(self).__name__} has a {given} that it was given: no second one can have it as well")
        # gymnasium.make has written down there how it was made.
        spec = vars(self).get("spec")
        return functools.partial(type(self), *args, **kwargs), (), {"spec": spec} if spec else None


def no_others(words: dict[str, object]) -> None:
    """An environment takes no words but its own."""
    known = "where its simulator is, say endpoint, launch, wait, timeout, context and fleet"
    for word in words:
        # Python's own words: libraries look for them, and then leave the word out.
        raise TypeError(f"an environment got an unexpected keyword argument {word!r}; {OTHERS.get(word, known)}")


def checked_options(options: Any) -> dict[str, Any]:
    options = {} if options is None else options
    if not isinstance(options, Mapping):
        raise ValueError(f"options must be a dict, not {options!r:.80}")
    if "seed" in options:
        raise ValueError("options have no seed: write reset(seed=…)")
    return dict(options)
