"""The page "You come from ML-Agents": a project moves in as it says, its tables are true, and the log channel of
ML-Agents' documentation runs, of early 2020 and of today, in both languages. Each line that names ML-Agents is replaced
as the page says, and nothing else.
"""

import importlib
import re
import signal

import pytest

from kitlib.docs import guide
from kitlib.unity import ml_agents
from tests.conftest import PYTHON
from tests.programs import LIMIT, ROOT, finished, steady_port

gymnasium = pytest.importorskip("gymnasium", reason="lesson 09 needs gymnasium: kit.py run 9 installs it")

from tests.lessons.scene_clock import Arena, ArenaSimulator, Walker  # noqa: E402

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


def written(text: str, changes: dict[str, str]) -> str:
    """A text of 2020 as the documentation has it today."""
    for old, new in changes.items():
        assert text.count(old) == 1, old
        text = text.replace(old, new)
    return text


NEW_CHANNEL = written(
    OLD_CHANNEL,
    {
        "using MLAgents;\nusing MLAgents.SideChannels;": "using Unity.MLAgents;\nusing Unity.MLAgents.SideChannels;",
        "using System.Text;\n": "",
        "public override void OnMess": "protected override void OnMess",
        "byte[] msg": "IncomingMessage msg",
        "Encoding.ASCII.GetString(msg)": "msg.ReadString()",
        """        var line = type + ": " + logString;
        var bytes = Encoding.ASCII.GetBytes(line);
        base.QueueMessageToSend(bytes);
""": """        using (var message = new OutgoingMessage())
        {
            message.WriteString(type + ": " + logString);
            QueueMessageToSend(message);
        }
""",
    },
)
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
    decision_steps, terminal_steps = env.get_steps(group_name)
    n_agents = len(decision_steps) + len(terminal_steps)
    string_log.send_string(f"step {i}, agents: {n_agents}")
    env.step()
env.close()
"""
NEW_PYTHON = written(
    OLD_PYTHON,
    {
        "import SideChannel\n": "import IncomingMessage, OutgoingMessage, SideChannel\n",
        "(self, data: bytes)": "(self, msg: IncomingMessage)",
        'data.decode("ascii")': "msg.read_string()",
        """        super().queue_message_to_send(data.encode("ascii"))
""": """        msg = OutgoingMessage()
        msg.write_string(data)
        super().queue_message_to_send(msg)
""",
        "base_port=UnityEnvironment.DEFAULT_EDITOR_PORT, ": "",
        "env.get_agent_groups()[0]": "list(env.behavior_specs.keys())[0]",
    },
)
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


CHASER = """using Unity.MLAgents;
using Unity.MLAgents.Actuators;
using Unity.MLAgents.Sensors;
using UnityEngine;

public class Chaser : Agent
{
    public Transform target;
    private float speed;

    public override void Initialize() =>
        speed = Academy.Instance.EnvironmentParameters.GetWithDefault("speed", 2);

    public override void OnEpisodeBegin()
    {
        transform.localPosition = Vector3.zero;
        target.localPosition = new Vector3(Random.Range(-3f, 3f), 0, 0);
    }

    public override void CollectObservations(VectorSensor sensor)
    {
        sensor.AddObservation(transform.localPosition.x);
        sensor.AddObservation(target.localPosition.x);
    }

    public override void OnActionReceived(ActionBuffers actions)
    {
        var push = Mathf.Clamp(actions.ContinuousActions[0], -1, 1);
        transform.localPosition += Vector3.right * (push * speed * Time.deltaTime);
        AddReward(-0.01f);
        if (Mathf.Abs(transform.localPosition.x - target.localPosition.x) > 0.2f) return;
        SetReward(1);
        EndEpisode();
    }

    public override void Heuristic(in ActionBuffers actionsOut)
    {
        var continuous = actionsOut.ContinuousActions;
        continuous[0] = Input.GetAxis("Horizontal");
    }
}
"""
PROJECT = {
    "Assets/Chaser.cs": CHASER,
    "Assets/Main.unity": """%YAML 1.1
--- !u!114 &1
MonoBehaviour:
  m_Script: {fileID: 11500000, guid: 5d1c4e0b1822b495aa52bc52839ecb30, type: 3}
  m_BrainParameters:
    VectorObservationSize: 2
    NumStackedVectorObservations: 1
    m_ActionSpec:
      m_NumContinuousActions: 1
      BranchSizes:
  m_BehaviorName: Chaser
  m_BehaviorType: 0
  TeamId: 0
  m_Model: {fileID: 11400000, guid: 0123456789abcdef0123456789abcdef, type: 3}
--- !u!114 &2
MonoBehaviour:
  m_Script: {fileID: 11500000, guid: 3a5c9d521e5ef4759a8246a07d52221e, type: 3}
  DecisionPeriod: 5
