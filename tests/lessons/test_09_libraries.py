"""Libraries of reinforcement learning take environments as their own: they copy and pickle them, ask for all that
Gymnasium's and PettingZoo's own have, take plain spaces, masks and goals, and end in whatever way, after which no
simulator may be left. Rules for each library, run where that library is installed.
"""

import copy
import importlib
import pickle
import signal
import sys
import time
import types
from typing import Any

import pytest

from tests.conftest import PYTHON
from tests.lessons.conftest import simulated
from tests.programs import LIMIT, ROOT, Mark, finds_processes

gymnasium = pytest.importorskip("gymnasium", reason="lesson 09 needs gymnasium: kit.py run 9 installs it")
np = pytest.importorskip("numpy", reason="lesson 09 needs numpy: kit.py run 9 installs it")
pytest.importorskip("pettingzoo", reason="lesson 10 needs pettingzoo: kit.py run 10 installs it")
from gymnasium import spaces  # noqa: E402
from gymnasium.utils.env_checker import data_equivalence  # noqa: E402
from gymnasium.vector import SyncVectorEnv, VectorEnv  # noqa: E402
from gymnasium.vector.utils import batch_space, iterate  # noqa: E402
from gymnasium.wrappers.vector import RecordEpisodeStatistics  # noqa: E402
from pettingzoo import AECEnv, ParallelEnv  # noqa: E402

sys.path.append(str(ROOT / "python" / "11_observations"))
from collector import ACTION, seen_space  # noqa: E402

from netmq_example import envs  # noqa: E402
from netmq_example.envs.plain_spaces import Plain, PlainSpaces  # noqa: E402
from netmq_example.scene import Agent, Scene, SceneSimulator  # noqa: E402

ID = "NetMQExample/CartPole-v0"
UNITY = "NetMQExample/Unity-v0"
posix = pytest.mark.skipif(sys.platform == "win32", reason="Windows has no signals")
POLES = ["10_many_agents", "--world", "CartPole", "--areas"]
# Of each class a lesson whose client it launches, with its words, and what it is made of.
MADE = {
    "UnityGymEnv": (["09_environment"], {"env_name": "CartPole"}),
    "UnityVectorEnv": ([*POLES, "3"], {"num_envs": 3, "env_name": "CartPole", "max_episode_steps": 9}),
    "UnityParallelEnv": (["10_many_agents"], {"env_name": "Pursuit"}),
    "UnityAECEnv": (["10_many_agents"], {"env_name": "Pursuit"}),
    "Coins": (
        ["11_observations"],
        {"env_name": "Coins", "observation_space": seen_space(False), "action_space": ACTION},
    ),
}


def client(key, *words):
    """The command of a lesson's client in Python, for an environment that launches it."""
    return [PYTHON, ROOT / "python" / key / "client.py", *words, "--timeout", "60"]


@pytest.fixture
def mark(monkeypatch):
    """It finds what this test launches, or would."""
    mark = Mark()
    monkeypatch.setenv("KIT_TEST_MARK", mark.environment["KIT_TEST_MARK"])
    return mark


@pytest.fixture
def made(make):
    """made("UnityGymEnv"): one with a simulator of its own."""

    def made(name):
        words, more = MADE[name]
        return make(getattr(envs, name, envs.UnityGymEnv), **more, launch=client(*words))

    return made


def simulators(mark):
    # The first is the time that one takes which was asked to end.
    return [pid for pid, command in mark.processes().items() if "--endpoint" in command]


def becomes(count, mark):
    end = time.monotonic() + LIMIT
    while len(simulators(mark)) != count and time.monotonic() < end:
        time.sleep(0.05)
    return len(simulators(mark)) == count


def action(env, agent=None):
    """Always the same for the same agent."""
    space = env.action_space if agent is None else env.action_space(agent)
    space.seed(1)
    return space.sample()


def step(env):
    if isinstance(env, AECEnv):
        agent = env.agent_selection
        env.step(action(env, agent))
        return agent, env.observe(agent), dict(env.rewards)
    if isinstance(env, ParallelEnv):
        return env.step({agent: action(env, agent) for agent in env.agents})
    return env.step(action(env))


