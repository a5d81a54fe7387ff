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
  test_observations_are_copies_and_begin_with_nothing, and test_11_trees.py
- dictionaries were touched by socket threads: here only Update touches a scene, and the player, in which the tests
  below run, throws if another thread does

What cannot exist here: a pinned websockets, resumed connections, distutils, NumSharp's DLL (none is used); a deleted
folder beside a video (lesson 11 writes no files).
"""

from __future__ import annotations

import sys

import pytest

from kitlib.docs import guide
from kitlib.setup import dotnet
from tests.programs import ROOT, free_port, steady_endpoint

pytest.importorskip("gymnasium", reason="lesson 11 needs gymnasium: kit.py run 11 installs it")
pytest.importorskip("pettingzoo", reason="lesson 11 needs pettingzoo: kit.py run 11 installs it")
from netmq_example.messages import MessageError

PARTS = {block.language: block.body for block in guide.blocks(ROOT / "docs" / "guide" / "from_gymize.md")}
CHECKS = ROOT / "tests" / "lessons" / "checks"


@pytest.fixture
def scene(netmq, start):
    """A scene with the page's agent, of tests/lessons/checks/Scenes.cs, as a program."""
    program = dotnet.build(netmq, CHECKS)
    return lambda endpoint, *how: start("dotnet", program, "scene", "gymize", endpoint, *how)


@pytest.fixture
def run(scene, capsys, monkeypatch):
    """The page's script, and such a scene: what the script prints, its error, and the scene."""

    def run(*how, before_close=""):
        endpoint, names, error = steady_endpoint(), {}, ""
        text = PARTS["python"].replace('env_name="Runner",', f'env_name="Runner", endpoint="{endpoint}",')
        text = text.replace("env.close()", f"{before_close}env.close()")
        player = scene(endpoint, *how)
        monkeypatch.setattr(sys, "path", [*sys.path])
        # That the scene was built.
        capsys.readouterr()
        try:
            exec(compile(text, "script.py", "exec"), names)
        except MessageError as refusal:
            error = str(refusal)
        finally:
            names["env"].close()
        return capsys.readouterr().out.replace(endpoint, "tcp://127.0.0.1:5561"), error, player

    return run


def test_an_agent_that_has_moved_runs_and_prints_what_the_page_says(run):
    assert PARTS["csharp"] == (CHECKS / "Runner.cs").read_text(encoding="utf-8")
    printed, error, player = run()
    assert (printed, error) == (PARTS[""], "")
    player.wait_for("^done: 1 episodes, 4 steps")


def test_what_is_wrong_in_a_scene_is_said_once_and_the_rest_plays(run):
    """And the environment hears what is sent to nobody."""
    printed, _, player = run("wrong", before_close='env.unwrapped.send_info("all", "")\n')
    assert printed == PARTS[""]
    player.wait_for("^heard all$")
    for said in (
        "gave up: two agents are named 'agent': each needs a name of its own",
        "gave up: CameraSensor on eye has no agent above it, and its locator names none",
        'gave up: Speeder.speed, locator ".speed[": column 8: expected a key',
    ):
        assert player.output.count(said) == 1
    assert player.output.count("gave up: ") == 3


def test_an_agent_that_is_disabled_is_not_there(run):
    _, error, _ = run("gone")
    assert error.endswith("unknown-agent: no agent is named 'agent'; there are: ")


def test_a_sensor_of_ones_own_brings_whatever_an_attribute_takes(run):
    printed, _, _ = run("radar")
    assert printed == PARTS[""].replace(" 0. 0.]", " 7. 8.]")
    _, error, _ = run("broken")
    assert error == "no-space: Radar on twin: no space takes a GameObject"


def test_a_script_names_the_agents_that_it_makes(run):
    """One that was named already, and some that were made; the page's script plays with the one that was not named.

    Another one goes by the clock, and is told.
    """
    printed, error, player = run("named", before_close='env.unwrapped.send_info("", "nobody")\n')
    assert printed == PARTS[""]
    assert error == "unknown-agent: no agent is named 'nobody'; there are: one, two, clocked, agent"
    assert player.output.count("gave up: two agents are named 'one': each needs a name of its own") == 1
    clock = "trouble: Animal.FixedUpdate runs by the clock: what belongs to a step is done in OnTick(double dt)"
    assert player.output.count(clock) == player.output.count("FixedUpdate") == 1


def test_agents_without_a_manager_say_so_at_once(scene):
    player = scene(f"tcp://127.0.0.1:{free_port()}", "alone")
    player.wait_for("^trouble: agent waits for a GymManager: put one on any game object of the scene")
    player.wait_for("^the sensor's camera draws: False")
    assert player.output.count("GymManager") == 1
