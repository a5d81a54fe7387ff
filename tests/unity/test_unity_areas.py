"""Many agents in a scene: the terminal's numbers, and one step of physics for all of them."""

import sys
from typing import Any

import pytest

from tests.programs import ROOT, steady_endpoint
from tests.unity.conftest import NEAREST

np = pytest.importorskip("numpy", reason="lesson 10 needs numpy: pip install numpy")
gymnasium = pytest.importorskip("gymnasium", reason="lesson 10 needs gymnasium: pip install gymnasium")
from gymnasium.utils.env_checker import data_equivalence  # noqa: E402

pytest.importorskip("pettingzoo", reason="lesson 10 needs pettingzoo: pip install pettingzoo")
# It registers them, too.
from netmq_example.envs import UnityGymEnv, UnityParallelEnv, UnityVectorEnv  # noqa: E402

AREAS = 4
ID, CLIENT = "NetMQExample/CartPole-v0", ROOT / "python" / "10_many_agents" / "client.py"


def test_areas_of_a_scene_are_those_of_a_terminal(play):
    """One connection serves all of them, and physics moves once for all."""
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


@pytest.mark.parametrize(
    ("what", "said"),
    [
        ("rate", ["2 30", "0 -1", "2 30"]),
        ("keep", ["2 30"]),
        ("set", ["2 30", "0 -1", "0 50", "2 50"]),
        ("off", ["2 30", "0 -1", "2 30"]),
    ],
)
def test_frames_are_as_fast_as_they_can_while_python_steps_and_no_longer(what, said, play):
    endpoint = steady_endpoint()
    program = play("areas", "2", what, "--endpoint", endpoint)
    envs = gymnasium.make_vec(ID, 2, endpoint=endpoint)
    try:
        # It said hello and was asked nothing: nobody knows for how long Python will think.
        assert "frames: 0 -1" not in program.lines
        envs.reset(seed=1)
        if what != "keep":
            program.wait_for("^frames: 0 -1$")
        for _ in range(5 * (what != "off")):
            envs.step(np.ones(2, int))
        if what == "set":
            program.wait_for(f"^frames: {said[2]}$")
    finally:
        envs.close()
    assert program.wait() == 0, program.output
    assert [line for line in program.lines if line.startswith("frames: ")] == [f"frames: {each}" for each in said]


QUIET: dict[str, Any] = {
    "world": lambda endpoint: UnityGymEnv("Quiet", endpoint=endpoint),
    "areas": lambda endpoint: UnityVectorEnv(3, "Quiet", endpoint=endpoint),
    "game": lambda endpoint: UnityParallelEnv("Quiet", endpoint=endpoint),
}


@pytest.mark.parametrize("what", QUIET)
def test_a_frame_in_which_python_steps_leaves_nothing_to_collect(what, play):
    endpoint = steady_endpoint()
    program = play("quiet", what, "--endpoint", endpoint)
    env = QUIET[what](endpoint)
    infos = env.reset(seed=1)[-1]
    spaces = {agent: env.action_space(agent) for agent in env.agents} if what == "game" else {"": env.action_space}
    steps = 0
    while "lost" not in str(infos):
        actions = {agent: space.sample() for agent, space in spaces.items()}
        *_, infos = env.step(actions.get("", actions))
        steps += 1
    env.close()
    assert program.wait() == 0, program.output
    assert program.lines[-1].endswith(", 0 bytes allocated in 0 frames"), program.lines[-1]
    assert steps >= 200, "one in each frame, and as a rule a hundred"


def test_physics_is_given_back_by_the_last_one_that_steps_it(play):
    program = play("areas", "2", "switch")
    assert program.wait() == 0, program.output
    said = [line for line in program.lines if line.startswith("physics: ")]
    assert said == [*["physics: Script"] * 2, "physics: FixedUpdate"]
