"""The modules around ML-Agents' environments that programs import by name: wrappers for gym and PettingZoo, builds by
their paths, loggers, timers, the registry. The environments are made up here, as in ML-Agents' own tests of them.
"""

import importlib
import os
import pickle
import pkgutil
import re
import sys
import threading
from collections import defaultdict
from unittest import mock

import pytest

from tests.programs import LIMIT, ROOT, finished

np = pytest.importorskip("numpy", reason="ML-Agents' API needs numpy: kit.py run 13 installs it")
pytest.importorskip("gymnasium", reason="the wrappers need the spaces of gymnasium: kit.py run 13 installs it")

from netmq_example import launch  # noqa: E402
from netmq_example.mlagents_envs import env_utils, timers  # noqa: E402
from netmq_example.mlagents_envs.base_env import (  # noqa: E402
    ActionSpec,
    BaseEnv,
    BehaviorMapping,
    BehaviorSpec,
    DecisionSteps,
    DimensionProperty,
    ObservationSpec,
    ObservationType,
    TerminalSteps,
)
from netmq_example.mlagents_envs.envs import env_helpers  # noqa: E402
from netmq_example.mlagents_envs.envs.unity_gym_env import UnityGymException, UnityToGymWrapper  # noqa: E402
from netmq_example.mlagents_envs.exception import (  # noqa: E402
    UnityActionException,
    UnityEnvironmentException,
    UnityException,
)
from netmq_example.mlagents_envs.registry import LocalRegistryEntry, UnityEnvRegistry, default_registry  # noqa: E402
from netmq_example.mlagents_envs.side_channel import (  # noqa: E402
    SideChannelManager,
    StatsSideChannel,
)

PICTURE = (3, 8, 8)
GOAL = 3


def observed(*shapes):
    return [
        ObservationSpec(shape, (DimensionProperty.NONE,) * len(shape), ObservationType.DEFAULT, f"seen {number}")
        for number, shape in enumerate(shapes)
    ]


class Walk(BaseEnv):
    """Agents walk by their actions' sum. One that has come to GOAL has ended, and begins `again` in the same step."""

    def __init__(self, behaviors=("Walk?team=0",), agents=1, shapes=((2,),), action=(1, ()), again=True):
        self.spec = BehaviorSpec(observed(*shapes), ActionSpec(*action))
        self.names = behaviors
        self.agents = agents
        self.again = again
        self.closed = 0
        self.done = {}
        self._side_channel_manager = SideChannelManager([StatsSideChannel()])

    @property
    def behavior_specs(self):
        return BehaviorMapping(dict.fromkeys(self.names, self.spec))

    def reset(self):
        self.places = {name: dict.fromkeys(range(self.agents), 0.0) for name in self.names}
        self.ended = {name: {} for name in self.names}
        self.done = {}

    def step(self):
        for name, places in self.places.items():
            self.ended[name] = {}
            for row, agent in enumerate(list(places)):
                action = self.done[name]
                places[agent] += action.continuous[row].sum() + action.discrete[row].sum()
                if places[agent] >= GOAL:
                    self.ended[name][agent] = places.pop(agent)
                    if self.again:
                        places[agent] = 0.0

    def set_actions(self, behavior_name, action):
        self.done[behavior_name] = action

    def set_action_for_agent(self, behavior_name, agent_id, action):
        raise NotImplementedError

    def rows(self, places):
        seen = [
            np.stack([np.full(spec.shape, place / GOAL, np.float32) for place in places.values()])
            if places
            else np.zeros((0, *spec.shape), np.float32)
            for spec in self.spec.observation_specs
        ]
        count = len(places)
        ids = np.array([*places], np.int32)
        return seen, np.array([*places.values()], np.float32), ids, np.full(count, 7), np.full(count, 0.5)

    def get_steps(self, behavior_name):
        seen, reward, ids, group, group_reward = self.rows(self.places[behavior_name])
        branches = self.spec.action_spec.discrete_branches
        masks = [np.zeros((len(ids), choices), bool) for choices in branches] or None
        now = DecisionSteps(seen, reward, ids, masks, group, group_reward)
        seen, reward, ids, group, group_reward = self.rows(self.ended[behavior_name])
        return now, TerminalSteps(seen, reward, np.ones(len(ids), bool), ids, group, group_reward)

    def close(self):
        self.closed += 1


