"""Lesson 13 on lesson 09's steps: what was set before a step is there in it, what it records comes with its state."""

import re

import pytest

from netmq_example.mlagents_envs.side_channel import EnvironmentParametersChannel, SideChannelManager, StatsSideChannel
from tests.conftest import PYTHON
from tests.lessons.test_13_side_channels_bytes import RUNTIMES
from tests.programs import ROOT, finished
from tests.unity.test_unity_play import needs_mono

gymnasium = pytest.importorskip("gymnasium", reason="lesson 09 needs gymnasium: kit.py run 9 installs it")
from netmq_example import envs  # noqa: E402
from netmq_example.envs import UnityGymEnv, carry  # noqa: E402

KEY = "13_side_channels"


MOON = f"""
import sys
sys.path.insert(0, {str(ROOT / "python")!r})
import numpy as np
from netmq_example.scene import Agent, EnvironmentClient, Scene, SceneSimulator, SideChannelSimulator
from netmq_example.mlagents_envs.side_channel.environment_parameters_channel import EnvironmentParametersChannel
from gymnasium.spaces import Box, Discrete
from netmq_example.mlagents_envs.side_channel import OutgoingMessage
from netmq_example.mlagents_envs.side_channel.side_channel_manager import SideChannelManager
from netmq_example.mlagents_envs.side_channel.stats_side_channel import StatsSideChannel

class Parameters(EnvironmentParametersChannel):
    gravity = 9.75
    def on_message_received(self, msg):
        name, kind, self.gravity = msg.read_string(), msg.read_int32(), msg.read_float32()

class Moon(Agent):
    state_size, observation, action = 1, Box(0, 100, (1,)), Discrete(9)
    def on_reset(self):
        self.gravity = len(self.state) + parameters.gravity
    def on_action(self, action):
        message = OutgoingMessage()
        message.write_string("action")
        message.write_float32(float(action))
        message.write_int32(2)
        stats.queue_message_to_send(message)
    def observe(self):
        return [self.gravity]

count = int(sys.argv[sys.argv.index("--count") + 1]) if "--count" in sys.argv else 1
parameters, stats = Parameters(), StatsSideChannel()
simulator = SceneSimulator(Scene("Moon", [Moon("a") for _ in range(count)]))
if "--without" not in sys.argv:
    simulator = SideChannelSimulator(simulator, SideChannelManager([parameters, stats]))
EnvironmentClient(sys.argv[sys.argv.index("--endpoint") + 1], timeout=20).run(simulator)
"""


@pytest.fixture
def moon(make, tmp_path):
    """moon(*words): an environment that launches such a simulator, and its channels."""
    (tmp_path / "moon.py").write_text(MOON, encoding="utf-8")

    def made(*words, kind=UnityGymEnv, **more):
        parameters, stats, said = EnvironmentParametersChannel(), StatsSideChannel(), []
        launch = [str(word) for word in words or (PYTHON, tmp_path / "moon.py")]
        env = make(kind, env_name="Moon", launch=launch, **more)
        carry(env, SideChannelManager([parameters, stats], said.append))
        return env, parameters, stats, said

    return made


@pytest.mark.parametrize("kind", ["python", ".net", "mono"])
def test_what_is_set_before_a_reset_is_there_in_it_and_what_a_step_records_comes_with_its_state(kind, moon, checks):
    if kind == "mono":
        needs_mono()
    env, parameters, stats, said = moon(
        *([] if kind == "python" else [RUNTIMES[kind], checks, "sidechannels", "steps"])
    )
    assert env.reset(seed=1)[0] == 9.75, "nothing was set"
    parameters.set_float_parameter("gravity", 1.5)
    assert env.reset(seed=1)[0] == 1.5
    assert env.reset(seed=1, options={"state": [0.0]})[0] == 2.5, "the state is an array of its own"
    for action in (3, 5):
        seen, reward, *_, info = env.step(action)
        assert (seen, reward, info) == (1.5 + 1, 0.0, {"env": [], "agent": []})
        assert stats.get_and_reset_stats() == {"action": [(float(action), 2)]}
    parameters.set_float_parameter("gravity", 4.0)
    env.step(0)
    assert env.reset(seed=1)[0] == 4.0, "it came with the step"
    assert said == []


