"""python -m netmq_example.mlagents_learn: ML-Agents' trainer over this kit.

What it says and what it puts in whose place is tested with made up packages. Where ML-Agents' own are, `--long` trains
by them, in minutes: what is learnt is what they learn with a world in process, to the last bit.
"""

import importlib.util
import os
import re
import signal
import subprocess
import sys
import time
import zipfile
from importlib import metadata
from pathlib import Path

import pytest

from tests.programs import LIMIT, ROOT, Mark, finds_processes, finished

pytest.importorskip("numpy", reason="ML-Agents' API needs numpy: kit.py run 13 installs it")
pytest.importorskip("gymnasium", reason="lesson 09 needs gymnasium: kit.py run 9 installs it")

from netmq_example import mlagents_learn

HERE = Path(__file__).parent
POLES = HERE / "mlagents_poles.py"
LEARN = [sys.executable, "-m", "netmq_example.mlagents_learn"]
THERE = all(importlib.util.find_spec(name) for name in ("mlagents", "mlagents_envs", "torch"))
NEEDS = "needs ML-Agents: train_by_mlagents_learn.md says how it is installed"


def trains(test):
    """A test for which ML-Agents itself trains."""
    return pytest.mark.long(pytest.mark.timeout(900)(pytest.mark.skipif(not THERE, reason=NEEDS)(test)))


def test_each_package_that_is_missing_has_a_line(monkeypatch):
    monkeypatch.setattr(mlagents_learn, "found", lambda module: False)
    monkeypatch.setattr(mlagents_learn, "version", lambda package: ())
    # A newer Python has a line of its own.
    monkeypatch.setattr(mlagents_learn, "LAST_PYTHON", sys.version_info[:2])
    lines = mlagents_learn.missing()
    assert len(lines) == len(mlagents_learn.NEEDS)
    for line, (module, pin) in zip(lines, mlagents_learn.NEEDS.items(), strict=True):
        assert re.fullmatch(rf"{re.escape(module)} is not installed: \S+ -m pip install [^\n]+", line)
        assert pin in line and ("--no-deps --ignore-requires-python" in line) == module.startswith("mlagents")


OLD = {"protobuf": "3.20.3", "cattrs": "1.5.0", "torch": "2.4.1", "mlagents": "1.1.0"}
TOO_NEW = {"protobuf": "5.29.3", "cattrs": "24.1.2"}


@pytest.fixture
def versions(monkeypatch):
    """As if all was installed, in these versions."""
    chosen = {**OLD, "numpy": "1.26.4"}
    monkeypatch.setattr(mlagents_learn, "found", lambda module: True)
    monkeypatch.setattr(metadata, "version", chosen.__getitem__)
    monkeypatch.setattr(sys, "version_info", (3, 11, 9))
    return chosen


@pytest.mark.parametrize("package", ["protobuf", "cattrs"])
def test_a_version_that_is_too_new_has_a_line(package, versions):
    assert mlagents_learn.missing() == []
    versions[package] = TOO_NEW[package]
    (line,) = mlagents_learn.missing()
    assert line.startswith(f"{package} {TOO_NEW[package]} is too new for ML-Agents: ")
    assert re.search(rf"pip install {package}==[\d.]+$", line)


def test_a_python_that_is_too_new_has_a_line(versions, monkeypatch):
    monkeypatch.setattr(sys, "version_info", (3, 12, 1))
    (line,) = mlagents_learn.missing()
    assert line.startswith("ML-Agents 1.1.0 needs Python 3.11 or older: python3.11 -m venv")
    versions["mlagents"] = "1.2.0"
    assert mlagents_learn.missing() == []


def test_an_old_torch_has_a_line_and_goes_on(versions, caplog):
    versions["torch"] = "1.13.0a0"
    assert mlagents_learn.missing() == []
    assert "set summary_freq above max_steps, or " in caplog.text


