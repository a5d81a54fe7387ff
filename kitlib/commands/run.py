"""Runs one lesson: the server, then the client, both shown line by line behind a prefix."""

import argparse
import functools
import os
import shlex
import sys
import webbrowser
from pathlib import Path
from subprocess import DEVNULL

from kitlib import lessons
from kitlib.lessons import ROOT, KitError, Lesson, UsageError, find
from kitlib.programs import MOMENT, TIMEOUT, Program, quietly, wait
from kitlib.setup import dotnet, python_setup
from kitlib.signals import uninterrupted
from kitlib.terminal import say, show

ABOUT = "Runs a lesson: starts its Python server and a client, shows both line by line, and stops the server."
EXAMPLES = [
    "run 1                            lesson 01 with the C# client",
    "run lazy-pirate --client unity   its Unity scripts, played without Unity",
    'run 4 --server="--slow-on 3"     the server is late with reply 3',
    'run 1 --options="--count 3"      the client asks three times',
    'run 2 --watch --options="--count 200000 --timeout 2"   a page shows the messages, and drops one by a button',
]
# The page of --watch is lesson 16's tap, which needs this extra beyond the core.
EXTRA = "16_web_gateway"
# So many seconds a browser has to open it.
OPENING = 20.0
STAYS = "the page stays until Ctrl-C"
CURE = 'what the client takes goes into --options="…", what the server takes into --server="…"'