def played(env):
    return [env.reset(seed=3), *(step(env) for _ in range(5))]


class Least(gymnasium.Env):  # type: ignore[name-defined]
    """Has what every environment has."""

    observation_space, action_space = gymnasium.spaces.Discrete(2), gymnasium.spaces.Discrete(2)


def public(kind, *others):
    """All names that they have, or are declared to have."""
    names = {name for one in kind.__mro__ for name in vars(one).get("__annotations__", ())}
    return {name for name in names.union(dir(kind), *map(dir, others)) if not name.startswith("_")}


# Of SyncVectorEnv: what it makes its environments of, and how it keeps them.
OWN = {"copy", "env_fns", "envs"}


@finds_processes
@pytest.mark.filterwarnings("ignore:.*dictionary is deprecated")
@pytest.mark.parametrize("name", MADE)
def test_it_has_what_others_have_and_a_copy_is_an_environment_of_its_own(name, made, make, mark):
    env = made(name)
    first = played(env)
    base = next(each for each in (VectorEnv, gymnasium.Env, ParallelEnv, AECEnv) if isinstance(env, each))
    assert base is AECEnv or base in type(env).__bases__, "by which skrl knows it"
    if base is VectorEnv:
        needed = public(SyncVectorEnv, SyncVectorEnv([Least])) - OWN
    else:
        needed = public(Least, Least()) if base is gymnasium.Env else public(base)
    assert sorted(one for one in needed if not hasattr(env, one)) == []
    other = make(pickle.loads, pickle.dumps(env))
    assert type(other) is type(env) and len(simulators(mark)) == 2
    assert data_equivalence(played(other), first, exact=True)
    # And it goes on where it was, as if there had been no other.
    again = step(env)
    assert data_equivalence(again, step(other), exact=True)
    other.close()
    assert becomes(1, mark)
    assert data_equivalence(played(env), first, exact=True)
    env.close()
    assert becomes(0, mark)


@finds_processes
def test_a_copy_of_what_make_returns_is_as_it_was_made(mark):
    """With its wrappers, and its spec, by which libraries make more of them."""
    env = PlainSpaces(gymnasium.make(ID, launch=client("09_environment"), max_episode_steps=2))
    other = copy.deepcopy(env)
    assert other.spec == env.spec and other.unwrapped.spec == env.unwrapped.spec
    other.reset(seed=1)
    assert [other.step(0)[3] for _ in range(2)] == [False, True]
    more = gymnasium.make(other.spec)
    more.reset()
    assert len(simulators(mark)) == 3 and isinstance(more, PlainSpaces)
    for each in more, other, env:
        each.close()
    assert becomes(0, mark)


def test_one_with_a_given_socket_refuses_a_copy(inside, make):
    env = make(envs.UnityGymEnv, "CartPole", socket=inside(simulated()).socket)
    for way in copy.deepcopy, pickle.dumps:
        with pytest.raises(TypeError, match=r"^UnityGymEnv has a socket that it was given"):
            way(env)


# The end of a script


SCRIPT = """
import os, sys, time
sys.path.append({path!r})
import gymnasium, netmq_example.envs
if __name__ == "__main__":
    many, how, *launch = sys.argv[1:]
    if many == "async":
        env = gymnasium.make_vec({id!r}, 2, vectorization_mode="async", launch=launch)
    else:
        env = gymnasium.make({id!r}, launch=launch)
    env.reset()
    env.step(env.action_space.sample())
    print("ready", flush=True)
    if how == "exit":
        os._exit(3)
    if how == "raise":
        raise ValueError("it is over")
    if how != "end":
        time.sleep(1000)
"""
ENDS = {
    "end": None,
    "raise": None,
    "exit": None,
    "terminated": signal.SIGTERM,
    "interrupted": signal.SIGINT,
    "killed": getattr(signal, "SIGKILL", None),
}


