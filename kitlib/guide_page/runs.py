"""A block of the guide runs its own commands of kit.py, and nothing else; each line is told as it comes."""

import re
import shlex
import socket
from collections.abc import Mapping
from pathlib import Path

from kitlib import commands
from kitlib.commands import client, doctor, run, server, test
from kitlib.docs import guide
from kitlib.lessons import KitError, Lesson, UsageError, find

# These change nothing but what they leave in the folder of a run.
COMMANDS = {"run": run, "server": server, "client": client, "doctor": doctor, "test": test}
# Options that may get another value, and values that end neither a word nor a command.
FIELD = re.compile(r"(--(?!client)[\w-]+) ([\w.][\w./|-]*|'[^']*')")
VALUE = re.compile(r"[\w ./|:+-]{1,80}")
# A terminal is the place for servers that other machines reach, for folders and files, and for two commands in a line.
ELSEWHERE = re.compile(r"--folder|--open-to-anyone|/server\.py|tcp://(?!127\.0\.0\.1\b)| ; ")
# The first guide on this machine has this UDP port, and so the lessons' own ports.
FIRST = 5550
# The client has ended, and the page of messages is still there.
STAYS = f"kit    | {run.STAYS}"


def steps(block: guide.Block, values: Mapping[str, str] | None = None) -> list[list[str]]:
    """The words after kit.py of each line, with these values in its fields; none where a line is no command of ours."""
    found = []
    for line in filled(block, values or {}).splitlines():
        try:
            words = shlex.split(line.split("  #")[0])
            if words[:2] != ["python3", "kit.py"] or block.language or ELSEWHERE.search(line):
                return []
            commands.parse(COMMANDS[words[2]], words[3:])
        except (ValueError, LookupError, UsageError):
            return []
        found.append(words[2:])
    return found


def fields(block: guide.Block) -> list[tuple[str, str]]:
    """The options with a value that stand in a block, each with the value."""
    return [(name, value.strip("'")) for name, value in FIELD.findall(block.body)]


def filled(block: guide.Block, values: Mapping[str, str]) -> str:
    """The block with other values, by the number of the field."""
    numbers = iter(range(len(fields(block))))

    def other(found: re.Match[str]) -> str:
        was = found[2].strip("'")
        value = values.get(str(next(numbers)), was)
        if not VALUE.fullmatch(value):
            raise KitError(f"{found[1]} takes letters, numbers and . / | : + - here, not {value!r:.40}")
        plain = re.fullmatch(r"[\w.]\S*", value)
        return found[0] if value == was else f"{found[1]} {value}" if plain else f"{found[1]}='{value}'"

    return FIELD.sub(other, block.body)


def place(lesson: Lesson) -> list[str]:
    """An endpoint for its server, where somebody has its own."""
    with socket.socket() as probe:
        return [] if probe.connect_ex(("127.0.0.1", lesson.port)) else ["--endpoint", lesson.anywhere]


def apart(lesson: Lesson, number: int) -> list[str]:
    """An endpoint by a number of up to 10,000, which no other run takes while its server is started anew.

    The system gives these ports to no client: one that retries could otherwise be connected to itself.
    """
    return ["--endpoint", lesson.anywhere.replace(":0", f":{20_000 + (number + lesson.port) % 10_000}")]


def arranged(words: list[str], origin: str, folder: Path | None, number: int) -> list[str]:
    """A run's words, with a place for it and for its files, and with its page of messages in one of this origin's.

    With a number it leaves the lessons' own ports to others.
    """
    if words[0] not in ("run", "server", "client"):
        return words
    lesson = find(words[1])
    more = ["--folder", str(folder / lesson.key[:2])] if folder else []
    if origin:
        more += ["--watch", "--frame", origin]
    elif number or words[0] == "run":
        more += apart(lesson, number) if number else place(lesson)
    return [*words[:2], *more, *(word for word in words[2:] if word != "--watch")]


def spoken(program: str, line: str) -> dict[str, str | bool]:
    """The line with the name of its speaker."""
    found = re.fullmatch(r"(\S[^|]{0,20}?) *\| ?(.*)", line)
    return {"who": found[1], "text": found[2]} if found else {"who": program, "text": line}
