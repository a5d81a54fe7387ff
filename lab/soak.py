"""Whether programs that run for long keep their size: python3 -m lab.soak [MINUTES], an hour if not said. On Linux.

Servers and C# clients talk at the rate of a game, those of lessons 04 and 08 in the kit's player, and lesson 04's
server is killed and started again every five minutes. What each program holds after a tenth of the time, when it is
warm, stands beside what it holds at the end.
"""

import os
import re
import sys
import time
from contextlib import suppress
from pathlib import Path

from kitlib.commands import guarded
from kitlib.commands.run import client_command, server_command
from kitlib.lessons import KitError, find
from kitlib.programs import Program
from kitlib.setup import python_setup

# Lessons, the options of their servers, where their clients run, and options with which these come to no end.
COUNT = ["--count", "1000000000"]
# A machine that stalls for some seconds must not end the hour.
PATIENT = [*COUNT, "--timeout", "60"]
PAIRS = {
    "01": (["--delay", "0.01"], "csharp", PATIENT),
    "03": ([], "csharp", PATIENT),
    "04": ([], "unity", COUNT),
    "07": ([], "csharp", [*PATIENT, "--seconds", "80000"]),
    "08": ([], "unity", COUNT),
}
KILLED, EVERY = "04", 300.0


def soak(minutes: float) -> int:
    """Run them, and print the table."""
    python = python_setup.interpreter("tests", optional=("08_see_and_steer",))
    running: dict[str, Program] = {}
    try:
        for number, (options, kind, endless) in PAIRS.items():
            server = Program([*server_command(find(number), python), "--endpoint", "tcp://127.0.0.1:0", *options])
            running[f"{number} server"] = server
            places = [word for name, place in server.endpoints().items() for word in (f"--{name}", place)]
            client = [*client_command(kind, find(number), python), *places, *endless]
            running[f"{number} client, {kind}"] = Program(client)
        server = running[f"{KILLED} server"]
        again = [*server.command[:2], "--endpoint", server.endpoints()["endpoint"], *PAIRS[KILLED][0]]
        started = time.monotonic()
        warm: dict[str, list[int]] = {}
        kills = 0
        while (passed := time.monotonic() - started) < minutes * 60:
            time.sleep(1)
            for name, program in running.items():
                if program.ended:
                    raise KitError(f"{name} has ended; its last lines: {program.lines[-3:]}")
                del program.lines[:-3]
            if not warm and passed > minutes * 6:
                warm = {name: held(program) for name, program in running.items()}
            if passed > EVERY * (kills + 1) and passed < minutes * 60 - EVERY:
                kills += 1
                running[f"{KILLED} server"].process.kill()
                running[f"{KILLED} server"].end()
                running[f"{KILLED} server"] = Program(again)
        print(f"{minutes:g} minutes; lesson {KILLED}'s server was killed {kills} times")
        print(f"{'':26}{'memory':>16}{'threads':>14}{'open files':>14}")
        for name, program in running.items():
            megabytes, threads, files = zip(warm[name], held(program), strict=True)
            print(f"{name:26}{row(megabytes, ' MB'):>16}{row(threads):>14}{row(files):>14}")
    finally:
        for program in reversed(running.values()):
            with suppress(KitError):
                program.end()
    return 0


def held(program: Program) -> list[int]:
    """Its memory in MB, its threads, and its open files."""
    folder = Path(f"/proc/{program.process.pid}")
    status = (folder / "status").read_text()
    memory, threads = (int(re.findall(rf"^{name}:\s+(\d+)", status, re.M)[0]) for name in ("VmRSS", "Threads"))
    return [round(memory / 1024), threads, len(os.listdir(folder / "fd"))]


def row(pair: tuple[int, ...], unit: str = "") -> str:
    return f"{pair[0]} -> {pair[1]}{unit}"


if __name__ == "__main__":
    sys.exit(guarded(lambda: soak(float(sys.argv[1]) if len(sys.argv) > 1 else 60)))
