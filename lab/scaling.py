"""How many simulators are worth how much: python3 -m lab.scaling

Measures lesson 17's hub with 1 to 64 simulators that wait 10 ms in each step, and with ones that compute for as long;
beside it Ray's calls, where Ray is installed. Keeps the numbers in lab/scaling.json and draws img/17_scaling.svg.

    python3 -m lab.scaling --quick     a few seconds, with four simulators; what it finds is in .build/bench
    python3 -m lab.scaling --draw      draws the numbers that are kept, and writes the guide's table anew

The hub, the messages and the trainers are the lesson's. The simulators are not: they answer with the same observation
each time, and 16 that wait share one process, so that the machine has time for what is to be measured. Those that
compute have a process each. Trainers step eight simulators at a time, one trainer beside the other.
"""

from __future__ import annotations

import argparse
import datetime
import heapq
import importlib.util
import json
import multiprocessing
import os
import platform
import re
import sys
import threading
import time
from pathlib import Path
from typing import Any

import zmq

from kitlib.lessons import ROOT
from kitlib.programs import Program
from lab import machine

sys.path.append(str(ROOT / "python"))
from netmq_example.messages import Array, Message, read

COUNTS, TEAM, TOGETHER, STEP = (1, 2, 4, 8, 16, 32, 64), 8, 16, 0.01
KEPT, PICTURE, ASIDE = ROOT / "lab" / "scaling.json", ROOT / "img" / "17_scaling.svg", ROOT / ".build" / "bench"
PAGE = ROOT / "docs" / "guide" / "17_ray.md"
# Ray has a process for each actor; more than that is a test of this machine's memory.
RAY = 8


def state(id: int) -> list[Any]:
    values = {"reward": 1.0, "terminated": False, "truncated": False}
    return Message("state", id, values, [Array("float32", (4,), bytes(16))]).frames()


def simulate(endpoint: str, hello: list[bytes], count: int, wait: float, work: float) -> None:
    """`count` simulators in this process. Each step takes `wait` seconds, and `work` seconds of processor time."""
    context, poller = zmq.Context(), zmq.Poller()
    sockets = [context.socket(zmq.DEALER) for _ in range(count)]
    kept, under_way = dict[Any, tuple[int, list[Any]]](), list[tuple[float, int, int]]()
    for socket in sockets:
        socket.linger = 0
        socket.connect(endpoint)
        socket.send_multipart(hello)
        poller.register(socket, zmq.POLLIN)
    while True:
        first = 1000 * (under_way[0][0] - time.monotonic()) if under_way else 200
        for socket, _ in poller.poll(max(0, int(first + 1))):
            request = read(socket.recv_multipart())
            if request.kind in ("reset", "step") and (socket not in kept or request.id > kept[socket][0]):
                kept[socket] = request.id, []
                begin = time.thread_time()
                while time.thread_time() < begin + work * (request.kind == "step"):
                    pass
                due = time.monotonic() + wait * (request.kind == "step")
                heapq.heappush(under_way, (due, sockets.index(socket), request.id))
            elif request.kind in ("reset", "step") and kept[socket][1]:
                socket.send_multipart(kept[socket][1])
        while under_way and under_way[0][0] <= time.monotonic():
            _, index, id = heapq.heappop(under_way)
            kept[sockets[index]] = id, state(id)
            sockets[index].send_multipart(kept[sockets[index]][1])


class Team(threading.Thread):
    """A trainer with lesson 10's vector environment, whose steps are counted."""

    def __init__(self, endpoint: str, areas: int) -> None:
        super().__init__(daemon=True)
        self.endpoint, self.areas, self.steps, self.on = endpoint, areas, 0, True

    def run(self) -> None:
        import gymnasium
        import numpy as np

        import netmq_example.envs  # noqa: F401, it registers the vector environments.
        from netmq_example.fleet.trainer import FleetSocket

        with FleetSocket(self.endpoint, "CartPole", self.areas) as socket:
            envs = gymnasium.make_vec("NetMQExample/CartPole-v0", self.areas, socket=socket, wait=120.0)
            envs.reset(seed=0)
            actions = np.zeros(self.areas, np.int64)
            while self.on and "lost" not in envs.step(actions)[4]:
                self.steps += self.areas
            envs.close()


