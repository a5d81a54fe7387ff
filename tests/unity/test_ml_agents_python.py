"""A Python that gives a seed and parameters, is not there, or is lost: what a scene of ML-Agents' shape does then.

Expectations are derived from ML-Agents 3.0.0's source: Academy, RpcCommunicator, HeuristicPolicy.
"""

from __future__ import annotations

import os
import signal
import subprocess
import sys

import pytest

pytest.importorskip("numpy", reason="ML-Agents' shape needs numpy: pip install numpy")
from netmq_example.mlagents_envs.side_channel.environment_parameters_channel import EnvironmentParametersChannel
from tests.programs import ROOT, steady_port
from tests.unity.scene_worlds import told


def test_pythons_seed_goes_to_unitys_random_once(world):
    def numbers(seed: int) -> list[str]:
        run = world("A period=1", "A init 1: random", "A begin 2: random", seed=seed)
        run.reset()
        run.reset()
        return [line for line in run.told() if line.startswith("random ")]

    first, again, other = numbers(5), numbers(5), numbers(6)
    assert first == again and first[0] != other[0]
    # The reset did not begin it anew.
    assert len(first) == 2 and first[0] != first[1]


def test_side_channels_of_a_message_are_read_before_its_reset(world):
    """Also the first ones: Academy.Instance waits for Python's first reset, and Initialize reads them."""
    channel = EnvironmentParametersChannel()
    deeds = [f"A {call}: parameter size" for call in ("init 1", "begin 1", "begin 2")]
    run = world("A period=1", *deeds, side_channels=[channel])
    channel.set_float_parameter("size", 3)
    run.reset()
    channel.set_float_parameter("size", 4)
    run.reset()
    assert [line for line in run.told() if line.startswith("size ")] == ["size 3", "size 3", "size 4"]


def test_without_python_heuristic_decides_at_once(alone):
    """On decision steps, on cleared actions; they are repeated in between, and after an end as well."""
    lines, output = alone("A period=3 numbers=1 branches=3", "A act 2: end", "A act 4: python", "steps=4")
    assert lines[lines.index("step 0") : lines.index("python False")] == [
        "step 0", "A see 1", "A decide 0 #0", "A act 1 #1",
        "step 1", "A act 1 #1", "A see 2", "A begin steps=0 sum=0 episodes=1",
        "step 2", "A act 1 #1",
        "step 3", "A see 2", "A decide 0 #0", "A act 2 #1",
    ]  # fmt: skip
    assert "no Python" in output


def test_one_that_has_heuristic_only_is_never_seen_by_python(world):
    run = world("A period=1", "B period=1 type=HeuristicOnly behavior=Other")
    run.reset()
    run.step()
    assert [*run.env.behavior_specs] == ["Ball?team=0"]
    assert "B act 1" in run.told()


LOST = """
import os, sys
from netmq_example.mlagents_envs.environment import UnityEnvironment
env = UnityEnvironment(base_port=int(sys.argv[1]))
env.reset()
env.step()
print("stepped", flush=True)
sys.stdin.read()
"""


@pytest.mark.skipif(not hasattr(signal, "SIGKILL"), reason="kills Python")
def test_a_python_that_is_killed_ends_play(play, start):
    port = str(steady_port())
    program = play("clock", "A period=1", "--mlagents-port", port)
    python = start(
        sys.executable, "-c", LOST, port, stdin=subprocess.PIPE, folder=ROOT, PYTHONPATH=str(ROOT / "python")
    )
    python.wait_for("^stepped$")
    os.kill(python.process.pid, signal.SIGKILL)
    program.wait()
    assert "stop" in told(program.lines)