@posix
@finds_processes
@pytest.mark.parametrize(
    ("kind", "many", "ends"),
    [
        ("python", "single", [*ENDS]),
        ("python", "async", ["exit", "terminated"]),
        ("csharp", "single", ["end", "killed"]),
    ],
)
def test_no_simulator_is_left_however_a_script_ends(kind, many, ends, start, launch, tmp_path):
    """They would wait for ten minutes, if nobody ended them."""
    script = tmp_path / "script.py"
    script.write_text(SCRIPT.format(path=str(ROOT / "python"), id=ID), encoding="utf-8")
    words = launch(kind, "--timeout", "600")
    # All at once: it takes long to start each of them.
    scripts = {}
    for how in ends:
        mark = Mark()
        scripts[how] = mark, start(PYTHON, script, many, how, *words, **mark.environment)
    for how, (mark, program) in scripts.items():
        program.wait_for("^ready")
        # A script that ends at once may be gone by now.
        if ENDS[how]:
            assert len(simulators(mark)) == (2 if many == "async" else 1)
            program.process.send_signal(ENDS[how])
    for how, (mark, program) in scripts.items():
        program.wait()
        assert becomes(0, mark), (how, mark.processes())


# Spaces


BOX = spaces.Box(-1, 1, (2,))
PICTURE = spaces.Box(0, 255, (4, 4, 3), np.uint8)
LIST = spaces.Sequence(spaces.Dict(place=BOX, kind=spaces.Discrete(3, start=1), says=spaces.Text(3)))
STACK = spaces.Sequence(spaces.Dict(keys=spaces.MultiBinary([2, 2]), gears=spaces.MultiDiscrete([3, 3])), stack=True)
# What is seen, and what becomes of it.
SEEN = [
    (BOX, BOX),
    (spaces.Dict(a=BOX, b=PICTURE), spaces.Dict(a=BOX, b=PICTURE)),
    (spaces.Discrete(5, start=3), spaces.Discrete(5)),
    (
        spaces.MultiDiscrete(np.array([[3, 4], [2, 2]]), start=np.array([[1, 1], [0, 0]])),
        spaces.MultiDiscrete([3, 4, 2, 2]),
    ),
    (spaces.Box(-1, 1, ()), spaces.Box(-1, 1, (1,))),
    (spaces.Sequence(BOX), spaces.Box(-1, 1, (8, 2))),
    (spaces.Sequence(spaces.Box(1, 2, ())), spaces.Box(0, 2, (8, 1))),
    (spaces.Dict({"a.b": BOX, "a_b": BOX, "": BOX}), spaces.Dict({"a_b": BOX, "a_b_": BOX, "seen": BOX})),
    (spaces.Dict(a=spaces.Tuple([BOX, spaces.Text(3)])), spaces.Dict(a_0=BOX)),
    (LIST, spaces.Dict(place=spaces.Box(-1, 1, (8, 2)), kind=spaces.MultiDiscrete([3] * 8))),
    (STACK, spaces.Dict(keys=spaces.MultiBinary(32), gears=spaces.MultiDiscrete([3] * 16))),
]
GEARS = spaces.Tuple(
    [spaces.MultiDiscrete(np.array([[3, 2], [2, 2]]), start=np.ones((2, 2), int)), spaces.MultiBinary([2, 2])]
)
DONE = [
    (BOX, BOX),
    (spaces.Discrete(3, start=2), spaces.Discrete(3)),
    (spaces.MultiDiscrete(np.array([[3, 2], [2, 2]])), spaces.MultiDiscrete([3, 2, 2, 2])),
    (spaces.MultiBinary([2, 2]), spaces.MultiBinary(4)),
    (spaces.Box(-128, 127, (2, 2), np.int8), spaces.Box(-1, 1, (4,))),
    (
        spaces.Dict(arm=spaces.Box(-4.6, 2.7, ()), gear=spaces.Discrete(3, start=-1), keys=GEARS),
        spaces.Box(-1, 1, (17,)),
    ),
    (spaces.Dict(open=spaces.Box(0, np.inf, (1,))), spaces.Box(-1, 1, (1,))),
]


def plain_of(seen, done):
    """As it is, and as it comes out of a pickle."""
    return pickle.loads(pickle.dumps(Plain(seen, done)))


