"""The scene's clock: what happens when, by worlds written for it; and what Python gives a scene, or takes from it.

Each expectation is derived from ML-Agents 3.0.0's source: Academy.EnvironmentStep, Agent, DecisionRequester, the
remote and the heuristic policy, RpcCommunicator. In the player the first frame has two FixedUpdates, each other one.
"""

import os
import signal
import subprocess
import sys

import pytest

pytest.importorskip("numpy", reason="ML-Agents' shape needs numpy: pip install numpy")
from netmq_example.mlagents_envs.side_channel.environment_parameters_channel import EnvironmentParametersChannel
from tests.programs import ROOT, steady_port
from tests.unity.scene_worlds import told

BEGIN = "begin steps=0 sum=0 episodes=0"


def starts(lines, *expected):
    assert lines[: len(expected)] == [*expected]


def test_initialize_then_all_starts_then_the_first_episode_and_its_first_row_in_one_step(world):
    """AgentForceReset is the first thing in the first EnvironmentStep, which is in FixedUpdate; no action between."""
    run = world("A period=2", "B period=2")
    assert run.reset() == [("wants", 0, 0, 1), ("wants", 1, 0, 1)]
    assert run.step(7) == [("wants", 0, 0, 2), ("wants", 1, 0, 2)]
    first = ["A init", "B init", "A start", "B start", "reset", f"A {BEGIN}", f"B {BEGIN}"]
    steps = ["step 0", "A see 1", "B see 1", "A act 7", "B act 7", "step 1", "A act 7", "B act 7", "step 2", "A see 3"]
    starts(run.told(), *first, *steps)


def test_who_asked_is_observed_and_acts_in_the_order_of_onenable(world):
    """B is in the scene before A, and A was enabled first: in B's Start, before any step, without an episode yet."""
    run = world("B period=1 active=no", "A period=1", "A start 1: B>on")
    assert run.reset() == [("wants", 0, 0, 1), ("wants", 1, 0, 1)]
    run.step(1)
    lines = [line for line in run.told() if line != "B start"]
    starts(
        lines, "A init", "A start", "B init", "reset", f"A {BEGIN}", f"B {BEGIN}", "step 0", "A see 1",
        "B see 1", "A act 1", "B act 1", "step 1", "A see 2", "B see 2"
    )  # fmt: skip


def test_requesters_ask_by_the_academys_step_and_actions_come_between(world):
    """step % period == offset, of the step before it is counted. Without a decision so far actions are zeros."""
    run = world("A period=3 offset=1 between=no", "B period=2")
    assert run.reset() == [("wants", 1, 0, 1)]
    assert run.step(5) == [("wants", 0, 0, 1)]
    assert run.step(6) == [("wants", 1, 0, 2)]
    assert run.step(7) == [("wants", 0, 0, 2), ("wants", 1, 0, 3)]
    lines = run.told()
    lines = lines[lines.index("step 0") :]
    starts(
        lines, "step 0", "B see 1", "B act 5", "step 1", "A see 2", "A act 6", "B act 5", "step 2", "B see 3",
        "B act 7", "step 3", "B act 7", "step 4", "A see 5", "B see 5"
    )  # fmt: skip


def test_a_row_has_the_rewards_since_that_agents_own_last_row(world):
    run = world("A period=2", "B period=3", "A act *: add 1", "B act *: add 1")
    assert run.reset() == [("wants", 0, 0, 1), ("wants", 1, 0, 1)]
    assert run.step() == [("wants", 0, 2, 2)]
    assert run.step() == [("wants", 1, 3, 2)]
    assert run.step() == [("wants", 0, 2, 3)]
    assert run.step() == [("wants", 0, 2, 4), ("wants", 1, 3, 3)]
    run.told()


def test_setreward_replaces_what_no_row_has_yet(world):
    """And corrects the sum by the difference."""
    run = world("A period=2", "A act 1: add 2, set 5, sum", "A act 2: add 1, sum", "A act 3: set 1, sum")
    run.reset()
    assert run.step()[0].reward == 6
    assert run.step()[0].reward == 1
    assert [line for line in run.told() if " sum " in line and "begin" not in line] == ["A sum 5", "A sum 6", "A sum 7"]


def test_a_later_reset_arrives_in_the_middle_of_a_step(world):
    """OnEpisodeBegin, then zeros for who had asked in this step, physics, and only then the first observation.

    There is no terminal row. A's row had its rewards; the sum goes on, and what B has earned since its row stays. B
    did not ask in this step: Python's last action for it is still there, and it acts by that.
    """
    run = world("A period=2", "B period=2 offset=1", "A act *: add 1", "B act *: add 1")
    run.reset()
    assert run.step(7) == [("wants", 1, 1, 1)]
    assert run.step(8) == [("wants", 0, 2, 2)]
    assert run.reset() == [("wants", 0, 1, 3)]
    assert run.step(9) == [("wants", 1, 3, 2)]
    lines = run.told()
    starts(
        lines[lines.index("step 2") :], "step 2", "A see 3", "reset", "A begin steps=0 sum=2 episodes=0",
        "B begin steps=0 sum=2 episodes=0", "A act 0", "B act 8", "step 0", "A see 1", "A act 9", "B act 8", "step 1",
        "B see 2"
    )  # fmt: skip


