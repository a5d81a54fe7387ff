"""A server's replies: `answer` takes a text and returns a text; with `json_answer` a dict and a dict.

    @json_answer
    def answer(state: dict) -> dict:
        return {"say": f"Hello, {state['name']}!"}

A mistake ends no server: `error: …` is the reply.
"""

import functools
import json
import logging
import traceback
from collections.abc import Callable
from typing import Any

from netmq_example.console import printable
from netmq_example.json_text import shallow
from netmq_example.program import encoded, text_of
from netmq_example.trouble import Trouble, ends_program, shown

log = logging.getLogger("netmq_example.server")


def reply_to(answer: Callable[[str], str], request: bytes) -> bytes:
    """The reply that `answer` gives to a request. A mistake in it is reported to both sides, and ends neither."""
    try:
        return sendable(answer(text_of(request)))
    except BaseException as error:
        if ends_program(error):
            raise
        return encoded(told(error))


def id_and_text(frames: list[bytes]) -> tuple[list[bytes], bytes, bytes]:
    """What a ROUTER received of [id][text], apart: the way back with the id, the id, and the text.

    The way ends with REQ's empty frame, and is longer through brokers; a DEALER has only its name. What is one frame
    alone, or more than two, has no id, and its text is that of all of them, with a blank between.
    """
    start = frames.index(b"") + 1 if b"" in frames[:-1] else 1
    way, body = frames[:start], frames[start:]
    if len(body) == 2 and body[0]:
        return [*way, body[0]], body[0], body[1]
    return way, b"", b" ".join(body)


def sendable(text: str) -> bytes:
    """What `answer` has returned, in UTF-8. Misfit says why it cannot be sent, which may lie in the request."""
    if not isinstance(text, str):
        raise Misfit(f"answer returned {text!r:.40}: return a text")
    try:
        return encoded(text, "strict")
    except ValueError as error:
        raise Misfit(f"answer returned what cannot be sent: {error}") from None


# Each mistake that was made, by its place in the code. Each has its own line a second.
again: dict[tuple[object, ...], Trouble] = {}


def told(error: BaseException) -> str:
    """The reply to a request that an exception has ended, which is also logged.

    With its traceback the first time; then it is a line a second at most, since a client may go on asking.
    """
    places = [(frame.f_code.co_filename, line) for frame, line in traceback.walk_tb(error.__traceback__)]
    # Two servers of one program may fail in the same place, and come there on different ways.
    mistake = (type(error), *places[:4], places[-1])
    first = mistake not in again
    report = again.setdefault(mistake, Trouble(log.error))
    text = str(error) if isinstance(error, Misfit) else shown(error)
    if first and not isinstance(error, Misfit):
        log.error("a mistake in answer", exc_info=error)
    else:
        report(text)
    return f"error: {printable(text, LONGEST_MISTAKE)}"


# In characters. A longer reply than the limit would be dropped by the client, with the connection.
LONGEST_MISTAKE = 1000


class Misfit(KeyError):
    """A request or a reply is not what was agreed: one line for both sides, and no traceback."""

    # A KeyError's own shows its argument between quotation marks.
    __str__ = Exception.__str__


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


def refuse_constant(name: str) -> None:
    raise ValueError(f"{name} is not JSON")


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
