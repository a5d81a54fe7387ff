"""What a block of the guide runs: its own commands of kit.py, and nothing else, each line shown as it comes."""

import re
import shlex
import socket
import sys
import threading
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from queue import Empty, SimpleQueue
from subprocess import DEVNULL, PIPE, STDOUT, Popen
from typing import Any

from kitlib import commands
from kitlib.commands import client, doctor, run, server, test
from kitlib.docs import guide
from kitlib.lessons import ROOT, KitError, UsageError, find
from kitlib.programs import end, spawn

# These change nothing but what they leave in the folder of a run.
COMMANDS = {"run": run, "server": server, "client": client, "doctor": doctor, "test": test}
KIT = ROOT / "kit.py"
# Options that a reader may give another value, and values that end neither a word nor a command.
FIELD = re.compile(r"(--(?!client|endpoint|folder|only)[\w-]+) ([\w.][\w./|-]*|'[^']*')")
VALUE = re.compile(r"[\w ./|:+-]{1,80}")
# What other machines would reach, and where files would lie, is for a terminal.
ELSEWHERE = re.compile(r"--folder|--open-to-anyone|tcp://(?!127\.0\.0\.1\b)")
# The client has ended, and the page of messages is still there.
STAYS = f"kit    | {run.STAYS}"
SPEAKER = re.compile(r"(\S[^|]{0,20}?) *\| ?(.*)")
Tell = Callable[[dict[str, Any]], None]


def steps(block: guide.Block, values: Mapping[str, str] | None = None) -> list[list[str]]:
    """The words after kit.py of each line, with these values in its fields; none where a line is no command of ours."""
    found = []
    for line in filled(block, values or {}).splitlines():
        try:
            words = shlex.split(line.split("  #")[0])
            command = COMMANDS[words[2]] if words[:2] == ["python3", "kit.py"] else None
            if not command or ELSEWHERE.search(line):
                return []
            commands.parse(command, words[3:])
        except (ValueError, LookupError, UsageError):
            return []
        found.append(words[2:])
    return found if not block.language else []


def fields(block: guide.Block) -> list[tuple[str, str]]:
    """The options with a value that stand in a block, each with the value."""
    return [(name, value.strip("'")) for name, value in FIELD.findall(block.body)]


def filled(block: guide.Block, values: Mapping[str, str]) -> str:
    """The block with other values, by the number of the field."""
    numbers = iter(range(len(fields(block))))

    def other(found: re.Match[str]) -> str:
        value = values.get(str(next(numbers)), found[2].strip("'"))
        if not VALUE.fullmatch(value):
            raise UsageError(f"{found[1]} takes letters, numbers and . / | : + - here, not {value!r:.40}")
        return f"{found[1]}='{value}'"

    return FIELD.sub(other, block.body)


def watchable(block: guide.Block) -> bool:
    found = steps(block)
    return len(found) == 1 and found[0][0] == "run" and find(found[0][1]).scheme == "tcp"


def transcript(page: Path, words: Sequence[str]) -> guide.Block | None:
    """What the page shows of this very run."""
    same = (b for b in guide.blocks(page) if b.kind in ("run", "like") and plain(shlex.split(b.source)) == plain(words))
    return next(same, None)


def plain(words: Sequence[str]) -> list[str]:
    """A value means the same behind a space, an equals sign or quotation marks."""
    return shlex.split(" ".join(words).replace("=", " "))


def arranged(words: list[str], origin: str, folder: Path | None) -> list[str]:
    """A run's words, on a free port where somebody has the lesson's own; with its page of messages in this origin's."""
    if words[0] not in ("run", "server", "client"):
        return words
    lesson = find(words[1])
    more = ["--folder", str(folder / lesson.key[:2])] if folder else []
    if origin:
        more += ["--watch", "--frame", origin]
    elif words[0] == "run" and taken(lesson.port):
        more += ["--endpoint", lesson.anywhere]
    return [*words[:2], *more, *(word for word in words[2:] if word != "--watch")]


def taken(port: int) -> bool:
    with socket.socket() as probe:
        return probe.connect_ex(("127.0.0.1", port)) == 0


