"""ML-Agents' UnityEnvironment: with the scene's clock, of the world in scene_clock.py, and with Python's, of scenes of
lessons 09 to 11. A simulator is in a thread of this process, or launched.
"""

import _thread
import os
import re
import sys
import threading

import pytest

from tests.conftest import PYTHON
from tests.programs import LIMIT, ROOT, finished, steady_port

pytest.importorskip("gymnasium", reason="lesson 09 needs gymnasium: kit.py run 9 installs it")
import numpy as np
from gymnasium.spaces import Box, Dict, Discrete, MultiBinary, MultiDiscrete, Text, Tuple

from netmq_example.mlagents_envs import environment
from netmq_example.mlagents_envs.base_env import ActionTuple, BaseEnv, DimensionProperty, ObservationType
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
from netmq_example.mlagents_envs.side_channel import EnvironmentParametersChannel
from netmq_example.scene import Agent, Scene, SceneSimulator
from netmq_example.wire import trees
from netmq_example.wire.records import IDS, MASKS
from tests.lessons.scene_clock import Arena, ArenaSimulator, Walker

FALLING_BALL = ROOT / "python" / "13_side_channels" / "falling_ball.py"
BALL, GOAL, CORRIDOR = "Ball?team=0", "Goal?team=1", "Corridor?team=0"


@pytest.fixture
def connected(served):
    """connected(simulator, **words): ML-Agents' environment of a simulator in a thread of this process."""
    made = []

    def connect(simulator, **more):
        made.append(UnityEnvironment(base_port=served(simulator) - 3, worker_id=3, timeout_wait=LIMIT, **more))
        return made[-1]

    yield connect
    for env in made:
        if env._loaded:
            env.close()


@pytest.fixture
def arena(connected):
    """arena(*walkers): the environment of a world by the scene's clock, whose `arena` is at hand."""

    def make(*walkers, **more):
        world = Arena(*walkers)
        env = connected(ArenaSimulator(world), **more)
        env.arena = world
        return env

    return make


def ids(env, name=BALL):
    """The ids of those that want an action, and of those that have ended."""
    now, over = env.get_steps(name)
    return list(now), list(over)


# The scene's clock. Requests and ends, masks and groups are in tests/unity/test_ml_agents_*.py, with C#'s scene.


def test_behaviors_are_what_the_scene_says(arena):
    env = arena(Walker("Ball", picture=True), Walker("Goal", team=1, floats=1, branches=(3, 2)), seed=7)
    assert issubclass(UnityEnvironment, BaseEnv) and len(env.behavior_specs) == 0, "they come with the first reset"
    env.reset()
    assert list(env.behavior_specs) == env.get_behavior_names() == env.get_agent_groups() == [BALL, GOAL]
    assert env._env_specs[BALL] == env.get_behavior_spec(BALL) == env.behavior_specs[BALL]
    vector, eye = env.behavior_specs[BALL].observation_specs
    assert vector == ((4,), (DimensionProperty.NONE,), ObservationType.DEFAULT, "VectorSensor_size4")
    equivariant = DimensionProperty.TRANSLATIONAL_EQUIVARIANCE
    assert (eye.shape, eye.observation_type) == ((1, 2, 3), ObservationType.GOAL_SIGNAL)
    assert eye.dimension_property == (DimensionProperty.NONE, equivariant, equivariant)
    assert env.behavior_specs[GOAL].action_spec == (1, (3, 2))
    now, over = env.get_steps(BALL)
    assert [(seen.dtype, seen.shape) for seen in now.obs] == [(np.float32, (1, 4)), (np.float32, (1, 1, 2, 3))]
    assert now.obs[1].ravel() == pytest.approx([0, 0.2, 0.4, 0.6, 0.8, 1])
    assert now.obs[1].max() == 1 and len(over) == 0 and now.action_mask is None
    assert env.arena.resets == [{"seed": 7}], "once"
    env.reset()
    assert env.arena.resets == [{"seed": 7}, {}]


def test_pictures_have_their_channels_last_as_before_2024(arena):
    env = arena(Walker("Ball", picture=True), channels_first=False)
    env.reset()
    spec, seen = env.behavior_specs[BALL].observation_specs[1], env.get_steps(BALL)[0].obs[1]
    assert spec.shape == (2, 3, 1) and seen.shape == (1, 2, 3, 1)
    assert spec.dimension_property[2] == DimensionProperty.NONE
    assert seen[0, 1, :, 0].tolist() == pytest.approx([0.6, 0.8, 1])