# Packages as ML-Agents has them, with which no trainer comes.
FAKES = {
    "attr.py": "",
    "cattr.py": "",
    "cloudpickle.py": "",
    "h5py.py": "",
    "pkg_resources.py": "",
    "PIL/__init__.py": "",
    "google/protobuf/__init__.py": "",
    "tensorboard/__init__.py": "",
    "yaml.py": "class YAMLError(Exception): pass",
    "torch.py": """
class onnx:
    def export(model, path, dynamo=True):
        print("exported", model, path, dynamo)
""",
    "mlagents_envs/__init__.py": "raise ImportError('the kit stands in its place')",
    "mlagents_envs/timers.py": "raise ImportError('the kit has its own')",
    "mlagents_envs/rpc_utils.py": "from mlagents_envs.timers import timed",
    "mlagents/__init__.py": "",
    "mlagents/trainers/__init__.py": "",
    "mlagents/trainers/exception.py": """
class TrainerError(Exception): pass
class TrainerConfigError(Exception): pass
""",
    "mlagents/trainers/trainer_controller.py": "from mlagents_envs.exception import UnityCommunicatorStoppedException",
    "mlagents/trainers/settings.py": """
import yaml

def load_config(path):
    if path == "broken": raise yaml.YAMLError("mapping values\\n  in line 1")
    return {}.get(path)
""",
    "mlagents/trainers/worker.py": """
import numpy
import mlagents_envs
from mlagents_envs import logging_util, rpc_utils
from mlagents_envs.environment import UnityEnvironment
from mlagents_envs.side_channel.stats_side_channel import StatsSideChannel
import mlagents_envs.envs.unity_gym_env as gym

def told():
    kinds = UnityEnvironment, StatsSideChannel, rpc_utils.timed, logging_util.get_logger, gym.UnityToGymWrapper
    print(*(kind.__module__ for kind in kinds), rpc_utils.__name__, flush=True)
    print(mlagents_envs.__version__, numpy.float is float, hasattr(numpy, "long"), flush=True)
""",
    "mlagents/trainers/learn.py": """
import multiprocessing, sys, torch
from mlagents.trainers import exception, settings, trainer_controller, worker
from mlagents_envs.exception import UnityCommunicatorStoppedException, UnityTimeOutException

class Options(list):
    num_envs = 0 if "none" in sys.argv else 1
    env_settings = property(lambda self: self)

def parse_command_line():
    if "many" in sys.argv: raise ValueError("no number: 'many'")
    if sys.argv[1] in ("broken", "empty"): settings.load_config(sys.argv[1])
    return Options(sys.argv[1:])

def run_cli(options):
    print(options)
    if "bad" in sys.argv: raise exception.TrainerConfigError("no such trainer")
    if "lost" in sys.argv:
        try:
            raise UnityCommunicatorStoppedException("the simulator is lost")
        except UnityCommunicatorStoppedException as error:
            if not isinstance(error, trainer_controller.UnityCommunicatorStoppedException): raise
    if "late" in sys.argv: raise UnityTimeOutException("no simulator came")
    torch.onnx.export("a model", path="a.onnx")
    worker.told()
    process = multiprocessing.get_context("spawn").Process(target=worker.told)
    process.start()
    process.join()
""",
}


@pytest.fixture
def fakes(tmp_path):
    """fakes("word") runs the program with these packages."""
    for name, text in FAKES.items():
        (tmp_path / name).parent.mkdir(parents=True, exist_ok=True)
        (tmp_path / name).write_text(text, encoding="utf-8")
    for name, version in OLD.items():
        info = tmp_path / f"{name}-{version}.dist-info"
        info.mkdir()
        (info / "METADATA").write_text(f"Metadata-Version: 2.1\nName: {name}\nVersion: {version}\n", encoding="utf-8")

    def run(*words):
        path = os.pathsep.join([str(tmp_path), str(ROOT / "python")])
        return finished([*LEARN, *words], env={**os.environ, "PYTHONPATH": path}, cwd=tmp_path)

    return run