@pytest.mark.parametrize(("seen", "expected"), SEEN)
def test_what_is_seen_becomes_arrays(seen, expected):
    plain = plain_of(seen, BOX)
    assert plain.observation_space == expected
    three = batch_space(seen, 3)
    for seed in range(9):
        three.seed(seed)
        batch = three.sample()
        each = [plain.look(one) for one in iterate(three, batch)]
        assert all(one in expected for one in each)
        # The batch is the same at once.
        assert data_equivalence(list(iterate(batch_space(expected, 3), plain.look(batch, 3))), each, exact=True)


@pytest.mark.parametrize(("done", "expected"), DONE)
def test_whatever_an_array_says_can_be_done(done, expected):
    plain = plain_of(BOX, done)
    assert plain.action_space == expected
    actions = [expected.sample() for _ in range(9)]
    if isinstance(expected, spaces.Box):
        actions += [np.full(expected.shape, end, np.float32) for end in (-1, 1)]
    each = [plain.choose(one) for one in actions]
    assert all(one in done for one in each)
    many = batch_space(done, len(actions))
    assert data_equivalence(list(iterate(many, plain.choose(np.stack(actions)))), each, exact=True)


def test_the_ends_of_an_array_are_those_of_a_box_and_what_has_no_array_is_named():
    plain = Plain(BOX, spaces.Box(-128, 127, (2,), np.int8))
    assert [plain.choose(np.array(end)).tolist() for end in ([-1, 1], [0, 9])] == [[-128, 127], [0, 127]]
    with pytest.raises(ValueError, match="nothing is left of Text"):
        Plain(spaces.Text(3), BOX)
    with pytest.raises(ValueError, match="no array says what is done in Text"):
        Plain(BOX, spaces.Dict(a=spaces.Text(3)))


# Masks and goals


class Picky(Agent):
    """Ends of an action that it does not allow."""

    observation = spaces.Dict(observation=spaces.Box(0, 99, (1,)), action_mask=spaces.MultiBinary(3))
    action = spaces.Discrete(3)
    life = 9

    def on_reset(self):
        self.age = 0

    def allowed(self):
        return np.array([self.age % 2, 1 - self.age % 2, self.age % 3 == 0], np.int8)

    def on_action(self, action):
        if not self.allowed()[action]:
            raise ValueError(f"{action} is not allowed")

    def on_stepped(self):
        self.age += 1
        self.reward = 1.0
        self.terminated = self.age == self.life

    def observe(self):
        return {"observation": [self.age], "action_mask": self.allowed()}


class Shy(Picky):
    """Its mask is in its info."""

    observation = spaces.Box(0, 99, (1,))

    def on_reset(self):
        super().on_reset()
        self.info["action_mask"] = self.allowed()

    def on_stepped(self):
        super().on_stepped()
        self.info["action_mask"] = self.allowed()

    def observe(self):
        return [self.age]


class Reach(Agent):
    """A goal, as hindsight replay wants it."""

    observation = spaces.Dict(dict.fromkeys(("observation", "achieved_goal", "desired_goal"), BOX))
    action = BOX

    def on_reset(self):
        self.place, self.goal = np.zeros(2), np.array([2 * self.rng() - 1 for _ in range(2)])

    def on_action(self, action):
        self.place = np.clip(self.place + action / 4, -1, 1)

    def on_stepped(self):
        self.reward = float(nearness(self.place, self.goal, {}))

    def observe(self):
        return {"observation": self.place, "achieved_goal": self.place, "desired_goal": self.goal}


def nearness(achieved, desired, infos):
    return -(np.linalg.norm(achieved - desired, axis=-1) > 0.3).astype(np.float32)


def scene_of(kind, count, name="Masks"):
    return SceneSimulator(Scene(name, [kind() for _ in range(count)]))


# Stable-Baselines3


