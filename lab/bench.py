"""The performance lab, `kit.py bench`: which work the contenders do, and what is kept of it."""

from __future__ import annotations

import json
import re
import shutil
import statistics
import sys
import time
from typing import Any

from kitlib.commands import guarded
from kitlib.lessons import ROOT, KitError
from kitlib.programs import quietly
from kitlib.setup import dotnet, python_setup
from kitlib.terminal import say
from lab import machine, report
from lab.contest import (
    BARE,
    BARE_ACTION,
    BUSY,
    BY_SOCKETIO,
    BY_TAP,
    BY_WATCHED_TAP,
    BY_WEBSOCKET,
    CURVE,
    FAST,
    GRPC,
    HELLO,
    HTTP,
    JSON,
    NAIVE,
    POOL,
    POOLED,
    SPIN,
    STEER,
    STEPS,
    SUBSCRIBER,
    TCP,
    WEBSOCKET,
    Lab,
    elsewhere,
    many,
    progress,
)  # fmt: skip
from lab.programs import LIMIT

SIZES = {"32 B": 32, "1 KB": 1024, "64 KB": 65536, "230,400 B": 230400, "2 MB": 2 << 20}
WINDOWS = (1, 4, 16, 64, 256)
# A picture of 320 x 240 points, each of three bytes.
PICTURE = 230400


def bench(quick: bool, free: bool) -> int:
    """Run everything, print the tables, keep the results and draw them."""
    if not dotnet.sdk():
        raise KitError(f"the lab's clients are C#, and there is {dotnet.DOWNLOAD}")
    lessons = ("05_messages", "08_see_and_steer", "09_environment", "16_web_gateway")
    python = python_setup.interpreter("tests", optional=(*lessons, "bench"))
    started = time.monotonic()
    lab = Lab(python, programs(), *((2, 0.04) if quick else (9, 0.2)), free=free)
    busy = machine.busy()
    try:
        for name in list(lab.builds):
            try:
                lab.program(name).ask("close")
            except KitError as error:
                if name == "dotnet":
                    raise
                lab.failed(name, "its program", error)
                del lab.builds[name]
        works = [*echoes(lab), *other_work(lab, quick)]
        results = {
            "machine": machine.about(lab),
            "noise": machine.noise(busy, works),
            "works": works,
            "first": starts(lab, quick),
            "frames": frames(lab, 120 if quick else 600),
            "skipped": lab.skipped,
            "seconds": round(time.monotonic() - started),
        }
    finally:
        lab.end()
    print(report.text(results))
    # What is kept is a full run's: its numbers with the lab, its pictures with the others.
    aside = ROOT / ".build" / "bench"
    numbers, pictures = (aside, aside) if quick or free else (ROOT / "lab", ROOT / "img")
    numbers.mkdir(parents=True, exist_ok=True)
    kept = numbers / "performance.json"
    kept.write_text(json.dumps(results, indent=1) + "\n", encoding="utf-8")
    say(f"results: {kept.relative_to(ROOT)}")
    if python_setup.has(python, ["matplotlib"]):
        drawn = quietly([python, "-m", "lab.plots", kept, pictures], LIMIT, cwd=ROOT)
        say(drawn.output.strip() if drawn.ok else f"no plots: {drawn.first('Error')}")
    else:
        say("no plots: they need a package: pip install matplotlib")
    return 0


def programs() -> dict[str, dotnet.NetMQ]:
    """The client programs that run here: on .NET, with its thread pool, and on Mono."""
    names = ["dotnet", "pool", *(["mono"] if shutil.which("mono") else [])]
    return dict.fromkeys(names, dotnet.find_netmq())


def echoes(lab: Lab) -> list[dict[str, Any]]:
    """Round trips of each size, first the small ones that everybody can do."""
    everywhere = [TCP, BARE, POOLED, NAIVE, WEBSOCKET, HTTP, GRPC, JSON]
    there = elsewhere("mono", "on Mono")
    found = []
    for title, size in SIZES.items():
        if size == 32:
            taking_part = [TCP, HELLO, SPIN, POOL, BUSY, *everywhere[1:], *map(many, WINDOWS), FAST, *there]
        else:
            taking_part = [*everywhere, *(each for each in there if not each.only_small)]
        found.append(lab.work(f"echo of {title}", taking_part, f"echo {{name}} {{endpoint}} {size} {lab.moment}"))
    return found