def test_gym_one_vector_whose_episode_ends():
    walk = Walk(action=(2, ()))
    # Its constructor has reset it: the first step needs no reset.
    env = UnityToGymWrapper(walk)
    seen, reward, done, info = env.step([1, 0.5])
    assert (seen.tolist(), reward, done) == ([0.5, 0.5], 1.5, False)
    assert isinstance(reward, float) and isinstance(info["step"], DecisionSteps)
    assert env.observation_space.contains(seen) and env.action_space.sample().shape == (2,)
    assert (env.name, env.group_spec.action_spec.continuous_size) == ("Walk?team=0", 2)
    seen, reward, done, info = env.step([2, 0.5])
    assert (seen.tolist(), reward, done) == ([pytest.approx(4 / 3)] * 2, 4.0, True)
    assert isinstance(info["step"], TerminalSteps)
    with pytest.raises(UnityGymException, match="call reset"):
        env.step([1, 0])
    seen = env.reset()
    assert isinstance(seen, np.ndarray) and seen.tolist() == [0, 0] and env.step([1, 0])[2] is False
    env.close()
    assert walk.closed == 1


@pytest.mark.parametrize("flatten", [True, False])
def test_gym_branches(flatten):
    one = UnityToGymWrapper(Walk(action=(0, (5,))), flatten_branched=flatten)
    assert one.action_space.n == 5 and one.step(2)[1] == 2, "one is never flattened"
    env = UnityToGymWrapper(Walk(action=(0, (2, 2, 3))), flatten_branched=flatten)
    if not flatten:
        assert env.action_space.nvec.tolist() == [2, 2, 3] and env._flattener is None
        assert env.step([0, 1, 1])[1] == 2
        return
    assert env.action_space.n == 12
    assert [env._flattener.lookup_action(number) for number in (0, 5, 11)] == [[0, 0, 0], [0, 1, 2], [1, 1, 2]]
    result = env.step(np.int64(4))
    assert result[1] == 2 and not result[3]["step"].action_mask[0].any()


def test_gym_the_action_space_has_a_seed():
    drawn = [UnityToGymWrapper(Walk(action=(2, ())), action_space_seed=1337).action_space.sample() for _ in range(2)]
    assert (drawn[0] == drawn[1]).all()


@pytest.mark.parametrize("uint8", [True, False])
@pytest.mark.parametrize("shapes", [(PICTURE,), (PICTURE, (3,)), (PICTURE, (1,), PICTURE, (2,))])
def test_gym_pictures(shapes, uint8):
    pictures = shapes.count(PICTURE)
    several = UnityToGymWrapper(Walk(shapes=shapes), uint8_visual=uint8, allow_multiple_obs=True)
    alone = UnityToGymWrapper(Walk(shapes=shapes), uint8_visual=uint8)
    for seen in (several.reset(), several.step([1])[0]):
        assert isinstance(seen, list) and len(seen) == len(several.observation_space)
        assert [each.shape for each in seen] == [PICTURE] * pictures + [(3,)] * (len(shapes) > 1)
        assert all(space.contains(each) for space, each in zip(several.observation_space, seen, strict=True))
    for seen in (alone.reset(), alone.step([1])[0]):
        assert seen.shape == PICTURE and alone.observation_space.contains(seen)
        assert seen.dtype == (np.uint8 if uint8 else np.float32)
    assert seen.max() == (85 if uint8 else np.float32(1 / 3))
    assert (alone.render() == seen).all() and alone.metadata["render.modes"] == ["rgb_array"]


@pytest.mark.parametrize(
    ("walk", "says"),
    [
        (Walk(behaviors=("A?team=0", "B?team=0")), "one behavior, and the scene 2"),
        (Walk(agents=2), "one agent, and the scene 2"),
        (Walk(shapes=((2, 3),)), "neither a picture nor a vector"),
        (Walk(action=(1, (2,))), "continuous or discrete"),
    ],
)
def test_gym_says_in_a_line_what_does_not_fit(walk, says):
    with pytest.raises(UnityGymException, match=says) as caught:
        UnityToGymWrapper(walk)
    assert "\n" not in str(caught.value)


class Gym:
    class Env:
        pass


def test_gym_is_a_base_where_a_program_knows_it(monkeypatch):
    monkeypatch.setitem(sys.modules, "gym", Gym)
    monkeypatch.setitem(sys.modules, "gym.spaces", importlib.import_module("gymnasium.spaces"))
    monkeypatch.delitem(sys.modules, f"{ENVS}.unity_gym_env")
    env = importlib.import_module(f"{ENVS}.unity_gym_env").UnityToGymWrapper(Walk())
    assert env.reset().tolist() == [0, 0] and isinstance(env, Gym.Env)