def measure(count: int, wait: float, work: float, seconds: float) -> float:
    """Steps a second of so many simulators behind one hub."""
    from netmq_example.fleet.simulator import FleetSimulator
    from netmq_example.worlds.cart_pole import CartPole

    hello = [bytes(frame) for frame in FleetSimulator(CartPole(), "1").hello().frames()]
    server = ROOT / "python" / "17_many_machines" / "server.py"
    hub = Program([sys.executable, server, "--endpoint", "tcp://127.0.0.1:0", "--idle", "600"])
    together, processes = 1 if work else TOGETHER, []
    try:
        endpoint = hub.wait_for(r"^listening on (\S+)", 60)[1]
        for begin in range(0, count, together):
            words = endpoint, hello, min(together, count - begin), wait, work
            processes.append(multiprocessing.get_context("spawn").Process(target=simulate, args=words, daemon=True))
            processes[-1].start()
        teams = [Team(endpoint, min(TEAM, count)) for _ in range(0, count, TEAM)]
        for team in teams:
            team.start()
        end = time.monotonic() + 180
        while not all(team.steps for team in teams):
            if time.monotonic() > end or not all(team.is_alive() for team in teams):
                sys.exit(f"gave up: {count} simulators do not step; the hub said {hub.lines[-3:]}")
            time.sleep(0.1)
        time.sleep(seconds / 4)
        before, began = sum(team.steps for team in teams), time.monotonic()
        time.sleep(seconds)
        rate = (sum(team.steps for team in teams) - before) / (time.monotonic() - began)
        if not all(team.is_alive() for team in teams):
            sys.exit(f"gave up: a simulator of {count} was lost; the hub said {hub.lines[-3:]}")
        for team in teams:
            team.on = False
        for team in teams:
            team.join(30)
        return rate
    finally:
        for process in processes:
            process.terminate()
        hub.process.terminate()
        hub.process.wait(10)


def with_ray(counts: list[int], wait: float, seconds: float) -> dict[str, float]:
    """The same as Ray's calls: as many actors, each with one step under way, and the next round when all are over."""
    os.environ["RAY_USAGE_STATS_ENABLED"] = "0"
    import ray

    ray.init("local", num_cpus=max(counts), include_dashboard=False, log_to_driver=False, logging_level=40)

    @ray.remote
    class Actor:
        def step(self) -> None:
            time.sleep(wait)

    found, actors = dict[str, float](), list[Any]()
    for count in counts:
        actors += [Actor.remote() for _ in range(count - len(actors))]  # type: ignore[attr-defined]
        ray.get([actor.step.remote() for actor in actors], timeout=120)
        steps, began = 0, time.monotonic()
        while time.monotonic() < began + seconds:
            ray.get([actor.step.remote() for actor in actors], timeout=120)
            steps += count
        found[str(count)] = steps / (time.monotonic() - began)
    ray.shutdown()
    return found


def run(counts: tuple[int, ...], seconds: float) -> dict[str, Any]:
    others = machine.busy()
    curves: dict[str, dict[str, float]] = {"wait": {}, "compute": {}, "at once": {}}
    for name, wait, work in ("wait", STEP, 0.0), ("compute", 0.0, STEP), ("at once", 0.0, 0.0):
        for count in counts if name != "at once" else counts[-1:]:
            curves[name][str(count)] = round(measure(count, wait, work, seconds), 1)
            print(f"{count} simulators that {name}: {curves[name][str(count)]:,.0f} steps a second", flush=True)
    if importlib.util.find_spec("ray"):
        rates = with_ray([count for count in counts if count <= RAY], STEP, seconds)
        curves["Ray, wait"] = {count: round(rate, 1) for count, rate in rates.items()}
        curves["Ray, at once"] = {"1": round(with_ray([1], 0, seconds)["1"], 1)}
        print(f"Ray: {curves['Ray, wait']} steps a second; of one actor at once {curves['Ray, at once']}", flush=True)
    most, areas = curves["at once"][str(counts[-1])], min(TEAM, counts[-1])
    size = sum(len(frame) for frame in state(1000))
    ask = sum(len(frame) for frame in Message("step", 1000, {}, [Array("int64", (), bytes(8))]).frames())
    model = platform.processor() or platform.machine()
    if sys.platform == "linux":
        found = [line for line in Path("/proc/cpuinfo").read_text().splitlines() if line.startswith("model name")]
        model = found[0].partition(": ")[2] if found else model
    return {
        "machine": {
            "date": datetime.date.today().isoformat(),
            "processor": f"{model}, {os.cpu_count()} cores",
            "system": f"{platform.system()} {platform.release()}",
            "versions": f"Python {platform.python_version()}, pyzmq {zmq.__version__}, libzmq {zmq.zmq_version()}",
            "others": f"other programs used {others:.0%} of the processor before it began",
        },
        "curves": curves,
        # Each step is two messages between the hub and a simulator, and a share of a trainer's two.
        "hub": {"messages": round(most * (2 + 2 / areas)), "state": size, "step": ask},
    }


