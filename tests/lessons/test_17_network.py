"""Lesson 17 on three machines, which are network namespaces here: a hub, its simulators and a trainer, with cables."""

import re

import pytest

from tests.conftest import PYTHON
from tests.lessons.test_17_many_machines import KEY, TRAIN, played, returns
from tests.machines import HUB
from tests.programs import ROOT

PORT = 5567


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
    trainer = train(2, 6)
    server.wait_for(r"^2 simulators, \d free, 1 trainers, 1 at work")
    told = len(server.lines)
    machines.cable("simulators", "down")
    for simulator in fleet:
        simulator.wait_for("^trouble: the environment is gone, or silent$")
    server.wait_for("^0 simulators", start=told)
    machines.cable("simulators", "up")
    assert played(trainer) == returns(6)
    begun_anew = re.findall(r" (\d+) begun anew", server.output)[-1]
    assert int(begun_anew) >= 2


def test_a_trainer_whose_cable_was_pulled_leaves_its_simulators_to_others(machines, hub, simulators, train):
    server = hub()
    simulators("python", "python")
    server.wait_for("^2 simulators, 2 free")
    first = train(2, 100_000, "--timeout", "5")
    server.wait_for(r"^2 simulators, \d free, 1 trainers, 1 at work")
    told = len(server.lines)
    machines.cable("trainer", "down")
    server.wait_for("^2 simulators, 2 free, 0 trainers", start=told)
    assert played(first, code=1) == []
    machines.cable("trainer", "up")
    assert played(train(2, 2)) == returns(2)