def test_the_example_prints_what_the_page_says():
    page = (ROOT / "docs" / "guide" / f"{KEY}.md").read_text(encoding="utf-8")
    said = re.findall(r"^gravity .* m/s$", page, re.MULTILINE)
    done = finished([PYTHON, ROOT / "python" / KEY / "falling_ball.py"])
    assert done.returncode == 0, done.stderr
    printed = [line for line in done.stdout.splitlines() if not line.startswith("simulating Ball for")]
    assert len(said) == 2 and printed == said, done.stdout


def test_what_was_said_to_a_lost_simulator_is_said_to_the_next_one(moon):
    env, parameters, stats, _ = moon()
    env.reset(seed=1)
    parameters.set_float_parameter("gravity", 1.5)
    env.simulators.process.kill()
    assert "lost" in env.step(1)[-1]
    assert env.reset(seed=1)[0] == 1.5
    assert stats.get_and_reset_stats() == {}
    # And what is said anew before the reset that follows is there in it, too.
    parameters.set_float_parameter("gravity", 2.5)
    env.simulators.process.kill()
    assert "lost" in env.step(1)[-1]
    parameters.set_float_parameter("gravity", 3.5)
    assert env.reset(seed=1)[0] == 3.5


@pytest.mark.parametrize("kind", ["UnityVectorEnv", "UnityParallelEnv", "UnityAECEnv"])
def test_many_agents_carry_them_as_well(kind, moon, tmp_path):
    pytest.importorskip("pettingzoo", reason="lesson 10 needs pettingzoo: kit.py run 10 installs it")
    count = {"num_envs": 2} if kind == "UnityVectorEnv" else {}
    words = PYTHON, tmp_path / "moon.py", "--count", "2"
    env, parameters, stats, said = moon(*words, kind=getattr(envs, kind), **count)
    parameters.set_float_parameter("gravity", 1.5)
    seen = env.reset(seed=1)
    if kind == "UnityVectorEnv":
        assert seen[0].tolist() == [[1.5], [1.5]]
        env.step(env.action_space.dtype.type([3, 5]))
    elif kind == "UnityParallelEnv":
        assert seen[0] == {"a_0": 1.5, "a_1": 1.5}
        env.step({"a_0": 3, "a_1": 5})
    else:
        for action in (3, 5):
            assert env.last()[0] == 1.5
            env.step(action)
    assert stats.get_and_reset_stats() == {"action": [(3.0, 2), (5.0, 2)]}
    assert said == []


def test_a_vector_that_gymnasium_makes_is_refused_with_the_cure():
    many = gymnasium.vector.SyncVectorEnv([lambda: gymnasium.make("CartPole-v1")])
    with pytest.raises(TypeError, match=r"^SyncVectorEnv is not of this package: carry where each environment"):
        carry(many, None)


@pytest.mark.parametrize("kind", ["python", "csharp"])
def test_a_simulator_without_side_channels_is_one_line_with_the_cure(kind, moon, checks, tmp_path, caplog):
    words = (
        (PYTHON, tmp_path / "moon.py", "--without") if kind == "python" else ("dotnet", checks, "sidechannels", "plain")
    )
    env, parameters, stats, said = moon(*words)
    for _ in range(2):
        assert env.reset(seed=1)[0] == 9.75
        parameters.set_float_parameter("gravity", 1.5)
        assert env.step(1)[0] == 9.75
    (line,) = [line for line in caplog.messages if "side-channels" in line]
    assert line.endswith("; is the simulator in a SideChannelSimulator?")
    assert (stats.get_and_reset_stats(), said) == ({}, [])


def test_a_cut_exchange_is_a_line_and_the_step_is_done(moon, capfd):
    env, _, _, said = moon()
    env.reset(seed=1)
    env.simulators.ask.__self__.unsent = b"cut"
    assert env.step(1)[0] == 9.75
    assert said == []
    env.close()
    # The launched simulator says it, on the terminal that it shares with this one.
    assert "an exchange that ends with 3 bytes of a header" in "".join(capfd.readouterr())
