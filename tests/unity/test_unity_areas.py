"""Lesson 10's areas in a scene: the terminal's numbers, and one step of physics for all of them."""

from __future__ import annotations

import sys
from collections.abc import Callable

import pytest

from tests.programs import ROOT, Program, steady_endpoint
from tests.unity.conftest import NEAREST

np = pytest.importorskip("numpy", reason="lesson 10 needs numpy: pip install numpy")
gymnasium = pytest.importorskip("gymnasium", reason="lesson 10 needs gymnasium: pip install gymnasium")
from gymnasium.utils.env_checker import data_equivalence  # noqa: E402

import netmq_example.envs  # noqa: E402, F401 - it registers them

AREAS = 4
ID, CLIENT = "NetMQExample/CartPole-v0", ROOT / "python" / "10_many_agents" / "client.py"
Play = Callable[..., Program]


def test_areas_of_a_scene_are_those_of_a_terminal(play: Play) -> None:
    """None of them connects by itself, and physics moves once for all of them."""
    endpoint = steady_endpoint()
    program = play("areas", str(AREAS), "warn", "--endpoint", endpoint, runtime=NEAREST)
    ours = gymnasium.make_vec(ID, AREAS, endpoint=endpoint, max_episode_steps=12)
    terminal = [sys.executable, str(CLIENT), "--world", "CartPole", "--areas", str(AREAS)]
    theirs = gymnasium.make_vec(ID, AREAS, launch=terminal, max_episode_steps=12)
    try:
        assert data_equivalence(ours.reset(seed=7), theirs.reset(seed=7))
        for number in range(30):
            action = np.array([1, 1, number % 2, number // 2 % 2])
            assert data_equivalence(ours.step(action), theirs.step(action)), number
    finally:
        ours.close()
        theirs.close()
    assert program.wait() == 0, program.output
    assert program.output.count("asking ") == 1, program.output
    assert program.output.count("Physics.Simulate does nothing") == 30


def test_a_scene_without_areas_says_so(play: Play) -> None:
    program = play("areas", "0", "play")
    assert program.wait() == 1
    assert "gave up: field has no CartPoleEnvironment below it; put one into each area" in program.output


def test_physics_is_given_back_by_the_last_one_that_steps_it(play: Play) -> None:
    program = play("areas", "2", "switch")
    assert program.wait() == 0, program.output
    said = [line for line in program.lines if line.startswith("physics: ")]
    assert said == [*["physics: Script"] * 3, "physics: FixedUpdate"]
