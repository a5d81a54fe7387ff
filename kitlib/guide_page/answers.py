"""The reader's folder: copies of servers to change, the exercises that are done, and a table of them for a teacher."""

import json
import re
import shlex
import threading
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
# Two ticks at once are both kept.
TICKING = threading.Lock()


@dataclass(frozen=True)
class Exercise:
    """A row of the classroom's table: what to do, and the commands that show it done."""

    key: str
    text: str
    done: str

    @property
    def check(self) -> list[str]:
        """The options of each client; none where a page has to be looked at."""
        found = re.findall(r"`python3 kit\.py run ([^`]+)`", self.done)
        return [commands.parse(run, shlex.split(each)).options for each in found]

    def verdict(self, folder: Path, lines: Sequence[str]) -> dict[str, str | bool]:
        """Done, which is kept; or what stands in the table and was not printed, and what was."""
        said = [line.removeprefix("client | ") for line in lines if line.startswith("client |")]
        wanted, printed = re.findall(r" prints `([^`]+)`(, with [^`]+)?", self.done), "\n".join(said)
        missing = []
        for each, more in wanted:
            # A digit of the table stands for any, but the table's own time is not the time.
            found = re.search(re.sub(r"\d", r"\\d", re.escape(each)), printed)
            if not found or (more and each in printed):
                missing.append(each + more)
        if less := re.search(r"the second one (\d+) less", self.done):
            balances = [int(each) for line in said for each in re.findall(r"received (-?\d+)$", line)]
            if len(balances) != 2 or balances[0] - balances[1] != int(less[1]):
                missing = [f"two balances, {less[0]}"]
        ended = sum(line.startswith("done: ") for line in said) == len(self.check)
        if ended and not missing and "error" not in printed:
            tick(folder, self.key, "checked")
            return {"verdict": "done", "good": True}
        came = [line for line in said if not re.match("asking |done: ", line)]
        # Where the server has crashed, the client only hears nothing.
        if errors := [line for line in lines if re.match(r"server \| [\w.]*(Error|Exception)\b", line)]:
            came.append(errors[-1])
        elif re.search("gave up.*no reply", printed):
            came.append("(nothing came: is there a loop that never ends?)")
        must = f"the client has to print {' and '.join(missing) or 'no error'}"
        return {"verdict": "\n".join([f"not yet: {must}. It printed:", *(came[-8:] or ["nothing"])]), "good": False}


def exercises() -> dict[str, Exercise]:
    """By the lesson, in the order of the table."""
    rows = re.findall(r"^\| (\d\d)\b.*? \| (.*?) \| (.*?) \|$", CLASSROOM.read_text(encoding="utf-8"), re.MULTILINE)
    return {find(row[0]).key: Exercise(find(row[0]).key, *row[1:]) for row in rows}


def own_server(folder: Path, key: str) -> Path:
    """The reader's copy of a lesson's server; made if it is not there."""
    path = folder / key / "server.py"
    if not path.exists():
        copy.write(folder, copy.programs(find(key), folder)[0], force=False)
    return path


def mistake(path: Path) -> tuple[str, int]:
    """Python's complaint about it, if it has any, and the number of the line."""
    try:
        compile(path.read_bytes(), path.name, "exec")
    except (SyntaxError, ValueError, MemoryError, RecursionError) as error:
        return f"{error}: fix it, and save again", getattr(error, "lineno", None) or 0
    return "", 0


def tick(folder: Path, key: str, how: str) -> None:
    with TICKING:
        done = {each: value for each, value in read_json(folder / TICKS).items() if each != key}
        folder.mkdir(parents=True, exist_ok=True)
        put(folder / TICKS, json.dumps({**done, key: how} if how else done, indent=1).encode())


def ticks(path: Path) -> dict[str, str]:
    """How each exercise was done; an error where the guide did not write the file so."""
    known, written = exercises(), json.loads(path.read_text(encoding="utf-8-sig"))
    done = {key: how for key, how in written.items() if key in known}
    if not all(how in ("checked", "ticked") for how in done.values()) or (written and not done):
        raise ValueError(done)
    return done


def places(folder: Path) -> list[Path]:
    """Where its exercises are: there, or in the folder `answers` that the kit makes."""
    return [path for path in (folder / TICKS, folder / "answers" / TICKS) if path.exists()]


def report(folders: Sequence[Path]) -> int:
    """Print a row for each folder, or for each in it: which exercises were checked, and which ticked by hand."""
    # Of a class each pupil has a row, also who has never pressed Check.
    within = {folder: sorted(each for each in folder.glob("[!.]*") if each.is_dir()) for folder in folders}
    classes = [each for each in folders if not places(each) and any(map(places, within[each]))]
    folders = [row for each in folders for row in (within[each] if each in classes else [each])]
    # A name of a pupil's may hold what a terminal takes for a command.
    names = ["".join(each if each.isprintable() else "?" for each in str(folder)) for folder in folders]
    wide = max(map(len, names))
    print(" " * wide, *(f"{key[:2]:7}" for key in exercises()), sep="  ")
    for name, folder in zip(names, folders, strict=True):
        done, why = {}, ""
        try:
            done = ticks((places(folder) or [folder / TICKS])[0])
        except FileNotFoundError:
            why = f"{name} has no {TICKS}: name the folder that `kit.py guide` names when it starts"
        except (OSError, ValueError, AttributeError, RecursionError):
            why = f"{TICKS} of {name} is not as the guide writes it: look at the pupil's own screen"
        print(f"{name:{wide}}", *(f"{done.get(key, '-'):7}" for key in exercises()), sep="  ")
        if why:
            say(why)
    return 0
