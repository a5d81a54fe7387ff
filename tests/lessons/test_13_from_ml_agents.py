"""The page "You come from ML-Agents": the log channel of its documentation runs, of early 2020 and of today, in both
languages. Each line that names ML-Agents is replaced as the page says, and nothing else.
"""

from __future__ import annotations

import re
import threading
import uuid

import pytest

from kitlib.docs import guide
from kitlib.lessons import find
from kitlib.unity.scripts import code, of_lesson, with_used
from tests.conftest import PYTHON
from tests.programs import LIMIT, ROOT, steady_port

pytest.importorskip("gymnasium", reason="lesson 09 needs gymnasium: kit.py run 9 installs it")
import numpy as np
from gymnasium.spaces import Box, Dict, Discrete, MultiDiscrete, Text

from netmq_example.mlagents_envs.base_env import ActionTuple, DecisionStep, TerminalStep
from netmq_example.mlagents_envs.environment import UnityEnvironment
from netmq_example.mlagents_envs.exception import (
    UnityActionException,
    UnityCommunicationException,
    UnityCommunicatorStoppedException,
    UnityEnvironmentException,
    UnityException,
    UnityTimeOutException,
    UnityWorkerInUseException,
)
from netmq_example.mlagents_envs.side_channel.raw_bytes_channel import RawBytesChannel
from netmq_example.scene import Agent, EnvironmentClient, Scene, SceneSimulator

GUIDE = ROOT / "docs" / "guide"
PAGE = (GUIDE / "from_ml_agents.md").read_text(encoding="utf-8")
# Line by line, where a lookup in the page finds both halves.
CSHARP = {
    "using Unity.MLAgents;": "using NetMQExample.MLAgents;",
    "using Unity.MLAgents.SideChannels;": "using NetMQExample.MLAgents.SideChannels;",
    "using MLAgents;": "using NetMQExample.MLAgents;",
    "using MLAgents.SideChannels;": "using NetMQExample.RawSideChannels;",
}
RAW = (
    "from netmq_example.mlagents_envs.side_channel.side_channel import SideChannel",
    "from netmq_example.mlagents_envs.side_channel.raw_side_channel import SideChannel",
)

