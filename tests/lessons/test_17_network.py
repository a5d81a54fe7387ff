"""Lesson 17 on three machines, which are network namespaces here: a hub, its simulators and a trainer, with cables."""

from __future__ import annotations

import re
import shutil
import subprocess
import uuid

import pytest

from tests.conftest import PYTHON
from tests.lessons.test_17_many_machines import KEY, TRAIN, played, returns
from tests.programs import ROOT, finished

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


@pytest.fixture(scope="module")
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

    def some(*kinds):
        # So slow that a cable can be pulled while they play.
        words = ["--timeout", "60", "--delay", "0.02"]
        commands = [client_command(kind, KEY, f"tcp://{HUB}:{PORT}", *words) for kind in kinds]
        return [start(*machines.inside("simulators"), *command) for command in commands]

    return some


@pytest.fixture
def train(machines, start):
    def program(areas, episodes, *words):
        numbers = ["--areas", str(areas), "--episodes", str(episodes), "--endpoint", f"tcp://10.217.2.1:{PORT}"]
        return start(*machines.inside("trainer"), PYTHON, TRAIN, *numbers, "--each", *words)

    return program


def test_an_episode_goes_on_after_the_cable_of_its_simulators_was_pulled(machines, hub, simulators, train):
    """Both sides notice it. None of its simulators is left; those that come back are new ones, and do again what was
    done.
    """
    server = hub()
    fleet = simulators("python", "csharp")
    trainer = train(2, 12)
    server.wait_for(r"^2 simulators, \d free, 1 trainers, 1 at work")
    told = len(server.lines)
    machines.cable("simulators", "down")
    for simulator in fleet:
        simulator.wait_for("^trouble: the environment is gone, or silent$")
    server.wait_for("^0 simulators", start=told)
    machines.cable("simulators", "up")
    assert played(trainer) == returns(12)
    begun_anew = re.findall(r" (\d+) begun anew", server.output)[-1]
    assert int(begun_anew) >= 2


def test_a_trainer_whose_cable_was_pulled_leaves_its_simulators_to_others(machines, hub, simulators, train):
    server = hub()
    simulators("python", "python")
    first = train(2, 100_000, "--wait", "10")
    server.wait_for(r"^2 simulators, \d free, 1 trainers, 1 at work")
    told = len(server.lines)
    machines.cable("trainer", "down")
    server.wait_for("^2 simulators, 2 free, 0 trainers", start=told)
    assert played(first, code=1) == []
    machines.cable("trainer", "up")
    assert played(train(2, 2)) == returns(2)


def test_the_hub_is_found_in_its_network(machines, hub, start):
    hub("--announce", "10.217.1.255:5567")
    client = start(*machines.inside("simulators"), PYTHON, ROOT / "python" / KEY / "client.py", "--find", "5567")
    client.wait_for(f"^simulating CartPole for tcp://{HUB}:{PORT}$")


def test_a_hub_that_cannot_be_heard_says_so_once(machines):
    """A network without a router has no way to everybody."""
    # It tries once a second.
    tell = """
from netmq_example.fleet.beacon import Beacon
beacon = Beacon("255.255.255.255:5567", "tcp://127.0.0.1:1")
for _ in range(2):
    beacon.sent -= 2
    beacon.tell()
"""
    done = finished([*machines.inside("hub"), PYTHON, "-c", tell], cwd=ROOT / "python")
    why = "Network is unreachable; give the broadcast address of your network, such as 192.168.0.255"
    assert (done.stdout, done.stderr) == (f"cannot announce at 255.255.255.255: {why}\n", "")