def test_actions_reach_those_who_asked_and_are_for_one_step(arena):
    walkers = [Walker("Ball", floats=2), Walker("Goal", team=1, floats=1, branches=(9, 2)), Walker("Ball", period=2)]
    env = arena(*walkers)
    env.reset()
    floats = np.array([[0.5, -2000], [7, 8]])
    env.set_actions(BALL, ActionTuple(floats))
    env.set_actions(GOAL, ActionTuple([[0.25]], [[8, 1]]))
    env.step()
    assert [one.done[-1] for one in walkers] == [((0.5, -2000.0), ()), ((0.25,), (8, 1)), ((7.0, 8.0), ())], "no limits"
    assert ids(env) == ([0], [])
    # Nobody has set one: zeros; and the other repeats its own.
    env.step()
    assert [one.done[-1] for one in walkers] == [((0, 0), ()), ((0,), (0, 0)), ((7, 8), ())]
    env.set_action_for_agent(BALL, 2, ActionTuple(np.array([[3, 4]])))
    env.step()
    assert [one.done[-1][0] for one in walkers if one.behavior == "Ball"] == [(0, 0), (3, 4)]
    env.set_actions(BALL, np.array([[5, 6]]))
    env.reset()
    env.step()
    assert walkers[0].done[-1] == ((0, 0), ()), "reset forgets it"
    mine = np.ones((2, 2), np.float32)
    env.set_actions(BALL, ActionTuple(mine))
    env.set_action_for_agent(BALL, 2, ActionTuple(np.full((1, 2), 9)))
    env.step()
    assert [one.done[-1][0] for one in walkers if one.behavior == "Ball"] == [(1, 1), (9, 9)]
    assert mine.tolist() == [[1, 1], [1, 1]], "the caller's array is not changed"


def test_a_behavior_of_which_nobody_has_its_turn(arena):
    env = arena(Walker("Ball", period=3), Walker("Goal", team=1, floats=0, branches=(2,)))
    env.reset()
    env.step()
    now, over = env.get_steps(BALL)
    assert len(now) == len(over) == 0 and now.obs[0].shape == (0, 4)
    env.set_actions(BALL, env.behavior_specs[BALL].action_spec.empty_action(0))
    env.set_actions(BALL, ActionTuple(continuous=np.array([])))
    with pytest.raises(IndexError, match=r"^agent 0 of Ball\?team=0 wants no action in this step$"):
        env.set_action_for_agent(BALL, 0, np.zeros((1, 2)))
    env.step()


WITHOUT = """
import sys
for name in ("gymnasium", "gym", "pettingzoo"): sys.modules[name] = None
from netmq_example.mlagents_envs.environment import UnityEnvironment
env = UnityEnvironment(base_port=int(sys.argv[1]), timeout_wait=float(sys.argv[2]))
env.reset()
env.step()
print(list(env.behavior_specs), len(env.get_steps("Ball?team=0")[0]))
env.close()
"""


def test_the_scenes_clock_needs_no_gymnasium(served):
    port = served(ArenaSimulator(Arena(Walker("Ball"))), LIMIT)
    done = finished([sys.executable, "-c", WITHOUT, str(port), str(LIMIT)], cwd=ROOT / "python")
    assert done.stdout == "['Ball?team=0'] 1\n", done.stderr


# The scene's clock: faults


class Wrong(ArenaSimulator):
    """Its answers to steps, and their first section, have other values."""

    def __init__(self, section, answer):
        super().__init__(Arena(Walker("Ball", floats=0, branches=(3,))))
        self.wrong = section, answer

    def do(self, request):
        answer = super().do(request)
        if request.id > 1:
            for part, values in zip((answer.sections[0], answer), self.wrong, strict=True):
                for name, value in values.items():
                    setattr(part, name, value)
        return answer


def described(name, **more):
    return trees.write({"kinds": [{**Walker(name).described(), **more}]})


