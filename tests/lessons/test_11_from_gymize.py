"""The page "You come from gymize": its agent and its script run as they stand there, and so do scenes with what gymize
did wrong: agents that die, leave and come, and scenes that load. The player throws if another thread touches them.
"""

import string
import sys

import pytest

from kitlib.docs import guide
from tests.programs import ROOT, free_port, steady_endpoint

gymnasium = pytest.importorskip("gymnasium", reason="lesson 11 needs gymnasium: kit.py run 11 installs it")
np = pytest.importorskip("numpy", reason="lesson 11 needs numpy: kit.py run 11 installs it")
pytest.importorskip("pettingzoo", reason="lesson 11 needs pettingzoo: kit.py run 10 installs it")
from gymnasium import spaces  # noqa: E402

from netmq_example.envs import UnityParallelEnv  # noqa: E402
from netmq_example.messages import MessageError  # noqa: E402

PARTS = {block.language: block.body for block in guide.blocks(ROOT / "docs" / "guide" / "from_gymize.md")}
CHECKS = ROOT / "tests" / "lessons" / "checks"


@pytest.fixture
def scene(checks, start):
    """A scene with the page's agent, of tests/lessons/checks/Scenes.cs, as a program."""
    return lambda endpoint, *how, name="gymize": start("dotnet", checks, "scene", name, endpoint, *how)


@pytest.fixture
def run(scene, capsys, caplog, monkeypatch):
    """The page's script, and such a scene: what the script logs and prints, its error, and the scene."""

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
            if "env" in names:
                names["env"].close()
        said = "".join(f"{line}\n" for line in caplog.messages) + capsys.readouterr().out
        return said.replace(endpoint, "tcp://127.0.0.1:5559"), error, player

    return run


def test_an_agent_that_has_moved_runs_and_prints_what_the_page_says(run):
    assert PARTS["csharp"] == (CHECKS / "Runner.cs").read_text(encoding="utf-8")
    printed, error, player = run()
    assert (printed, error) == (PARTS[""], "")
    player.wait_for("^done: 1 episodes, 4 steps")


def test_what_is_wrong_in_a_scene_is_said_once_and_the_rest_plays(run):
    printed, _, player = run("wrong", before_close='env.unwrapped.send_info("all", "")\n')
    assert printed == PARTS[""]
    player.wait_for("^heard all$")
    for said in (
        "gave up: CameraSensor on eye has no agent above it, and its locator names none",
        'gave up: Speeder.speed, locator ".speed[": column 8: expected a key',
    ):
        assert player.output.count(said) == 1
    assert player.output.count("gave up: ") == 2


def test_a_scene_whose_only_agent_is_wrong_ends_and_says_why(run):
    """Python hears of it at once, and not only that nobody came."""
    _, error, player = run("mistake")
    why = "Speeder.speed, locator \".speed[\": column 8: expected a key, a number, a slice, ... or ']', found the end"
    assert error == f"gave-up: Runner has no agents: {why}"
    assert player.output.count(f"gave up: {why}") == 1
    player.wait_for("^gave up: Runner has no agents: ")


def test_an_info_that_nobody_hears_is_said_once(run):
    _, _, player = run("mute", before_close='env.unwrapped.send_info("all")\n' * 2)
    player.wait_for("^trouble: Python has sent an info to the environment, and nobody hears it: name an agent in ")
    assert player.output.count("trouble: ") == 1


def test_an_agent_that_is_disabled_is_not_there(run):
    _, error, _ = run("gone")
    assert error == "unknown-agent: agent agent is not in the scene now"


def test_a_sensor_of_ones_own_brings_whatever_an_attribute_takes(run):
    printed, _, _ = run("radar")
    assert printed == PARTS[""].replace(" 0. 0.]", " 7. 8.]")


def test_a_script_names_the_agents_that_it_makes(run):
    """One that was named already, and some that were made. Another one goes by the clock, and is told."""
    _, error, player = run("named")
    assert error.startswith("wrong-scene: the scene has 5 agents named one_0, one_1, two, clocked, agent: say which ")
    clock = "trouble: Animal.FixedUpdate runs by the clock: what belongs to a step is done in OnTick(double dt)"
    assert player.output.count(clock) == player.output.count("FixedUpdate") == 1


def test_agents_without_a_manager_say_so_at_once(scene):
    player = scene(f"tcp://127.0.0.1:{free_port()}", "alone")
    player.wait_for("^trouble: no GymManager is enabled in this scene: its agents do nothing")
    player.wait_for("^the sensor's camera draws: False")
    assert player.output.count("GymManager") == 1


def test_without_python_agents_are_played_by_hand(scene):
    """Each episode that has ended is followed by another one."""
    player = scene(f"tcp://127.0.0.1:{free_port()}", name="Faller")
    for _ in range(3):
        player.wait_for("^by hand: 3 steps, return 1.5$")


# Bots that die in their third step, tests/lessons/checks/Scenes.cs: who leaves keeps its reward, its end and its info

BOTS = ["leader", "stays", "ends", "ends_off", "off", "led", "destroyed", "respawned", "replaced"]


