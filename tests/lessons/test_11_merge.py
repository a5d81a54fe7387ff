"""Lesson 11, merging: a value is written where a locator says. The language itself is in test_11_locators.py."""

from __future__ import annotations

import re

import pytest

from tests.programs import ROOT
from tests.tables import rows

PAGE = ROOT / "docs" / "guide" / "11_locators.md"

np = pytest.importorskip("numpy", reason="merging needs numpy: pip install numpy")
pytest.importorskip("gymnasium", reason="merging needs gymnasium: pip install gymnasium")
from netmq_example import locator  # noqa: E402
from netmq_example.envs import merge as module  # noqa: E402
from netmq_example.locator import LocatorError  # noqa: E402


def merge(observations, *said):
    """One message of texts and values."""
    appended = set()
    for text, value in said:
        module.merge(observations, locator.parse(text), value, appended)
    return observations


def same(one, other):
    """Equal, and of the same kinds."""
    if type(one) is not type(other):
        return False
    if isinstance(one, np.ndarray):
        return one.dtype == other.dtype and one.shape == other.shape and np.array_equal(one, other, equal_nan=True)
    if isinstance(one, dict):
        return one.keys() == other.keys() and all(same(one[key], other[key]) for key in one)
    if isinstance(one, (list, tuple)):
        return len(one) == len(other) and all(map(same, one, other))
    return one == other


def test_the_page_says_what_is_written():
    found = rows(PAGE, "there is", "locator", "value", "then there is")
    assert len(found) > 12
    for there, text, value, then in found:
        names = {"array": lambda items: np.array(items, np.float32)}
        before = {"car": eval(there, names)}
        kept = before["car"]
        try:
            after = merge(before, (text, eval(value, names)))
        except LocatorError as error:
            assert str(error) == then
            assert before == {"car": kept}, "all or nothing"
        else:
            assert same(after, {"car": eval(then, names)}), (text, after)
        assert same(kept, eval(there, names)), f"{text}: what was given out is not changed"


def test_a_new_message_clears_what_was_appended_of_each_agent():
    there = {"a": {"s": [0]}, "b": {"s": (0,)}, "c": {"s": []}}
    merge(there, ("@@.s[]", 1), ("@@.s[]", 2), ("a@.s[]", 3))
    assert there == {"a": {"s": [1, 2, 3]}, "b": {"s": (1, 2)}, "c": {"s": [1, 2]}}
    merge(there, ("a@.s[]", 4))
    assert there == {"a": {"s": [4]}, "b": {"s": (1, 2)}, "c": {"s": [1, 2]}}


def test_a_locator_writes_to_all_its_places_or_to_none():
    there = {"a": {"x": 0}, "b": {"x": 0}}
    with pytest.raises(LocatorError, match="'m'"):
        merge(there, ("a@.x & b@.m", 1))
    assert there == {"a": {"x": 0}, "b": {"x": 0}}


def test_every_kind_of_value_is_cast_to_what_is_there():
    picture = np.frombuffer(b"\1\2\3\4", np.uint8)
    given = {
        "f": (np.zeros(2, np.float32), [1, None], np.array([1, np.nan], np.float32)),
        "one": (np.zeros(1, np.float32), 2.5, np.array([2.5], np.float32)),
        "u": (np.zeros(4, np.uint8), picture, picture),
        "b": (np.zeros(2, np.int8), [True, False], np.array([1, 0], np.int8)),
        "d": (np.int64(0), 3, np.int64(3)),
        "t": ("", "naïve", "naïve"),
        "tuple": ((np.zeros(1), "a"), [[1], "b"], (np.ones(1), "b")),
        "longer": ((np.float32(0),), [1, 2, 3], (np.float32(1), np.float32(2), np.float32(3))),
        "empty": ([], [1, 2], [1, 2]),
        "none": (None, 5, 5),
    }
    there = {"car": {key: before for key, (before, _, _) in given.items()}}
    merge(there, ("car@", {key: value for key, (_, value, _) in given.items()}))
    assert same(there["car"], {key: after for key, (_, _, after) in given.items()}), there
    assert not np.shares_memory(there["car"]["u"], picture), "what was received is not handed on"


@pytest.mark.parametrize(
    "value", [300, -1, 1.5, float("nan"), None, "x", [[1, 2]], 10**400, {}, b"1"], ids=lambda value: repr(value)[:9]
)
def test_what_would_become_another_number_is_refused(value):
    there = {"car": {"u": np.zeros(3, np.uint8)}}
    with pytest.raises(LocatorError) as refusal:
        merge(there, ("car@.u(0)", value))
    assert re.fullmatch(r"'car'@\['u'\]\(0\) = \$: [ -~]{5,200}", str(refusal.value))
    assert there["car"]["u"].tolist() == [0, 0, 0]


@pytest.mark.parametrize("text", [[("car@", 1), (".u", 3000)], [("car@.x", 1), ("(:)", 5_000)]], ids=["keys", "slices"])
def test_a_path_deeper_than_anything_is_refused(text):
    with pytest.raises(LocatorError) as refusal:
        merge({"car": {"u": {}, "x": np.zeros(3)}}, ("".join(piece * count for piece, count in text), 1))
    assert len(str(refusal.value)) < 400
