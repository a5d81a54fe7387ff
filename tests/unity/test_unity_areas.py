"""Lesson 10's areas in a scene: the terminal's numbers, one step of physics for all of them, and what that costs."""

from __future__ import annotations

import sys
from collections.abc import Callable

import pytest

from kitlib.setup import dotnet
from tests.lessons.test_10_many_agents import np, same
from tests.programs import ROOT, Program, steady_endpoint
from tests.unity.test_unity_play import RUNTIMES, needs_mono

gymnasium = pytest.importorskip("gymnasium", reason="lesson 10 needs gymnasium: pip install gymnasium")
AREAS = 4
ID, CLIENT = "NetMQExample/CartPole-v0", ROOT / "python" / "10_many_agents" / "client.py"


@pytest.fixture
def scene(netmq: dotnet.NetMQ, start: Callable[..., Program]) -> Callable[..., Program]:
    """scene(".net", "4", "play", …) starts tests/unity/play/ManyAreas.cs."""

    def start_scene(runtime: str, *words: str) -> Program:
        if runtime == "mono":
            needs_mono()
        harness = dotnet.build(netmq, ROOT / "tests" / "unity" / "play")
        return start({"mono": "mono", ".net": "dotnet"}[runtime], harness, "areas", *words)

    return start_scene


@pytest.mark.parametrize("runtime", RUNTIMES)
def test_areas_of_a_scene_are_those_of_a_terminal(runtime: str, scene: Callable[..., Program]) -> None:
    """None of them connects by itself, and physics moves once for all of them."""
    endpoint = steady_endpoint()
    program = scene(runtime, str(AREAS), "warn", "--endpoint", endpoint)
    ours = gymnasium.make_vec(ID, AREAS, endpoint=endpoint, max_episode_steps=12)
    terminal = [sys.executable, str(CLIENT), "--world", "CartPole", "--areas", str(AREAS)]
    theirs = gymnasium.make_vec(ID, AREAS, launch=terminal, max_episode_steps=12)
    try:
        same(ours.reset(seed=7), theirs.reset(seed=7))
        for number in range(30):
            action = np.array([1, 1, number % 2, number // 2 % 2])
            same(ours.step(action), theirs.step(action))
    finally:
        ours.close()
        theirs.close()
    assert program.wait() == 0, program.output
    assert program.output.count("asking ") == 1, program.output
    assert program.output.count("Physics.Simulate does nothing") == 30


def test_a_scene_without_areas_says_so(scene: Callable[..., Program]) -> None:
    program = scene(".net", "0", "play")
    assert program.wait() == 1
    assert "gave up: field has no CartPoleEnvironment below it; put one into each area" in program.output


@pytest.mark.parametrize("runtime", RUNTIMES)
def test_physics_is_given_back_by_the_last_one_that_steps_it(runtime: str, scene: Callable[..., Program]) -> None:
    program = scene(runtime, "2", "switch")
    assert program.wait() == 0, program.output
    said = [line for line in program.lines if line.startswith("physics: ")]
    assert said == [*["physics: Script"] * 3, "physics: FixedUpdate"]


@pytest.mark.parametrize("runtime", RUNTIMES)
def test_what_a_step_costs_the_main_thread(
    runtime: str, scene: Callable[..., Program], capsys: pytest.CaptureFixture[str]
) -> None:
    """Printed, and not asserted: a busy machine takes what it needs."""
    program = scene(runtime, "16", "cost", "1000")
    assert program.wait() == 0, program.output
    with capsys.disabled():
        print(f"\n{runtime}: {program.wait_for('^16 areas: 1000 steps: mean .*')[0]}")
