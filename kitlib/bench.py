"""The performance lab, `kit.py bench`: which work the contenders do, and what is kept of it."""

from __future__ import annotations

import datetime
import json
import os
import platform
import re
import shutil
import statistics
import subprocess
import sys
import time
from pathlib import Path
from typing import Any

from . import dotnet, python_setup, report
from .contest import (
    BARE,
    BUSY,
    GRPC,
    HELLO,
    HTTP,
    JSON,
    NAIVE,
    POOL,
    POOLED,
    SPIN,
    SUBSCRIBER,
    TCP,
    WEBSOCKET,
    Lab,
    elsewhere,
    many,
    progress,
)  # fmt: skip
from .lab import LIMIT, machine_is_busy
from .lessons import ROOT, KitError
from .terminal import say

SIZES = {"32 B": 32, "1 KB": 1024, "64 KB": 65536, "230,400 B": 230400, "2 MB": 2 << 20}
WINDOWS = (1, 4, 16, 64, 256)
# A picture of 320 x 240 points, each of three bytes.
PICTURE = 230400
# More work of others than this, or raw TCP that differs by more between rounds, and the run is called noisy.
BUSY_LIMIT, SPREAD_LIMIT = 0.1, 2.5


def bench(quick: bool, free: bool, engine: str | None) -> int:
    """Run everything, print the tables, keep the results and draw them."""
    if not dotnet.sdk():
        raise KitError(f"the lab's clients are C#, and there is {dotnet.DOWNLOAD}")
    python = python_setup.interpreter("tests", optional=("05_messages", "bench"))
    started = time.monotonic()
    lab = Lab(python, engines(engine), *((2, 0.04) if quick else (9, 0.2)), free=free)
    busy = machine_is_busy()
    try:
        for name in lab.engines:
            lab.program(name)
        works = [*echoes(lab), *other_work(lab, quick)]
        results = {
            "machine": machine(lab),
            "noise": noise(busy, works),
            "seconds": round(time.monotonic() - started),
            "works": works,
            "first": starts(lab, quick),
            "frames": frames(lab, 120 if quick else 600),
            "skipped": lab.skipped,
        }
    finally:
        lab.end()
    results["seconds"] = round(time.monotonic() - started)
    print(report.text(results))
    folder = ROOT / ".build" / "bench" if quick or free else ROOT / "img"
    folder.mkdir(parents=True, exist_ok=True)
    kept = folder / "performance.json"
    kept.write_text(json.dumps(results, indent=1) + "\n", encoding="utf-8")
    say(f"results: {kept.relative_to(ROOT)}")
    if python_setup.has(python, ["matplotlib"]):
        subprocess.run([str(python), "-m", "kitlib.plots", str(kept)], cwd=ROOT, check=True)
    else:
        say("no plots: they need a package: pip install matplotlib")
    return 0


def engines(asked: str | None) -> dict[str, dotnet.Engine]:
    """The client programs that can be built: the engine of this machine, the other one, and Mono."""
    engine = dotnet.choose_engine(asked)
    # What .NET's thread pool costs is seen in a program that uses it.
    found = {"dotnet": engine, "pool": engine}
    if engine.name == "netmq":
        found["offline"] = dotnet.Engine("libzmq", "to compare")
    if shutil.which("mono") and engine.framework.startswith("netstandard"):
        found["mono"] = engine
    return found


def echoes(lab: Lab) -> list[dict[str, Any]]:
    """Round trips of each size, first the small ones that everybody can do."""
    everywhere = [TCP, BARE, POOLED, NAIVE, WEBSOCKET, HTTP, GRPC, JSON]
    there = [*elsewhere("offline", "offline engine"), *elsewhere("mono", "on Mono")]
    found = []
    for title, size in SIZES.items():
        if size == 32:
            taking_part = [TCP, HELLO, SPIN, POOL, BUSY, *everywhere[1:], *map(many, WINDOWS), *there]
        else:
            taking_part = [*everywhere, *(each for each in there if not each.only_small)]
        found.append(lab.work(
            f"echo of {title}",
            taking_part,
            lambda each, endpoint, size=size: ["echo", each.name, endpoint, size, lab.moment],  # type: ignore[misc]
        ))  # fmt: skip
    return found


def other_work(lab: Lab, quick: bool) -> list[dict[str, Any]]:
    """One way, one to many, many to one, and a server that thinks."""
    found = [
        lab.work(
            "one way, frames of 230,400 B",
            [
                TCP,
                BARE,
                WEBSOCKET,
                JSON,
                *(each for each in elsewhere("offline", "offline engine") if each.name == "bare"),
            ],
            lambda each, endpoint: ["stream", each.name, endpoint, PICTURE, lab.moment],
        )
    ]
    for count in (1, 10, 100):
        found.append(lab.work(
            f"publish 32 B to {count}",
            [TCP, SUBSCRIBER, WEBSOCKET],
            lambda each, endpoint, count=count: [  # type: ignore[misc]
                "publish", f"{each.name}@{count}", endpoint, 32, (500 if quick else 10000) // count, count
            ],
        ))  # fmt: skip
    for count in (1, 10, 100) if quick else (1, 10, 100, 1000):
        found.append(lab.work(
            f"{count} clients, 32 B",
            [TCP, HELLO, BARE, WEBSOCKET, HTTP],
            lambda each, endpoint, count=count: ["echo", each.name, endpoint, 32, lab.moment, count],  # type: ignore[misc]
        ))  # fmt: skip
    found.append(lab.work(
        "a server that takes 10 ms",
        [HELLO, BUSY],
        lambda each, endpoint: ["echo", each.name, endpoint, 32, lab.moment],
        "--delay", "0.01",
    ))  # fmt: skip
    return found