def draw(results: dict[str, Any], path: Path) -> None:
    from matplotlib import pyplot

    from lab.plots import LIMIT, MARKS, OTHERS, OURS, save

    title = "Steps a second, by how many simulators there are"
    figure, axes = pyplot.subplots(figsize=(10, 6.4))
    curves, labels = results["curves"], {"wait": "simulators that wait 10 ms", "compute": "that compute for 10 ms"}
    counts = [int(count) for count in curves["wait"]]
    axes.plot(counts, [n * curves["wait"]["1"] for n in counts], "--", color=LIMIT, label="so many times one")
    for (name, label), mark, colour in zip(
        {**labels, "Ray, wait": "calls of Ray's actors that wait"}.items(),
        MARKS,
        (OURS, "#D55E00", OTHERS),
        strict=False,
    ):
        points = [(int(count), rate) for count, rate in curves.get(name, {}).items()]
        if points:
            axes.plot(*zip(*points, strict=True), f"{mark}-", color=colour, linewidth=2, markersize=8, label=label)
            axes.annotate(f"{points[-1][1]:,.0f}", points[-1], textcoords="offset points", xytext=(10, -4), fontsize=12)
    axes.set(xscale="log", yscale="log", xlabel="simulators", ylabel="steps a second")
    axes.set_xticks(counts, [str(count) for count in counts])
    axes.minorticks_off()
    axes.margins(0.12, 0.1)
    axes.set_title(title, fontsize=16, loc="left")
    axes.legend(fontsize=12, loc="upper left", frameon=False)
    axes.text(0, -0.18, "{processor}, {date}; {others}".format(**results["machine"]), fontsize=11,
              transform=axes.transAxes)  # fmt: skip
    save(path, figure, title)


def paper(results: dict[str, Any]) -> str:
    """The rows of the guide's table that follow from what was measured: 1,000 simulators of 0.01 s a step."""
    hub, step, state = (results["hub"][name] for name in ("messages", "step", "state"))
    enough = int(hub / 2.25 / 100)
    return (
        f"| what the hub does with one core, at most (measured) | {hub:,} |\n"
        f"| so one hub is enough for | {hub:,} / 2.25 / 100 = {enough} simulators |\n"
        f"| bytes of a step: the action {step}, the observation {state} | {step + state} |\n"
        f"| bytes a second | 100,000 x {step + state} = {(step + state) / 10:.1f} MB, a fifth of 1 Gbit/s |\n"
    )


def main() -> None:
    parser = argparse.ArgumentParser(description="Measures lesson 17's hub, and draws what it has found.")
    parser.add_argument("--quick", action="store_true", help="a few seconds, aside")
    parser.add_argument("--draw", action="store_true", help="draw the kept numbers")
    options = parser.parse_args()
    kept, picture = (ASIDE / "scaling.json", ASIDE / "17_scaling.svg") if options.quick else (KEPT, PICTURE)
    kept.parent.mkdir(parents=True, exist_ok=True)
    if not options.draw:
        results = run((1, 2, 4) if options.quick else COUNTS, 1 if options.quick else 8)
        kept.write_text(json.dumps(results, indent=1) + "\n", encoding="utf-8")
    results = json.loads(kept.read_text(encoding="utf-8"))
    draw(results, picture)
    if not options.quick:
        # From one row to the end of the table.
        page = re.sub(r"\| what the hub does(.+\n)+", lambda _: paper(results), PAGE.read_text(encoding="utf-8"))
        PAGE.write_text(page, encoding="utf-8")


if __name__ == "__main__":
    main()