OLD_CHANNEL = """using MLAgents;
using MLAgents.SideChannels;
using System;
using System.Text;
using UnityEngine;

public class StringLogSideChannel : SideChannel
{
    public StringLogSideChannel()
    {
        ChannelId = new Guid("621f0a70-4f87-11ea-a6bf-784f4387d1f7");
    }

    public override void OnMessageReceived(byte[] msg)
    {
        var text = Encoding.ASCII.GetString(msg);
        Debug.Log("Python says " + text);
    }

    public void SendDebugStatementToPython(string logString, string stackTrace, LogType type)
    {
        if (type != LogType.Error) return;
        var line = type + ": " + logString;
        var bytes = Encoding.ASCII.GetBytes(line);
        base.QueueMessageToSend(bytes);
    }
}
"""
OLD_REGISTER = """using MLAgents;
using UnityEngine;

public class RegisterStringLogSideChannel : MonoBehaviour
{
    StringLogSideChannel channel;

    public void Awake()
    {
        channel = new StringLogSideChannel();
        Application.logMessageReceived += channel.SendDebugStatementToPython;
        Academy.Instance.RegisterSideChannel(channel);
    }

    public void OnDestroy()
    {
        Application.logMessageReceived -= channel.SendDebugStatementToPython;
        if (Academy.IsInitialized)
        {
            Academy.Instance.UnregisterSideChannel(channel);
        }
    }

    public void Update()
    {
        if (Input.GetKeyDown(KeyCode.Space)) Debug.LogError("somebody pressed Space");
    }
}
"""
NEW_CHANNEL = """using Unity.MLAgents;
using Unity.MLAgents.SideChannels;
using System;
using UnityEngine;

public class StringLogSideChannel : SideChannel
{
    public StringLogSideChannel()
    {
        ChannelId = new Guid("621f0a70-4f87-11ea-a6bf-784f4387d1f7");
    }

    protected override void OnMessageReceived(IncomingMessage msg)
    {
        var text = msg.ReadString();
        Debug.Log("Python says " + text);
    }

    public void SendDebugStatementToPython(string logString, string stackTrace, LogType type)
    {
        if (type != LogType.Error) return;
        using (var message = new OutgoingMessage())
        {
            message.WriteString(type + ": " + logString);
            QueueMessageToSend(message);
        }
    }
}
"""
NEW_REGISTER = (
    OLD_REGISTER.replace("using MLAgents;", "using Unity.MLAgents;\nusing Unity.MLAgents.SideChannels;")
    .replace("Academy.Instance.Reg", "SideChannelManager.Reg")
    .replace("Academy.Instance.Unreg", "SideChannelManager.Unreg")
)
OLD_PYTHON = """import uuid

from mlagents_envs.environment import UnityEnvironment
from mlagents_envs.side_channel.side_channel import SideChannel


class StringLogChannel(SideChannel):
    def __init__(self) -> None:
        super().__init__(uuid.UUID("621f0a70-4f87-11ea-a6bf-784f4387d1f7"))

    def on_message_received(self, data: bytes) -> None:
        print(data.decode("ascii"), flush=True)

    def send_string(self, data: str) -> None:
        super().queue_message_to_send(data.encode("ascii"))


string_log = StringLogChannel()
env = UnityEnvironment(base_port=UnityEnvironment.DEFAULT_EDITOR_PORT, side_channels=[string_log])
env.reset()
string_log.send_string("the world was made")
group_name = env.get_agent_groups()[0]
for i in range(1000):
    step_data = env.get_step_result(group_name)
    n_agents = step_data.n_agents()
    string_log.send_string(f"step {i}, agents: {n_agents}")
    env.step()
env.close()
"""
NEW_PYTHON = """import uuid

from mlagents_envs.environment import UnityEnvironment
from mlagents_envs.side_channel.side_channel import IncomingMessage, OutgoingMessage, SideChannel


class StringLogChannel(SideChannel):
    def __init__(self) -> None:
        super().__init__(uuid.UUID("621f0a70-4f87-11ea-a6bf-784f4387d1f7"))

    def on_message_received(self, msg: IncomingMessage) -> None:
        print(msg.read_string(), flush=True)

    def send_string(self, data: str) -> None:
        msg = OutgoingMessage()
        msg.write_string(data)
        super().queue_message_to_send(msg)


string_log = StringLogChannel()
env = UnityEnvironment(side_channels=[string_log])
env.reset()
string_log.send_string("the world was made")
group_name = list(env.behavior_specs.keys())[0]
for i in range(1000):
    decision_steps, terminal_steps = env.get_steps(group_name)
    n_agents = len(decision_steps) + len(terminal_steps)
    string_log.send_string(f"step {i}, agents: {n_agents}")
    env.step()
env.close()
"""
# The scene: an agent, and the page's manager of lesson 13. Its episodes have ten steps, and in the fourth of them all
# somebody presses Space.
WORLD = """using NetMQExample;
using UnityEngine;

public sealed class World : Agent
{
    private int steps, all;

    public override GymSpace Observation { get; } = GymSpace.Box(new[] { 0.0 }, new[] { 10.0 });
    public override GymSpace Action { get; } = GymSpace.Discrete(3);
    public override void OnReset() => steps = 0;
    public override void Observe(SpaceWriter seen) => seen.Add(steps);

    public override void OnAction(SpaceReader action)
    {
        steps++;
        if (++all == 4) UnityPlayer.Player.Press(0, 0, KeyCode.Space);
        if (steps == 10) Terminate();
    }
}
"""
(MANAGER,) = [block.body for block in guide.blocks(GUIDE / "13_side_channels.md") if "MakeSimulator" in block.body]
OLD, NEW = (OLD_CHANNEL, OLD_REGISTER, OLD_PYTHON), (NEW_CHANNEL, NEW_REGISTER, NEW_PYTHON)