def starts(lab: Lab, quick: bool) -> list[dict[str, Any]]:
    """Milliseconds from nothing to the first reply: a new connection in a program that runs, and whole programs."""
    found = []
    contenders = [TCP, HELLO, BARE, POOLED, WEBSOCKET, HTTP, GRPC, JSON]
    times: dict[str, list[float]] = {}
    for number in range(lab.rounds + 1):
        progress(f"first reply: round {number} of {lab.rounds}", last=number == lab.rounds)
        for each in lab.here(*contenders):
            answer = lab.program(each.program).ask("first", each.name, lab.server(each.server).endpoint, 32)
            if number > 0:
                times.setdefault(f"connection: {each.label}", []).append(answer["seconds"] * 1000)
    console = dotnet.build(lab.python, lab.engines["dotnet"])
    endpoint = lab.server(HELLO.server).endpoint
    for label, command in {
        "program: C# client": ["dotnet", str(console), "1"],
        "program: Python client": [str(lab.python), str(ROOT / "python" / HELLO.server / "client.py")],
    }.items():
        for _ in range(2 if quick else 7):
            start = time.perf_counter()
            subprocess.run(
                [*command, "--endpoint", endpoint, "--count", "1"], check=True, capture_output=True, timeout=LIMIT
            )
            times.setdefault(label, []).append((time.perf_counter() - start) * 1000)
    for label, values in times.items():
        found.append(
            {"label": label, "milliseconds": [round(pick(values), 2) for pick in (min, statistics.median, max)]}
        )
    return found


def frames(lab: Lab, count: int) -> list[dict[str, Any]]:
    """What lesson 04's client costs Unity's main thread in a frame, in the player at 60 frames a second."""
    found = []
    for name, client in lab.clients.items():
        if name in ("grpc", "pool"):
            continue
        endpoint = lab.server("04_background_client").endpoint
        said = " ".join(client.ask("frames", endpoint, count)["said"])
        numbers = re.search(
            r"mean ([\d.]+) ms, half below ([\d.]+) ms, 99 of 100 below ([\d.]+) ms, longest ([\d.]+) ms, (\d+) bytes",
            said,
        )
        if numbers is None:
            raise KitError(f"lesson 04 in the player measured nothing: {said[-200:]}")
        keys = ("mean", "half", "of_100_99", "longest", "bytes")
        found.append(
            {
                "label": report.RUNTIMES[name],
                "frames": count,
                **dict(zip(keys, map(float, numbers.groups()), strict=True)),
            }
        )
    return found


def noise(busy: float, works: list[dict[str, Any]]) -> list[str]:
    """Why not to trust this run, if there are reasons."""
    found = []
    if busy > BUSY_LIMIT:
        found.append(f"other programs used {busy:.0%} of the processor before it began")
    for work in works:
        least, _, greatest = next((row["rate"] for row in work["rows"] if row["label"] == TCP.label), (1, 1, 1))
        if greatest > SPREAD_LIMIT * least:
            found.append(f"{work['title']}: raw TCP made {least:.0f} to {greatest:.0f} a second")
    return found


def machine(lab: Lab) -> dict[str, str]:
    """What it was measured on and with."""

    def versions(*names: str) -> str:
        code = (
            f"import importlib.metadata as m\nfor n in {names!r}:\n"
            "  try: print(n, m.version(n))\n  except Exception: pass"
        )
        return ", ".join(
            subprocess.run([str(lab.python), "-c", code], capture_output=True, text=True).stdout.split("\n")[:-1]
        )

    model = platform.processor() or platform.machine()
    if sys.platform == "linux":
        model = next(iter(re.findall(r"model name\s*: (.*)", Path("/proc/cpuinfo").read_text())), model)
    libzmq = subprocess.run(
        [str(lab.python), "-c", "import zmq; print(zmq.zmq_version())"], capture_output=True, text=True
    )
    return {
        "date": datetime.date.today().isoformat(),
        "processor": f"{model}, {os.cpu_count()} cores",
        "system": f"{platform.system()} {platform.release()}",
        "cores": f"clients on {sorted(lab.client_cores)}, servers on {sorted(lab.server_cores)}"
        if lab.client_cores
        else "wherever the system puts them",
        "engine": lab.engines["dotnet"].name,
        "runtimes": f".NET SDK {dotnet.sdk()}, Python {platform.python_version()}"
        + (f", {mono_version()}" if "mono" in lab.engines else ""),
        "packages": f"libzmq {libzmq.stdout.strip()}, " + versions("pyzmq", "websockets", "aiohttp", "grpcio"),
    }


def mono_version() -> str:
    text = subprocess.run(["mono", "--version"], capture_output=True, text=True).stdout
    return "Mono " + "".join(re.findall(r"version ([\d.]+)", text)[:1])