def test_the_academy_counts(world):
    """A step is counted before it is observed; a later reset begins the count anew, and not that of the Play."""
    run = world("A period=1", "A see *: academy")
    run.reset()
    run.step()
    run.reset()
    starts([line for line in run.told() if "academy" in line], "academy 1 1 1", "academy 2 2 1", "academy 1 3 2")


def test_an_id_is_an_agents_own_from_onenable_to_ondisable(world):
    run = world("A period=1", "B", "A act 1: end", "B physics 3: A>off", "B physics 4: A>on")
    assert run.reset() == [("wants", 0, 0, 1)]
    assert run.step() == [("ended", 0, 0, 2), ("wants", 0, 0, 3)]
    assert run.reset() == [("wants", 0, 0, 4)]
    # It is off: its episode is over and not interrupted.
    assert run.step() == [("ended", 0, 0, 5)]
    # B was the second.
    assert run.step() == [("wants", 2, 0, 6)]
    run.told()


def test_one_made_later_begins_before_instantiate_returns(world):
    run = world("A period=2", "B period=2 late", "A physics 2: make B, copy")
    run.reset()
    assert run.step(1) == [("wants", 0, 0, 2), ("wants", 1, 0, 1), ("wants", 2, 0, 1)]
    lines = run.told()
    lines = lines[lines.index("A physics") :]
    copied = ["A(Clone) init", f"A(Clone) {BEGIN}", "copied A(Clone)"]
    starts(lines, "A physics", "B init", f"B {BEGIN}", "made B", *copied, "B start", "A(Clone) start", "step 2")


def test_one_made_before_the_first_step_begins_in_it(world):
    run = world("A period=1", "B period=1 late", "A start 1: make B")
    assert run.reset() == [("wants", 0, 0, 1), ("wants", 1, 0, 1)]
    starts(run.told(), "A init", "A start", "B init", "made B", "B start", "reset", f"A {BEGIN}", f"B {BEGIN}")


def test_enabled_again_it_has_another_id_and_its_episode_begins_at_once(world):
    """Its steps go on, its episodes are not counted, and it is initialized once more. It asks by the Academy's step."""
    run = world("A period=2", "B", "B physics 2: A>add 1, A>off", "B physics 4: A>on")
    run.reset()
    assert run.step(7) == [("ended", 0, 1, 2)]
    assert run.step() == [("wants", 2, 0, 3)]
    lines = run.told()
    starts(
        lines[lines.index("B physics") :], "B physics", "A see 2", "step 2", "step 3", "B physics", "A init",
        "A begin steps=2 sum=0 episodes=0", "step 4", "A see 3"
    )  # fmt: skip


def test_the_row_of_the_last_one_that_is_disabled_waits(world):
    """Nobody exchanges until an agent of Python's is enabled again: B has a Heuristic of its own.

    In step 4 its requester has asked for it, though it is off: in step 5 it decides.
    """
    channel = EnvironmentParametersChannel()
    deeds = ["A physics 2: off", "B physics 5: A>on", "B physics *: parameter p"]
    run = world("A period=2", "B type=HeuristicOnly behavior=Other", *deeds, side_channels=[channel])
    run.reset()
    assert run.step() == [("ended", 0, 0, 2), ("wants", 2, 0, 3)]
    channel.set_float_parameter("p", 3)
    assert run.step() == [("wants", 2, 0, 4)]
    starts([line for line in run.told() if line.startswith("p ")], *["p -1"] * 5, "p 3")


def test_a_decision_that_was_asked_for_after_a_step_goes_in_the_next_one_once(world):
    run = world("A", "A physics 2: ask, ask, request", "A update 2: ask")
    assert run.reset() == [("wants", 0, 0, 1)]
    assert run.step(4) == [("wants", 0, 0, 2)]
    lines = run.told()
    starts(
        lines[lines.index("step 0") :], "step 0", "step 1", "A physics", "step 2", "A see 3", "A act 4", "A update",
        "step 3", "A see 4"
    )  # fmt: skip


def test_in_fixedupdate_it_asks_for_the_next_step(world):
    """Ours is before all others. (In ML-Agents it has no order.)"""
    run = world("A", "A fixed 3: ask")
    run.reset()
    lines = run.told()
    starts(lines[lines.index("step 2") :], "step 2", "A fixed", "step 3", "A see 4")


def test_physics_stays_unitys(world):
    run = world("A period=1", "A act 1: physics, python", "A see 3: physics")
    for act in (run.reset, run.step, run.step, run.step):
        act()
    lines = run.told()
    assert [line for line in lines if "by" in line] == ["physics by FixedUpdate"] * 2
    assert "python True" in lines and "Physics.Simulate" not in run.output


def test_a_step_by_hand(alone):
    """None within a step, and none by FixedUpdate."""
    deeds = ["A init 1: automatic off", "A update 2: step, step", "A act 1: step"]
    lines, _ = alone("A period=1", *deeds, "steps=2")
    (thrown,) = [line for line in lines if line.startswith("A threw UnityAgentsException: ")]
    assert "EnvironmentStep" in thrown
    lines.remove(thrown)
    acts = ["step 0", "A see 1", "A decide 0", "A act 1", "step 1", "A see 2", "A decide 0", "A act 2"]
    starts(lines, "A init", "A start", "A update", "reset", f"A {BEGIN}", *acts)


# Python


def test_pythons_seed_goes_to_unitys_random_once(world):
    def numbers(seed):
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