def moved(text: str) -> str:
    """With the page's replacements of whole lines."""
    return "\n".join(CSHARP.get(line, line) for line in text.split("\n"))


@pytest.mark.parametrize("channel, register, script", [OLD, NEW], ids=["2020", "today"])
def test_the_example_of_the_documentation_runs(channel, register, script, tmp_path, start, console, netmq):
    port = steady_port()
    old = channel is OLD_CHANNEL
    scripts = {"World": WORLD, "MyManager": MANAGER, "StringLogSideChannel": channel, "Register": register}
    for name, text in scripts.items():
        assert "MLAgents" not in moved(text).replace("NetMQExample.MLAgents", "")
        (tmp_path / f"{name}.cs").write_text(moved(text), encoding="utf-8")
    # The scene's port is this test's own.
    script = script.replace("UnityEnvironment.DEFAULT_EDITOR_PORT", f"{port}")
    script = script.replace("UnityEnvironment(side", f"UnityEnvironment(base_port={port}, side")
    # The player may compile for longer than Python waits by itself.
    script = script.replace("side_channels=[", f"timeout_wait={LIMIT}, side_channels=[")
    script = script.replace("mlagents_envs", "netmq_example.mlagents_envs")
    script = script.replace(*RAW) if old else script
    (tmp_path / "log.py").write_text(script, encoding="utf-8")
    python = start(PYTHON, tmp_path / "log.py", PYTHONPATH=str(ROOT / "python"))
    files = [tmp_path / f"{name}.cs" for name in scripts]
    player = start(PYTHON, ROOT / "kit.py", "play", *files, "--endpoint", f"tcp://127.0.0.1:{port}")
    assert python.wait(2 * LIMIT) == 0, python.output + player.output
    # An error was logged.
    assert player.wait() == 1, player.output
    assert python.lines.count("Error: somebody pressed Space") == 1
    heard = [line for line in player.lines if line.startswith("Python says")]
    assert heard[0] == "Python says the world was made"
    # The one whose episode has ended, and the one that begins: every ten steps, as there.
    assert heard[1:] == [f"Python says step {i}, agents: {1 + (i > 0 and i % 10 == 0)}" for i in range(1000)]
    assert "trouble" not in player.output


def test_the_page_says_each_replacement():
    for line, new in CSHARP.items():
        row = next(row for row in PAGE.split("\n") if row.startswith("|") and f"`{line}`" in row)
        assert f"`{new}`" in row, row
    assert f"`{RAW[1]}`" in PAGE


def test_the_examples_that_the_page_lets_one_delete_are_used_by_nothing_else():
    (listed,) = re.findall(r"delete the\s+examples: (.*?)\.$", PAGE, re.DOTALL | re.MULTILINE)
    gone = re.findall(r"`(\w+)`", listed)
    copied = {script for lesson in ("13", "9") for script in of_lesson(find(lesson).unity) if script.suffix == ".cs"}
    left = {script for script in copied if not {script.stem, script.parent.name} & {*gone}}
    assert all(any(name in (script.stem, script.parent.name) for script in copied) for name in gone)
    # With what these use in turn.
    assert set(with_used(sorted(left), "99", code)) == left


# The environment


class Corridor(Agent):
    """Five numbers of steps; what was done is seen."""

    observation = Dict(done=Box(-9, 9, (2,)), step=Box(0, 9, ()))

    def __init__(self, action=None, last=(5, True)):
        super().__init__()
        self.action, (self.end, self.terminates) = action or Box(-1, 1, (2,)), last

    def on_reset(self):
        self.steps, self.done = 0, np.zeros(2)

    def on_action(self, action):
        self.steps += 1
        self.done = np.resize(action, 2)
        self.reward = 0.5
        over = self.steps == self.end
        self.terminated, self.truncated = over and self.terminates, over and not self.terminates

    def observe(self):
        return {"done": self.done.astype(np.float32), "step": np.array(self.steps, np.float32)}


