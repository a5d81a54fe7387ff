"""The lessons, discovered from the folders: a new one is added by adding its files."""

import ast
import difflib
import json
import os
import re
import tempfile
from dataclasses import dataclass
from pathlib import Path
from typing import Any

ROOT = Path(__file__).resolve().parent.parent
# The Unity package.
PACKAGE = ROOT / "unity" / "Assets" / "NetMQExample"
# Everything that is made here, and can be made again.
BUILD = ROOT / ".build"
# A classroom without internet brings these along: wheels and NuGet packages, from `kit.py pack`.
PACKAGES = ROOT / "packages"
WINDOWS = os.name == "nt"
KIT = "py kit.py" if WINDOWS else "python3 kit.py"


class KitError(Exception):
    """A user can mend it: it is one line with the cause and the cure."""

    code = 1


class UsageError(KitError):
    code = 2


def writable(folder: Path) -> bool:
    """Tried, because what the permissions say is not the whole truth: a share, a stick, another user's folder."""
    try:
        folder.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryFile(dir=folder):
            return True
    except OSError:
        return False


def unwritable(path: Path) -> str:
    """Why nothing can be written there: what is in the way, and whose it is."""
    there = Path(os.path.realpath(path))
    while not os.path.lexists(there):
        there = there.parent
    try:
        owner = f", which belongs to {there.owner()},"
    except KeyError:
        owner = f", which belongs to user {there.stat().st_uid},"
    except (NotImplementedError, OSError):
        # Windows does not say.
        owner = ""
    return f"{there}{owner} cannot be written to: copy the kit to a folder of your own"


def denied(output: str) -> str:
    """The file that another program was not allowed to write, by its own words, and whose it is; or nothing."""
    found = re.search(r"(?:denied: |Access to the path )'([^']+)'", output)
    # On Windows a program that still uses the file is what denies it, most often.
    return unwritable(Path(found[1])) if found and not WINDOWS else ""


def read_json(path: Path) -> dict[str, Any]:
    """The object in a file; a file that is damaged is as good as none."""
    try:
        # With a byte order mark or without: Windows' editors write one.
        found = json.loads(path.read_text(encoding="utf-8-sig"))
    except (OSError, ValueError, RecursionError):
        return {}
    return found if isinstance(found, dict) else {}


def parsed(path: Path) -> ast.Module:
    """Its code; a SyntaxError names the file."""
    return ast.parse(path.read_text(encoding="utf-8"), str(path))


def docstring(path: Path) -> str:
    """The text at the top of a program. PYTHONOPTIMIZE takes it away from what is imported or run."""
    return ast.get_docstring(parsed(path)) or ""


@dataclass
class Lesson:
    """One lesson; `key` (such as 01_request_reply) is spelled the same in every tree."""

    key: str

    def __post_init__(self) -> None:
        self.number = int(self.key[:2])
        # Lessons 09 to 11 are one thing, and share theirs.
        self.port = 5559 if self.number in (10, 11) else 5550 + self.number
        self.python = ROOT / "python" / self.key
        self.unity = PACKAGE / self.key
        self.console = ROOT / "csharp-console" / f"{self.key}.cs"
        self.guide = ROOT / "docs" / "guide" / f"{self.key}.md"

    def folder(self, chosen: Path | None = None) -> Path:
        """Where its programs run, so that what they leave behind lies in one place."""
        if chosen:
            chosen.mkdir(parents=True, exist_ok=True)
            return chosen
        folder = BUILD / "run" / self.key[:2]
        return folder if writable(folder) else ROOT

    @property
    def title(self) -> str:
        """The first line of its server, without the lesson's number."""
        return re.sub(r"^(Lesson|Application) \d+, ", "", docstring(self.python / "server.py").partition("\n")[0])

    @property
    def how(self) -> dict[str, Any]:
        """RUN of its server, which says what belongs to a run of the lesson besides server and client."""
        for node in parsed(self.python / "server.py").body:
            if isinstance(node, ast.Assign) and ast.unparse(node.targets[0]) == "RUN":
                return dict(ast.literal_eval(node.value))
        return {}

    @property
    def also(self) -> list[list[str]]:
        """The other programs that are started, and get the server's endpoint, such as `train.py --areas 2`."""
        return [line.split() for line in self.how.get("also", [])]

    @property
    def scheme(self) -> str:
        """How its endpoints begin: a gateway's are those of the web."""
        return str(self.how.get("scheme", "tcp"))

    @property
    def anywhere(self) -> str:
        return f"{self.scheme}://127.0.0.1:0"

    @property
    def behind(self) -> list[tuple[str, "Lesson"]]:
        """The lessons whose servers answer behind it, each with the option that takes where that one listens."""
        return [(name, find(str(number))) for name, number in self.how.get("behind", {}).items()]


def lessons() -> list[Lesson]:
    servers = (ROOT / "python").glob("[0-9][0-9]_*/server.py")
    return sorted((Lesson(path.parent.name) for path in servers), key=lambda lesson: lesson.key)


def find(text: str) -> Lesson:
    """The lesson that a user means by 1, 01, 01_request_reply or request-reply."""
    found = lessons()
    wanted = text.strip().lower().replace("-", "_").replace(" ", "_")
    for lesson in found:
        if wanted in (lesson.key, str(lesson.number), lesson.key[:2], lesson.key[3:]):
            return lesson
    keys = {lesson.key[3:]: lesson.key for lesson in found}
    word = re.sub(r"^\d+_?", "", wanted)
    near = [name for name in keys if word and word in name] or difflib.get_close_matches(word, keys, 1)
    what = f"did you mean {keys[near[0]]}?" if near else f"there are: {', '.join(keys.values())}"
    raise UsageError(f"there is no lesson {text}; {what}")
