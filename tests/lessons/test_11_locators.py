"""Lesson 11, the locator language, in both languages: golden tables, random texts, and the page's tables."""

import itertools
import json
import random
import re
import runpy
import sys

import pytest

from netmq_example import locator
from netmq_example.locator import LocatorError
from tests.programs import ROOT, finished
from tests.tables import rows
from tests.unity.test_unity_play import needs_mono

KEY = "11_observations"
PAGE = ROOT / "docs" / "guide" / "11_locators.md"


def text_of(said):
    """A text or none, or pieces and how often they are repeated."""
    return said if isinstance(said, str | None) else "".join(piece * count for piece, count in said)


def table(name):
    return json.loads((ROOT / "tests" / "lessons" / "golden" / name).read_text(encoding="utf-8"))


GOLDEN = table("11_locators.json")
for text, said in table("11_gymize.json")["answers"].items():
    GOLDEN.append({"name": text, "text": text, "column" if isinstance(said, int) else "canonical": said})
CASES = [(text_of(one["text"]), one.get("default", ""), one.get("scope")) for one in GOLDEN]
# The sentence of an error, by its column and how it begins.
ERROR = re.compile(r"column (\d+): expected ([^\x00-\x1f\x7f]+)")


def python_says(text, name="", scope=None):
    try:
        return "ok", locator.parse(text, name, None if scope is None else locator.parse(scope)).text
    except LocatorError as error:
        return "error", str(error)


@pytest.fixture(scope="session")
def csharp_says(checks):
    """Ask Locator.cs of each case, in one process. A text in place of a case is the culture of those after it."""

    def digits(text):
        return "-" if text is None else "=" + text.encode("utf-16-be", "surrogatepass").hex()

    def says(cases, runtime="dotnet"):
        lines = [f"culture {case}" if isinstance(case, str) else " ".join(map(digits, case)) for case in cases]
        done = finished([runtime, checks, "locators"], input="\n".join(lines) + "\n")
        assert done.returncode == 0, done.stderr
        answers = [answer.split(" ", 1) for answer in done.stdout.splitlines()]
        return [
            (word, said if word == "here:" else bytes.fromhex(said).decode("utf-16-be", "surrogatepass"))
            for word, said in answers
        ]

    return says


@pytest.fixture(scope="module")
def python_said():
    return [*itertools.starmap(python_says, CASES)]


def check(entry, answer):
    word, said = answer
    if "canonical" in entry:
        assert (word, said) == ("ok", text_of(entry["canonical"])), entry["name"]
    else:
        assert word == "error", (entry["name"], said[:200])
        column, expected = ERROR.fullmatch(said).groups()
        assert int(column) == entry["column"], (entry["name"], said[:200])
        assert expected.startswith(entry.get("expected", "")), entry["name"]
        assert len(said) < 200, entry["name"]


def test_python_agrees_with_the_golden_table(python_said):
    for entry, answer in zip(GOLDEN, python_said, strict=True):
        check(entry, answer)


CULTURES = {"": "FILE 0.5 -1", "de-DE": "FILE 0,5 -1", "tr-TR": "FİLE 0,5 -1", "minus": "FILE 0.5 ~1"}


@pytest.mark.parametrize("runtime", ["dotnet", "mono"])
def test_csharp_agrees_with_the_golden_table(runtime, csharp_says, python_said):
    """A Turk's capital i has a dot, a German writes 0,5, and both sort letters in another order than a computer.

    Mono is the runtime that is closest to Unity's.
    """
    if runtime == "mono":
        needs_mono()
    # What is long is not long in another way elsewhere.
    short = [at for at, (text, *_) in enumerate(CASES) if len(text or "") < 1000]
    asked = [("", range(len(CASES))), *((culture, short) for culture in CULTURES if culture and runtime == "dotnet")]
    answers = iter(
        csharp_says([one for culture, which in asked for one in (culture, *map(CASES.__getitem__, which))], runtime)
    )
    for culture, which in asked:
        here = next(answers)[1]
        # A machine may know no country, and then writes as in none.
        assert here in (CULTURES[culture], CULTURES[""]) if "-" in culture else here == CULTURES[culture]
        for at in which:
            answer = next(answers)
            check(GOLDEN[at], answer)
            assert answer == python_said[at], (culture, GOLDEN[at]["name"])


# Random ones


SIGNS = [
    *"@.[](){}=$&,:'\"\\+-0129 \t\nß\0",
    *["@@", "...", "newaxis", "np.", "[]", "\u2003", "\\u00e9", "\\ud83d", "\\x41", "\\c", "99999999999"],
    *["\U0001f697", "\udc80"],
]


def spoiled(at_random, text):
    for _ in range(at_random.choice([1, 1, 2, 5])):
        at, size = at_random.randrange(len(text) + 1), at_random.choice([0, 0, 1, 3])
        text = text[:at] + at_random.choice([*SIGNS, ""]) + text[at + size :]
    return text


