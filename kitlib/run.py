"""Runs one lesson: the server, then the client, both shown line by line behind a prefix."""

from __future__ import annotations

import os
import queue
import re
import subprocess
import threading
import time
from collections.abc import Mapping
from pathlib import Path

from . import dotnet
from .lessons import ROOT, KitError, Lesson
from .terminal import later, say, show, uninterrupted

# A server prints its ready line within this many seconds, or something is wrong with it.
READY = 20.0
# The server is asked to end, and waited for this long.
GOODBYE = 5.0


class Side:
    """A running program whose lines appear behind its name."""

    def __init__(self, name: str, command: list[str], env: Mapping[str, str]) -> None:
        self.name = name
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
            env={**os.environ, "PYTHONUNBUFFERED": "1", "PYTHONIOENCODING": "utf-8", **env},
        )
        self.reader = threading.Thread(target=self.read, daemon=True)
        self.reader.start()

    def read(self) -> None:
        assert self.process.stdout
        for line in self.process.stdout:
            show(self.name, line.rstrip("\r\n"))
            self.lines.put(line)
        self.lines.put(None)

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
        if self.process.poll() is None:
            # SIGTERM on Linux and macOS; Windows knows only an end without asking.
            self.process.terminate()
            try:
                self.process.wait(GOODBYE)
            except subprocess.TimeoutExpired:
                self.process.kill()
                self.process.wait()
        self.reader.join(GOODBYE)


def client_command(kind: str, lesson: Lesson, python: Path, engine: str | None) -> list[str]:
    """The words that start a client; without a .NET SDK it is the Python one."""
    if kind != "python" and not dotnet.sdk():
        say(f"{dotnet.DOWNLOAD}; running the Python client instead")
        kind = "python"
    if kind == "python":
        return [str(python), str(lesson.python / "client.py")]
    choice = dotnet.choose_engine(engine)
    say(f"engine: {choice.name} ({choice.why})")
    unity = ["--unity"] if kind == "unity" else []
    return ["dotnet", str(dotnet.build(python, choice)), lesson.key, *unity]


def run(lesson: Lesson, python: Path, client: list[str], endpoint: str | None, server_options: list[str]) -> int:
    """Start the server, run the client against it, stop the server; returns the client's exit code."""
    given = ["--endpoint", endpoint] if endpoint else []
    started: list[Side] = []
    try:
        with later():
            started.append(Side("server", [str(python), str(lesson.python / "server.py"), *given, *server_options], {}))
        # The name of an endpoint is the name of the client's option, and of the script's field in Unity.
        for name, address in started[0].endpoints().items():
            client += ["--set", f"{name}={address}"] if "--unity" in client else [f"--{name}", address]
        with later():
            started.append(Side("client", client, {}))
        return started[-1].process.wait()
    except KeyboardInterrupt:
        # The terminal sends Ctrl-C to the programs too; they are given the time to end by themselves.
        return 130
    finally:
        with uninterrupted():
            for side in reversed(started):
                side.end()
