"""The reader's folder: copies of servers to change, the exercises that are done, and a table of them for a teacher."""

import json
import re
import shlex
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from kitlib import commands
from kitlib.commands import copy, run
from kitlib.files import put
from kitlib.lessons import ROOT, find, read_json
from kitlib.terminal import say

CLASSROOM = ROOT / "docs" / "guide" / "classroom.md"
TICKS = "exercises.json"


@dataclass(frozen=True)
class Exercise:
    """A row of the classroom's table: what to do, and the command that shows it done."""

    text: str
    done: str

    @property
    def check(self) -> list[str]:
        """The client's options; none where a page has to be looked at."""
        command = re.match(r"`python3 kit\.py run ([^`]+)`", self.done)
        return run.split(commands.parse(run, shlex.split(command[1])).options, "--options") if command else []

    def passed(self, code: int, lines: Sequence[str]) -> bool:
        """Whether the client has ended well, and has printed what stands in the table, if something does."""
        said = "\n".join(line for line in lines if line.startswith("client |"))
        wanted = re.search(r" prints `([^`]+)`", self.done)
        return code == 0 and "error" not in said and (not wanted or wanted[1] in said)


def exercises() -> dict[str, Exercise]:
    """By the lesson, in the order of the table."""
    rows = re.findall(r"^\| (\d\d)\b.*? \| (.*?) \| (.*?) \|$", CLASSROOM.read_text(encoding="utf-8"), re.MULTILINE)
    return {find(number).key: Exercise(text, done) for number, text, done in rows}


def own_server(folder: Path, key: str) -> Path:
    """The reader's copy of a lesson's server; made if it is not there."""
    path = folder / key / "server.py"
    if not path.exists():
        copy.write(folder, copy.programs(find(key), folder)[0], force=False)
    return path


def mistake(path: Path) -> str:
    """The line that Python does not understand, or nothing."""
    try:
        compile(path.read_bytes(), path.name, "exec")
    except (SyntaxError, ValueError) as error:
        return f"{error}: fix it, and save again"
    return ""


def tick(folder: Path, key: str, how: str) -> None:
    done = {each: value for each, value in read_json(folder / TICKS).items() if each != key}
    folder.mkdir(parents=True, exist_ok=True)
    put(folder / TICKS, json.dumps({**done, key: how} if how else done, indent=1).encode())


def report(folders: Sequence[Path]) -> int:
    """Print a row for each folder: which exercises were checked, and which ticked by hand."""
    wide = max(len(str(folder)) for folder in folders)
    print(" " * wide, *(f"{key[:2]:7}" for key in exercises()), sep="  ")
    for folder in folders:
        done = read_json(folder / TICKS)
        print(f"{folder!s:{wide}}", *(f"{done.get(key, '-')!s:7}" for key in exercises()), sep="  ")
        if not (folder / TICKS).exists():
            say(f"{folder} has no {TICKS}: name the folder that `kit.py guide` names when it starts")
    return 0
