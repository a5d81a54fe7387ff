"""One table of what is on this machine, each missing thing with its cure."""

import argparse
import errno
import glob
import os
import re
import socket
import sys
from collections.abc import Iterator
from contextlib import suppress
from pathlib import Path

from kitlib.lessons import BUILD, KIT, ROOT, KitError, Lesson, lessons, unwritable, writable
from kitlib.programs import quietly
from kitlib.setup import dotnet, python_setup
from kitlib.terminal import coloured, command

ABOUT = "Shows what is on this machine and what is missing, each missing thing with its cure."
EXAMPLES = ["doctor"]
# Where an emulator of Android listens, and where every adb looks for one.
ANDROID = (5554, 5555)
Row = tuple[bool, str, str]


def do(_: argparse.Namespace) -> int:
    # All of it first: what asks NuGet says so, and not in the middle of the table.
    for fine, what, finding in list(rows(python_setup.found())):
        mark = coloured("ok", "kit") if fine else coloured("--", "error")
        print(f"{mark}  {what:10} {finding}", flush=True)
    return 0


def rows(python: Path | None) -> Iterator[Row]:
    """(fine, what, finding) for each thing a lesson may need."""
    yield True, "Python", f"{sys.version.split()[0]} ({sys.executable})"
    fine = writable(BUILD)
    yield fine, "folder", str(ROOT) if fine else unwritable(BUILD)
    if python is None:
        yield False, "pyzmq", f"missing; `{KIT} run 1` installs it, or says what to run"
    else:
        code = "import zmq; print(zmq.__version__, 'with libzmq', zmq.zmq_version())"
        yield True, "pyzmq", f"{quietly([*python_setup.alone(python), '-c', code], 20).output.strip()} ({python})"
        yield from package_rows(python)
        for lesson in lessons():
            yield from optional_rows(python, lesson)
    yield from csharp_rows()
    mono = quietly(["mono", "--version"], 20)
    absent = "missing; only the Play/Stop tests use it (Debian: mono-devel)"
    yield mono.ok, "Mono", mono.first("version") if mono.ok else absent
    held = {lesson.port: why for lesson in lessons() if (why := not_free(lesson))}
    for port, why in held.items():
        yield False, f"port {port}", why
    yield True, "ports", f"those of {'the other' if held else 'all'} lessons are free"


def package_rows(python: Path) -> Iterator[Row]:
    """Each package once, with the lessons that need it."""
    users: dict[str, list[int]] = {}
    for lesson in lessons():
        for need in python_setup.needs(lesson.key)[len(python_setup.needs()) :]:
            users.setdefault(need, []).append(lesson.number)
    lacking = python_setup.lacking(python, list(users))
    for need, numbers in users.items():
        there = python_setup.name(need) not in lacking
        cure = "" if there else f"; missing: `{KIT} run {numbers[0]}` installs it"
        yield there, python_setup.name(need), f"needed by {', '.join(f'{number:02}' for number in numbers)}{cure}"


def optional_rows(python: Path, lesson: Lesson) -> Iterator[Row]:
    for part, needs in python_setup.large_extras(lesson).items():
        packages = [python_setup.name(need) for need in needs]
        missing = python_setup.not_found(python, packages)
        cure = f"no {', '.join(missing)}; `{command(python, '-m', 'pip', 'install', *missing)}` installs it"
        yield not missing, part, f"optional, for lesson {lesson.number:02}: {cure if missing else 'there'}"


def csharp_rows() -> Iterator[Row]:
    """The .NET SDK, and where NetMQ comes from."""
    sdk = dotnet.sdk()
    if not sdk:
        package = " (on Linux perhaps the package dotnet-sdk-8.0)" if sys.platform.startswith("linux") else ""
        yield False, ".NET SDK", f"{dotnet.download()}{package}; until then the Python clients run"
        return
    yield True, ".NET SDK", sdk
    try:
        yield True, "NetMQ", dotnet.find_netmq(ask_again=True).why
    except KitError as error:
        yield False, "NetMQ", f"{error}; until then the Python clients run"


def not_free(lesson: Lesson) -> str:
    """Why nobody can listen on the lesson's own port, with the cure; empty if somebody can."""
    port = lesson.port
    with socket.socket() as probe:
        # As libzmq listens; on Windows the option would mean sharing a taken port.
        if sys.platform != "win32":
            probe.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        try:
            probe.bind(("127.0.0.1", port))
            return ""
        except OSError as error:
            reserved = "the system reserves it (netsh int ipv4 show excludedportrange protocol=tcp); "
            why = reserved if error.errno in (errno.EACCES, 10013) else taken(port)
            return f"{why}use `{KIT} run {lesson.number} --endpoint {lesson.anywhere}`"


def taken(port: int) -> str:
    """By whom, where the system says so, and what to do."""
    if holders := listeners(port):
        return f"taken by {', '.join(holders)}; end it, or "
    android = ", perhaps by Android's emulator or adb" if port in ANDROID else ""
    shows = {"win32": f"netstat -ano | findstr :{port}", "linux": f"sudo ss -ltnp sport = :{port}"}
    return f"taken{android}; `{shows.get(sys.platform, f'lsof -nP -iTCP:{port} -sTCP:LISTEN')}` shows who; end it, or "


def listeners(port: int) -> list[str]:
    """The programs that listen on it, from Linux's /proc; of other users' programs only root hears."""
    tables = "".join(path.read_text() for path in map(Path, ("/proc/net/tcp", "/proc/net/tcp6")) if path.exists())
    inodes = re.findall(rf"^ *\d+: \w+:{port:04X} \S+ 0A(?: +\S+){{5}} +(\d+)", tables, re.MULTILINE)
    found = set()
    for file in glob.glob("/proc/[0-9]*/fd/*") if inodes else []:
        # It may be closed meanwhile, or not ours to see.
        with suppress(OSError):
            if os.readlink(file) in [f"socket:[{inode}]" for inode in inodes]:
                process = Path(file).parents[1]
                command = (process / "cmdline").read_text().replace("\0", " ").strip()
                found.add(f"{command} (process {process.name})")
    return sorted(found)
