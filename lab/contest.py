"""The contenders of kit.py bench, and how they are compared: in rounds that take turns.

Each round lets every contender work for a moment, so that whatever else the machine does hits all of them alike; what
is compared is each contender's rate with that of raw TCP in the same round. The first round only warms up.
"""

from __future__ import annotations

import math
import os
import shutil
import statistics
import sys
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from kitlib.lessons import ROOT, KitError
from kitlib.setup import dotnet, python_setup
from lab.programs import Client, Server, halves

LAB = ROOT / "lab" / "contenders"


@dataclass(frozen=True)
class Contender:
    """One that takes part: a client program, what it is asked for, and the server it talks to."""

    label: str
    program: str
    name: str
    server: str
    # The package that its server needs, if any.
    package: str = ""
    only_small: bool = False


TCP = Contender("raw TCP", "dotnet", "tcp", "tcp")
HELLO = Contender("lesson 01", "dotnet", "hello", "01_request_reply", only_small=True)
BUSY = Contender("busy-wait client", "dotnet", "busy", "01_request_reply", only_small=True)
BARE = Contender("NetMQ alone", "dotnet", "bare", "zmq")
NAIVE = Contender("lesson 05, naive", "dotnet", "naive", "05_messages")
POOLED = Contender("lesson 05, pooled", "dotnet", "pooled", "05_messages")
STEER = Contender("lesson 08", "dotnet", "steer", "steer")
BARE_ACTION = Contender(BARE.label, "dotnet", "bare@200", "zmq")
CURVE = Contender("NetMQ with CURVE", "dotnet", "curve", "curve")
SSH = Contender("NetMQ through SSH", "dotnet", "bare", "ssh")
HTTP = Contender("HTTP, aiohttp", "dotnet", "http", "http", "aiohttp")
WEBSOCKET = Contender("WebSocket, websockets", "dotnet", "websocket", "websocket", "websockets")
GRPC = Contender("gRPC, Python both sides", "grpc", "grpc", "grpc", "grpcio")
JSON = Contender("JSON lines, Base64", "dotnet", "json", "json")
MANY = Contender("lesson 06, 64 in flight", "dotnet", "many@64", "06_many_in_flight", only_small=True)
# Each client with the same server: those of the lessons differ in more than their clients.
CLIENTS = [
    Contender("lesson 01", "dotnet", "hello", "world"),
    Contender("lesson 02", "dotnet", "pirate", "world"),
    Contender("lesson 04, one at a time", "dotnet", "background", "world"),
]
ECHOES = [TCP, HELLO, BARE, POOLED, NAIVE, WEBSOCKET, HTTP, GRPC, JSON, MANY]
# A trainer that launches its simulators itself: there is no server to start.
STEPS = [
    Contender("Gymnasium's own, in process", "trainer", "own", "", "gymnasium"),
    Contender(BARE.label, "trainer", "echo", "", "gymnasium"),
    Contender("lesson 09, C#", "trainer", "csharp", "", "gymnasium"),
    Contender("lesson 09, Python both sides", "trainer", "python", "", "gymnasium"),
    Contender("ML-Agents' UnityEnvironment, C#", "trainer", "mlagents", "", "gymnasium"),
    *(
        Contender(label.format(count), "trainer", f"{name}@{count}", "", package)
        for count in (16, 64, 256)
        for label, name, package in (
            ("Gymnasium's own, {} in process", "own", "gymnasium"),
            (BARE.label + ", {} agents' bytes", "echo", "gymnasium"),
            ("lesson 10, {} agents, C#", "csharp", "gymnasium"),
        )
    ),
    Contender("ML-Agents' UnityEnvironment, 16 agents, C#", "trainer", "mlagents@16", "", "gymnasium"),
    *(
        Contender(label.format(count), "trainer", f"{name}@{count}", "", "stable-baselines3")
        for count in (16, 64)
        for label, name in (("DummyVecEnv, {} in process", "dummy"), ("UnityVecEnv, {} agents, C#", "sb3"))
    ),
    Contender("lesson 11, C#", "trainer", "coins", "", "gymnasium"),
    Contender("lesson 11, 16 agents, C#", "trainer", "coins@16", "", "gymnasium"),
    Contender("lesson 09, in frames", "trainer", "player", "", "gymnasium"),
    Contender("one in frames, async", "trainer", "async@1", "", "gymnasium"),
    Contender("two in frames, async", "trainer", "async@2", "", "gymnasium"),
    Contender("four in frames, sync", "trainer", "sync@4", "", "gymnasium"),
    *(Contender(f"in frames, thinking {ms} ms", "trainer", f"player+{ms}", "", "gymnasium") for ms in (2, 5, 20)),
]
# Each sees a picture of width and height, and does nothing.
SIGHTS = [
    Contender(f"{label}, {width} x {height}{also}", "trainer", f"{name}{width}x{height}{at}", "", "gymnasium")
    for width, height in ((64, 48), (84, 84))
    for also, at in (("", ""), (", 16 agents", "@16"))
    for label, name in ((BARE.label, "echo"), ("lesson 09, C#", "see"))
]


