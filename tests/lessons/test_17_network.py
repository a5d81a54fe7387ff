"""Lesson 17 on three machines, which are network namespaces here: a hub, its simulators and a trainer, with cables."""

from __future__ import annotations

import os
import re
import shutil
import subprocess
import time
import uuid
from pathlib import Path

import pytest

from tests.conftest import PYTHON
from tests.lessons.test_17_many_machines import KEY, played, returns
from tests.programs import ROOT

HUB, PORT = "10.217.1.1", 5567


def run(*words):
    return subprocess.run(words, capture_output=True, text=True, timeout=20)


class Machines:
    """The hub's has a cable to that of the simulators and one to the trainer's; no other network is touched."""

    def __init__(self):
        mark = uuid.uuid4().hex[:8]
        self.names = {role: f"kit-{mark}-{role}" for role in ("hub", "simulators", "trainer")}

    def make(self):
        """Why it cannot be, if so."""
        for name in self.names.values():
            if (made := run("ip", "netns", "add", name)).returncode:
                return made.stderr
        for number, role in enumerate(("simulators", "trainer"), start=1):
            hub, name, net = self.names["hub"], self.names[role], f"10.217.{number}"
            cable = ["link", "add", f"to{number}", "type", "veth", "peer", "name", "eth0", "netns", name]
            if (made := run("ip", "-n", hub, *cable)).returncode:
                return made.stderr
            for where, address, device in ((hub, f"{net}.1/24", f"to{number}"), (name, f"{net}.2/24", "eth0")):
                run("ip", "-n", where, "addr", "add", address, "brd", f"{net}.255", "dev", device)
                run("ip", "-n", where, "link", "set", device, "up")
                run("ip", "-n", where, "link", "set", "lo", "up")
        return ""

    def remove(self):
        # Its cables go with it.
        for name in self.names.values():
            run("ip", "netns", "del", name)

    def inside(self, role):
        return ["ip", "netns", "exec", self.names[role]]

    def cable(self, role, state):
        assert run("ip", "-n", self.names[role], "link", "set", "eth0", state).returncode == 0

    def lose(self, role, percent):
        """So many of a hundred packets, of those that come and of those that go."""
        if not shutil.which("nft"):
            pytest.skip("this system has no `nft` to lose packets with")
        for hook in ("input", "output"):
            rules = f"add table ip kit; add chain ip kit {hook} {{ type filter hook {hook} priority 0; }};"
            rules += f"add rule ip kit {hook} numgen random mod 100 < {percent} drop"
            assert (made := run(*self.inside(role), "nft", rules)).returncode == 0, made.stderr


@pytest.fixture
def machines():
    if not shutil.which("ip"):
        pytest.skip("this system has no `ip netns` to make machines with")
    machines = Machines()
    try:
        if why := machines.make():
            pytest.skip(f"no network namespaces or virtual cables here: {why.strip()}")
        yield machines
    finally:
        machines.remove()


@pytest.fixture
def hub(machines, start):
    """hub("--late", "1"): a hub on its machine."""

    def begin(*words):
        server = ROOT / "python" / KEY / "server.py"
        endpoint = f"tcp://0.0.0.0:{PORT}"
        command = [PYTHON, server, "--endpoint", endpoint, "--open-to-anyone", "--idle", "600", *words]
        program = start(*machines.inside("hub"), *command)
        program.wait_for("^listening on ")
        return program

    return begin


@pytest.fixture
def simulators(machines, start, client_command):
    """Started side by side; each asks for the hub for a minute."""

    def some(count, kind="python", *words):
        command = client_command(kind, KEY, f"tcp://{HUB}:{PORT}", "--timeout", "60", *words)
        return [start(*machines.inside("simulators"), *command) for _ in range(count)]

    return some


@pytest.fixture
def train(machines, start):
    def program(areas, episodes, *words):
        numbers = ["--areas", str(areas), "--episodes", str(episodes), "--endpoint", f"tcp://10.217.2.1:{PORT}"]
        command = [PYTHON, ROOT / "python" / KEY / "train.py", *numbers, "--each", *words]
        return start(*machines.inside("trainer"), *command)

    return program


