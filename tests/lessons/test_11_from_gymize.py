"""The page "You come from gymize": its agent and its script run as they stand there. And each defect that its users
knew of, or that was found when it was read, is a test here or in another file of this lesson:

- several agents were waited for until one had answered: test_a_step_waits_for_all_who_act
- with PettingZoo 1.27 its AEC class failed, and asking twice for `last()` hung: test_one_after_the_other
- reset cleared terminations twice, truncations never: test_reset_clears_rewards_ends_and_infos
- `OnInfo +=` did not compile, and who None and "" are was said wrong: below, and test_infos_go_both_ways
- an agent that was disabled stayed (OnDisabled, misspelt): test_agents_end_leave_and_come, and below in a scene
- a picture had four channels, and three in its shape: test_a_camera_sensor_sees_the_scene_upright
- private members of base classes were not found: test_every_member_is_seen_as_its_attribute_says
- observations began with a random sample, dicts were replaced whole, and what was handed out changed later:
  test_observations_are_copies_and_begin_with_nothing, and test_11_merge.py
- dictionaries were touched by socket threads: here only Update touches a scene, and the player, in which the tests
  below run, throws if another thread does

What cannot exist here: a pinned websockets, resumed connections, distutils, NumSharp's DLL (none is used); a deleted
folder beside a video (lesson 11 writes no files).
"""

from __future__ import annotations

import ast
import re
import sys

import pytest

from kitlib.docs import guide
from tests.conftest import PYTHON
from tests.docs.test_guide import build
from tests.programs import ROOT, finished, free_port, steady_endpoint

pytest.importorskip("gymnasium", reason="lesson 11 needs gymnasium: pip install gymnasium")
PAGE = ROOT / "docs" / "guide" / "from_gymize.md"
PARTS = {block.language: block.body for block in guide.blocks(PAGE)}

# The page's agent, a manager that is found, and what the scene says of itself; as in a scene file.
PLAY = """
using UnityEngine;
using NetMQExample;

public sealed class Says : MonoBehaviour
{
    private void Start()
    {
        if (GymManager.Current != null) GymManager.Current.Simulator.OnInfo += info => Debug.Log($"heard {info}");
    }
}

public sealed class Radar : SensorComponent
{
    public bool broken;
    public override object GetObservation() => broken ? (object)gameObject : new Vector2(7, 8);
}

public sealed class Speeder : Agent
{
    [Box(".speed[")] private float speed = 1;
    public override void OnReset() { }
    public override void OnAction(object action) { }
}

public abstract class Animal : Agent
{
    private void FixedUpdate() { }
}

public sealed class Clocked : Animal
{
    public override void OnReset() { }
    public override void OnAction(object action) { }
    private void Start() { }
}

public static class Program
{
    public static void Main(string[] args)
    {
        var player = new UnityPlayer.Player(typeof(Runner).Assembly);
        player.Begin(() =>
        {
            var (thing, other) = (new GameObject("scene"), new GameObject("twin"));
            thing.SetActive(false);
            var scripts = new MonoBehaviour[] { thing.AddComponent<Runner>(), thing.AddComponent<GymManager>() };
            thing.AddComponent<Says>();
            UnityPlayer.Inspector.Set(scripts, "endpoint", args[0]);
            UnityPlayer.Inspector.Set(scripts, "envName", "Runner");
            // Before any other agent.
            if (args[1] == "locator") other.AddComponent<Speeder>();
            if (args[1] == "alone") scripts[1].enabled = false;
            thing.SetActive(true);
            if (args[1] == "named")
            {
                ((Agent)scripts[0]).Name = "one";
                other.AddComponent<Runner>().Name = "two";
                var (third, last) = (new GameObject("third"), new GameObject("last"));
                third.AddComponent<Runner>().Name = "one";
                last.AddComponent<Runner>();
            }
            if (args[1] == "clock")
            {
                ((Agent)scripts[0]).Name = "one";
                other.AddComponent<Clocked>();
            }
            if (args[1] == "twice") other.AddComponent<Runner>();
            if (args[1] == "sensor") other.AddComponent<CameraSensor>();
            if (args[1] == "gone") scripts[0].enabled = false;
            if (args[1].StartsWith("radar"))
            {
                other.SetActive(false);
                other.transform.SetParent(thing.transform);
                var radar = other.AddComponent<Radar>();
                radar.broken = args[1] == "radar broken";
                UnityPlayer.Inspector.Set(new[] { radar }, "locator", "@.place(1:)");
                other.SetActive(true);
            }
        });
        player.Run(System.TimeSpan.FromSeconds(60), () => false);
        player.Stop();
    }
}
"""


@pytest.fixture(scope="module")
def scene(tmp_path_factory, console):
    folder = tmp_path_factory.mktemp("scene")
    (folder / "Runner.cs").write_text(PARTS["csharp"], encoding="utf-8")
    (folder / "Program.cs").write_text(PLAY, encoding="utf-8")
    done = build(folder, console, "<OutputType>Exe</OutputType>")
    assert done.returncode == 0, done.stdout + done.stderr
    return ["dotnet", next(folder.rglob("bin/**/fragments.dll"))]