def test_gym_without_spaces_is_a_line(monkeypatch):
    for name in ("gym", "gymnasium"):
        monkeypatch.setitem(sys.modules, name, None)
        monkeypatch.setitem(sys.modules, f"{name}.spaces", None)
    with pytest.raises(ModuleNotFoundError, match=r"^no gym and no gymnasium.*: .*pip install gymnasium$"):
        UnityToGymWrapper(Walk())


ALONE = """
import sys
for name in ("gym", "gymnasium", "pettingzoo", "yaml"):
    sys.modules[name] = None
import importlib
for name in sys.argv[1:]:
    importlib.import_module(name)
"""
ENVS = "netmq_example.mlagents_envs.envs"
WRAPPERS = [f"{ENVS}.{each.name}" for each in pkgutil.iter_modules(importlib.import_module(ENVS).__path__)]
OTHERS = ("environment", "base_env", "exception", "side_channel", "env_utils", "logging_util", "timers", "registry")


def test_the_modules_need_no_library_to_be_imported():
    assert len(WRAPPERS) == 5
    words = [sys.executable, "-c", ALONE, *WRAPPERS, *(f"netmq_example.mlagents_envs.{each}" for each in OTHERS)]
    done = finished(words, cwd=ROOT / "python")
    assert done.returncode == 0, done.stderr


@pytest.fixture
def zoo():
    pytest.importorskip("pettingzoo", reason="needs pettingzoo: pip install pettingzoo")
    turns, at_once = (importlib.import_module(f"{ENVS}.unity_{name}_env") for name in ("aec", "parallel"))
    return turns.UnityAECEnv, at_once.UnityParallelEnv


TWO = ("Walk?team=0", "Walk?team=1")


@pytest.mark.parametrize(("behaviors", "agents"), [(TWO[:1], 1), (TWO, 2)], ids=["single", "multi"])
def test_pettingzoo_in_turns(zoo, behaviors, agents):
    """As PettingZoo 1.15's test of environments: each agent has its turn, and takes leave with None."""
    from pettingzoo import AECEnv

    walk = Walk(behaviors, agents, again=False)
    env = zoo[0](walk)
    assert isinstance(env, AECEnv)
    env.reset()
    everybody = sorted(f"{name}?agent_id={number}" for name in behaviors for number in range(agents))
    assert env.agents == env.possible_agents == everybody
    turns = []
    for agent in env.agent_iter(100):
        seen, reward, done, info = env.last()
        turns.append((agent, round(float(reward)), done))
        assert done or env.observation_space(agent).contains(seen)
        assert info["behavior_name"] == agent.partition("?agent_id")[0] and info["group_id"] == 7
        assert info.get("interrupted", False) == done
        env.step(None if done else [1])
    assert turns == [(agent, place, place == GOAL) for place in range(GOAL + 1) for agent in everybody]
    assert env.agents == []
    env.close()
    env.close()
    assert walk.closed == 1
    with pytest.raises(UnityException, match="closed"):
        env.reset()


@pytest.mark.parametrize(("behaviors", "agents"), [(TWO[:1], 1), (TWO, 3)], ids=["single", "multi"])
def test_pettingzoo_all_at_once(zoo, behaviors, agents):
    from pettingzoo import ParallelEnv

    env = zoo[1](Walk(behaviors, agents, again=False), seed=3)
    assert isinstance(env, ParallelEnv)
    for _ in range(2):
        seen = env.reset()
        assert [*seen] == env.agents and len(seen) == len(behaviors) * agents
        count = 0
        while env.agents:
            seen, rewards, dones, infos = env.step({agent: [1] for agent in env.agents})
            count += 1
            assert {*seen} == {*rewards} == {*dones} == {*infos} == {*env.possible_agents}
            assert {*rewards.values()} == {count} and {*dones.values()} == {count == GOAL}
        assert count == GOAL
        with pytest.raises(UnityException, match="call reset"):
            env.step({"Walk?team=0?agent_id=0": [1]})


