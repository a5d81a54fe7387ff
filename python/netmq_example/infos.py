"""Infos: what an environment and its simulator say to many, or of them, in one value of a message.

    text = pack([("hunter_0", {"energy": 0.5}), ("", {"weather": "rain"})])
    unpack(text)                     the way back, from [["hunter_0",{"energy":0.5}],["",{"weather":"rain"}]]

It is JSON; "" is the environment itself. An info is flat: texts, numbers, true and false by name, as the values of a
message are. ValueError says what cannot be sent, MessageError what is wrong with what a peer sent. In C# it is
Infos.cs. It needs numpy.
"""

import json
from collections.abc import Collection
from typing import Any

import numpy as np

from netmq_example.messages import DECODER, ENCODER, EXACT, MessageError

# In characters. In a header each may take four bytes, and a header has at most 64 KB.
LONGEST = 12_000


def pack(infos: list[tuple[Any, dict[str, Any]]]) -> str:
    """ValueError says what has no place in an info."""
    infos = [(who, checked(who, info)) for who, info in infos]
    text = ENCODER.encode(infos)
    if "\\u" in text:
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


def unpack(text: Any, whose: type = str, reserved: Collection[str] = ()) -> list[tuple[Any, dict[str, Any]]]:
    """MessageError says what is wrong with what a peer sent. `reserved` names are the environment's own."""
    try:
        infos = [(who, info) for who, info in DECODER.decode(text)]
        pack(infos)
        wrong = [who for who, info in infos if type(who) is not whose or not info.keys().isdisjoint(reserved)]
        if wrong:
            raise ValueError(
                f"{wrong[0]!a:.40} is no {whose.__name__}, or has a name of the environment's own: {reserved}"
            )
    except (ValueError, TypeError, RecursionError) as error:
        raise MessageError("bad-infos", f"these are no infos: {error!s:.120}") from None
    return infos


class InfoQueue:
    """Infos that wait for the next message: no more than fit into one, and those that are left out are counted."""

    def __init__(self) -> None:
        self.clear()

    def clear(self) -> None:
        self.infos: list[tuple[str, dict[str, Any]]] = []
        self.size = 0
        self.dropped = 0

    def send(self, agent: str, info: dict[str, Any]) -> None:
        size = len(pack([(agent, info)]))
        if self.size + size > LONGEST:
            self.dropped += 1
        else:
            self.size += size
            self.infos.append((agent, dict(info)))

    def take(self) -> str:
        """All of them as text, and from then on the queue is empty."""
        lost = [("", {"dropped": self.dropped})] if self.dropped else []
        text = pack(self.infos + lost)
        self.clear()
        return text