@pytest.mark.parametrize(
    ("section", "answer", "why"),
    [
        ({"values": bytes(12)}, {}, r"12 bytes are not those that 'Ball\?team=0' sees"),
        ({"kind": 5}, {}, "there is no behavior 5 of 1"),
        ({"columns": 0, "ids": b""}, {}, "agents of the scene's clock have ids"),
        ({"columns": IDS | MASKS, "masks": b"\1\0"}, {}, "masks of .* have 3 choices"),
        ({"numbers": np.array([np.nan]).tobytes()}, {}, "the reward is nan"),
        ({}, {"bits": 0}, "the answer is none of the scene's clock"),
        ({}, {"said": described("Ball", continuous=3)}, "came twice"),
        ({}, {"said": described("Cube", branches=[-1])}, "a branch has at least one choice"),
    ],
)
def test_a_wrong_answer_is_said_in_one_line_and_a_reset_goes_on(section, answer, why, connected):
    env = connected(Wrong(section, answer))
    env.reset()
    with pytest.raises(UnityCommunicationException, match=why) as raised:
        env.step()
    assert "\n" not in str(raised.value)
    with pytest.raises(KeyError, match="call reset before get_steps"):
        env.get_steps(BALL)


def test_after_a_step_that_was_interrupted_the_next_one_is_a_reset(arena):
    env = arena(Walker("Ball"))
    env.reset()
    may_go_on, begun = threading.Event(), threading.Event()
    tick = env.arena.tick

    def slow():
        begun.set()
        assert may_go_on.wait(LIMIT)
        tick()

    env.arena.tick = slow
    threading.Thread(target=lambda: begun.wait(LIMIT) and _thread.interrupt_main(), daemon=True).start()
    env.set_actions(BALL, np.array([[1, 2]]))
    with pytest.raises(KeyboardInterrupt):
        env.step()
    may_go_on.set()
    with pytest.raises(KeyError, match="call reset before get_steps"):
        env.get_steps(BALL)
    env.step()
    assert env.arena.resets == [{"seed": 0}, {}] and env.get_steps(BALL)[0].obs[0][0].tolist()[:2] == [0, 0]
    assert env.arena.walkers[0].done == [((1, 2), ())], "it was done once"
    env.step()
    assert env.arena.ticks == 2 and env.arena.walkers[0].done[1:] == [((0, 0), ())]


def test_a_reset_without_an_answer_does_not_wait_twice(arena, monkeypatch):
    env = arena(Walker("Ball"))
    env._simulators.wait = env._simulators.connection.timeout = 1.5
    may_go_on, waits = threading.Event(), []
    env.arena.reset = lambda options: may_go_on.wait(LIMIT) and ([], [])

    def wait(limit, accept, ended):
        waits.append(limit)
        raise TimeoutError("nobody came")

    monkeypatch.setattr(env._simulators.connection, "wait", wait)
    with pytest.raises(UnityTimeOutException, match="nobody came"):
        env.reset()
    may_go_on.set()
    # A second answer is awaited for no longer than it takes to say hello.
    assert waits == [1]


def test_what_is_pythons_alone_is_refused_by_the_scenes_clock(arena):
    with pytest.raises(UnityEnvironmentException, match=r"max_episode_steps and spaces are for Python's clock: its"):
        arena(Walker("Ball"), max_episode_steps=5)


# Python's clock


class Corridor(Agent):
    """Five numbers of steps; what was done is seen."""

    observation = Dict(done=Box(-9, 9, (2,)), step=Box(0, 9, ()))

    def __init__(self, action=None, last=(5, True), name="agent"):
        super().__init__(name)
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
def corridor(connected):
    return lambda *words, **more: connected(SceneSimulator(Scene("Corridor", [Corridor(*words)])), **more)


def test_what_is_seen_and_done_has_its_names(corridor):
    env = corridor()
    env.step()
    assert env.get_behavior_names() == list(env.behavior_specs) == [CORRIDOR]
    spec = env.behavior_specs[CORRIDOR]
    assert [(one.name, one.shape) for one in spec.observation_specs] == [("done", (2,)), ("step", (1,))]
    assert spec.action_spec == (2, ()) and spec.action_spec.is_continuous()
    now, over = env.get_steps(CORRIDOR)
    assert (len(now), len(over), list(now), now.reward.tolist()) == (1, 0, [0], [0.0])
    assert [seen.shape for seen in now.obs] == [(1, 2), (1, 1)]
    assert [seen.shape for seen in over.obs] == [(0, 2), (0, 1)]
    assert now.action_mask is None and [now.group_id.tolist(), now.group_reward.tolist()] == [[0], [0.0]]
    env.set_action_for_agent(CORRIDOR, 0, ActionTuple(np.array([[0.25, -1]])))
    env.step()
    now, _ = env.get_steps(CORRIDOR)
    assert now[0].obs[0].tolist() == [0.25, -1] and now[0].reward == 0.5
    env.step()
    assert env.get_steps(CORRIDOR)[0].obs[0].tolist() == [[0, 0]], "an action is for one step"
    env.set_actions(CORRIDOR, spec.action_spec.random_action(1))
    env.step()
    assert 0 < np.abs(env.get_steps(CORRIDOR)[0].obs[0]).max() <= 1