def count(hub):
    """The hub's last numbers by name."""
    lines = [line for line in hub.lines if re.match(r"\d+ simulators, ", line)]
    return {name: int(number) for number, name in re.findall(r"(\d+) ([a-z ]+)", lines[-1])} if lines else {}


@pytest.mark.parametrize("kind", ["python", "csharp"])
def test_a_pulled_cable_is_noticed_on_both_sides_and_who_is_back_goes_on(kind, machines, hub, simulators, train):
    server = hub()
    fleet = simulators(2, kind)
    server.wait_for("^2 simulators, 2 free")
    begin, told = time.monotonic(), len(server.lines)
    machines.cable("simulators", "down")
    for simulator in fleet:
        simulator.wait_for("^trouble: the environment is gone, or silent$")
    server.wait_for("^0 simulators", start=told)
    print(f"noticed by all within {time.monotonic() - begin:.1f} s")
    trainer = train(2, 8)
    trainer.wait_for("^waiting for a simulator")
    machines.cable("simulators", "up")
    assert played(trainer) == returns(8)


def test_an_episode_goes_on_after_the_cable_of_its_simulators_was_pulled(machines, hub, simulators, train):
    """None of its simulators is left; those that come back are new ones, and do again what was done."""
    server = hub()
    simulators(2, "python", "--delay", "0.01")
    trainer = train(2, 12)
    server.wait_for(r"^2 simulators, \d free, 1 trainers, 1 at work")
    told = len(server.lines)
    machines.cable("simulators", "down")
    server.wait_for("^0 simulators", start=told)
    machines.cable("simulators", "up")
    assert played(trainer) == returns(12)
    assert count(server)["begun anew"] >= 2


def test_a_trainer_whose_cable_was_pulled_leaves_its_simulators_to_others(machines, hub, simulators, train):
    server = hub()
    simulators(2)
    first = train(2, 100_000, "--wait", "10")
    server.wait_for(r"^2 simulators, \d free, 1 trainers, 1 at work")
    told = len(server.lines)
    machines.cable("trainer", "down")
    assert played(first, code=1) == []
    server.wait_for("^2 simulators, 2 free, 0 trainers", start=told)
    machines.cable("trainer", "up")
    assert played(train(2, 6)) == returns(6)


def test_the_hub_is_found_in_its_network(machines, hub, start):
    hub("--announce", "10.217.1.255:5567")
    client = start(*machines.inside("simulators"), PYTHON, ROOT / "python" / KEY / "client.py", "--find", "5567")
    client.wait_for(f"^simulating CartPole for tcp://{HUB}:{PORT}$")


def test_a_hub_that_cannot_be_heard_says_so_once(hub, simulators):
    """A network without a router has no way to everybody."""
    server = hub("--announce", "255.255.255.255:5567")
    why = "Network is unreachable; give the broadcast address of your network, such as 192.168.0.255"
    server.wait_for(f"^cannot announce at 255.255.255.255: {why}$")
    # It tries once a second, and simulators take longer to start.
    simulators(2)
    assert server.stop() == 0
    assert server.output.count("cannot announce") == 1


# Hands on what comes, 20 ms later. A kernel could do that too, and many have not got what it takes.
LATER = """
import asyncio, sys
async def hand_on(reader, writer):
    while data := await reader.read(65_536):
        await asyncio.sleep(0.02)
        writer.write(data)
    writer.close()
async def come(reader, writer):
    other = await asyncio.open_connection(sys.argv[1], int(sys.argv[2]))
    await asyncio.gather(hand_on(reader, other[1]), hand_on(other[0], writer), return_exceptions=True)
async def main():
    server = await asyncio.start_server(come, sys.argv[1], int(sys.argv[3]))
    print("ready", flush=True)
    await server.serve_forever()
asyncio.run(main())
"""


