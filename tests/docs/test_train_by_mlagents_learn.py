"""docs/guide/train_by_mlagents_learn.md as a reader types it, where ML-Agents' packages are."""

import importlib.util
import os
import re
import sys

import pytest

from tests.programs import ROOT, finished

PAGE = (ROOT / "docs" / "guide" / "train_by_mlagents_learn.md").read_text(encoding="utf-8")
SCENE, PLACE = re.findall(r"```python\n(.*?)```", PAGE, re.DOTALL)
(CONFIG,) = re.findall(r"```yaml\n(.*?)```", PAGE, re.DOTALL)
COMMAND, *INSTALLS = re.findall(r"^python -m (.+)$", PAGE, re.MULTILINE)
PRINTED = re.findall(r"Step: (\d+)\. .*Mean Reward: (\S+)\. ", PAGE)
THERE = all(importlib.util.find_spec(name) for name in ("mlagents", "mlagents_envs", "torch", "gymnasium"))
needs_ml_agents = pytest.mark.skipif(not THERE, reason="needs ML-Agents, as the page says")


def run(folder, *words):
    environment = {**os.environ, "PYTHONPATH": str(ROOT / "python")}
    done = finished([sys.executable, *words], timeout=600, cwd=folder, env=environment)
    assert done.returncode == 0, done.stdout + done.stderr
    return done.stdout


def test_it_installs_what_the_program_asks_for():
    from netmq_example import mlagents_learn

    words = " ".join(INSTALLS).replace('"', "").split()
    assert {*mlagents_learn.NEEDS.values()} <= {*words}


@needs_ml_agents
def test_two_lines_put_the_kit_into_the_place_of_mlagents_envs(tmp_path):
    more = "import mlagents.trainers.learn, mlagents_envs.environment as found\nprint(found.__name__)\n"
    (tmp_path / "own.py").write_text(PLACE + more, encoding="utf-8")
    assert run(tmp_path, "own.py") == "netmq_example.mlagents_envs.environment\n"


@needs_ml_agents
@pytest.mark.long
def test_a_drone_learns_to_hover(tmp_path):
    (tmp_path / "hover.py").write_text(SCENE, encoding="utf-8")
    (tmp_path / "hover.yaml").write_text(CONFIG, encoding="utf-8")
    printed = re.findall(r"Step: (\d+)\. .*Mean Reward: (\S+)\. ", run(tmp_path, "-m", *COMMAND.split(), "--seed=1"))
    means = [float(mean) for _, mean in printed]
    assert [step for step, _ in printed][-1] == PRINTED[-1][0]
    assert means[-1] > 130 > 2 * means[0], means
    assert (tmp_path / "results" / "first" / "Hover.onnx").exists()