class VecEnv:
    """As Stable-Baselines3 2.9 has it, around the methods of a class derived from it."""

    get_attr: Any
    step_async: Any
    step_wait: Any

    def __init__(self, num_envs, observation_space, action_space):
        self.num_envs, self.observation_space, self.action_space = num_envs, observation_space, action_space
        self.reset_infos = [{} for _ in range(num_envs)]
        self._reset_seeds()
        self._reset_options()
        assert set(self.get_attr("render_mode")) == {None}

    def _get_indices(self, indices):
        return range(self.num_envs) if indices is None else [indices] if isinstance(indices, int) else indices

    def _reset_seeds(self):
        self._seeds = [None] * self.num_envs

    def _reset_options(self):
        self._options = [{} for _ in range(self.num_envs)]

    def seed(self, seed):
        self._seeds = [seed + number for number in range(self.num_envs)]

    def set_options(self, options):
        self._options = options if isinstance(options, list) else [options] * self.num_envs

    def step(self, actions):
        self.step_async(actions)
        return self.step_wait()


@pytest.fixture
def sb3(monkeypatch):
    """netmq_example.sb3, also where there is no Stable-Baselines3."""
    try:
        importlib.import_module("stable_baselines3.common.vec_env")
    except ImportError:
        for name in ("", ".common", ".common.vec_env"):
            module = types.ModuleType(f"stable_baselines3{name}")
            monkeypatch.setitem(sys.modules, module.__name__, module)
            module.__dict__["VecEnv"] = VecEnv
    monkeypatch.delitem(sys.modules, "netmq_example.sb3", raising=False)
    yield importlib.import_module("netmq_example.sb3")
    sys.modules.pop("netmq_example.sb3", None)


@pytest.fixture
def many(sb3, inside, make):
    """many(Picky, 3): so many agents for Stable-Baselines3."""

    def many(kind, count, name="Masks", **words):
        socket = inside(scene_of(kind, count, name)).socket
        return make(sb3.UnityVecEnv, UNITY, count, env_name=name, socket=socket, **words)

    return many


def test_a_vecenv_is_the_vector_environment(sb3, inside, make):
    """An end by the world and one by time are told apart. It makes itself, or is made of what make_vec made."""
    words = {"max_episode_steps": 12, "autoreset_mode": "SameStep"}
    vector, wrapped = (make(gymnasium.make_vec, ID, 4, socket=inside(simulated(count=4)).socket, **words) for _ in "ab")
    words = {"max_episode_steps": 12, "socket": inside(simulated(count=4)).socket}
    both = [
        make(sb3.UnityVecEnv, f"netmq_example.envs:{ID}", 4, **words),
        make(sb3.UnityVecEnv, RecordEpisodeStatistics(wrapped)),
    ]
    first = vector.reset(seed=[7, 8, 9, 10])[0]
    for areas in both:
        areas.seed(7)
        assert np.array_equal(areas.reset(), first) and areas.reset_infos == [{}] * 4
    ends = set()
    for step in range(60):
        # Two are pushed over, and two are kept up until their time is over.
        actions = np.array([1, 0, step % 2, step % 2], np.int32)
        theirs, gains, terminated, truncated, infos = vector.step(actions)
        for areas in both:
            seen, rewards, over, said = areas.step(actions)
            assert np.array_equal(seen, theirs) and np.array_equal(over, terminated | truncated)
            assert np.array_equal(rewards, gains) and rewards.dtype == np.float32
            for area in range(4):
                assert ("terminal_observation" in said[area]) == over[area]
                # The infos of one of Gymnasium's wrappers.
                assert ("episode" in said[area]) == (over[area] and areas is not both[0])
                if over[area]:
                    assert np.array_equal(said[area]["terminal_observation"], infos["final_obs"][area])
                    assert said[area]["TimeLimit.truncated"] == truncated[area] != terminated[area]
                    ends.add(said[area]["TimeLimit.truncated"])
    assert ends == {True, False}


@pytest.mark.parametrize("kind", [Picky, Shy])
def test_masks_of_each_agent(kind, many):
    areas = many(kind, 3)
    # By which MaskablePPO finds out whether there are any.
    areas.get_attr("action_masks")
    areas.reset()
    told = [["action_mask"] if kind is Shy else []] * 3
    assert [list(info) for info in areas.reset_infos] == told
    for _ in range(12):
        masks = areas.env_method("action_masks", indices=[2, 0])
        assert all(data_equivalence(mask, masks[0], exact=True) for mask in masks) and masks[0].dtype == bool
        areas.step(areas.action_masks().argmax(1))
    areas = many(Reach, 2)
    areas.reset()
    with pytest.raises(AttributeError, match="no action_mask is in what the agents see"):
        areas.get_attr("action_masks")