def test_pettingzoo_an_end_is_seen_where_the_next_episode_begins_in_the_same_step(zoo):
    env = zoo[1](Walk(agents=2, action=(0, (GOAL + 1,))))
    env.reset()
    first, second = env.agents
    for _ in range(2):
        seen, rewards, dones, _ = env.step({first: GOAL, second: 0})
        assert (seen[first].tolist(), rewards[first], dones) == ([1, 1], GOAL, {first: True, second: False})
        assert env.agents == [second]
        seen, rewards, dones, _ = env.step({second: 0})
        assert seen[first]["observation"][0].tolist() == [0, 0] and dones == {first: False, second: False}


def test_pettingzoo_actions_of_each_kind(zoo):
    """ML-Agents' own makes whole numbers of floats, and gives each float the value of the first."""
    env = zoo[1](Walk(action=(2, (3, 3)), shapes=((1,), PICTURE)))
    seen = env.reset()
    (agent,) = seen
    assert len(env.action_space(agent)) == 2 and env.action_spaces[agent].contains(env.action_space(agent).sample())
    assert [each.shape for each in seen[agent]["observation"]] == [(1,), PICTURE]
    assert [each.tolist() for each in seen[agent]["action_mask"]] == [[False] * 3] * 2
    _, rewards, _, _ = env.step({agent: ([0.25, 0.5], [0, 2])})
    assert rewards[agent] == 2.75
    with pytest.raises(UnityActionException, match="takes Tuple"):
        env.step({agent: ([0.25, 0.5], [0, 3])})
    assert isinstance(env.side_channel["StatsSideChannel"], StatsSideChannel)


def test_pettingzoo_that_is_missing_is_a_line(monkeypatch):
    monkeypatch.setitem(sys.modules, "pettingzoo", None)
    env_helpers.derived.cache_clear()
    module = importlib.import_module(f"{ENVS}.unity_aec_env")
    with pytest.raises(ModuleNotFoundError, match=r"pip install pettingzoo$"):
        module.UnityAECEnv(Walk())


BUILDS = {"linux": "Game.x86_64", "darwin": "Game.app/Contents/MacOS/My Game", "win32": "Game.exe"}


@pytest.mark.parametrize("platform", BUILDS)
def test_a_build_is_found_by_each_systems_name_of_it(platform, tmp_path, monkeypatch):
    assert env_utils.validate_environment_path(" ") is None
    monkeypatch.setattr(sys, "platform", platform)
    folder = tmp_path / "Build [1]"
    with pytest.raises(FileNotFoundError, match=r"no game at .*Game: there is neither this file nor .*Game\."):
        launch.game(folder / "Game")
    (folder / "Game_Data").mkdir(parents=True)
    for build in BUILDS.values():
        (folder / build).parent.mkdir(parents=True, exist_ok=True)
        (folder / build).write_text("#!/bin/sh\n", encoding="ascii")
        assert env_utils.is_player(str(folder / build)) and not env_utils.is_player(str(folder / "game.sh"))
    program = folder / BUILDS[platform]
    assert launch.game(folder / "Game") == str(program)
    assert os.access(program, os.X_OK), "it was made executable"
    for ending in ("", ".exe", ".app", ".x86_64", ".x86"):
        assert env_utils.validate_environment_path(f"{folder}/Game{ending}") == str(program)


def test_a_windows_build_is_found_by_its_folder(tmp_path):
    for name in ("Game.exe", "UnityCrashHandler64.exe", "A.dll"):
        (tmp_path / name).write_bytes(b"")
    assert env_utils.validate_environment_path(str(tmp_path)) == str(tmp_path / "Game.exe")


def test_a_build_is_launched(tmp_path):
    with pytest.raises(UnityEnvironmentException, match="no game at"):
        env_utils.launch_executable(" ", [])
    script = tmp_path / "scene.py"
    script.write_text("import sys; sys.exit(len(sys.argv))", encoding="utf-8")
    process = env_utils.launch_executable(str(script), ["-batchmode", "-nographics"])
    assert process.wait(LIMIT) == 3
    process.stdin.close()
    refused = mock.patch("subprocess.Popen", side_effect=PermissionError(13, "not allowed"))
    with refused, pytest.raises(UnityEnvironmentException, match="not allowed"):
        env_utils.launch_executable(str(script), [])


@pytest.mark.skipif(sys.platform == "win32", reason="Windows has no such right")
def test_only_a_program_is_made_executable(tmp_path):
    text, script = tmp_path / "notes.txt", tmp_path / "game.sh"
    text.write_text("no program", encoding="utf-8")
    script.write_text("#!/bin/sh\n", encoding="utf-8")
    with pytest.raises(UnityEnvironmentException, match=r"notes\.txt is no program of this system"):
        env_utils.launch_executable(str(text), [])
    with pytest.raises(FileNotFoundError, match=r"notes\.txt: it is no program; a script needs"):
        launch.program(text)
    assert launch.program(script) == [str(script)]
    assert [os.access(file, os.X_OK) for file in (text, script)] == [False, True]