@pytest.mark.parametrize(
    ("last", "most", "interrupted"),
    [((2, True), 0, False), ((2, False), 0, True), ((3, True), 2, True), ((2, True), 2, False)],
    ids=["terminated", "truncated", "by its time", "in the last step of its time"],
)
def test_the_step_that_ends_an_episode_begins_the_next_one(last, most, interrupted, corridor):
    env = corridor(Discrete(3, start=5), last, max_episode_steps=most)
    env.reset()
    for _ in range(2):
        env.set_actions(CORRIDOR, np.array([[2]]))
        env.step()
        now, over = env.get_steps(CORRIDOR)
        assert now.obs[0].tolist() == [[7, 7]] and len(over) == 0, "0 is the first that there is"
        env.step()
        now, over = env.get_steps(CORRIDOR)
        assert (list(now), list(over)) == ([0], [0]), "an agent keeps its id"
        assert over.obs[1].tolist() == [[2]] and over[0].reward == 0.5 and bool(over[0].interrupted) == interrupted
        assert now.obs[1].tolist() == [[0]] and now[0].reward == 0


def test_several_kinds_of_several_agents(connected):
    agents = [Corridor(None, (2, True), f"long_{at}") for at in range(2)]
    agents += [Corridor(Discrete(4), (3, True), f"short_{at}") for at in range(3)]
    env = connected(SceneSimulator(Scene("Corridors", agents)))
    env.reset()
    one, other = env.behavior_specs
    assert (one, other) == ("long?team=0", "short?team=0")
    assert (ids(env, one), ids(env, other)) == (([0, 1], []), ([2, 3, 4], []))
    env.set_actions(one, np.array([[0.5, 0], [-0.5, 0]]))
    env.set_actions(other, np.array([[1], [2], [3]]))
    env.step()
    assert [agent.done[0] for agent in agents] == [0.5, -0.5, 1, 2, 3]
    env.step()
    assert (ids(env, one), ids(env, other)) == (([0, 1], [0, 1]), ([2, 3, 4], []))
    env.step()
    assert (ids(env, one), ids(env, other)) == (([0, 1], []), ([2, 3, 4], [2, 3, 4]))


@pytest.mark.parametrize(
    ("space", "spec", "action", "done"),
    [
        (MultiDiscrete([2, 5]), (0, (2, 5)), [[1, 4]], [1, 4]),
        (MultiBinary(2), (0, (2, 2)), [[0, 1]], [0, 1]),
        (Discrete(3, start=-1), (0, (3,)), [[0]], -1),
        # A float32 at the limit of a float64 is within it.
        (Box(-0.1, 0.1, (2,), np.float64), (2, ()), [[0.1, -0.1]], [0.1, -0.1]),
    ],
)
def test_actions_of_each_space(space, spec, action, done, corridor):
    env = corridor(space)
    env.reset()
    assert env.behavior_specs[CORRIDOR].action_spec == spec
    env.set_actions(CORRIDOR, np.array(action))
    env.step()
    assert env.get_steps(CORRIDOR)[0].obs[0][0] == pytest.approx(np.resize(done, 2))


class Mixed(Agent):
    """Floats and branches, in parts of parts; a picture, and what may be done."""

    observation = Dict(
        eye=Box(0, 255, (2, 3, 3), np.uint8), action_mask=MultiBinary(5), inner=Tuple([Discrete(9), Box(-1, 1, (2, 2))])
    )
    action = Dict(gear=MultiDiscrete([3, 2]), steer=Tuple([Box(-1, 1, (2,)), Box(0, 5, (), np.float64)]))

    def on_reset(self):
        self.given = None

    def on_action(self, action):
        self.given = action

    def observe(self):
        eye = np.arange(18, dtype=np.uint8).reshape(2, 3, 3)
        return {
            "eye": eye,
            "action_mask": np.array([1, 1, 0, 1, 0], np.int8),
            "inner": (4, np.eye(2, dtype=np.float32)),
        }