@pytest.fixture
def run(scene, start, tmp_path):
    """The page's script, and the scene: what the script prints, and the scene as a program."""

    def run(how="", before_close="", code=0):
        endpoint = steady_endpoint()
        script = tmp_path / "script.py"
        text = PARTS["python"].replace('env_name="Runner",', f'env_name="Runner", endpoint="{endpoint}",')
        text = text.replace("env.close()", f"{before_close}env.close()")
        text = text.replace('"python"', repr(str(ROOT / "python")))
        script.write_text(text, encoding="utf-8")
        player = start(*scene, endpoint, how)
        done = finished([PYTHON, script])
        assert done.returncode == code, done.stderr + player.output
        return done.stdout.replace(endpoint, "tcp://127.0.0.1:5561"), done.stderr, player

    return run


def test_an_agent_that_has_moved_runs_and_prints_what_the_page_says(run):
    printed, _, player = run()
    assert printed == PARTS[""]
    player.wait_for("^done: 1 episodes, 4 steps")


def test_only_marked_lines_are_new():
    """A user's own class and script keep all other lines: three and two have changed."""
    for language, most in (("csharp", 3), ("python", 2)):
        assert len(re.findall(r"(?://|#) was: ", PARTS[language])) <= most
    names = {node.value for node in ast.walk(ast.parse(PARTS["python"])) if isinstance(node, ast.Constant)}
    assert {"NetMQExample/Unity-v0", "Runner"} <= names


def test_the_environment_hears_what_is_sent_to_nobody(run):
    _, _, player = run(before_close='env.unwrapped.send_info("all", "")\n')
    player.wait_for("^heard all$")


@pytest.mark.parametrize(
    ("how", "said"),
    [
        ("twice", "gave up: two agents are named 'agent': each needs a name of its own"),
        ("sensor", "gave up: CameraSensor on twin has no agent above it, and its locator names none"),
        ("locator", 'gave up: Speeder.speed, locator ".speed[": column 8: expected a key'),
    ],
)
def test_what_is_wrong_in_a_scene_is_said_once_and_the_rest_plays(how, said, run):
    printed, _, player = run(how)
    assert printed == PARTS[""]
    assert player.output.count("gave up: ") == player.output.count(said) == 1


def test_an_agent_that_is_disabled_is_not_there(run):
    _, error, _ = run("gone", code=1)
    assert error.rstrip().endswith("unknown-agent: no agent is named 'agent'; there are:")


def test_a_sensor_of_ones_own_brings_whatever_an_attribute_takes(run):
    printed, _, _ = run("radar")
    assert printed == PARTS[""].replace(" 0. 0.]", " 7. 8.]")
    _, error, _ = run("radar broken", code=1)
    assert error.rstrip().endswith("no-space: Radar on twin: no space takes a GameObject")


def test_a_script_names_the_agents_that_it_makes(run):
    """One that was named already, and some that were made; the page's script plays with the one that was not named."""
    printed, error, player = run("named", before_close='env.unwrapped.send_info("", "nobody")\n', code=1)
    assert printed == PARTS[""]
    assert error.rstrip().endswith("unknown-agent: no agent is named 'nobody'; there are: one, two, agent")
    assert player.output.count("gave up: two agents are named 'one': each needs a name of its own") == 1


def test_agents_without_a_manager_say_so_at_once(scene, start):
    player = start(*scene, f"tcp://127.0.0.1:{free_port()}", "alone")
    player.wait_for("^trouble: agent waits for a GymManager: put one on any game object of the scene")
    assert player.output.count("GymManager") == 1


def test_an_agent_that_goes_by_the_clock_is_told(scene, start):
    player = start(*scene, f"tcp://127.0.0.1:{free_port()}", "clock")
    why = r"what belongs to a step is done in OnTick\(double dt\)"
    player.wait_for(f"^trouble: Animal.FixedUpdate runs by the clock: {why}")
    assert player.output.count("FixedUpdate") == 1


@pytest.mark.long
def test_the_pages_words_play_it_without_unity(netmq, console, start, tmp_path):
    (words,) = re.findall(r"^python3 (kit.py play Runner.cs .*)$", PAGE.read_text(encoding="utf-8"), re.MULTILINE)
    (tmp_path / "Runner.cs").write_text(PARTS["csharp"], encoding="utf-8")
    endpoint = f"tcp://127.0.0.1:{free_port()}"
    words = words.replace("Runner.cs", str(tmp_path / "Runner.cs"), 1).split()
    player = start(PYTHON, *words, "--endpoint", endpoint, "--timeout", "1")
    assert player.wait(300) == 1
    assert player.lines[-1].startswith(f"gave up: no environment at {endpoint} within 1 s")
    assert "waits for a GymManager" not in player.output


def test_nothing_that_gymize_needed_is_needed():
    places = ("11_observations/*.py", "netmq_example/*.py", "netmq_example/envs/*.py", "netmq_example/simulation/*.py")
    files = [path for place in places for path in (ROOT / "python").glob(place)]
    nodes = [node for path in files for node in ast.walk(ast.parse(path.read_text(encoding="utf-8")))]
    names = [node.module for node in nodes if isinstance(node, ast.ImportFrom)]
    names += [alias.name for node in nodes if isinstance(node, ast.Import) for alias in node.names]
    used = {name.split(".")[0] for name in names} - {"netmq_example", "collector"}
    assert used - set(sys.stdlib_module_names) == {"gymnasium", "numpy", "pettingzoo", "zmq"}