@pytest.mark.skipif(sys.version_info >= (3, 12), reason="ML-Agents needs Python 3.11 or older")
def test_the_kit_stands_in_the_place_of_mlagents_envs_also_in_a_worker_that_is_spawned(fakes):
    done = fakes("config.yaml", "--env=Game")
    assert done.returncode == 0, done.stdout + done.stderr
    own = "environment", "side_channel.stats_side_channel", "timers", "logging_util", "envs.unity_gym_env"
    places = [f"netmq_example.mlagents_envs.{name}" for name in own]
    told = [" ".join([*places, "mlagents_envs.rpc_utils"]), "1.1.0 True True"]
    exported = "exported a model a.onnx False"
    assert done.stdout.splitlines() == ["['config.yaml', '--env=Game']", exported, *told, *told]


@pytest.mark.skipif(sys.version_info >= (3, 12), reason="ML-Agents needs Python 3.11 or older")
@pytest.mark.parametrize(
    ("word", "says"),
    [
        ("bad", "no such trainer"),
        ("many", "no number: 'many': look at the file and the options"),
        ("none", "with no simulator nobody plays: write --num-envs=1, or leave it out"),
        ("late", "no simulator came"),
        ("lost", "the simulator is lost"),
        ("empty", "empty has no settings: write behaviors:, and below it those of each behavior"),
        ("broken", "broken is no YAML: mapping values in line 1"),
    ],
)
def test_an_error_of_the_trainers_is_one_line(fakes, word, says):
    done = fakes(word)
    assert done.returncode == 1 and done.stderr.splitlines()[-1] == f"mlagents-learn ended: {says}"
    assert "Traceback" not in done.stderr


def test_a_place_that_is_taken_already_is_an_error():
    script = "import sys, mlagents_envs; from netmq_example.mlagents_learn import take_place; take_place()"
    words = [sys.executable, "-c", f"import sys; sys.modules['mlagents_envs'] = sys; {script}"]
    assert "take_place comes before the first import of mlagents_envs" in finished(words, cwd=ROOT / "python").stderr


# From here on ML-Agents itself trains.
CONFIG = """
behaviors:
  {behavior}:
    trainer_type: {trainer}
    hyperparameters: {{{more}}}
    network_settings: {{hidden_units: 64, num_layers: 2}}
    time_horizon: 64
    max_steps: {steps}
    summary_freq: {each}
"""
PPO = "batch_size: 128, buffer_size: 1024, learning_rate: 0.003"
SAC = "batch_size: 64, buffer_size: 5000, buffer_init_steps: 500, steps_per_update: 10.0"
SUMMARY = re.compile(r"Step: (\d+)\. Time Elapsed: \S+ s\. Mean Reward: (\S+)\. ")
# torch 1.13 fails at histograms with numpy 1.24, unless a machine has mended that.
SPAWN = """
import multiprocessing, runpy
if __name__ == "__main__":
    multiprocessing.set_start_method("spawn")
    runpy.run_module("netmq_example.mlagents_learn", run_name="__main__", alter_sys=True)
"""


class Trainings:
    def __init__(self, folder):
        self.folder = folder
        # Also for the scenes, which are processes of their own.
        self.environment = {**os.environ, "PYTHONPATH": os.pathsep.join([str(ROOT / "python"), str(ROOT)])}

    def config(self, behavior="Pole", trainer="ppo", more=PPO, steps=3000, each=1000, add=""):
        text = CONFIG.format(behavior=behavior, trainer=trainer, more=more, steps=steps, each=each) + add
        (self.folder / "config.yaml").write_text(text, encoding="utf-8")

    def words(self, *words, program=LEARN):
        return [*map(str, program), "config.yaml", "--seed=1", *map(str, words)]

    def run(self, *words, program=LEARN):
        done = finished(self.words(*words, program=program), timeout=600, env=self.environment, cwd=self.folder)
        assert done.returncode == 0, done.stdout + done.stderr
        return done.stdout + done.stderr

    def start(self, *words):
        return subprocess.Popen(
            self.words(*words), stdout=subprocess.PIPE, text=True, env=self.environment, cwd=self.folder
        )

    def model(self, run, behavior="Pole"):
        """The opset that Unity has to read."""
        onnx = pytest.importorskip("onnx", reason="needs onnx: pip install onnx")
        folder = self.folder / "results" / run
        model = onnx.load(folder / f"{behavior}.onnx")
        onnx.checker.check_model(model)
        assert [*folder.glob("*.data")] == []
        assert [*(folder / behavior).glob("events.out.tfevents*")]
        (opset,) = model.opset_import
        return opset.version