def test_parts_of_parts_pictures_and_masks(connected):
    agent = Mixed()
    env = connected(SceneSimulator(Scene("Mixed", [agent])))
    env.reset()
    spec = env.behavior_specs["Mixed?team=0"]
    assert spec.action_spec == (3, (3, 2))
    names = ["eye", "inner.0", "inner.1"]
    assert [(one.name, one.shape) for one in spec.observation_specs] == [
        *zip(names, [(3, 2, 3), (1,), (2, 2)], strict=True)
    ]
    equivariant = DimensionProperty.TRANSLATIONAL_EQUIVARIANCE
    assert spec.observation_specs[0].dimension_property == (DimensionProperty.NONE, equivariant, equivariant)
    now, _ = env.get_steps("Mixed?team=0")
    assert [seen.dtype for seen in now.obs] == [np.float32] * 3
    assert now.obs[0][0, 1].ravel() * 255 == pytest.approx([1, 4, 7, 10, 13, 16])
    assert now.obs[1].tolist() == [[4]] and now.obs[2].tolist() == [[[1, 0], [0, 1]]]
    assert [mask.tolist() for mask in now.action_mask] == [[[False, False, True]], [[False, True]]]
    env.set_actions("Mixed?team=0", ActionTuple(np.array([[0.5, -1, 2.5]]), np.array([[2, 1]])))
    env.step()
    assert agent.given["gear"].tolist() == [2, 1] and float(agent.given["steer"][1]) == 2.5
    assert agent.given["steer"][0].tolist() == [0.5, -1]


class Choosing(Corridor):
    """It says in its info what may be done, at times."""

    def on_action(self, action):
        super().on_action(action)
        if self.steps % 2:
            self.info["action_mask"] = np.array([1, 0, 1], np.int8)


def test_masks_of_infos(connected):
    env = connected(SceneSimulator(Scene("Choosing", [Choosing(Discrete(3)), Choosing(Discrete(3), name="agent_1")])))
    env.reset()
    (name,) = env.behavior_specs
    masks = []
    for _ in range(2):
        env.step()
        masks.append(env.get_steps(name)[0].action_mask[0].tolist())
    assert masks == [[[False, True, False]] * 2, [[False] * 3] * 2]


def test_an_agent_that_leaves_has_ended_and_another_in_its_place_has_its_own_id(connected):
    agents = [Corridor(None, (9, True), f"agent_{at}") for at in range(3)]
    scene = Scene("Corridor", [*agents])
    env = connected(SceneSimulator(scene))
    env.reset()
    (name,) = env.behavior_specs
    env.step()
    scene.agents.remove(agents[1])
    env.step()
    now, over = env.get_steps(name)
    assert (list(now), list(over), over.interrupted.tolist()) == ([0, 2], [1], [True])
    assert over.obs[1].tolist() == [[1]], "as it was seen last"
    env.set_actions(name, np.array([[0.5, 0], [-0.5, 0]]))
    env.step()
    assert ids(env, name) == ([0, 2], []) and [agents[0].done[0], agents[2].done[0]] == [0.5, -0.5]
    scene.agents.append(Corridor(None, (9, True), "agent_1"))
    env.step()
    env.step()
    now, over = env.get_steps(name)
    assert (list(now), list(over), now.obs[1].ravel().tolist()) == ([0, 3, 2], [], [5, 1, 5])


def test_the_same_seed_gives_the_same_episodes_as_gymnasium(connected, inside, make):
    from netmq_example.envs import UnityGymEnv
    from tests.lessons.conftest import simulated

    env = connected(simulated(), seed=9)
    gym = make(UnityGymEnv, "CartPole", socket=inside(simulated()).socket)
    env.reset()
    seen, _ = gym.reset(seed=9)
    (name,) = env.behavior_specs
    for _ in range(25):
        assert env.get_steps(name)[0].obs[0][0].tolist() == seen.tolist()
        env.set_actions(name, np.array([[1]]))
        env.step()
        seen, _, over, _, _ = gym.step(1)
        if over:
            assert env.get_steps(name)[1].obs[0][0].tolist() == seen.tolist()
            seen, _ = gym.reset()