def test_both_languages_say_the_same_of_random_locators(csharp_says):
    at_random = random.Random(11)
    short = [text for text, *_ in CASES if text is not None and len(text) < 200]
    right = [text for text in short if python_says(text)[0] == "ok"]
    cases = []
    for number in range(2_000):
        text = " & ".join(at_random.choices(right, k=at_random.choice([1, 2, 2])))
        text = spoiled(at_random, at_random.choice([text, *at_random.choices(short)])) if number % 2 else text
        # Half of the scopes fit nowhere: relative ones, and those with a source.
        scope = at_random.choice([None, None, "car@", "car@.a", "@@bus@", "a@.b & c@", "a@(0)", "a@.s[]", *right[:20]])
        cases.append((text, at_random.choice(["", "", "f", "it's"]), scope))
    said = [python_says(*case) for case in cases]
    others = csharp_says(cases)
    assert [(case, *both) for case, *both in zip(cases, said, others, strict=True) if both[0] != both[1]] == []
    # Of each kind so many that the comparison means something.
    fine = [text for word, text in said if word == "ok"]
    assert 600 < len(fine) < 1_600
    assert len({re.sub(r"\d+|found.*", "", text) for word, text in said if word == "error"}) >= 19
    assert [text for text in fine if python_says(text) != ("ok", text)] == []


# What is meant


@pytest.mark.parametrize(
    ("text", "named"), [("a@b@", "ab"), ("@@", "abc"), ("@@b@", "ac"), ("@", ""), (".x", ""), ("''@", "")]
)
def test_whose_observation_is_meant(text, named):
    (mapping,) = locator.parse(text).mappings
    assert "".join(filter(mapping.names, "abc")) == named
    assert mapping.absolute == ("@" in text[1:])


# The programs


def python_program(capsys, *words):
    """How locator.py ends: (exit code, standard output, error output)."""
    # That C# was built.
    capsys.readouterr()
    old, sys.argv, code = sys.argv, ["locator.py", *words], 0
    try:
        runpy.run_path(str(ROOT / "python" / KEY / "locator.py"), run_name="__main__")
    except SystemExit as end:
        code = end.code
    finally:
        sys.argv = old
    return code, *capsys.readouterr()


PROGRAMS = [
    (".b & .a", [], 0, "['a'] = $ & ['b'] = $"),
    ("", ["--name", "it's"], 0, "['it\\'s'] = $"),
    ("", [], 0, " = $"),
    ("@.x", ["--scope", "car@.body"], 0, "'car'@['x'] = $"),
    ("=$[0]", ["--scope", "car@.body", "--name", "f"], 0, "'car'@['body']['f'] = $[0]"),
    ("['naïve \U0001f697']", [], 0, "['naïve \U0001f697'] = $"),
    ("-x", [], 2, "column 1: expected '.', '[', '(', '=', '&' or the end, found '-'"),
    ("--speed", [], 2, "column 1: expected '.', '[', '(', '=', '&' or the end, found '-'"),
    (".a[", [], 2, "column 4: expected a key, a number, a slice, ... or ']', found the end"),
    (".a", ["--scope", "car@.b."], 2, "scope, column 8: expected a name, found the end"),
    (".a", ["--scope", ".b"], 0, "['b']['a'] = $"),
    ("['\x1b[2J", [], 2, None),
]


def test_the_programs_say_the_same(capsys, runs):
    csharp = runs("csharp", KEY, [[f"--locator={text}", *options] for text, options, *_ in PROGRAMS])
    for (text, options, code, said), other in zip(PROGRAMS, csharp, strict=True):
        ended, *streams = python_program(capsys, *options, text)
        assert ended == other.code == code, text
        lines = streams[1 if code else 0].removesuffix("\n").split("\n")
        assert streams[0 if code else 1] == ""
        assert len(lines) == 1 and lines[0].isprintable(), text
        assert said in (None, lines[0]), text
        assert lines == other.lines, text


# The page


def examples():
    """Of every table: the text, the default, the scope, and what is said of it."""
    yield from ((text, "", None, said) for text, said, _ in rows(PAGE, "locator", "canonical text", "meaning"))
    yield from ((text, "", None, said) for text, said in rows(PAGE, "locator", "what is printed"))
    yield from ((text, "", None, said) for text, said, _ in rows(PAGE, "locator", "here", "in gymize"))
    for scope, default, text, said in rows(PAGE, "scope", "default", "locator", "canonical text"):
        yield text, default, scope, said


def test_the_page_says_what_both_languages_say(csharp_says):
    found = list(examples())
    assert len(found) > 20
    cases = [(text, name, scope) for text, name, scope, _ in found]
    python, csharp = [python_says(*case) for case in cases], csharp_says(cases)
    assert [said.strip() for _, said in python] == [said for *_, said in found]
    assert csharp == python