def elsewhere(program: str, where: str) -> list[Contender]:
    """The same clients in another program: on Mono."""
    return [
        Contender(f"{each.label}, {where}", program, each.name, each.server, only_small=each.only_small)
        for each in (TCP, HELLO, MANY, BARE, POOLED)
    ]


@dataclass
class Row:
    """The results of one contender in one kind of work, a value for each round."""

    label: str
    rates: list[float] = field(default_factory=list)
    ratios: list[float] = field(default_factory=list)
    waits: list[float] = field(default_factory=list)
    # Processor time in microseconds of the client and of the server, and how often their threads went to sleep.
    spent: list[float] = field(default_factory=lambda: [0.0] * 4)
    messages: int = 0

    def add(self, answer: dict[str, Any], spent: list[float]) -> None:
        """The next round, as the client program has answered, and what both programs have used."""
        self.rates.append(answer["messages"] / answer["seconds"])
        self.waits += answer["waits"]
        self.messages += answer["messages"]
        self.spent = [before + now for before, now in zip(self.spent, spent, strict=True)]

    def compare(self, limit: Row | None) -> None:
        """The ratio of this round to raw TCP's, if raw TCP takes part."""
        if limit and self.rates and len(self.ratios) < len(self.rates):
            self.ratios.append(self.rates[-1] / limit.rates[-1])

    def result(self) -> dict[str, Any]:
        """Numbers to print and to draw: messages a second, ratios to raw TCP, microseconds."""
        waits = sorted(self.waits)
        each = [None if math.isnan(total) else float(f"{total / self.messages:.4g}") for total in self.spent]
        return {
            "label": self.label,
            "rate": three(self.rates),
            "ratio": three(self.ratios) if self.ratios else None,
            "latency": {f"p{share}": below(waits, share) for share in (50, 99, 99.9)} if len(waits) > 20 else None,
            "client_cpu": each[0],
            "server_cpu": each[1],
            "client_sleeps": each[2],
            "server_sleeps": each[3],
        }


def three(values: list[float]) -> list[float]:
    """The least, the middle and the greatest."""
    return [float(f"{value:.4g}") for value in (min(values), statistics.median(values), max(values))]


def below(waits: list[float], share: float) -> float:
    return waits[min(len(waits) - 1, int(len(waits) * share / 100))]