LOGS = """
from netmq_example.mlagents_envs.logging_util import DEBUG, INFO, get_logger, set_log_level
one = get_logger("one")
set_log_level(INFO)
one.info("hello")
get_logger("one").debug("not said")
set_log_level(DEBUG)
get_logger("another").debug("hello")
"""


def test_all_loggers_have_one_level_and_write_to_standard_output():
    first, second = finished([sys.executable, "-c", LOGS], cwd=ROOT / "python", check=True).stdout.splitlines()
    assert first == "[INFO] hello" and re.fullmatch(r"[\d-]+ [\d:]+ DEBUG \[<string>:8\] hello", second)


@timers.timed
def added(x=0, y=1.0):
    timers.set_gauge("sum", x + y)
    return x + y


@pytest.fixture
def stacks(monkeypatch):
    monkeypatch.setattr(timers, "STACKS", defaultdict(timers.TimerStack))


def test_a_tree_of_timers(stacks):
    with timers.hierarchical_timer("all"):
        for number in range(3):
            with timers.hierarchical_timer("each"):
                assert added(number, y=number) == 2 * number
        with pytest.raises(RuntimeError), timers.hierarchical_timer("raises"):
            raise RuntimeError("over")
        with timers.hierarchical_timer("goes on"):
            pass
    timers.set_gauge("sum", float("nan"))
    timers.add_metadata("who", "a test")
    tree = timers.get_timer_tree()
    seconds = {"total": mock.ANY, "self": mock.ANY}
    inner = {"added": {**seconds, "count": 3}}
    below = {
        "each": {**seconds, "count": 3, "children": inner},
        "raises": {**seconds, "count": 1},
        "goes on": {**seconds, "count": 1},
    }
    words = ("timer_format_version", "start_time_seconds", "end_time_seconds", "python_version")
    assert tree == {
        **seconds,
        "name": "root",
        "count": 1,
        "children": {"all": {**seconds, "count": 1, "children": below}},
        "gauges": {"sum": {"value": 4.0, "min": 0.0, "max": 4.0, "count": 3}},
        "metadata": {**dict.fromkeys((*words, "command_line_arguments"), mock.ANY), "who": "a test"},
    }


def test_a_workers_timers_are_merged(stacks):
    with timers.hierarchical_timer("step"):
        timers.set_gauge("speed", 2.0)
    worker = pickle.loads(pickle.dumps(timers.get_timer_root()))
    gauges = timers.get_timer_stack_for_thread(threading.current_thread()).gauges
    timers.reset_timers()
    timers.set_gauge("speed", 5.0)
    timers.merge_gauges(gauges)
    for _ in range(2):
        timers.get_timer_root().merge(worker, root_name="worker")
    tree = timers.get_timer_tree()
    below = tree["children"]["worker"]
    assert below["is_parallel"] and below["count"] == below["children"]["step"]["count"] == 2
    assert tree["gauges"]["speed"] == {"value": 2.0, "min": 2.0, "max": 5.0, "count": 2}
    added()
    timers.reset_timers()
    assert "children" not in timers.get_timer_tree()
    thread = threading.Thread(target=added)
    thread.start()
    thread.join()
    assert timers.get_timer_stack_for_thread(thread).root.children["added"].count == 1
    assert timers.get_timer_stack_for_thread(threading.Thread()) is None


def test_the_registry_has_what_was_registered():
    registry = UnityEnvRegistry()
    assert not registry and not default_registry
    registry.register(LocalRegistryEntry("Walk", 10.0, "there and back", file_name="no such build"))
    assert [*registry] == ["Walk"] and registry["Walk"].expected_reward == 10.0
    with pytest.raises(UnityEnvironmentException, match="no such build"):
        registry["Walk"].make(base_port=5004)
    with pytest.raises(KeyError, match=r"no environment '3DBall' .* cannot be downloaded any more: register\("):
        default_registry["3DBall"]
    with pytest.raises(NotImplementedError, match="downloads none"):
        registry.register_from_yaml("https://example.org/manifest.yaml")
    registry.clear()
    assert len(registry) == 0
