"""A block of the guide runs its own commands of kit.py, and nothing else; each line is told as it comes."""

import re
import shlex
import socket
import sys
import threading
import time
from collections import deque
from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from pathlib import Path
from queue import Empty, Queue
from subprocess import DEVNULL, PIPE, STDOUT, Popen
from typing import Any

from kitlib import commands
from kitlib.commands import client, doctor, run, server, test
from kitlib.docs import guide
from kitlib.lessons import ROOT, KitError, Lesson, UsageError, find
from kitlib.programs import end, spawn

# These change nothing but what they leave in the folder of a run.
COMMANDS = {"run": run, "server": server, "client": client, "doctor": doctor, "test": test}
# Options that may get another value, and values that end neither a word nor a command.
FIELD = re.compile(r"(--(?!client)[\w-]+) ([\w.][\w./|-]*|'[^']*')")
VALUE = re.compile(r"[\w ./|:+-]{1,80}")
# A terminal is the place for servers that other machines reach, for folders, and for two commands in a line.
ELSEWHERE = re.compile(r"--folder|--open-to-anyone|tcp://(?!127\.0\.0\.1\b)| ; ")
Send = Callable[[list[dict[str, Any]]], None]
# A program may print in an endless loop. The page gets the first lines and the last of what comes in so many seconds.
SLICE, ENDS = 0.1, 100
# Bounds of what waits to be read and of what a verdict sees, in lines, and of a line, in bytes.
MOST_WAITING, MOST_LINES, LONGEST_LINE = 10_000, 20_000, 4000
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
        return found[0] if value == was else f"{found[1]}='{value}'"

    return FIELD.sub(other, block.body)


def verdict(page: Path, words: Sequence[str], lines: Sequence[str]) -> str:
    """Whether a run printed what the page shows of it, by the rule of the tests; nothing where the page shows none."""
    for block in guide.blocks(page):
        fits = len(lines) < MOST_LINES and block.kind in ("run", "like")
        if fits and ["run", *shlex.split(block.source)] == words:
            said = guide.with_own_ports("\n".join(lines), block.source).splitlines()
            return guide.first_difference(block, said) or "as on the page"
    return ""


def place(lesson: Lesson) -> list[str]:
    """An endpoint for its server, where somebody has its own."""
    with socket.socket() as probe:
        return [] if probe.connect_ex(("127.0.0.1", lesson.port)) else ["--endpoint", lesson.anywhere]


def arranged(words: list[str], origin: str, folder: Path | None) -> list[str]:
    """A run's words, with a place for it and for its files, and with its page of messages in one of this origin's."""
    if words[0] not in ("run", "server", "client"):
        return words
    lesson = find(words[1])
    more = ["--folder", str(folder / lesson.key[:2])] if folder else []
    more += ["--watch", "--frame", origin] if origin else place(lesson) if words[0] == "run" else []
    return [*words[:2], *more, *(word for word in words[2:] if word != "--watch")]


class Play:
    """Runs steps until the last one has ended or nobody listens any more; a server goes on beside the next step."""

    def __init__(self, steps: list[list[str]], folder: Path, send: Send, done: Callable[["Play"], None]) -> None:
        """`done` is called when the last step has ended, but not where that is a server."""
        self.steps, self.folder, self.send, self.done = steps, folder, send, done
        self.news: Queue[tuple[int, Popen[bytes], str | None]] = Queue(MOST_WAITING)
        self.batch: list[dict[str, Any]] = []
        self.running: dict[int, Popen[bytes]] = {}
        # The newest lines, and the exit code of the newest step that has ended.
        self.lines: deque[str] = deque(maxlen=MOST_LINES)
        self.code = 0
        # Where a reader's own server listens.
        self.place: list[str] = []

    def all(self, listens: Callable[[], bool]) -> None:
        over = False
        try:
            self.begin(0)
            while listens() and not over:
                over = self.collect()
                self.flush()
        finally:
            for process in reversed(self.running.values()):
                end(process)
            # A thread that waits for room ends as well.
            with suppress(Empty):
                while self.news.get(timeout=SLICE):
                    pass

    def collect(self) -> bool:
        """Hear what comes within the next moment. True at the end of all."""
        until, over = time.monotonic() + SLICE, False
        with suppress(Empty):
            while not over and (left := until - time.monotonic()) > 0:
                number, process, line = self.news.get(timeout=left)
                # A client that was ended for a new one may have lines left.
                over = self.running[number] is process and self.hear(number, line)
        return over

    def tell(self, news: dict[str, Any]) -> None:
        self.batch.append(news)

    def flush(self) -> None:
        """Send what there is to tell; where a program has printed too much, without the middle of it."""
        batch, self.batch = self.batch, []
        for who in {each.get("who", "") for each in batch}:
            middle = [each for each in batch if who and each.get("who") == who][ENDS:-ENDS]
            for each in middle:
                each.clear()
            if middle:
                middle[0].update(who=who, text=f"... {len(middle)} lines left out")
        self.send([each for each in batch if each])

    def begin(self, number: int) -> None:
        """Start a step, again if need be."""
        if number in self.running:
            end(self.running[number])
        self.tell({"begins": self.steps[number][0]})
        words = [sys.executable, str(ROOT / "kit.py"), *self.steps[number], *(self.place if number else [])]
        process = self.running[number] = spawn(words, self.folder, stdin=DEVNULL, stdout=PIPE, stderr=STDOUT)
        threading.Thread(target=self.read, args=(number, process), daemon=True).start()

    def read(self, number: int, process: Popen[bytes]) -> None:
        while line := process.stdout.readline(LONGEST_LINE) if process.stdout else b"":
            self.news.put((number, process, line.decode("utf-8", "replace").rstrip("\r\n")))
        self.news.put((number, process, None))

    def hear(self, number: int, line: str | None) -> bool:
        """A line, or the end, of a step. True if that is the end of all."""
        words, last = self.steps[number], number + 1 == len(self.steps)
        if line is None:
            self.code = self.running[number].wait()
        else:
            self.show(words[0], line)
        if words[0] == "server":
            if not last and (ready := re.match(r"listening on (\S+)", line or "")):
                # A reader's own server may listen elsewhere, and is started anew when it is saved.
                self.place = ["--endpoint", ready[1]] if words[1].endswith(".py") else []
                self.begin(number + 1)
            return line is None
        if line is None and not last:
            self.begin(number + 1)
        elif line in (None, STAYS):
            self.done(self)
        return line is None and last and "--reload" not in self.steps[0]

    def show(self, program: str, line: str) -> None:
        found = re.fullmatch(r"(\S[^|]{0,20}?) *\| ?(.*)", line)
        who, text = found.groups() if found else (program, line)
        if page := re.match(r"open (http://127\.0\.0\.1:\d+/) in", text):
            self.tell({"page": page[1]})
        self.lines.append(f"{who} | {text}")
        self.tell({"who": who, "text": text})