@pytest.fixture
def training(tmp_path):
    return Trainings(tmp_path)


def weights(folder):
    with zipfile.ZipFile(folder / "checkpoint.pt") as file:
        return {name.partition("/")[2]: file.read(name) for name in file.namelist()}


SEERS = """
import numpy as np
from gymnasium.spaces import Box, Dict
from netmq_example.scene import Agent, Scene, run

class Seer(Agent):
    observation = Dict({"eye": Box(0, 255, (36, 40, 3), np.uint8), "place": Box(-9, 9, (2,), np.float32)})
    action = Box(-1, 1, (2,), np.float32)

    def on_reset(self):
        self.place, self.steps = np.zeros(2, np.float32), 0

    def on_action(self, action):
        self.place = np.clip(self.place + action, -9, 9).astype(np.float32)
        self.steps += 1

    def on_stepped(self):
        self.reward -= float(abs(self.place).sum())
        self.truncated = self.steps == 20

    def observe(self):
        return {"eye": np.full((36, 40, 3), 100, np.uint8), "place": self.place}

run(Scene("Seers", [Seer("seer") for _ in range(2)], dt=0.02))
"""
PARAMETERS = """
import sys
import numpy as np
from gymnasium.spaces import Box
from netmq_example.mlagents_envs.side_channel.side_channel_manager import SideChannelManager
from netmq_example.mlagents_envs.unity_channels import EnvironmentParameters
from netmq_example.scene import Agent, EnvironmentClient, Scene, SceneSimulator, SideChannelSimulator

parameters = EnvironmentParameters()

class Pupil(Agent):
    observation, action = Box(-1, 1, (1,), np.float32), Box(-1, 1, (1,), np.float32)

    def on_reset(self):
        self.steps, self.earns = 0, parameters.get_with_default("earns", 0)
        self.drawn = parameters.get_with_default("drawn", -1)

    def on_stepped(self):
        assert 5 <= self.drawn <= 6
        self.steps += 1
        self.reward += self.earns
        self.truncated = self.steps == 10

    def observe(self):
        return [0.5]

scene = Scene("School", [Pupil("pupil")], dt=0.02)
simulator = SideChannelSimulator(SceneSimulator(scene), SideChannelManager([parameters]))
EnvironmentClient(sys.argv[sys.argv.index("--endpoint") + 1], timeout=60).run(simulator)
"""
CURRICULUM = """
environment_parameters:
  earns:
    curriculum:
      - name: first
        completion_criteria: {measure: progress, behavior: School, min_lesson_length: 1, threshold: 0.4}
        value: 2.0
      - name: second
        value: 4.0
  drawn:
    sampler_type: uniform
    sampler_parameters: {min_value: 5.0, max_value: 6.0}
"""


@trains
def test_what_is_learnt_is_what_ml_agents_learns_in_process(training):
    training.config(steps=12_000, each=4000)
    here = training.run(f"--env={POLES}", "--run-id=here")
    there = training.run("--run-id=there", program=[sys.executable, HERE / "mlagents_in_process.py"])
    assert SUMMARY.findall(here) == SUMMARY.findall(there)
    means = [float(mean) for _, mean in SUMMARY.findall(here)]
    assert len(means) == 3 and means[2] > 3 * means[0], means
    results = training.folder / "results"
    assert weights(results / "here" / "Pole") == weights(results / "there" / "Pole")
    assert 7 <= training.model("here") <= 15