@pytest.mark.long
def test_a_slow_network_changes_no_result(machines, hub, start, client_command, train):
    hub("--timeout", "120")
    start(*machines.inside("hub"), PYTHON, "-c", LATER, HUB, str(PORT), "5568").wait_for("^ready$")
    command = client_command("python", KEY, f"tcp://{HUB}:5568", "--timeout", "60")
    for _ in range(2):
        start(*machines.inside("simulators"), *command)
    assert played(train(2, 4, "--wait", "120")) == returns(4)


@pytest.mark.long
@pytest.mark.timeout(1200)
def test_a_lossy_network_changes_no_result(machines, hub, simulators, train):
    server = hub("--timeout", "120")
    machines.lose("simulators", 20)
    simulators(2)
    trainer = train(2, 4, "--wait", "120")
    assert trainer.wait(500) == 0, trainer.output
    assert played(trainer) == returns(4)
    print(f"with 20 % of packets lost: {count(server)}")


@pytest.mark.long
@pytest.mark.timeout(900)
def test_a_thousand_episodes_while_a_simulator_is_killed_every_half_second(machines, hub, simulators, train):
    """Each episode once, and the sum of the run without deaths."""
    server = hub("--timeout", "120")
    alive, killed = simulators(6), 0
    trainer = train(2, 1000, "--wait", "120")
    trainer.wait_for("^waiting for a simulator")
    server.wait_for(r"^\d+ simulators, \d+ free, 1 trainers, 1 at work, [1-9]")
    while trainer.process.poll() is None:
        # Only one that was in the fleet has died.
        alive[0].wait_for("^simulating CartPole")
        alive.pop(0).kill()
        killed += 1
        alive += simulators(1)
        time.sleep(0.5)
    assert played(trainer) == returns(1000)
    print(f"{killed} killed, {count(server)}")
    assert killed > 3
    assert count(server)["begun anew"] > 0


@pytest.mark.long
def test_when_the_hub_is_killed_all_are_back_within_2_s(machines, hub, simulators):
    first = hub()
    simulators(8)
    first.wait_for("^8 simulators, 8 free")
    first.kill()
    begin = time.monotonic()
    second = hub()
    ready = time.monotonic()
    second.wait_for("^8 simulators, 8 free")
    print(
        f"all back {time.monotonic() - ready:.1f} s after it was ready, {time.monotonic() - begin:.1f} s after it died"
    )
    # The board tells it up to a second later.
    assert time.monotonic() - ready < 3


# Says hello, is welcomed, and goes: so many times.
JOIN_AND_LEAVE = """
import sys, zmq
sys.path.append(sys.argv[3])
from netmq_example.worlds.cart_pole import CartPole
from netmq_example.fleet.simulator import FleetSimulator
for _ in range(int(sys.argv[2])):
    with zmq.Context() as context, context.socket(zmq.DEALER) as socket:
        socket.linger, socket.rcvtimeo = 0, 20_000
        socket.connect(sys.argv[1])
        socket.send_multipart(FleetSimulator(CartPole(), "1").hello().frames())
        assert b"welcome" in socket.recv()
"""


def test_who_joins_and_leaves_a_hundred_times_leaves_nothing_behind(machines, hub, start):
    server, sizes = hub(), []

    def size():
        process = Path("/proc") / str(server.process.pid)
        sockets = sum("socket" in os.readlink(file) for file in (process / "fd").iterdir())
        status = (process / "status").read_text(encoding="utf-8")
        return {"sockets": sockets} | {
            name: int(re.search(rf"^{name}:\s+(\d+)", status, re.MULTILINE)[1]) for name in ("VmRSS", "Threads")
        }

    for times, last in ("10", 10), ("100", 110):
        words = [PYTHON, "-c", JOIN_AND_LEAVE, f"tcp://{HUB}:{PORT}", times, ROOT / "python"]
        assert start(*machines.inside("simulators"), *words).wait() == 0
        server.wait_for(f"^simulator {last} is gone: its connection is$")
        sizes.append(size())
    before, after = sizes
    assert (after["sockets"], after["Threads"]) == (before["sockets"], before["Threads"])
    # In kB: a tenth of what a hundred simulators that are kept would be.
    assert after["VmRSS"] < before["VmRSS"] + 2000