def test_who_dies_keeps_its_last_reward_and_the_next_reset_brings_it_back(scene):
    endpoint = steady_endpoint()
    player = scene(endpoint, name="Arena")
    space = {name: spaces.Dict(age=spaces.Discrete(99)) for name in BOTS}
    actions = {name: spaces.Discrete(2) for name in BOTS}
    env = UnityParallelEnv("Arena", observation_spaces=space, action_spaces=actions, endpoint=endpoint)
    for episode in range(3):
        seen, _ = env.reset(seed=episode)
        assert {name: one["age"] for name, one in seen.items()} == dict.fromkeys(BOTS, 0)
        for _ in range(2):
            env.step(dict.fromkeys(env.agents, 0))
        assert env.agents == BOTS
        _, rewards, terminated, truncated, infos = env.step(dict.fromkeys(BOTS, 0))
        # A new one takes the place of one that was not over, a frame later: it begins when that is told.
        died = [name for name in BOTS[2:] if name != "replaced"]
        assert {rewards[name] for name in died} == {-10} and rewards["leader"] == rewards["stays"] == 1
        assert [name for name in BOTS if terminated[name]] == [name for name in died if name != "off"]
        assert [name for name in BOTS if truncated[name]] == [name for name in BOTS if name in ("off", "replaced")]
        assert [name for name in died if infos[name]["agent"] == ["died"]] == died
        assert infos["off"]["lost"] == infos["replaced"]["lost"] == "it has left the scene"
        assert env.agents == ["leader", "stays"]
        seen = env.step(dict.fromkeys(env.agents, 0))[0]
        assert {*env.agents} == {"leader", "stays", "respawned", "replaced"} and seen["replaced"]["age"] == 0
        for _ in range(30):
            env.step(dict.fromkeys(env.agents, 0))
    env.close()
    assert "gave up" not in player.output


# The class of gymize's README, tests/lessons/checks/Racer.cs: OnReset loads the scene, Update ends the episode


@pytest.fixture
def race(scene, make):
    pytest.importorskip("PIL", reason="the agent sees a PNG file: pip install pillow")

    def race(*how, **shown):
        endpoint = steady_endpoint()
        player = scene(endpoint, *how, name="Racer")
        env = make(
            "NetMQExample/Unity-v0",
            env_name="Racer",
            endpoint=endpoint,
            wait=60,
            observation_space=spaces.Dict(
                m_NickName=spaces.Text(20, charset=string.printable),
                Distance=spaces.Box(-np.inf, np.inf, ()),
                Height=spaces.Box(-np.inf, np.inf, (1,)),
                track=spaces.Graph(spaces.Box(0, 9, (2,)), spaces.Box(0, 9, (1,))),
                eye=spaces.Box(0, 255, (1, 2, 3), np.uint8),
            ),
            **shown,
            action_space=spaces.Dict(speed=spaces.Box(-1, 1, (1,)), arr=spaces.Tuple([spaces.Discrete(3)])),
        )
        return env, player

    return race


DRIVE = {"speed": np.ones(1, np.float32), "arr": (1,)}


@pytest.mark.parametrize("how", [[], ["first"]], ids=["agent first", "manager first"])
def test_the_class_of_gymizes_readme_runs_as_it_stands(race, how):
    env, player = race(*how)
    loads = []
    for episode in range(4):
        seen, info = env.reset(seed=episode)
        assert (seen["Distance"], seen["m_NickName"]) == (0, "nobody"), "the agent of the new scene"
        assert seen["track"].edge_links.tolist() == [[0, 1]]
        assert seen["eye"].tolist() == [[[255, 0, 0], [0, 0, 255]]], "red and blue"
        env.unwrapped.send_info(b"abc" if episode else "Bob", "agent")
        steps, over = 0, False
        while not over:
            seen, _, over, _, info = env.step(DRIVE)
            steps += 1
            loads.append(int(info["agent"][0].split()[-1]))
        # Until it is known that this agent judges in Update, a frame is many steps.
        assert (seen["Distance"], steps) == (3, 3) or episode == 0
        assert seen["m_NickName"] == ("3 bytes" if episode else "Bob")
    assert sorted({*loads}) == [2, 3, 4, 5], "one scene for each episode, after that of Play"
    player.wait_for("^float32 .1.: 1$")
    late = "trouble: agent 'agent' called Terminate between two steps, such as in its Update: from now on each step"
    assert player.output.count(late) == player.output.count("trouble: ") == 1
    assert player.output.count("asking ") == 1, "one connection for all scenes"


def test_what_a_connection_needs_is_made_once_for_all_scenes(race):
    env, player = race("channels")
    for episode in range(3):
        env.reset(seed=episode)
    env.close()
    player.wait_for("^leaves$")
    assert player.lines.count("enters") == player.lines.count("leaves") == 1


def test_a_film_goes_on_over_the_scenes(race):
    views = steady_endpoint()
    env, _ = race(views, render_mode="rgb_array_list", view_endpoint=views)
    env.unwrapped.begin_render()
    for episode in range(3):
        env.reset(seed=episode)
        for _ in range(3):
            env.step(DRIVE)
    assert [picture.shape for picture in env.render()] == [(24, 32, 3)] * 12


def test_a_scene_without_a_manager_is_said_and_lost_at_once(race):
    env, player = race("lost")
    env.unwrapped.remote.simulators.wait = 1
    with pytest.raises(TimeoutError, match="no simulator came"):
        env.reset(seed=1)
    player.wait_for("^trouble: Main has no GymManager with the Env Name Racer: Python has lost it")


def test_a_script_that_is_no_agent_speaks_for_all(run):
    printed, _, player = run(
        "env",
        before_close="""for said in ("more", "enough"):
    env.reset()
    env.unwrapped.send_info(said)
    print(*env.step({"push": np.zeros(1, np.float32), "jump": 0})[1:])
""",
    )
    told = "{'env': ['the referee heard %s'], 'agent': ['yours', 'at 0']}"
    assert printed.endswith(f"5.5 False True {told % 'more'}\n5.5 True False {told % 'enough'}\n")
    player.wait_for("^unknown-agent: no agent is named 'nobody'; there are: agent$")