class Lab:
    """Everything that runs: the servers once each, and a client program for each runtime."""

    def __init__(self, python: Path, builds: dict[str, dotnet.NetMQ], rounds: int, moment: float) -> None:
        self.python, self.builds = python, builds
        # How often each contender has its turn, and for how many seconds.
        self.rounds, self.moment = rounds, moment
        self.client_cores, self.server_cores = halves()
        self.skipped: dict[str, str] = {}
        self.installed: dict[str, bool] = {}
        self.servers: dict[str, Server] = {}
        self.clients: dict[str, Client] = {}

    def program(self, name: str) -> Client:
        """A client program, started when it is first needed."""
        if name not in self.clients:
            cores = self.client_cores
            if name == "grpc":
                command = [str(self.python), str(LAB / "grpc_client.py")]
            elif name == "trainer":
                netmq = self.builds["dotnet"]
                dlls = [dotnet.build(netmq), dotnet.build(netmq, ROOT / "lab" / "csharp")]
                # The simulators that it launches would have to share its cores.
                command, cores = [str(self.python), str(LAB / "trainer.py"), *map(str, dlls)], set()
            else:
                dll = dotnet.build(self.builds[name], ROOT / "lab" / "csharp")
                command = ["mono" if name == "mono" else "dotnet", str(dll)]
            self.clients[name] = Client(command, cores)
        return self.clients[name]

    def server(self, name: str, *options: str) -> Server:
        """A server with these options, started when it is first needed. Lessons' servers print no line per reply."""
        key = " ".join([name, *options])
        if key not in self.servers:
            words = list(options)
            if name[:2].isdigit():
                script = ROOT / "python" / name / "server.py"
                quiet = ["--quiet"] if name in (HELLO.server, POOLED.server) else []
                words = ["--endpoint", "tcp://127.0.0.1:0", *quiet, *options]
            else:
                script = LAB / f"{name}_server.py"
            self.servers[key] = Server(self.python, script, words, self.server_cores)
        return self.servers[key]

    def here(self, *contenders: Contender) -> list[Contender]:
        """Those that can run on this machine; the others are kept in `skipped` with the reason."""
        return [each for each in contenders if not self.missing(each)]

    def missing(self, each: Contender) -> bool:
        need = python_setup.requirement(each.package)
        if need not in self.installed:
            self.installed[need] = not each.package or python_setup.has(self.python, [need])
        if not self.installed[need]:
            self.skipped[each.label] = f'it needs a package: pip install "{need}"'
        elif each.server == "ssh" and not shutil.which("sshd", path=f"{os.environ['PATH']}{os.pathsep}/usr/sbin"):
            self.skipped[each.label] = "it needs sshd: install openssh-server"
        elif each.program not in ("grpc", "trainer") and each.program not in self.builds:
            self.skipped[each.label] = "this machine has none"
        return each.label in self.skipped

    def work(self, title: str, contenders: list[Contender], line: str, *options: str) -> dict[str, Any]:
        """Rounds of one kind of work: what a client program is told, with {name} and {endpoint}; `options` are for
        the servers."""
        rows = {each: Row(each.label) for each in self.here(*contenders)}
        for number in range(self.rounds + 1):
            progress(f"{title}: round {number} of {self.rounds}", last=number == self.rounds)
            for each, row in list(rows.items()):
                try:
                    client = self.program(each.program)
                    server = self.server(each.server, *options) if each.server else None
                    sides = [client, server] if server else [client]
                    before = [side.spent() for side in sides]
                    answer = client.ask(line.format(name=each.name, endpoint=server.endpoint if server else ""))
                    used = [side.spent().since(then) for side, then in zip(sides, before, strict=True)]
                    used += [(math.nan, math.nan)] * (2 - len(used))
                except KitError as error:
                    self.failed(each.label, title, error)
                    del rows[each]
                    continue
                if number > 0:
                    row.add(answer, [each for pair in zip(*used, strict=True) for each in pair])
            for row in rows.values():
                row.compare(rows.get(TCP))
        for name, client in list(self.clients.items()):
            try:
                client.ask("close")
            except KitError as error:
                self.failed(name, title, error)
        return {"title": title, "rows": [row.result() for row in rows.values()]}

    def failed(self, label: str, title: str, error: KitError) -> None:
        """One contender less: keep why. A program that has ended is started anew when it is next needed."""
        self.skipped[f"{label} ({title})"] = str(error)
        for programs in (self.clients, self.servers):
            for name, program in list(programs.items()):
                if program.process.poll() is not None:
                    program.end()
                    del programs[name]

    def end(self) -> None:
        """End every program."""
        for process in [*self.clients.values(), *self.servers.values()]:
            process.end()


def progress(text: str, last: bool) -> None:
    """What happens now: a line that is written over on a terminal, and one line at the end elsewhere."""
    if sys.stdout.isatty():
        print(f"\r{text:78}", end="\n" if last else "", flush=True)
    elif last:
        print(text, flush=True)
