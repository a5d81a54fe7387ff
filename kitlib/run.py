"""Runs one lesson: the server, then the client, both shown line by line behind a prefix."""

from __future__ import annotations

import os
import queue
import re
import subprocess
import threading
import time
from pathlib import Path
from typing import Any

from kitlib.lessons import ROOT, WINDOWS, KitError, Lesson
from kitlib.setup import dotnet
from kitlib.terminal import GROUP, READABLE, ask_to_end, later, say, show, uninterrupted, wait

# A server prints its ready line within this many seconds, or something is wrong with it.
READY = 60.0
# The server is asked to end, and waited for this long.
GOODBYE = 5.0


class Side:
    """A running program whose lines appear behind its name."""

    def __init__(self, name: str, command: list[str]) -> None:
        self.name = name
        self.last = ""
        self.lines: queue.Queue[str | None] = queue.Queue()
        self.process = subprocess.Popen(
            command,
            cwd=ROOT,
            stdin=subprocess.DEVNULL,
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            text=True,
            encoding="utf-8",
            errors="replace",
            env={**os.environ, **READABLE},
            **(GROUP if WINDOWS else {}),
        )
        self.reader = threading.Thread(target=self.read, daemon=True)
        self.reader.start()

    def read(self) -> None:
        assert self.process.stdout
        for line in self.process.stdout:
            self.show_last()
            if self.name == "client" and line.startswith("done: "):
                # The end of the story: it waits for what the server has still to say.
                self.last = line
            else:
                show(self.name, line.rstrip("\r\n"))
            self.lines.put(line)
        self.lines.put(None)

    def show_last(self) -> None:
        """Show the line that was held back, if there is one."""
        if self.last:
            show(self.name, self.last.rstrip("\r\n"))
            self.last = ""

    def endpoints(self) -> dict[str, str]:
        """What the ready line says the server listens on, and where else by the lines before: `snapshots on E2`."""
        found: dict[str, str] = {}
        deadline = time.monotonic() + READY
        while True:
            try:
                line = self.lines.get(timeout=max(0.0, deadline - time.monotonic()))
            except queue.Empty:
                raise KitError(f"the server printed no ready line within {READY:.0f} s") from None
            if line is None:
                raise KitError("the server ended before it was ready; its own line above says why")
            if ready := re.match(r"(\w+) on (tcp://\S+)$", line):
                if ready[1] == "listening":
                    return {"endpoint": ready[2], **found}
                found[ready[1]] = ready[2]

    def end(self) -> None:
        """End it if it still runs, and let its last lines appear."""
        stop(self.process)
        self.reader.join(GOODBYE)


def stop(process: subprocess.Popen[Any]) -> None:
    """Ask a program to end if it still runs; what does not listen is ended all the same."""
    if process.poll() is None:
        ask_to_end(process)
        try:
            process.wait(GOODBYE)
        except subprocess.TimeoutExpired:
            process.kill()
            process.wait()


def client_command(kind: str, lesson: Lesson, python: Path, engine: str | None) -> list[str]:
    """The words that start a client; without a .NET SDK it is the Python one."""
    if kind != "python" and not dotnet.sdk():
        say(f"{dotnet.DOWNLOAD}; running the Python client instead")
        kind = "python"
    if kind == "python":
        return [str(python), str(lesson.python / "client.py")]
    try:
        choice = dotnet.choose_engine(engine)
    except dotnet.NoEngine as error:
        say(f"{error}; running the Python client instead")
        return [str(python), str(lesson.python / "client.py")]
    say(f"engine: {choice.name} ({choice.why})")
    unity = ["--unity"] if kind == "unity" else []
    return ["dotnet", str(dotnet.build(python, choice)), lesson.key, *unity]


def run(lesson: Lesson, python: Path, client: list[str], endpoint: str | None, server_options: list[str]) -> int:
    """Start the server, run the client against it, stop the server; returns the client's exit code."""
    given = ["--endpoint", endpoint] if endpoint else []
    started: list[Side] = []
    try:
        with later():
            started.append(Side("server", [str(python), str(lesson.python / "server.py"), *given, *server_options]))
        # The name of an endpoint is the name of the client's option, and of the script's field in Unity.
        for name, address in started[0].endpoints().items():
            client += ["--set", f"{name}={address}"] if "--unity" in client else [f"--{name}", address]
        with later():
            started.append(Side("client", client))
        return wait(started[-1].process)
    except KeyboardInterrupt:
        # The terminal sends Ctrl-C to the programs too; they are given the time to end by themselves.
        return 130
    finally:
        with uninterrupted():
            for side in reversed(started):
                side.end()
            if started:
                started[-1].show_last()


def alone(command: list[str]) -> int:
    """Run one program in this terminal, whose Ctrl-C reaches it as well; returns its exit code."""
    process: subprocess.Popen[bytes] | None = None
    try:
        with later():
            process = subprocess.Popen(command, cwd=ROOT, env={**os.environ, **READABLE})
        return wait(process)
    except KeyboardInterrupt:
        return 130
    finally:
        if process:
            with uninterrupted():
                try:
                    process.wait(GOODBYE / 5)
                except subprocess.TimeoutExpired:
                    stop(process)
