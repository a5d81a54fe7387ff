"""Lesson 05: what holds for every message, and for everything that is none. With --long on more than 20,000 cases."""

from __future__ import annotations

import json
import math
import re

import pytest

from netmq_example import messages
from netmq_example.messages import Array, Message, MessageError
from tests.lessons.test_05_messages import KEY, asked, csharp, same, serves_on

try:
    from hypothesis import HealthCheck, given, settings
    from hypothesis import strategies as st
except ImportError:

    @pytest.mark.skip(reason="hypothesis is not installed: pip install hypothesis")
    def test_properties():
        """Stands for the tests below, so that their absence is reported."""

else:
    QUIET = {
        "deadline": None,
        "database": None,
        "derandomize": True,
        "suppress_health_check": list(HealthCheck),
    }
    EXACT = 2**53 - 1
    texts = st.text(max_size=20)
    values = st.one_of(
        texts, st.booleans(), st.integers(-EXACT, EXACT), st.floats(allow_nan=False, allow_infinity=False)
    )

    @st.composite
    def arrays(draw):
        dtype = draw(st.sampled_from(sorted(messages.DTYPES)))
        shape = tuple(draw(st.lists(st.integers(0, 3), max_size=3)))
        size = math.prod(shape) * messages.DTYPES[dtype]
        return Array(dtype, shape, draw(st.binary(min_size=size, max_size=size)))

    good = st.builds(
        Message,
        texts,
        st.integers(0, EXACT),
        st.dictionaries(texts, values, max_size=4),
        st.lists(arrays(), max_size=3),
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
        """The message, or None if it is refused in the proper way; anything else that is raised fails the test."""
        try:
            return messages.read(frames)
        except MessageError as error:
            assert re.fullmatch(r"[a-z]+-[a-z]+", error.code)
            assert 0 < len(error.text) < 300
            assert type(error.id) is int
            # The reply that a server makes of it can always be sent.
            reply = Message("error", error.id, {"code": error.code, "text": error.text})
            assert messages.read(reply.frames()) == reply
            return None

    def cases(few, many):
        """How many; the many take a minute of a core."""
        return pytest.mark.parametrize("count", [few, pytest.param(many, marks=[pytest.mark.long])])

    @cases(300, 6000)
    @pytest.mark.timeout(1200)
    def test_what_is_written_is_read_again(count):
        @settings(max_examples=count, **QUIET)
        @given(good)
        def check(message):
            assert same(messages.read(message.frames()), message)

        check()

    @cases(500, 14_000)
    @pytest.mark.timeout(1200)
    def test_whatever_comes_is_read_or_refused(count):
        @settings(max_examples=count, **QUIET)
        @given(spoiled())
        def check(frames):
            if message := verdict(frames):
                assert same(messages.read(message.frames()), message)

        check()

    def collected(strategy, count):
        """So many cases of a strategy, to give them to another program at once."""
        cases = []

        @settings(max_examples=count, **QUIET)
        @given(strategy)
        def collect(case):
            cases.append(case)

        collect()
        return cases

    @cases(200, 2000)
    def test_csharp_reads_what_python_writes_and_the_other_way_round(messages_program, count):
        written = collected(good, count)
        for message, (word, frames) in zip(
            written, csharp(messages_program, [m.frames() for m in written]), strict=True
        ):
            assert word == "ok", (message, frames)
            assert same(messages.read(frames), message)

    @cases(400, 4000)
    def test_csharp_and_python_agree_on_what_is_no_message(messages_program, count):
        tried = [frames for frames in collected(spoiled(), count) if b"\n" not in frames[0]]
        refused = 0
        for frames, (word, result) in zip(tried, csharp(messages_program, tried), strict=True):
            message = verdict(frames)
            refused += message is None
            assert (word == "ok") == (message is not None), (frames, word, result)
            assert message is None or same(messages.read(result), message)
        assert refused > len(tried) / 4, "most cases must be wrong, or nothing was tested"

    def test_the_server_survives_whatever_comes(serve, context):
        server, endpoint = serve(KEY)
        for frames in collected(spoiled(), 200):
            message = verdict(frames)
            reply = asked(context, endpoint, frames)
            if message is None:
                assert reply.kind == "error", frames
            else:
                assert reply.id == message.id
        serves_on(context, endpoint)
        assert server.stop() == 0
        assert "Traceback" not in server.output