@trains
@pytest.mark.parametrize(("trainer", "more"), [("sac", SAC), ("poca", PPO)])
def test_trainers_write_a_model_that_unity_reads(training, trainer, more):
    training.config(trainer=trainer, more=more)
    printed = training.run(f"--env={POLES}", "--run-id=a")
    assert len(SUMMARY.findall(printed)) == 3
    assert 7 <= training.model("a") <= 15


@trains
def test_several_simulators_in_workers_that_are_spawned_then_on_and_anew(training):
    training.config(steps=2000)
    (training.folder / "spawn.py").write_text(SPAWN, encoding="utf-8")
    words = ["--run-id=a", "--num-envs=2", "--no-graphics"]
    assert SUMMARY.findall(training.run(f"--env={POLES}", *words, program=[sys.executable, "spawn.py"]))
    training.config(steps=4000)
    printed = training.run(f"--env={POLES}", "--run-id=a", "--resume")
    assert re.search(r"Resuming training from step 20\d\d", printed)
    printed = training.run(f"--env={POLES}", "--run-id=b", "--initialize-from=a")
    assert "Initializing from results/a/Pole/checkpoint.pt" in printed and "from step 0" in printed


@trains
def test_a_model_plays_and_learns_no_more(training):
    training.config(steps=2000)
    training.run(f"--env={POLES}", "--run-id=a")
    learnt = weights(training.folder / "results" / "a" / "Pole")
    process = training.start(f"--env={POLES}", "--run-id=a", "--resume", "--inference")
    for line in process.stdout:
        if "Not Training" in line:
            break
    process.send_signal(signal.SIGINT)
    assert process.wait(LIMIT) == 0
    assert weights(training.folder / "results" / "a" / "Pole") == learnt


@trains
def test_a_simulator_that_is_lost_for_good_is_an_error(training):
    training.config(add="env_settings: {max_lifetime_restarts: 0}\n")
    (training.folder / "scene.py").write_text(LOST, encoding="utf-8")
    lost = finished(training.words("--env=scene.py", "--run-id=a"), env=training.environment, cwd=training.folder)
    assert lost.returncode == 1 and "Traceback" not in lost.stderr
    assert "mlagents-learn ended: the simulator is lost" in lost.stderr


@trains
@finds_processes
def test_a_simulator_that_is_killed_is_started_again(training):
    training.config(steps=8000)
    mark = Mark()
    training.environment |= mark.environment
    process = training.start(f"--env={POLES}", "--run-id=a")
    for line in process.stdout:
        if SUMMARY.search(line):
            break
    (simulator,) = (number for number, words in mark.processes().items() if "--endpoint tcp:" in words)
    os.kill(simulator, signal.SIGKILL)
    rest = process.stdout.read()
    assert process.wait(LIMIT) == 0
    assert "Restarting worker[0] after 'the simulator is lost" in rest and "Exported results/a/Pole" in rest


@trains
def test_play(training):
    """Without --env; the port is ML-Agents' own."""
    training.config(steps=1000)
    process = training.start("--run-id=a")
    words = [sys.executable, POLES, "--endpoint", "tcp://127.0.0.1:5004"]
    time.sleep(1)
    scene = subprocess.Popen(words, env=training.environment, stdin=subprocess.DEVNULL)
    printed = process.communicate(timeout=300)[0]
    assert process.returncode == 0 and SUMMARY.findall(printed), printed
    assert scene.wait(LIMIT) == 0


@trains
def test_pictures(training):
    (training.folder / "scene.py").write_text(SEERS, encoding="utf-8")
    training.config("Seers", steps=600, each=200)
    assert len(SUMMARY.findall(training.run("--env=scene.py", "--run-id=a"))) == 3
    assert training.model("a", "Seers") == 9


@trains
def test_a_curriculum_and_a_sampler_reach_the_scene(training):
    """Each step earns what the lesson is about."""
    (training.folder / "scene.py").write_text(PARAMETERS, encoding="utf-8")
    training.config("School", steps=6000, each=1000, add=CURRICULUM)
    means = [float(mean) for _, mean in SUMMARY.findall(training.run("--env=scene.py", "--run-id=a"))]
    assert means[0] == 20 and means[-1] == 40