@pytest.fixture
def corridor():
    """corridor(*words): ML-Agents' environment of a simulator in a thread of this process."""
    made, threads = [], []

    def make(*words, **more):
        port = steady_port()
        client = EnvironmentClient(f"tcp://127.0.0.1:{port}", timeout=LIMIT)
        scene = SceneSimulator(Scene("Corridor", [Corridor(*words)]))
        threads.append(threading.Thread(target=client.run, args=(scene,), daemon=True))
        threads[-1].start()
        made.append(UnityEnvironment(base_port=port - 3, worker_id=3, **more))
        return made[-1]

    yield make
    for env in made:
        env.close()
    for thread in threads:
        thread.join(LIMIT)


def test_what_is_seen_and_done_has_its_names(corridor):
    env = corridor()
    env.step()
    (name,) = env.get_behavior_names()
    assert (name, list(env.behavior_specs)) == ("Corridor?team=0", [name])
    spec = env.behavior_specs[name]
    assert [(one.name, one.shape) for one in spec.observation_specs] == [("done", (2,)), ("step", ())]
    assert spec.action_spec == (2, ())
    assert spec.action_spec.is_continuous() and not spec.action_spec.is_discrete()
    now, over = env.get_steps(name)
    assert (len(now), len(over), list(now), now.reward.tolist()) == (1, 0, [0], [0.0])
    assert [seen.shape for seen in now.obs] == [(1, 2), (1,)]
    assert [seen.shape for seen in over.obs] == [(0, 2), (0,)]
    assert now.action_mask is None
    assert [now.group_id.tolist(), now.group_reward.tolist(), over.group_id.tolist()] == [[0], [0.0], []]
    action = ActionTuple()
    action.add_continuous(np.array([[0.25, -1]]))
    env.set_action_for_agent(name, 0, action)
    env.step()
    now, _ = env.get_steps(name)
    one = now[0]
    assert isinstance(one, DecisionStep) and (one.agent_id, one.action_mask, one.group_id) == (0, None, 0)
    assert one.obs[0].tolist() == [0.25, -1] and one.reward == 0.5
    env.step()
    assert env.get_steps(name)[0].obs[0].tolist() == [[0, 0]], "an action is for one step"
    env.set_actions(name, spec.action_spec.random_action(1))
    env.step()
    assert 0 < np.abs(env.get_steps(name)[0].obs[0]).max() <= 1


@pytest.mark.parametrize("terminates", [True, False])
def test_the_step_that_ends_an_episode_begins_the_next_one(terminates, corridor):
    env = corridor(Discrete(3, start=5), (2, terminates))
    env.reset()
    (name,) = env.behavior_specs
    env.set_actions(name, np.array([[2]]))
    env.step()
    assert env.get_steps(name)[0].obs[0].tolist() == [[7, 7]], "0 is the first that there is"
    env.step()
    now, over = env.get_steps(name)
    assert (list(now), list(over)) == ([1], [0])
    assert isinstance(over[0], TerminalStep) and (over[0].agent_id, over[0].group_reward) == (0, 0)
    assert over[0].obs[1] == 2 and over[0].reward == 0.5 and bool(over[0].interrupted) == (not terminates)
    assert now[1].obs[1] == 0 and now[1].reward == 0
    both = env.get_step_result(name)
    assert (both.n_agents(), both.done.tolist(), both.agent_id.tolist()) == (2, [True, False], [0, 1])
    assert (both.obs[1].tolist(), both.reward.tolist()) == ([2, 0], [0.5, 0])
    assert both.max_step.tolist() == [not terminates, False]
    env.step()
    assert len(env.get_steps(name)[1]) == 0
    env.reset()
    assert list(env.get_steps(name)[0]) == [2]


@pytest.mark.parametrize(("end", "interrupted"), [(3, True), (2, False)])
def test_max_step_ends_an_episode_and_an_end_in_the_last_step_is_no_interruption(end, interrupted, corridor):
    env = corridor(None, (end, True), max_episode_steps=2)
    env.reset()
    (name,) = env.behavior_specs
    for _ in range(2):
        env.step()
        assert len(env.get_steps(name)[1]) == 0
        env.step()
        now, over = env.get_steps(name)
        assert over.interrupted.tolist() == [interrupted] and over.obs[1].tolist() == [2]
        assert now.obs[1].tolist() == [0]


