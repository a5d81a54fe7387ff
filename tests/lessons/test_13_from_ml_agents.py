"""The page "You come from ML-Agents": the log channel of its documentation runs, of early 2020 and of today, in both
languages. Each line that names ML-Agents is replaced as the page says, and nothing else.
"""

from __future__ import annotations

import re

import pytest

from kitlib.docs import guide
from kitlib.lessons import find
from kitlib.unity.scripts import code, of_lesson, with_used
from tests.conftest import PYTHON
from tests.programs import LIMIT, ROOT, steady_port

pytest.importorskip("gymnasium", reason="lesson 09 needs gymnasium: kit.py run 9 installs it")

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