""",
    "Packages/manifest.json": '{"dependencies": {"com.unity.ml-agents": "3.0.0"}}',
    "ProjectSettings/ProjectVersion.txt": "m_EditorVersion: 2022.3.62f1\n",
}
BLOCKS = [*guide.blocks(GUIDE / "from_ml_agents.md")]
LOOP, BY_GYMNASIUM = [block.body for block in BLOCKS if block.language == "python"]
(BEHAVIOR,) = [block.body for block in BLOCKS if block.language == "csharp"]
(SAID,) = [block.body for block in BLOCKS if block.body.startswith("kit ")]
# Its port is this test's own; what it did is shown, and the player may compile for longer than it waits.
SHOWN = """
print(name, actions, decision_steps.obs[0].shape)
"""
THINKS = """
import threading
from netmq_example.mlagents_envs.environment import UnityEnvironment
env = UnityEnvironment(base_port={port})
threading.Event().wait()
"""


def test_a_project_moves_in_as_the_page_says(tmp_path, start, console, netmq):
    root = tmp_path / "My Game"
    for name, text in PROJECT.items():
        (root / name).parent.mkdir(parents=True, exist_ok=True)
        (root / name).write_text(text, encoding="utf-8")
    move = [PYTHON, ROOT / "kit.py", "unity", root, "--from", "ml-agents"]
    said = iter(finished(move).stdout.splitlines())
    assert [line for line in SAID.splitlines() if line != "..." and line not in said] == []
    assert finished([*move, "--yes", "--scripts-only"]).returncode == 0
    port = steady_port()
    loop = LOOP.replace("UnityEnvironment()", f"UnityEnvironment(base_port={port}, timeout_wait={LIMIT})")
    (tmp_path / "loop.py").write_text(loop.replace("env.close()", f"{SHOWN}env.close()"), encoding="utf-8")
    (tmp_path / "Behavior.cs").write_text(BEHAVIOR, encoding="utf-8")
    python = start(PYTHON, tmp_path / "loop.py", PYTHONPATH=str(ROOT / "python"))
    # A scene that finds no Python goes on by its Heuristic, as with ML-Agents.
    python.wait_for("^waiting for a simulator")
    files = [tmp_path / "Behavior.cs", root / "Assets" / "Chaser.cs"]
    words = ["--target", "Target", "--add", "DecisionRequester", "--mlagents-port", f"{port}"]
    player = start(PYTHON, ROOT / "kit.py", "play", *files, *words)
    assert python.wait(2 * LIMIT) == 0, python.output + player.output
    assert player.wait() == 0, player.output
    assert python.lines[-1].startswith("Chaser?team=0 ActionSpec(continuous_size=1"), python.output
    assert re.search(r"\([01], 2\)$", python.lines[-1]), python.output
    assert "Play ends: Python has closed it" in player.lines and "trouble" not in player.output
    both = finished([PYTHON, ROOT / "kit.py", "play", *files, *words, "--add", "GymManager", "--seconds", "1"])
    assert "such as a GymManager or one with side channels, has the connection" in both.stdout + both.stderr
    # A Python that thinks does not keep a player that is to end.
    thinking = start(PYTHON, "-c", THINKS.format(port=port), PYTHONPATH=str(ROOT / "python"))
    thinking.wait_for("^waiting for a simulator")
    player = start(PYTHON, ROOT / "kit.py", "play", *files, *words)
    player.wait_for("^simulating Main")
    assert player.stop(signal.SIGINT) != 0 and "stopped" in player.lines
    thinking.kill()


def test_the_pages_lines_drive_a_moved_scene_by_gymnasium(served):
    arena = Arena(Walker("Ball", period=5, length=12), name="Main")
    exec(BY_GYMNASIUM.replace("5004", f"{served(ArenaSimulator(arena), LIMIT)}"), {})
    # Its episodes have three decisions at most.
    assert len(arena.resets) > 100 // 3


def rows(title):
    """The rows of a section's tables, each with what its cells have as code."""
    section = PAGE.partition(f"\n## {title}\n")[2].partition("\n## ")[0]
    lines = [line.strip("|").split("|") for line in section.split("\n") if line.startswith("| ") and "`" in line]
    return [[re.findall("`([^`]+)`", cell) for cell in line] for line in lines]


def test_the_modules_that_the_page_names_are_there():
    for old, new, *_ in rows("What you change"):
        for name in [*old, *new]:
            whole = name if name[0] != "." else f"{(old if name in old else new)[0].rpartition('.')[0]}{name}"
            if re.fullmatch(r"(netmq_example\.)?mlagents_envs[.\w]*", whole):
                importlib.import_module(f"netmq_example.{whole.removeprefix('netmq_example.')}")


def test_the_seven_words_of_the_page_are_what_the_command_says():
    said = list(ml_agents.FACTS["words"].values())
    found = 0
    for (word, *_), (new, *_), *_ in rows("What you change"):
        for line in said:
            if line.startswith(word.partition("(")[0]):
                assert new in line
                found += 1
    assert found == 7


def test_each_line_that_the_page_quotes_is_one_of_the_kits():
    folders = ("unity/Assets/NetMQExample/MLAgents", "kitlib/unity", "python/netmq_example/mlagents_envs")
    files = [
        path for folder in folders for path in ROOT.glob(f"{folder}/**/*") if path.suffix in (".cs", ".py", ".toml")
    ]
    # A text goes on in the next line of a source.
    source = re.sub(r'"\s*\+?\s*\$?f?"', "", "".join(path.read_text(encoding="utf-8") for path in files))
    for _, (line, *_), *_ in rows("What stays behind"):
        for part in re.split(" ?…,? ?", line):
            assert part in source, part


def test_an_academy_of_before_1_is_named():
    found = ml_agents.csharp("using MLAgents;\nclass Mine : Academy { }\n", set(), True)
    assert [note.text.partition(":")[0] for note in found.notes] == ["an Academy of your own is not needed any more"]