def other_work(lab: Lab, quick: bool) -> list[dict[str, Any]]:
    """One way, one to many, many to one, and a server that thinks."""
    one_way = [TCP, BARE, WEBSOCKET, JSON]
    stream = f"stream {{name}} {{endpoint}} {PICTURE} {lab.moment}"
    found = [lab.work("one way, frames of 230,400 B", one_way, stream)]
    picture = f"echo {{name}} {{endpoint}} {PICTURE} {lab.moment}"
    found.append(lab.work("a picture of 230,400 B, an action back", [BARE_ACTION, STEER], picture))
    for title, size in SIZES.items():
        if size in (32, PICTURE):
            line = f"echo {{name}} {{endpoint}} {size} {lab.moment}"
            found.append(lab.work(f"with keys, echo of {title}", [BARE, CURVE], line))
    echo = f"echo {{name}} {{endpoint}} 32 {lab.moment}"
    found.append(lab.work(report.GATEWAY, [HELLO, BY_WEBSOCKET, BY_SOCKETIO], echo))
    found.append(lab.work(report.TAP, [HELLO, BY_TAP, BY_WATCHED_TAP], echo))
    for count in (1, 10, 100):
        publish = f"publish {{name}}@{count} {{endpoint}} 32 {(500 if quick else 10000) // count} {count}"
        found.append(lab.work(f"publish 32 B to {count}", [TCP, SUBSCRIBER, WEBSOCKET], publish))
    for count in (1, 10, 100) if quick else (1, 10, 100, 1000):
        found.append(lab.work(f"{count} clients, 32 B", [TCP, HELLO, BARE, WEBSOCKET, HTTP], f"{echo} {count}"))
    found.append(lab.work("a server that takes 10 ms", [HELLO, BUSY], echo, "--delay", "0.01"))
    found.append(lab.work(report.STEPS, STEPS, f"steps {{name}} {lab.moment}"))
    return found


def starts(lab: Lab, quick: bool) -> list[dict[str, Any]]:
    """Milliseconds from nothing to the first reply: a new connection in a program that runs, and whole programs."""
    contenders = [TCP, HELLO, BARE, POOLED, WEBSOCKET, HTTP, GRPC, JSON]
    times: dict[str, list[float]] = {}
    failed: set[str] = set()
    for number in range(lab.rounds + 1):
        progress(f"first reply: round {number} of {lab.rounds}", last=number == lab.rounds)
        for each in lab.here(*contenders):
            if each.label in failed:
                continue
            try:
                answer = lab.program(each.program).ask(f"first {each.name} {lab.server(each.server).endpoint} 32")
            except KitError as error:
                failed.add(each.label)
                lab.failed(each.label, report.FIRST, error)
                continue
            if number > 0:
                times.setdefault(f"connection: {each.label}", []).append(answer["seconds"] * 1000)
    console = dotnet.build(lab.builds["dotnet"])
    endpoint = lab.server(HELLO.server).endpoint
    for label, command in {
        "program: C# client": ["dotnet", str(console), "1"],
        "program: Python client": [str(lab.python), str(ROOT / "python" / HELLO.server / "client.py")],
    }.items():
        for _ in range(2 if quick else 7):
            start = time.perf_counter()
            done = quietly([*command, "--endpoint", endpoint, "--count", "1"], LIMIT)
            if not done.ok:
                lab.failed(label, report.FIRST, KitError(done.first("gave up")))
                break
            times.setdefault(label, []).append((time.perf_counter() - start) * 1000)
    return [
        {"label": label, "milliseconds": [round(pick(values), 2) for pick in (min, statistics.median, max)]}
        for label, values in times.items()
    ]


def frames(lab: Lab, count: int) -> list[dict[str, Any]]:
    """What lesson 04's client costs Unity's main thread in a frame, in the player at 60 frames a second."""
    found = []
    for name, client in list(lab.clients.items()):
        if name in ("grpc", "pool", "trainer"):
            continue
        try:
            endpoint = lab.server("04_background_client").endpoint
            said = " ".join(client.ask(f"frames {endpoint} {count}")["said"])
        except KitError as error:
            lab.failed(name, report.FRAMES, error)
            continue
        numbers = re.search(
            r"mean ([\d.]+) ms, half below ([\d.]+) ms, 99 of 100 below ([\d.]+) ms, longest ([\d.]+) ms, (\d+) bytes",
            said,
        )
        if numbers is None:
            why = KitError(f"lesson 04 in the player measured nothing: {said[-200:]}")
            lab.failed(name, report.FRAMES, why)
            continue
        keys = ("mean", "half", "of_100_99", "longest", "bytes")
        found.append(
            {
                "label": report.RUNTIMES[name],
                "frames": count,
                **dict(zip(keys, map(float, numbers.groups()), strict=True)),
            }
        )
    return found


if __name__ == "__main__":
    sys.exit(guarded(lambda: bench("--quick" in sys.argv, "--free" in sys.argv)))
