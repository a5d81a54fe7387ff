"""Lesson 05: what holds for every message, and for everything that is none."""

import json
import math
import re

import pytest

from netmq_example import messages
from netmq_example.messages import Array, Message, MessageError
from tests.lessons.test_05_messages import csharp, echo, same

hypothesis = pytest.importorskip("hypothesis", reason="hypothesis is not installed: pip install hypothesis")
st = hypothesis.strategies

EXACT = 2**53 - 1
texts = st.text(max_size=20)
values = st.one_of(texts, st.booleans(), st.integers(-EXACT, EXACT), st.floats(allow_nan=False, allow_infinity=False))


@st.composite
def arrays(draw):
    dtype = draw(st.sampled_from(sorted(messages.DTYPES)))
    shape = tuple(draw(st.lists(st.integers(0, 3), max_size=3)))
    size = math.prod(shape) * messages.DTYPES[dtype]
    return Array(dtype, shape, draw(st.binary(min_size=size, max_size=size)))


good = st.builds(
    Message, texts, st.integers(0, EXACT), st.dictionaries(texts, values, max_size=4), st.lists(arrays(), max_size=3)
)
anything = st.recursive(
    st.one_of(st.none(), st.booleans(), st.integers(-(2**70), 2**70), st.floats(), texts),
    lambda inner: st.one_of(st.lists(inner, max_size=3), st.dictionaries(texts, inner, max_size=3)),
    max_leaves=6,
)


@st.composite
def spoiled(draw):
    """The frames of a good message with one thing, or some, gone wrong."""
    frames = [bytes(frame) for frame in draw(good).frames()]
    how = draw(st.sampled_from(["field", "inner", "cut", "byte", "frames", "bytes", "json"]))
    header = json.loads(frames[0])
    if how == "field":
        header[draw(st.sampled_from(sorted(header)))] = draw(anything)
    elif how == "inner":
        inner = draw(st.sampled_from(header["arrays"] or [header]))
        inner[draw(st.sampled_from(["dtype", "shape", "kind", "id", "values", "version"]))] = draw(anything)
    elif how == "json":
        header = draw(anything)
    frames[0] = json.dumps(header).encode()
    at = draw(st.integers(0, len(frames[0]) - 1))
    if how == "cut":
        frames[0] = frames[0][:at]
    elif how == "byte":
        frames[0] = frames[0][:at] + draw(st.binary(max_size=2)) + frames[0][at + 1 :]
    elif how == "frames":
        frames = frames[:1] + draw(st.lists(st.binary(max_size=9), max_size=4))
    elif how == "bytes":
        frames = draw(st.lists(st.binary(max_size=60), min_size=1, max_size=3))
    return frames


def verdict(frames):
    """The message, or the code with which it is refused properly; anything else that is raised fails the test."""
    try:
        return messages.Message.read(frames)
    except MessageError as error:
        assert re.fullmatch(r"[a-z]+-[a-z]+", error.code)
        assert 0 < len(error.text) < 300
        assert type(error.id) is int
        # The reply that a server makes of it can always be sent.
        reply = messages.Message.read(echo(frames))
        assert (reply.kind, reply.id, reply.values["code"]) == ("error", error.id, error.code)
        return error.code


def collected(strategy, count):
    """So many cases of a strategy, which both languages get."""
    cases = []

    @hypothesis.settings(
        max_examples=count,
        deadline=None,
        database=None,
        derandomize=True,
        suppress_health_check=list(hypothesis.HealthCheck),
    )
    @hypothesis.given(strategy)
    def collect(case):
        cases.append(case)

    collect()
    return cases


def test_both_languages_agree_on_what_is_a_message(request):
    written = collected(good, 150)
    # C# is given a line for each.
    tried = [frames for frames in collected(spoiled(), 350) if b"\n" not in frames[0]]
    read = [verdict(frames) for frames in tried]
    taken = [message for message in read if isinstance(message, Message)]
    for message in [*written, *taken]:
        assert same(messages.Message.read(message.frames()), message)
    assert len(tried) - len(taken) > len(tried) / 4, "most cases must be wrong, or nothing was tested"
    # Python's part is done before it is found out that there is no C#.
    program = request.getfixturevalue("messages_program")
    answers = csharp(program, [*(message.frames() for message in written), *tried])
    for message, (word, result) in zip([*written, *read], answers, strict=True):
        if isinstance(message, Message):
            assert word == "ok" and same(messages.Message.read(result), message), (message, word, result)
        else:
            assert (word, result) == ("error", message)