def test_attributes_goals_and_options_of_a_vecenv(many, sb3):
    areas = many(Reach, 3, compute_reward=nearness)
    assert (
        areas.env_method("compute_reward", np.zeros((5, 2)), np.ones((5, 2)), {}, indices=[0])[0].tolist() == [-1] * 5
    )
    assert areas.get_attr("action_space", 1) == [BOX]
    assert areas.env_is_wrapped(gymnasium.Wrapper) == [False] * 3
    areas.set_attr("mine", 5)
    assert areas.get_attr("mine") == [5] * 3
    with pytest.raises(ValueError, match="mine is the same for all agents"):
        areas.set_attr("mine", 5, indices=[0])
    areas.seed(3)
    first = areas.reset()
    areas.set_options({"level": 7})
    assert not np.array_equal(areas.reset()["desired_goal"], first["desired_goal"]), "a seed is for one reset"
    areas.set_options([{"level": 7}, {"level": 7}, {}])
    with pytest.raises(ValueError, match="set_options takes one dict for all of them"):
        areas.reset()
    with pytest.warns(DeprecationWarning, match="Areas is UnityVecEnv now"):
        assert sb3.Areas is sb3.UnityVecEnv
    with pytest.raises(ValueError, match="wants the next episode at once"):
        sb3.UnityVecEnv(types.SimpleNamespace(metadata={"autoreset_mode": None}))


# Each library


def pursuit():
    return envs.UnityParallelEnv("Pursuit", launch=client("10_many_agents"))


def needs(name):
    """The module. Packages that it needs in turn may be missing as well."""
    try:
        return importlib.import_module(name)
    except ImportError as error:
        pytest.skip(f"{name} is not here: {error}")


@pytest.mark.long
def test_stable_baselines3_checks_and_learns(many, sb3):
    library = needs("stable_baselines3.common.env_checker") and needs("stable_baselines3")
    common, ppo = library.common, {"n_steps": 32, "batch_size": 32, "device": "cpu"}
    launches = {ID: client("09_environment"), "NetMQExample/Car-v0": client("09_environment", "--world", "Car")}
    for name, launch in launches.items():
        env = gymnasium.make(name, launch=launch)
        common.env_checker.check_env(env)
        env.close()
        # It asks for pictures unasked.
        two = common.env_util.make_vec_env(name, 2, env_kwargs={"launch": launch}, seed=1)
        library.PPO("MlpPolicy", two, **ppo).learn(64)
        two.close()
    poles = common.vec_env.VecMonitor(sb3.UnityVecEnv(ID, 4, launch=client(*POLES, "4")))
    for model in library.PPO("MlpPolicy", poles, **ppo), library.DQN("MlpPolicy", poles):
        model.learn(256)
        assert model.ep_info_buffer
    poles.close()
    goals = many(Reach, 2, compute_reward=nearness, max_episode_steps=10)
    library.SAC("MultiInputPolicy", goals, replay_buffer_class=library.HerReplayBuffer, learning_starts=40).learn(80)


@pytest.mark.long
def test_stable_baselines3s_own_vecenv_of_single_ones_is_the_same(sb3):
    vec_env = needs("stable_baselines3.common.vec_env.dummy_vec_env")
    words = {"max_episode_steps": 20}
    single = [lambda: gymnasium.make(ID, launch=client("09_environment"), **words)] * 3
    both = [vec_env.DummyVecEnv(single), sb3.UnityVecEnv(ID, 3, launch=client(*POLES, "3"), **words)]
    for envs_ in both:
        envs_.seed(5)
    try:
        assert np.array_equal(*(envs_.reset() for envs_ in both))
        for step in range(100):
            theirs, ours = (envs_.step(np.array([1, step % 2, step % 3 > 0], int)) for envs_ in both)
            assert data_equivalence(theirs[:3], ours[:3], exact=True)
            for one, other in zip(theirs[3], ours[3], strict=True):
                ends = {key: one[key] for key in one if key not in ("env", "agent")}
                assert data_equivalence(ends, {"TimeLimit.truncated": False, **other}, exact=True)
    finally:
        for envs_ in both:
            envs_.close()


