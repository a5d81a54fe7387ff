"""docs/guide/reinforcement_learning.md as a reader types it, with fewer steps, where its libraries are installed."""

import importlib.util
import os
import re
import shutil
import sys

import pytest

from tests.programs import ROOT, elsewhere, finished

PAGE = (ROOT / "docs" / "guide" / "reinforcement_learning.md").read_text(encoding="utf-8")
PYTHON = re.findall(r"```python\n(.*?)```", PAGE, re.DOTALL)
CSHARP = re.findall(r"```csharp\n(.*?)```", PAGE, re.DOTALL)
# Enough for one update of each.
FEWER = {
    "4096": "512",
    "20_480": "2048",
    "2048)": "256)",
    "range(5)": "range(1)",
    "UPDATES = 16, 128, 80": "UPDATES = 16, 32, 16",
}
POLE, FILM, SCENE, DRONES, IN_THE_PLAYER, PLAIN, LOOP = PYTHON
# An environment of lesson 11, which the page's program gets.
COINS = """
import sys

sys.path.append("python/11_observations")
import gymnasium
import netmq_example.envs
from collector import ACTION, seen_space

spaces = {"observation_space": seen_space(False), "action_space": ACTION}
launch = [sys.executable, "python/11_observations/client.py"]
env = gymnasium.make("NetMQExample/Unity-v0", env_name="Coins", max_episode_steps=200, launch=launch, **spaces)
"""


def run(program, folder):
    script = elsewhere(program)
    for many, few in FEWER.items():
        script = script.replace(many, few)
    script = script.replace('"MlpPolicy", env, seed=1', '"MlpPolicy", env, n_steps=512, seed=1')
    file = folder / "program.py"
    file.write_text(script, encoding="utf-8")
    environment = {**os.environ, "PYTHONPATH": str(ROOT / "python")}
    done = finished([sys.executable, file], timeout=300, cwd=folder, env=environment)
    assert done.returncode == 0, done.stdout + done.stderr
    return done.stdout


@pytest.fixture
def folder(tmp_path):
    """A reader's, with the scripts of the page, and its scene."""
    (tmp_path / "hover_scene.py").write_text(SCENE, encoding="utf-8")
    for code in CSHARP:
        name = re.search(r"class (\w+)", code)
        assert name
        (tmp_path / f"{name[1]}.cs").write_text(code, encoding="utf-8")
    return tmp_path


def needs(*modules):
    lacking = [name for name in modules if not importlib.util.find_spec(name)]
    return pytest.mark.skipif(bool(lacking), reason=f"needs a package: pip install {' '.join(lacking)}")


@needs("stable_baselines3", "torch")
def test_a_pole_is_learnt_and_filmed(folder):
    assert re.search(r"^512 steps: \d+ of 500$", run(POLE, folder), re.MULTILINE)
    if importlib.util.find_spec("moviepy"):
        run(FILM, folder)
        assert [*(folder / "films").glob("*.mp4")]


@needs("stable_baselines3", "torch")
def test_a_scene_of_ones_own_is_learnt_the_same_in_both_languages(folder):
    (line,) = re.findall("^LAUNCH = .*$", DRONES, re.MULTILINE)
    programs = [DRONES, DRONES.replace(line, IN_THE_PLAYER)][: 2 if shutil.which("dotnet") else 1]
    learnt = [re.findall(r"^2048 steps: \d+ of 500$", run(each, folder), re.MULTILINE) for each in programs]
    assert len(learnt[0]) == 1 and all(each == learnt[0] for each in learnt)


@needs("stable_baselines3", "torch")
def test_attributes_are_learnt(folder):
    run(f"{COINS}{PLAIN}env.close()\n", folder)


@needs("torch", "gymnasium")
def test_the_loop_learns(folder):
    assert re.search(r"^8192 steps: \d+ of 500$", run(LOOP, folder), re.MULTILINE)