def test_whole_numbers_that_are_several(corridor):
    env = corridor(MultiDiscrete([2, 5]))
    env.reset()
    (name,) = env.behavior_specs
    spec = env.behavior_specs[name].action_spec
    assert (spec, spec.discrete_size) == ((0, (2, 5)), 2)
    assert spec.is_discrete() and not spec.is_continuous()
    action = ActionTuple()
    action.add_discrete([[1, 4]])
    env.set_actions(name, action)
    env.step()
    assert env.get_steps(name)[0].obs[0].tolist() == [[1, 4]]


def test_what_is_wrong_is_said_in_one_line(corridor):
    with pytest.raises(ValueError, match=r"^ML-Agents has no action Text\(.*: take gymnasium.make"):
        corridor(Text(3))
    env = corridor()
    (name,) = env.behavior_specs
    with pytest.raises(ValueError, match="call reset before get_steps"):
        env.get_steps(name)
    env.reset()
    with pytest.raises(ValueError, match=r"^there is no behavior 'Maze'; there is: Corridor\?team=0$"):
        env.get_steps("Maze")
    with pytest.raises(
        ValueError, match=re.escape("an action is (1, 2) floats, (1, 0) integers, not (1, 3) and (1, 0)")
    ):
        env.set_actions(name, np.zeros((1, 3)))
    with pytest.raises(UnityActionException, match=r"^no agent 7 wants an action; there is: 0$"):
        env.set_action_for_agent(name, 7, np.zeros((1, 2)))
    with pytest.raises(ValueError, match="max_episode_steps"):
        UnityEnvironment(max_episode_steps=-1)


def test_a_simulator_that_is_missing_has_ml_agents_names(corridor):
    port = steady_port()
    with pytest.raises(UnityTimeOutException, match="no simulator came"):
        UnityEnvironment(base_port=port, timeout_wait=0.1)
    with pytest.raises(UnityTimeOutException, match="the simulator ended with code 2"):
        UnityEnvironment(str(PYTHON), additional_args=["nothing.py"])
    taken = corridor().env.simulators.connection.endpoint.rpartition(":")[2]
    in_use = rf"cannot listen on tcp://127.0.0.1:{taken}: .*; close\(\) the environment that has it"
    with pytest.raises(UnityWorkerInUseException, match=in_use):
        UnityEnvironment(base_port=int(taken))
    with pytest.raises(TypeError, match=r"^file_name takes a str or PathLike, not \['game"):
        UnityEnvironment(["game"])
    # Scripts that catch Python's own catch them as well.
    assert issubclass(UnityTimeOutException, UnityException) and issubclass(UnityTimeOutException, TimeoutError)


def test_a_build_is_launched_and_once_more_when_it_is_lost(tmp_path):
    """With the words that a build takes: here Python is the build."""
    channel = RawBytesChannel(uuid.uuid4())
    falling_ball = ROOT / "python" / "13_side_channels" / "falling_ball.py"
    env = UnityEnvironment(str(PYTHON), additional_args=[str(falling_ball)], seed=3, side_channels=[channel])
    try:
        env.reset()
        (name,) = env.get_behavior_names()
        assert name == "Ball?team=0"
        assert env.behavior_specs[name].observation_shapes == [(1,)]
        env.env.simulators.process.kill()
        env.env.simulators.process.wait()
        with pytest.raises(UnityCommunicatorStoppedException, match=r"^the simulator is lost: the simulator is gone; "):
            env.step()
        # Also by the name of any trouble with the connection.
        assert issubclass(UnityCommunicatorStoppedException, UnityCommunicationException)
        with pytest.raises(ValueError, match="call reset before get_steps"):
            env.get_steps(name)
        env.reset()
        env.step()
        assert list(env.get_steps(name)[0]) == [1], "another one goes on"
    finally:
        env.close()
    with pytest.raises(UnityEnvironmentException, match="no game at"):
        UnityEnvironment(str(tmp_path / "game"), no_graphics=True)