@pytest.mark.long
@pytest.mark.parametrize("kind", [Picky, Shy])
def test_maskable_ppo_never_does_what_is_forbidden(kind, many):
    ppo = needs("sb3_contrib").MaskablePPO
    policy = "MultiInputPolicy" if kind is Picky else "MlpPolicy"
    # An action that is not allowed is an error.
    model = ppo(policy, many(kind, 4), n_steps=32, batch_size=32, n_epochs=1, device="cpu").learn(256)
    assert len(model.ep_info_buffer) == 0 and model.num_timesteps == 256


@pytest.mark.long
def test_supersuit_makes_a_vector_of_a_game():
    supersuit = needs("supersuit")
    game = supersuit.black_death_v3(pursuit())
    vector = supersuit.concat_vec_envs_v1(supersuit.pettingzoo_env_to_vec_env_v1(game), 2, base_class="gymnasium")
    vector.reset()
    for _ in range(50):
        assert np.isfinite(vector.step(np.array([vector.action_space.sample() for _ in range(10)]))[1]).all()
    vector.close()


@pytest.mark.long
def test_skrl_knows_each_of_them():
    torch = needs("torch")
    wrap_env = needs("skrl.envs.wrappers.torch").wrap_env
    for env in (
        gymnasium.make(ID, launch=client("09_environment")),
        gymnasium.make_vec(ID, 4, launch=client(*POLES, "4")),
        pursuit(),
    ):
        wrapped = wrap_env(env)
        wrapped.reset()
        if isinstance(env, ParallelEnv):
            wrapped.step({agent: torch.zeros((1, 1), dtype=torch.int64) for agent in wrapped.agents})
        else:
            wrapped.step(torch.zeros((wrapped.num_envs, 1), dtype=torch.int64))
        wrapped.close()


@pytest.mark.long
def test_torchrl_makes_one_by_its_id():
    torchrl = needs("torchrl.envs")
    envs_ = gymnasium.make_vec(ID, 4, launch=client(*POLES, "4"), autoreset_mode="SameStep")
    for env in torchrl.GymEnv(ID, launch=client("09_environment")), torchrl.GymWrapper(envs_):
        env.rollout(5)
        env.close()


@pytest.mark.long
def test_agilerl_tells_the_dead_what_to_do():
    env = needs("agilerl.vector.pz_async_vec_env").AsyncPettingZooVecEnv([pursuit] * 2)
    env.reset(seed=1)
    for _ in range(120):
        env.step({agent: np.array([env.single_action_space(agent).sample() for _ in "ab"]) for agent in env.agents})
    env.close()


def test_what_the_dead_are_told_is_passed_over(inside, make):
    class Short(Picky):
        def on_stepped(self):
            super().on_stepped()
            self.terminated = self.age == 1 + int(self.name[-1])

    env = make(envs.UnityParallelEnv, "Masks", socket=inside(scene_of(Short, 3)).socket)
    env.reset()
    left = []
    for age in range(4):
        env.step(dict.fromkeys(env.possible_agents, 1 - age % 2))
        left.append(len(env.agents))
    assert left == [2, 1, 0, 0]


@pytest.mark.long
def test_rllib_has_many_agents_by_their_vector_entry_point():
    config = needs("torch") and needs("ray.rllib.algorithms.ppo").PPOConfig()
    ray = needs("ray")
    ray.init(num_cpus=2, include_dashboard=False)
    config = config.environment(f"netmq_example.envs:{ID}", env_config={"launch": client(*POLES, "4")})
    config = config.env_runners(
        num_env_runners=1, num_envs_per_env_runner=4, gym_env_vectorize_mode="vector_entry_point"
    )
    algorithm = config.training(train_batch_size_per_learner=256, num_epochs=1, minibatch_size=64).build_algo()
    try:
        assert algorithm.train()["env_runners"]["episode_return_mean"] > 0
    finally:
        algorithm.stop()
        ray.shutdown()
