"""A build that is launched: found by its path on every system, and ended with all that it has started.

    words = program("Build/Game")           ["…/Build/Game.exe"], Game.app or Game.x86_64; FileNotFoundError
    process = start_program([*words, "-batchmode"])
    end_program(process)
    watch_launcher()                        in the build: it ends when the one that launched it does, in whatever way

A training that is killed can end nobody. So it gives to each simulator that it launches a pipe, as its standard input,
in which nothing ever comes but one byte at the beginning; and the system closes it when the training ends. In C# it is
Launcher.cs. It needs pyzmq.
"""

import contextlib
import functools
import gc
import glob
import logging
import os
import shutil
import signal
import subprocess
import sys
import threading
import time
from collections.abc import Sequence

from netmq_example.extras import shell
from netmq_example.finalizers import undisturbed

# Set for a program that was launched: the process id of the one that did it.
VARIABLE = "NETMQ_EXAMPLE_LAUNCHER"
# And where its views are awaited: not in its words, of which it would have to know each.
VIEWS = "NETMQ_EXAMPLE_VIEWS"
# They begin a program of Linux, a script, and programs of macOS, for one kind of processor or for several.
PROGRAMS = (b"\x7fELF", b"#!", b"\xcf\xfa\xed\xfe", b"\xca\xfe\xba\xbe")
# How long a program gets to end by itself.
END_SECONDS = 2
# Until when nobody is told again that an endpoint waits: each wrong hello ends an environment, and begins the next one.
QUIET: dict[str, float] = {}

log = logging.getLogger("netmq_example.envs")


def say_waiting(endpoint: str, cure: str) -> None:
    """For environments that launch nothing."""
    if time.monotonic() > QUIET.get(endpoint, 0.0):
        # A warning, which Python shows also where nobody has set up logging: the program would look stuck.
        log.warning("waiting for a simulator on %s%s", endpoint, cure)
        QUIET[endpoint] = time.monotonic() + 1


def program(launch: str | os.PathLike[str] | Sequence[str] | None) -> list[str]:
    """A program by its whole path, and its first words; nothing, where none is to be launched."""
    if launch is None:
        return []
    words = [launch] if isinstance(launch, str | os.PathLike) else launch
    listed = isinstance(words, Sequence) and all(isinstance(word, str | os.PathLike) for word in words)
    if not listed or not words or not words[0]:
        raise TypeError(f"launch takes a path, or a list of a program and its words, not {launch!r:.80}")
    return [game(words[0]), *(os.fspath(word) for word in words[1:])]


def game(path: str | os.PathLike[str]) -> str:
    """The program that is meant by a build's path: each system has an ending, or a folder, of its own for it."""
    path = os.fspath(path)
    found = shutil.which(path)
    if found:
        return os.path.abspath(found)
    ending = {"win32": ".exe", "darwin": ".app/Contents/MacOS/*"}.get(sys.platform, ".x86_64")
    for pattern in (glob.escape(path), glob.escape(path) + ending):
        for file in filter(os.path.isfile, sorted(glob.glob(pattern))):
            if not os.access(file, os.X_OK):
                make_executable(file)
            return os.path.abspath(file)
    cure = "; the .NET SDK brings it: https://dot.net" if path == "dotnet" else ""
    raise FileNotFoundError(f"no game at {path}: there is neither this file nor {path}{ending}{cure}")


def make_executable(file: str) -> None:
    """An unpacked archive may have lost the right to be executed. FileNotFoundError: it is no program."""
    with open(file, "rb") as opened:
        begin = opened.read(4)
    if begin.startswith(PROGRAMS):
        os.chmod(file, 0o755)
    elif not file.endswith(".exe"):
        raise FileNotFoundError(cannot_start(file, "it is no program"))


def cannot_start(file: str, why: str | None) -> str:
    cure = f"a script needs its program: launch=[sys.executable, {os.path.basename(file)!r}]"
    return f"launch cannot start {file}: {why}; {cure}"


def start_program(words: Sequence[str], views: str = "") -> subprocess.Popen[bytes]:
    """In a session of its own, so that all of it can be ended; Ctrl-C is then for Python alone, which ends it.

    Its standard input is a pipe of this process, from which it learns that this one has ended, in whatever way.
    """
    # An environment that nobody has any more, but what an interrupted cell of a notebook has left, ends its own now.
    undisturbed(gc.collect)
    environment = {**os.environ, VARIABLE: str(os.getpid()), VIEWS: views}
    try:
        process = subprocess.Popen(words, start_new_session=True, stdin=subprocess.PIPE, env=environment)
    except OSError as error:
        raise OSError(cannot_start(words[0], error.strerror)) from None
    # By this byte it knows that it is this pipe. One that has ended already says why by its code.
    with contextlib.suppress(OSError):
        os.write(process.stdin.fileno(), b"\n")  # type: ignore[union-attr]
    return process


def why_ended(process: subprocess.Popen[bytes] | None) -> str:
    """Why a launched program will not come; empty as long as it runs, and where none was launched."""
    code = process.poll() if process else None
    if process is None or code is None:
        return ""
    # In a notebook its own words are in another window.
    by_hand = shell(*process.args)  # type: ignore[misc]
    if not code:
        return f"the simulator ended with code 0, and never said hello: does it call run? {by_hand} in {os.getcwd()}"
    return f"the simulator ended with code {code}: in {os.getcwd()}, {by_hand} shows why"


def end_program(process: subprocess.Popen[bytes]) -> None:
    """Let it end by itself for a moment, then end what is left: the simulator may be a child, as of `dotnet run`."""
    try:
        process.wait(END_SECONDS)
    except subprocess.TimeoutExpired:
        pass
    finally:
        if sys.platform == "win32":
            # Its lines go nowhere: to read them needs threads, which from 3.12 on no program can start at its end.
            words = ["taskkill", "/T", "/F", "/PID", str(process.pid)]
            subprocess.run(words, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL, check=False)
        else:
            # There may be nobody left.
            with contextlib.suppress(OSError):
                os.killpg(process.pid, signal.SIGKILL)
        process.wait()
        if process.stdin:
            process.stdin.close()


@functools.cache
def watch_launcher() -> None:
    if os.environ.get(VARIABLE, "").isdecimal():
        threading.Thread(target=wait, args=(int(os.environ[VARIABLE]),), daemon=True).start()


def wait(launcher: int) -> None:
    try:
        # Without the byte it is no pipe of a training's: somebody has given this program another input.
        if not os.read(0, 1):
            while os.getppid() == launcher:
                time.sleep(0.5)
        while os.read(0, 1):
            pass
    except OSError:
        # The pipe is closed, too.
        pass
    # This program may be waiting for anything.
    os._exit(1)