def add_options(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("lesson", metavar="LESSON", help="its number or name: 1, 01, request-reply; or your server.py")
    parser.add_argument("--endpoint", help="where the server listens; tcp://127.0.0.1:0 takes a free port")
    parser.add_argument("--server", default="", metavar="OPTIONS", help="for the server; `server N --help` has them")
    parser.add_argument("--options", default="", metavar="OPTIONS", help="for the client; `client N --help` has them")
    parser.add_argument("--reload", action="store_true", help="start the server anew when it is saved")
    parser.add_argument("--watch", action="store_true", help="see the messages pass, in a page of your browser")
    parser.add_argument("--frame", metavar="ORIGIN", help="with --watch: whose page shows that page, in a frame")
    add_folder(parser)
    add_client(parser)


def add_folder(parser: argparse.ArgumentParser) -> None:
    """The tests have one of their own, and leave alone what a reader's runs have left."""
    what = "where the programs run and leave their files; .build/run/NN if left out"
    parser.add_argument("--folder", type=Path, metavar="DIR", help=what)


def add_client(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("--client", choices=("csharp", "python", "unity"), help="csharp, if not said")


def do(options: argparse.Namespace) -> int:
    own = Path(options.lesson).absolute() if options.lesson.endswith(".py") else None
    lesson = find(own.parent.name if own else options.lesson)
    for_client, for_server = split(options.options, "--options"), split(options.server, "--server")
    if options.watch and lesson.scheme != "tcp":
        raise UsageError(f"--watch shows ZeroMQ, and {lesson.key} is asked over {lesson.scheme}; watch another lesson")
    python = python_setup.interpreter(lesson.key, *([EXTRA] if options.watch else []))
    client = [*client_command(options.client, lesson, python), *for_client]
    endpoint = options.endpoint or (lesson.anywhere if options.watch else "")
    given = ["--endpoint", endpoint] if endpoint else []
    others = [[str(python), str(lesson.python / name), *words] for name, *words in lesson.also]
    server = [str(python), str(own or lesson.python / "server.py")]
    if options.reload:
        server = [sys.executable, str(ROOT / "kit.py"), "server", str(own or lesson.key), "--reload", "--"]
    server += [*given, *for_server]
    tap = tap_command(lesson, python) if options.watch else []
    tap += ["--frame", options.frame] if tap and options.frame else []
    return run(lesson.folder(options.folder), server, others, client, behind(lesson, python, for_server), tap)


def tap_command(lesson: Lesson, python: Path | str) -> list[str]:
    program, title = Lesson(EXTRA).python / "tap.py", f"Lesson {lesson.number:02}: {lesson.key[3:].replace('_', ' ')}"
    return [str(python), str(program), "--endpoint", "tcp://127.0.0.1:0", "--title", title]


def open_page(tap: Program) -> None:
    """Open it before there is a client, so that its first messages are seen as they pass."""
    page = tap.wait_for(r"^page at (\S+)")[1]
    opened = "--frame" not in tap.command and open_in_browser(page)
    say(f"{'opening' if opened else 'open'} {page} in a browser; the client starts then, or after {OPENING:.0f} s")
    try:
        tap.wait_for("^a page looks on$", OPENING)
    except KitError:
        say("no page is open; the client starts, and a page that is opened later shows the latest messages")


def open_in_browser(page: str) -> bool:
    # Without a display Python may find a browser that takes over this terminal.
    display = sys.platform in ("win32", "darwin") or {"DISPLAY", "WAYLAND_DISPLAY", "BROWSER"} & set(os.environ)
    return bool(display) and webbrowser.open(page)


def own_options(name: str, file: str) -> str:
    """The own options of a lesson's program, as its --help has them; sets up nothing."""
    lesson = find(name)
    python = python_setup.found(lesson.key)
    said = quietly([python, lesson.python / file, "--help"], 20).output if python else ""
    own = said.partition("options:\n")[2].rstrip()
    return f"options of {lesson.key}/{file}:\n{own}" if own else f"{file}'s own options are here once `run {name}` ran"


def server_command(lesson: Lesson, python: Path) -> list[str]:
    return [str(python), str(lesson.python / "server.py")]


def behind(lesson: Lesson, python: Path, words: list[str]) -> dict[str, list[str]]:
    """The servers that this one passes requests on to, by the option that says where, unless the words say it."""
    here = [(name, other) for name, other in lesson.behind if name not in words]
    return {name: [*server_command(other, python), "--endpoint", other.anywhere] for name, other in here}


def client_command(kind: str | None, lesson: Lesson, python: Path | None = None) -> list[str]:
    """The words that start a client. None: in C#, or without a .NET SDK or NetMQ in Python."""
    if kind == "python":
        return [str(python or python_setup.interpreter(lesson.key)), str(lesson.python / "client.py")]
    try:
        built = dotnet.build(dotnet.find_netmq())
    except dotnet.DoesNotCompile:
        raise
    except KitError as error:
        if kind:
            raise KitError(f"{error}; `--client python` runs without it") from None
        say(f"{error}; running the Python client instead")
        return client_command("python", lesson, python)
    unity = ["--unity"] if kind == "unity" else []
    return ["dotnet", str(built), lesson.key, *unity]


class Session:
    """The programs of a run: each is shown behind its name, and in the end all are ended, the newest first."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        self.started: list[Program] = []
        self.last = ""

    def start(self, name: str, command: list[str], stdin: int | None = DEVNULL) -> Program:
        program = Program(command, folder=self.folder, stdin=stdin, heard=functools.partial(self.hear, name))
        self.started.append(program)
        return program

    def hear(self, name: str, line: str) -> None:
        """The client's last line is the end of the story: it waits for what the server has still to say."""
        if name == "client":
            self.show_last()
        if name == "client" and line.startswith("done: "):
            self.last = line
        else:
            show(name, line)

    def show_last(self) -> None:
        if self.last:
            show("client", self.last)
        self.last = ""

    def end(self, moment: float) -> None:
        with uninterrupted():
            # The last one was waited for; any other one that has ended by now may have been killed.
            for program in self.started[:-1]:
                if program.process.poll() is not None:
                    wait(program.process, Path(program.command[1]).name)
            for program in reversed(self.started):
                program.end(moment)
            self.show_last()


Words = list[str]


def run(folder: Path, server: Words, others: list[Words], client: Words, behind: dict[str, Words], tap: Words) -> int:
    """Run both sides, and what else the lesson starts; returns the client's exit code, or without one the server's.

    A tap between them stays until Ctrl-C.
    """
    session = Session(folder)
    # A Ctrl-C before the client has ended is the end of the run.
    code, moment = 130, 0.0
    try:
        for name, command in behind.items():
            server = [*server, name, ready(session.start(name.strip("-"), command))["endpoint"]]
        serving = session.start("server", server)
        if not client:
            return wait(serving.process, "server")
        # The name of an endpoint is the name of the client's option, and of the script's field in Unity.
        addresses = ready(serving)
        if tap:
            watched = session.start("tap", [*tap, *(f"{name}={address}" for name, address in addresses.items())])
            addresses = ready(watched, "tap")
            open_page(watched)
        for number, other in enumerate(others, start=2):
            # The first client is the one that is asked for.
            name = Path(other[1]).stem
            name = f"{name} {number}" if name == "client" else name
            session.start(name, [*other, "--endpoint", addresses["endpoint"]])
        words = [word for name, address in addresses.items() for word in (f"--{name}", address)]
        # Its keyboard is the terminal's: lesson 08 is driven by it.
        code = wait(session.start("client", [*client, *words], stdin=None).process, "client")
        if tap:
            session.show_last()
            say(STAYS)
            wait(watched.process, "tap")
    except KeyboardInterrupt:
        # The terminal sends Ctrl-C to the programs too; they are given the time to end by themselves.
        moment = MOMENT
    finally:
        session.end(moment)
    return code


def ready(server: Program, name: str = "server") -> dict[str, str]:
    """Where it listens, once it does."""
    try:
        return server.endpoints()
    except KitError:
        if server.ended:
            # It may have been killed, which has no line of its own.
            wait(server.process, name)
            raise KitError(f"the {name} ended before it was ready; the line above says why") from None
        raise KitError(f"the {name} printed no ready line within {TIMEOUT:.0f} s; is the machine busy?") from None


def split(text: str, option: str) -> list[str]:
    """The words of an option that holds options for a program."""
    try:
        # On Windows a backslash is part of a path.
        return shlex.split(text.replace("\\", r"\\") if lessons.WINDOWS else text)
    except ValueError:
        raise UsageError(f'{option} {text}: a quotation mark in it is not closed; write {option}="…"') from None
