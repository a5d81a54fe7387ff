"""The machine and the versions that the lab measured with, and why not to trust a run."""

from __future__ import annotations

import datetime
import json
import math
import os
import platform
import re
import subprocess
import sys
import time
from pathlib import Path
from typing import Any

from kitlib.setup import dotnet
from lab.contest import TCP, Lab

# More work of others than this, or raw TCP that differs by more between rounds, and the run is called noisy.
BUSY_LIMIT, SPREAD_LIMIT = 0.1, 2.5


def busy(seconds: float = 1.0) -> float:
    """How much of all cores others use while we do nothing, 0 to 1; nan where the system does not say."""

    def now() -> list[int]:
        return [int(word) for word in Path("/proc/stat").read_text().splitlines()[0].split()[1:9]]

    if sys.platform != "linux":
        return math.nan
    before = now()
    time.sleep(seconds)
    spent = [b - a for a, b in zip(before, now(), strict=True)]
    return 1 - (spent[3] + spent[4]) / max(1, sum(spent))


def noise(share: float, works: list[dict[str, Any]]) -> list[str]:
    """Why not to trust this run, if there are reasons; `share` is what busy() has found before it."""
    found = []
    if share > BUSY_LIMIT:
        found.append(f"other programs used {share:.0%} of the processor before it began")
    for work in works:
        least, _, greatest = next((row["rate"] for row in work["rows"] if row["label"] == TCP.label), (1, 1, 1))
        if greatest > SPREAD_LIMIT * least:
            found.append(f"{work['title']}: raw TCP made {least:.0f} to {greatest:.0f} a second")
    return found


def about(lab: Lab) -> dict[str, str]:
    """The machine and the versions, for the head of the results."""
    model = platform.processor() or platform.machine()
    if sys.platform == "linux":
        model = next(iter(re.findall(r"model name\s*: (.*)", Path("/proc/cpuinfo").read_text())), model)
    cores = f"clients on {sorted(lab.client_cores)}, servers on {sorted(lab.server_cores)}"
    python, packages = versions(lab.python)
    runtimes = [f".NET SDK {dotnet.sdk()}", f"Python {python}", *([mono()] if "mono" in lab.builds else [])]
    return {
        "date": datetime.date.today().isoformat(),
        "processor": f"{model}, {os.cpu_count()} cores",
        "system": f"{platform.system()} {platform.release()}",
        "cores": cores if lab.client_cores else "wherever the system puts them",
        "runtimes": ", ".join(runtimes),
        "packages": ", ".join(packages),
    }


def versions(python: Path) -> tuple[str, list[str]]:
    """Of an interpreter, and of what it has of the packages that the lab uses."""
    code = (
        "import importlib.metadata, json, platform, zmq\n"
        "installed = {each.name.lower(): each.version for each in importlib.metadata.distributions()}\n"
        "names = ['pyzmq', 'websockets', 'aiohttp', 'grpcio', 'gymnasium']\n"
        "packages = [f'{name} {installed[name]}' for name in names if name in installed]\n"
        "print(json.dumps([platform.python_version(), [f'libzmq {zmq.zmq_version()}', *packages]]))"
    )
    found = subprocess.run([str(python), "-c", code], check=True, capture_output=True, text=True).stdout
    version, packages = json.loads(found)
    return version, packages


def mono() -> str:
    """Its version, which it prints behind other words."""
    text = subprocess.run(["mono", "--version"], capture_output=True, text=True).stdout
    return "Mono " + "".join(re.findall(r"version ([\d.]+)", text)[:1])
