"""The performance lab, `kit.py bench`: which work the contenders do, and what is kept of it."""

from __future__ import annotations

import re
import shutil
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
    CLIENTS,
    CURVE,
    ECHOES,
    HELLO,
    SIGHTS,
    SSH,
    STEER,
    STEPS,
    Lab,
    elsewhere,
)
from lab.programs import LIMIT

# A picture of 320 x 240 points, each of three bytes.
PICTURE = 230400
SIZES = {"32 B": 32, "230,400 B": PICTURE}


def bench(quick: bool) -> int:
    """Run everything, print the tables, keep the results and draw them."""
    if not dotnet.sdk():
        raise KitError(f"{dotnet.download()}; the lab's clients are C#")
    lessons = ("05_messages", "08_see_and_steer", "09_environment")
    python = python_setup.interpreter("tests", optional=(*lessons, "bench"))
    started = time.monotonic()
    lab = Lab(python, programs(), *((2, 0.04) if quick else (9, 0.2)))
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
        works = [*echoes(lab), *other_work(lab)]
        results = {
            "machine": machine.about(lab),
            "noise": machine.noise(busy, works),
            "works": works,
            "frames": frames(lab, 120 if quick else 600),
            "skipped": lab.skipped,
            "seconds": round(time.monotonic() - started),
        }
    finally:
        lab.end()
    print(report.text(results))
    # What is kept is a full run's: its numbers with the lab, its pictures with the others.
    aside = ROOT / ".build" / "bench"
    numbers, pictures = (aside, aside) if quick else (ROOT / "lab", ROOT / "img")
    numbers.mkdir(parents=True, exist_ok=True)
    kept = numbers / "performance.json"
    kept.write_text(report.lines(results), encoding="utf-8")
    say(f"results: {kept.relative_to(ROOT)}")
    if python_setup.has(python, ["matplotlib"]):
        drawn = quietly([python, "-m", "lab.plots", kept, pictures], LIMIT, cwd=ROOT)
        if not drawn.ok:
            say(f"no plots: {drawn.first('Error')}")
    else:
        say("no plots: they need a package: pip install matplotlib")
    return 0


def programs() -> dict[str, dotnet.NetMQ]:
    """The client programs that run here: on .NET, and on Mono."""
    names = ["dotnet", *(["mono"] if shutil.which("mono") else [])]
    return dict.fromkeys(names, dotnet.find_netmq())


def echoes(lab: Lab) -> list[dict[str, Any]]:
    """Round trips of each size, first the small ones that everybody can do."""
    found = []
    for title, size in SIZES.items():
        everybody = [*ECHOES, *elsewhere("mono", "on Mono")]
        taking_part = [each for each in everybody if size == 32 or not each.only_small]
        found.append(lab.work(f"echo of {title}", taking_part, f"echo {{name}} {{endpoint}} {size} {lab.moment}"))
    return found


def other_work(lab: Lab) -> list[dict[str, Any]]:
    """A picture and an action, keys, a server that thinks, and steps of an environment."""
    echo = f"echo {{name}} {{endpoint}} {{size}} {lab.moment}"
    small, picture = (echo.replace("{size}", str(size)) for size in SIZES.values())
    return [
        lab.work("one server for several clients", CLIENTS, small),
        lab.work("a picture of 230,400 B, an action back", [BARE_ACTION, STEER], picture),
        lab.work("with keys, echo of 32 B", [BARE, CURVE], small),
        lab.work("with keys, echo of 230,400 B", [BARE, CURVE, SSH], picture),
        lab.work("with keys, echo of its JPEG file, 20,000 B", [BARE, CURVE, SSH], echo.replace("{size}", "20000")),
        lab.work("a server that takes 10 ms", [HELLO, BUSY], small, "--delay", "0.01"),
        lab.work(report.STEPS, STEPS, f"steps {{name}} {lab.moment}"),
        lab.work("steps with a camera's picture", SIGHTS, f"steps {{name}} {lab.moment}"),
    ]


def frames(lab: Lab, count: int) -> list[dict[str, Any]]:
    """The cost of lesson 04's client for Unity's main thread in a frame, in the player at 60 frames a second."""
    found = []
    for name, client in list(lab.clients.items()):
        if name in ("grpc", "trainer"):
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
            why = KitError(f"lesson 04 in the player measured nothing; it printed {said[-200:]}")
            lab.failed(name, report.FRAMES, why)
            continue
        keys = ("mean", "half", "of_100_99", "longest", "bytes")
        row: dict[str, Any] = {"label": report.RUNTIMES[name], "frames": count}
        found.append(row | dict(zip(keys, map(float, numbers.groups()), strict=True)))
    return found


if __name__ == "__main__":
    sys.exit(guarded(lambda: bench("--quick" in sys.argv)))