def test_what_is_wrong_is_said_in_one_line(corridor, connected):
    with pytest.raises(
        UnityEnvironmentException, match=r"^no-action: ML-Agents has no action Text\(.*: take gymnasium"
    ):
        corridor(Text(3))
    env = corridor(None, (2, True))
    env.set_actions(CORRIDOR, np.full((1, 2), 0.75))
    with pytest.raises(KeyError, match="call reset before get_steps"):
        env.get_steps(CORRIDOR)
    env.reset()
    env.step()
    assert env.get_steps(CORRIDOR)[0].obs[0].tolist() == [[0, 0]], "what was set before the first reset is none"
    with pytest.raises(UnityActionException, match=r"^there is no behavior 'Maze'; there is: Corridor\?team=0$"):
        env.get_steps("Maze")
    takes = "(1, 2) floats and (1, 0) whole numbers, [agents, size]"
    shapes = re.escape(f"Corridor?team=0 takes {takes}, and not (1, 3) and (1, 0)")
    with pytest.raises(ValueError, match=f"^{shapes}$"):
        env.set_actions(CORRIDOR, np.zeros((1, 3)))
    with pytest.raises(UnityActionException, match=r"^Corridor\?team=0 takes an ActionTuple, not \[\[1\], \[2, 3\]\]"):
        env.set_actions(CORRIDOR, [[1], [2, 3]])
    env.set_actions(CORRIDOR, np.array([[0, 1.5]]))
    with pytest.raises(UnityActionException, match=r"1\.5.* not in Box"):
        env.step()
    # Nothing has moved, and the next step goes on.
    env.step()
    assert env.get_steps(CORRIDOR)[1].obs[1].tolist() == [[2]]
    with pytest.raises(ValueError, match="max_episode_steps"):
        UnityEnvironment(max_episode_steps=-1)
    with pytest.raises(UnityEnvironmentException, match=r"^num_areas: nothing copies areas here"):
        UnityEnvironment(num_areas=4)
    with pytest.raises(TypeError, match="additional_args takes a list of words, not '-batchmode'"):
        UnityEnvironment(additional_args="-batchmode")
    with pytest.raises(ValueError, match="base_port takes"):
        UnityEnvironment(base_port="5004")


def test_a_mistake_in_the_scene_is_an_exception_of_ml_agents(connected):
    class Wrong(Corridor):
        def on_action(self, action):
            raise RuntimeError("no more fuel")

    env = connected(SceneSimulator(Scene("Corridor", [Wrong()])))
    env.reset()
    with pytest.raises(UnityCommunicationException, match="no more fuel"):
        env.step()
    env.reset()
    assert ids(env, "Corridor?team=0") == ([0], [])


def test_a_scene_without_side_channels_goes_on(corridor, caplog):
    channel = EnvironmentParametersChannel()
    env = corridor(side_channels=[channel])
    for _ in range(3):
        channel.set_float_parameter("gravity", 1)
        env.reset()
        env.step()
    assert caplog.text.count("no-side-channels") == 1 and not channel.message_queue


def test_agents_by_attributes_have_the_spaces_that_are_given(connected):
    from typing import Annotated

    from netmq_example.scene import Obs

    class Car(Agent):
        speed: Annotated[float, Obs()] = 0.0
        place: Annotated[np.ndarray, Obs()] = np.zeros(2, np.float32)

        def on_action(self, action):
            self.speed += float(action[0])

    spaces = {"observation_space": Dict(speed=Box(-9, 9, ()), place=Box(-9, 9, (2,))), "action_space": Box(-1, 1, (1,))}
    env = connected(SceneSimulator(Scene("Cars", [Car("car_0"), Car("car_1")])), **spaces)
    env.reset()
    env.set_actions("Cars?team=0", np.array([[0.5], [-0.25]]))
    env.step()
    now, _ = env.get_steps("Cars?team=0")
    names = [spec.name for spec in env.behavior_specs["Cars?team=0"].observation_specs]
    assert now.obs[names.index("speed")].tolist() == [[0.5], [-0.25]]


# Simulators that are found, launched, lost and closed