def hints(block: guide.Block) -> dict[str, str]:
    """What each field of a block is for, in the words of the programs' own help."""
    key = steps(block)[0][1]
    helps = "".join(run.own_options(key, f"{side}.py") + "\n" for side in guide.SIDES)
    found = {name: re.search(rf"^  {name} (.*(?:\n {{6,}}.*)*)", helps, re.MULTILINE) for name, _ in fields(block)}
    return {name: " ".join(help[1].split()) for name, help in found.items() if help}


class Play:
    """Runs commands until the last one has ended or nobody listens any more; a server goes on beside the next one."""

    def __init__(self, tell: Tell, listens: Callable[[], bool], folder: Path) -> None:
        self.tell, self.listens, self.folder = tell, listens, folder
        self.news: SimpleQueue[tuple[Popen[bytes], str | None]] = SimpleQueue()
        self.running: dict[int, Popen[bytes]] = {}
        # What the run has said since it began, and with which exit code it ended.
        self.lines: list[str] = []
        self.code = 0

    def begin(self, words: Sequence[str], number: int) -> None:
        """Start a command; the one that ran in its place ends first."""
        if number in self.running:
            end(self.running[number])
        self.tell({"begins": words[0]})
        streams: dict[str, Any] = {"stdin": DEVNULL, "stdout": PIPE, "stderr": STDOUT}
        process = self.running[number] = spawn([sys.executable, str(KIT), *words], self.folder, **streams)
        threading.Thread(target=self.read, args=(process,), daemon=True).start()

    def read(self, process: Popen[bytes]) -> None:
        assert process.stdout
        with process.stdout:
            for line in process.stdout:
                self.news.put((process, line.decode("utf-8", "replace").rstrip("\r\n")))
        self.news.put((process, None))

    def hear(self, words: Sequence[str], line: str) -> None:
        found = SPEAKER.fullmatch(line)
        speaker, text = (found[1], found[2]) if found else (words[0], line)
        if speaker == "kit" and (page := re.match(r"open (http://127\.0\.0\.1:\d+/) in", text)):
            self.tell({"page": page[1]})
        self.lines.append(line if found else f"{speaker} | {line}")
        self.tell({"who": speaker, "text": text})

    def all(self, steps: Sequence[list[str]], done: Callable[[], None]) -> None:
        """`done` is called when the last one has ended: the only one, or one that follows a server that goes on."""
        # A reader's own server is started anew when it is saved, and then the client as well.
        stays = "--reload" in steps[0]
        try:
            self.begin(steps[0], 0)
            while self.listens():
                try:
                    process, line = self.news.get(timeout=0.1)
                except Empty:
                    continue
                # What a client that was ended here has still said is of no use.
                for number in [at for at, each in self.running.items() if each is process]:
                    more = steps[number + 1 : number + 2]
                    if line is None:
                        self.code = process.wait()
                    else:
                        self.hear(steps[number], line)
                    ready = re.match(r"listening on (\S+)", line or "")
                    if steps[number][0] == "server":
                        if line is None:
                            return
                        if ready and more:
                            own = ["--endpoint", ready[1]] if steps[0][1].endswith(".py") else []
                            self.begin([*more[0], *own], number + 1)
                    elif line is None and more:
                        self.begin(more[0], number + 1)
                    elif line is None or line == STAYS:
                        done()
                        if line is None and not stays:
                            return
        finally:
            for process in reversed(self.running.values()):
                end(process)


def verdict(page: Path, words: Sequence[str], lines: Sequence[str]) -> str:
    """Whether a run printed what the page shows, by the rule of the tests."""
    block = transcript(page, words[1:]) if words[0] == "run" else None
    if not block:
        return ""
    source = shlex.join(words[1:])
    return guide.first_difference(block, guide.with_own_ports("\n".join(lines), source).splitlines()) or "as on the page"


def block_of(page: Path, number: int) -> guide.Block:
    found = list(guide.blocks(page))
    if page not in guide.pages() or not 0 <= number < len(found) or not steps(found[number]):
        raise KitError("this page has no such command: load it anew")
    return found[number]