@trains
@pytest.mark.skipif(sys.platform == "win32", reason="a script of a shell")
def test_a_script_that_starts_lesson_09_in_csharp(training, console):
    script = training.folder / "game.sh"
    script.write_text(f'#!/bin/sh\nexec {" ".join(console)} 09 "$@"\n', encoding="utf-8")
    script.chmod(0o755)
    training.config("CartPole", steps=1000, each=500)
    assert SUMMARY.findall(training.run("--env=./game.sh", "--run-id=a"))


# A scene by its own clock, whose walkers are a line of this test, and so is what a tick does.
SCENE = """
import os, sys
from netmq_example.scene import EnvironmentClient
from tests.lessons.scene_clock import Arena, ArenaSimulator, Walker

class World(Arena):
    def tick(self):
        steered = {{one: one.action[0][0] for one in self.walkers}}
        super().tick()
{tick}

arena = World({walkers})
EnvironmentClient(sys.argv[sys.argv.index("--endpoint") + 1], timeout=60).run(ArenaSimulator(arena))
"""
# Two steer; whoever is higher in the tenth step has won.
DUEL = SCENE.format(
    walkers='*(Walker("Duel", team=team, length=10) for team in (0, 1))',
    tick="""        for one in self.walkers:
            one.earned = 0.0
        for row in self.ended:
            row.earned = 1.0 if steered[row.walker] > min(steered.values()) else -1.0""",
)
SELF_PLAY = """
    self_play: {save_steps: 500, team_change: 1000, swap_steps: 300, window: 5, initial_elo: 1200.0}
"""
# A group of three earns what they steer together.
GROUP = SCENE.format(
    walkers='*(Walker("Team", length=10, group=1) for _ in range(3))',
    tick="""        for one in self.walkers:
            one.earned, one.group_reward = 0.0, sum(steered.values())
        for row in self.ended:
            row.earned = 0.0""",
)
# It ends in the middle of its training.
LOST = SCENE.format(walkers='Walker("Pole")', tick="        if self.ticks == 50:\n            os._exit(1)")


@trains
def test_two_teams_play_against_each_other(training):
    (training.folder / "scene.py").write_text(DUEL, encoding="utf-8")
    training.config("Duel", steps=4000, more="batch_size: 64, buffer_size: 512", add=SELF_PLAY)
    ratings = re.findall(r"ELO: (\S+)\.$", training.run("--env=scene.py", "--run-id=a"), re.MULTILINE)
    assert len(ratings) == 4 and len({*ratings}) > 1


@trains
def test_a_group_learns_together(training):
    (training.folder / "scene.py").write_text(GROUP, encoding="utf-8")
    training.config("Team", "poca", steps=6000, each=2000, more="batch_size: 64, buffer_size: 512")
    printed = training.run("--env=scene.py", "--run-id=a")
    first, *_, last = map(float, re.findall(r"Mean Group Reward: (\S+)\. ", printed))
    assert last > first + 5


# As ML-Agents' recorder writes it: fifty steps, in which the pole is pushed to where it falls.
DEMONSTRATION = """
from netmq_example.mlagents_learn import take_place

take_place()
from mlagents.trainers.demo_loader import write_demo
from mlagents_envs.communicator_objects.agent_info_action_pair_pb2 import AgentInfoActionPairProto
from mlagents_envs.communicator_objects.brain_parameters_pb2 import BrainParametersProto
from mlagents_envs.communicator_objects.demonstration_meta_pb2 import DemonstrationMetaProto

brain = BrainParametersProto(brain_name="Pole", is_training=True)
brain.action_spec.num_discrete_actions = 1
brain.action_spec.discrete_branch_sizes.append(2)
pairs = []
for step in range(50):
    pair = AgentInfoActionPairProto()
    seen = pair.agent_info.observations.add(shape=[4], dimension_properties=[1])
    angle = (step % 5 - 2) / 20
    seen.float_data.data.extend([0.0, 0.0, angle, 0.0])
    pair.agent_info.reward = 1.0
    pair.agent_info.done = step % 10 == 9
    pair.action_info.discrete_actions.append(angle > 0)
    pairs.append(pair)
meta = DemonstrationMetaProto(api_version=1, number_steps=50, number_episodes=5, mean_reward=10, demonstration_name="a")
write_demo("pole.demo", meta, brain, pairs)
"""
IMITATION = """
    reward_signals:
      extrinsic: {gamma: 0.99, strength: 1.0}
      gail: {strength: 0.1, demo_path: pole.demo}
      curiosity: {strength: 0.01}
      rnd: {strength: 0.01}
    behavioral_cloning: {demo_path: pole.demo, strength: 0.5}
"""