def test_ports_and_names(corridor):
    assert (UnityEnvironment.DEFAULT_EDITOR_PORT, UnityEnvironment.BASE_ENVIRONMENT_PORT) == (5004, 5005)
    assert UnityEnvironment.API_VERSION == "1.5.0"
    names = ("BaseEnv", "BehaviorMapping", "SideChannel", "TerminalSteps", "AgentId", "UnityTimeOutException")
    assert all(hasattr(environment, each) for each in names)
    env = corridor()
    capabilities = env.academy_capabilities
    assert (capabilities.baseRLCapabilities, capabilities.trainingAnalytics, len(capabilities)) == (True, False, 7)
    assert env._simulators.connection.endpoint.endswith(f":{env._port}") and env._process is None


def test_a_simulator_that_is_missing_has_ml_agents_names(corridor, tmp_path):
    with pytest.raises(UnityTimeOutException, match="no simulator came"):
        UnityEnvironment(base_port=steady_port(), timeout_wait=0.1)
    with pytest.raises(UnityTimeOutException, match="the simulator ended with code 2"):
        UnityEnvironment(str(PYTHON), additional_args=["nothing.py"])
    with pytest.raises(UnityEnvironmentException, match="no game at"):
        UnityEnvironment(str(tmp_path / "game"), no_graphics=True)
    taken = corridor()._port
    in_use = rf"^the port of worker 2 is in use: .*cannot listen on tcp://127.0.0.1:{taken}: "
    with pytest.raises(UnityWorkerInUseException, match=in_use):
        UnityEnvironment(base_port=taken - 2, worker_id=2)
    with pytest.raises(TypeError, match=r"^file_name takes a str or PathLike, not \['game"):
        UnityEnvironment(["game"])
    # Scripts that catch Python's own catch them as well.
    assert issubclass(UnityTimeOutException, UnityException) and issubclass(UnityTimeOutException, TimeoutError)


def test_after_close_it_says_so(corridor):
    env = corridor()
    env.reset()
    env.close()
    assert not env._loaded
    for call in (env.close, env.reset, env.step):
        with pytest.raises(UnityEnvironmentException, match="this environment is closed: make a new one"):
            call()


def test_a_build_gets_the_words_of_ml_agents(tmp_path):
    def words(**more):
        env = UnityEnvironment.__new__(UnityEnvironment)
        settings = {"no_graphics": False, "log_folder": None, "additional_args": [], "worker_id": 0, **more}
        vars(env).update({f"_{name}": value for name, value in settings.items()})
        return env._executable_args()

    assert words(additional_args=["--level", "2"]) == ["--level", "2"]
    assert words(no_graphics=True) == ["-nographics", "-batchmode"]
    log = str(tmp_path / "Player-3.log")
    assert words(log_folder=str(tmp_path), worker_id=3, additional_args=["a"]) == ["-logFile", log, "a"]
    assert words(log_folder=str(tmp_path), additional_args=["-LogFile", "x"]) == ["-LogFile", "x"]


def test_graphics_are_for_the_first_worker_where_one_watches():
    for worker in (0, 2):
        with pytest.raises(UnityTimeOutException, match="the simulator ended with code") as raised:
            UnityEnvironment(str(PYTHON), worker, no_graphics_monitor=True, additional_args=["-c", "pass"])
        assert ("-nographics -batchmode" in str(raised.value)) == bool(worker)


@pytest.mark.parametrize(
    ("words", "agents"),
    [(["-m", "tests.lessons.scene_clock"], [0, 1]), ([str(FALLING_BALL)], [0])],
    ids=["the scene's clock", "Python's clock"],
)
def test_a_build_is_launched_and_once_more_when_it_is_lost(words, agents, monkeypatch):
    """With the words that a build takes: here Python is the build."""
    monkeypatch.setenv("PYTHONPATH", f"{ROOT}{os.pathsep}{ROOT / 'python'}")
    env = UnityEnvironment(str(PYTHON), additional_args=words, seed=3, timeout_wait=LIMIT)
    try:
        env.reset()
        env.step()
        before = dict(env.behavior_specs)
        env._process.kill()
        env._process.wait()
        lost = r"^the simulator is lost: .*; reset waits for another"
        with pytest.raises(UnityCommunicatorStoppedException, match=lost):
            env.step()
        with pytest.raises(KeyError, match="call reset before get_steps"):
            env.get_steps(BALL)
        env.reset()
        env.set_actions(BALL, before[BALL].action_spec.random_action(len(agents)))
        env.step()
        assert dict(env.behavior_specs) == before and ids(env) == (agents, [])
    finally:
        env.close()
