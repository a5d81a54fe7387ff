"""Answers that are JSON: with `json_answer`, `answer` takes a dict and returns a dict. And requests with an id.

    @json_answer
    def answer(state: dict) -> dict:
        return {"say": f"Hello, {state['name']}!"}

A request that is no such JSON, and a result that cannot be written as one, are answered with `error: …`.
"""

import functools
import json
from collections.abc import Callable
from typing import Any

from netmq_example.console import printable
from netmq_example.errors import Misfit
from netmq_example.json_text import refuse_constant, shallow
from netmq_example.program import reply_to as reply_to


def id_and_text(frames: list[bytes]) -> tuple[list[bytes], bytes, bytes]:
    """A ROUTER's message of [id][text], apart: the way back with the id, the id, and the text.

    The way ends with REQ's empty frame, and is longer through brokers; a DEALER has only its name. What is one frame
    alone, or more than two, has no id, and its text is that of all of them, with a blank between.
    """
    start = frames.index(b"") + 1 if b"" in frames[:-1] else 1
    way, body = frames[:start], frames[start:]
    if len(body) == 2 and body[0]:
        return [*way, body[0]], body[0], body[1]
    return way, b"", b" ".join(body)


class Fields(dict[str, Any]):
    """A JSON object. A key that it lacks is a KeyError which names those that it has."""

    def __missing__(self, key: str) -> Any:
        raise Misfit(f"the request has no {key!r}; it has {', '.join(map(repr, self)) or 'nothing'}")

    def __getattr__(self, name: str) -> Any:
        raise AttributeError(f"a key of the request is written state[{name!r}]")


def json_answer(answer: Callable[[dict[str, Any]], dict[str, Any]]) -> Callable[[str], str]:
    """Write @json_answer above `answer(state: dict) -> dict`: both are JSON objects on the wire.

    A request that is none or lacks a key, and a result that cannot be written as one, are a Misfit, which reply_to
    answers with `error: …`. The server logs the reason too, a line a second at most.
    """
    return functools.wraps(answer)(lambda text: write(answer(read(text))))


def read(text: str) -> Fields:
    try:
        state = json.loads(shallow(text), object_hook=Fields, parse_constant=refuse_constant)
    except ValueError as error:
        raise Misfit(f"the request {printable(text, 80)!r} is no JSON: {error}") from None
    if not isinstance(state, Fields):
        raise Misfit(f"the request {printable(text, 80)!r} is no JSON object: send a class with fields")
    return state


def write(order: object) -> str:
    if not isinstance(order, dict):
        raise Misfit(f"answer returned {printable(repr(order), 80)}: return a dict")
    try:
        # NaN and Infinity are no JSON.
        return json.dumps(order, allow_nan=False)
    except (TypeError, ValueError, RecursionError) as error:
        raise Misfit(f"answer returned what JSON cannot have: {error}") from None
