"""The reader's folder: copies of servers to change, the exercises that are done, and a table of them for a teacher."""

import json
import re
import shlex
from collections.abc import Sequence
from dataclasses import dataclass
from html import escape
from pathlib import Path

from kitlib import commands
from kitlib.commands import copy, run
from kitlib.files import put
from kitlib.lessons import ROOT, KitError, find, read_json
from kitlib.terminal import say

CLASSROOM = ROOT / "docs" / "guide" / "classroom.md"
TICKS = "exercises.json"
CHECKED, BY_HAND = "checked", "ticked"


@dataclass(frozen=True)
class Exercise:
    """A row of the classroom's table: the lesson, what to do, and the command that shows it done."""

    key: str
    text: str
    done: str

    @property
    def check(self) -> list[str]:
        """The client's options; none where a page has to be looked at."""
        command = re.match(r"`python3 kit\.py (run [^`]+)`", self.done)
        words = shlex.split(command[1])[1:] if command else []
        return run.split(commands.parse(run, words).options, "--options") if words else []

    @property
    def wanted(self) -> str:
        """What one of its lines has to contain."""
        found = re.search(r" prints `([^`]+)`", self.done)
        return found[1] if found else ""

    def passed(self, code: int, lines: Sequence[str]) -> bool:
        said = [line for line in lines if line.startswith("client |")]
        return code == 0 and any(self.wanted in line for line in said) and not any("error" in line for line in said)


def exercises() -> list[Exercise]:
    rows = re.findall(r"^\| (\d\d)\b.*? \| (.*?) \| (.*?) \|$", CLASSROOM.read_text(encoding="utf-8"), re.MULTILINE)
    return [Exercise(find(number).key, text, done) for number, text, done in rows]


def exercise(key: str) -> Exercise | None:
    return next((each for each in exercises() if each.key == key), None)


def editor(key: str) -> str:
    """The place where a reader changes a lesson's server."""
    found = exercise(key)
    check = f' <button data-do="check">Check</button> <small>{found.text}</small>' if found and found.check else ""
    tools = f'<p class="tools"><button data-do="edit">Edit</button>{check}</p>'
    return f'<div class="own" data-lesson="{key}">{tools}</div>'


def class_list(folder: Path) -> str:
    """The exercises, each with a tick."""
    done, rows = read_json(folder / TICKS), ""
    for each in exercises():
        checked = " checked" * bool(done.get(each.key))
        rows += f'<tr><td><input type="checkbox" aria-label="done" data-tick="{each.key}"{checked}></td>'
        rows += f"<td>{each.key[:2]}</td><td>{escape(each.text)}{editor(each.key)}</td></tr>"
    return f"<h1>Class list</h1><p>It is kept in {escape(str(folder / TICKS))}.</p><table>{rows}</table>"


def own_server(folder: Path, key: str) -> Path:
    """The reader's copy of a lesson's server; made if it is not there."""
    path = folder / key / "server.py"
    if not path.exists():
        files, _ = copy.programs(find(key), folder)
        copy.write(folder, files, force=False)
    return path


def opened(path: Path) -> dict[str, object]:
    """Its text, and the place of the function that is to be changed."""
    text = path.read_text(encoding="utf-8")
    here = text.find("Your own")
    return {"path": str(path), "text": text, "at": max(0, text.rfind("\ndef ", 0, max(here, 0)) + 1)}


def saved(path: Path, text: str) -> str:
    """Write what the reader has typed; the mistake that Python finds in it, or nothing."""
    try:
        put(path, text.encode())
    except OSError as error:
        raise KitError(f"could not write {path}: {error}; name another folder by --folder") from None
    try:
        compile(text, path.name, "exec")
    except SyntaxError as error:
        return f"line {error.lineno}: {error.msg}; fix it, and save again"
    except ValueError as error:
        return f"{error}; fix it, and save again"
    return ""


def tick(folder: Path, key: str, how: str) -> None:
    done = {each: value for each, value in read_json(folder / TICKS).items() if each != key}
    folder.mkdir(parents=True, exist_ok=True)
    put(folder / TICKS, json.dumps({**done, key: how} if how else done, indent=1).encode())


def report(folders: Sequence[Path]) -> int:
    """Print a row for each folder: which exercises were checked, and which ticked by hand."""
    keys = [each.key for each in exercises()]
    wide = max(len(str(folder)) for folder in folders)
    print(" " * wide, *(f"{key[:2]:7}" for key in keys), sep="  ")
    for folder in folders:
        done = read_json(folder / TICKS)
        print(f"{folder!s:{wide}}", *(f"{done.get(key, '-')!s:7}" for key in keys), sep="  ")
        if not (folder / TICKS).exists():
            say(f"{folder} has no {TICKS}: name the folder that `kit.py guide` names when it starts")
    return 0