@trains
def test_demonstrations_are_read(training):
    """By ML-Agents' own protobuf, which the kit leaves in its place."""
    (training.folder / "demonstration.py").write_text(DEMONSTRATION, encoding="utf-8")
    done = finished([sys.executable, "demonstration.py"], env=training.environment, cwd=training.folder)
    assert done.returncode == 0, done.stderr
    training.config(add=IMITATION)
    assert len(SUMMARY.findall(training.run(f"--env={POLES}", "--run-id=a"))) == 3


DRONE = """
using NetMQExample.MLAgents;
using NetMQExample.MLAgents.Actuators;
using NetMQExample.MLAgents.Sensors;
using UnityEngine;

public class Drone : Agent
{
    private float height, speed, wind;

    public override void OnEpisodeBegin()
    {
        height = Random.Range(-2f, 2f);
        wind = Random.Range(-0.5f, 0.5f);
        speed = 0;
    }

    public override void CollectObservations(VectorSensor sensor)
    {
        sensor.AddObservation(height);
        sensor.AddObservation(speed);
        sensor.AddObservation(wind);
    }

    public override void OnActionReceived(ActionBuffers actions)
    {
        speed += (8 * Mathf.Clamp(actions.ContinuousActions[0], -1f, 1f) + 2 * wind) * 0.02f;
        height += speed * 0.02f;
        AddReward(1 - Mathf.Min(1f, Mathf.Abs(height)));
        if (Mathf.Abs(height) > 5) EndEpisode();
    }
}
"""
DRONES = """
using NetMQExample.MLAgents;
using NetMQExample.MLAgents.Actuators;
using NetMQExample.MLAgents.Policies;
using UnityEngine;

public sealed class Drones : MonoBehaviour
{
    private void Awake()
    {
        for (var i = 0; i < 8; i++)
        {
            var drone = new GameObject($"drone {i}");
            drone.SetActive(false);
            var parameters = drone.AddComponent<BehaviorParameters>();
            parameters.BehaviorName = "Drone";
            parameters.BrainParameters.VectorObservationSize = 3;
            parameters.BrainParameters.ActionSpec = ActionSpec.MakeContinuous(1);
            drone.AddComponent<Drone>().MaxStep = 200;
            drone.AddComponent<DecisionRequester>().DecisionPeriod = 1;
            drone.SetActive(true);
        }
    }
}
"""


@trains
@pytest.mark.skipif(sys.platform == "win32", reason="a script of a shell")
def test_agents_of_ml_agents_shape_in_csharp_learn(training, netmq):
    folder = training.folder
    (folder / "Drone.cs").write_text(DRONE, encoding="utf-8")
    (folder / "Drones.cs").write_text(DRONES, encoding="utf-8")
    play = f'"{sys.executable}" "{ROOT / "kit.py"}" play "{folder}/Drones.cs" "{folder}/Drone.cs" "$@"'
    (folder / "game.sh").write_text(f"#!/bin/sh\nexec {play}\n", encoding="utf-8")
    (folder / "game.sh").chmod(0o755)
    training.config("Drone", steps=24_000, each=8000)
    printed = training.run("--env=./game.sh", "--run-id=a", "--timeout-wait=180")
    means = [float(mean) for _, mean in SUMMARY.findall(printed)]
    assert len(means) == 3 and means[2] > 2 * means[0], means
