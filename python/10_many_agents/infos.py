"""Lesson 10, the infos: what is said of many, or to them, in one value of a message. In C#: Infos.cs.

    [["hunter_0",{"energy":0.5}],["",{"weather":"rain"}]]        JSON; "" is the environment

An info is flat: texts, numbers, true and false by name, as the values of a message are.
"""

import json
import sys
from collections.abc import Collection
from pathlib import Path
from typing import Any

import numpy as np

# In its own lesson's folder; at home they lie beside this file.
sys.path += [str(Path(__file__).resolve().parents[1] / name) for name in ("05_messages", "09_environment")]
from messages import DECODER, ENCODER, EXACT, Array, MessageError
from spaces import to_array

# Characters. In a header each may take four bytes, and a header has at most 64 KB.
LIMIT = 12_000


def pack(infos: list[tuple[Any, dict[str, Any]]]) -> str:
    """ValueError says what has no place in an info."""
    infos = [(who, checked(who, info)) for who, info in infos]
    if "\\u" in (text := ENCODER.encode(infos)):
        # Half a character, such as \ud800 alone, is none that could be printed.
        json.dumps(infos, ensure_ascii=False).encode()
    return text


def checked(who: Any, info: Any) -> dict[str, Any]:
    if type(who) not in (str, int) or type(info) is not dict:
        raise ValueError(f"{info!a:.40} of {who!a:.40} is no dict of a name or a number")
    # Whatever numpy made them of.
    plain = {name: value.item() if isinstance(value, np.generic) else value for name, value in info.items()}
    for name, value in plain.items():
        if type(name) is not str or type(value) not in (str, int, float, bool):
            raise ValueError(f"info {name!a:.40} of {who!a:.40} must be text, a number, true or false")
        if type(value) is int and abs(value) >= EXACT:
            raise ValueError(f"info {name!a:.40} of {who!a:.40} is too large to be exact")
    return plain


def unpack(text: Any, whose: type = str, own: Collection[str] = ()) -> list[tuple[Any, dict[str, Any]]]:
    """MessageError says what is wrong with what a peer sent. `own` are the names that the environment itself gives."""
    try:
        infos = [(who, info) for who, info in DECODER.decode(text)]
        pack(infos)
        if wrong := [who for who, info in infos if type(who) is not whose or not info.keys().isdisjoint(own)]:
            raise ValueError(f"{wrong[0]!a:.40} is no {whose.__name__}, or has a name of the environment's own: {own}")
    except (ValueError, TypeError, RecursionError) as error:
        raise MessageError("bad-infos", f"these are no infos: {error!s:.120}") from None
    return infos


def verdicts(judged: list[dict[str, Any]]) -> list[Array]:
    """The arrays rewards float64 [n], terminated and truncated uint8 [n]; what is left in them is info."""
    rewards = [one.pop("reward") for one in judged]
    if not np.isfinite(rewards).all():
        raise MessageError("bad-reward", f"the rewards are {rewards!s:.80}")
    flags = [[one.pop(name) for one in judged] for name in ("terminated", "truncated")]
    return [to_array(rewards, np.float64), *(to_array(flag, np.uint8) for flag in flags)]


class InfoQueue:
    """What is said between two messages: no more than fits into one, and what was left out is counted."""

    def __init__(self) -> None:
        self.infos, self.size, self.dropped = list[tuple[str, dict[str, Any]]](), 0, 0

    def send(self, agent: str, info: dict[str, Any]) -> None:
        size = len(pack([(agent, info)]))
        if self.size + size > LIMIT:
            self.dropped += 1
            return
        self.size += size
        self.infos.append((agent, dict(info)))

    def take(self) -> str:
        """All of it, and from then on it is empty."""
        lost = [("", {"dropped": self.dropped})] if self.dropped else []
        text = pack(self.infos + lost)
        self.infos, self.size, self.dropped = [], 0, 0
        return text
