"""docs/guide/train_by_mlagents_learn.md as a reader types it, where ML-Agents' packages are."""

import importlib.util
import os
import re
import sys

import pytest

from tests.programs import ROOT, finished

PAGE = (ROOT / "docs" / "guide" / "train_by_mlagents_learn.md").read_text(encoding="utf-8")
SCENE, PLACE = re.findall(r"```python\n(.*?)```", PAGE, re.DOTALL)
CONFIG, SAC = re.findall(r"```yaml\n(.*?)```", PAGE, re.DOTALL)
COMMAND, *INSTALLS = re.findall(r"^python -m (.+)$", PAGE, re.MULTILINE)
LINE = re.compile(r"Step: (\d+)\. .*Mean Reward: (\S+)\. ")
THERE = all(importlib.util.find_spec(name) for name in ("mlagents", "mlagents_envs", "torch", "gymnasium"))
needs_ml_agents = pytest.mark.skipif(not THERE, reason="needs ML-Agents, as the page says")


def run(folder, *words):
    environment = {**os.environ, "PYTHONPATH": str(ROOT / "python")}
    done = finished([sys.executable, *words], timeout=1800, cwd=folder, env=environment)
    assert done.returncode == 0, done.stdout + done.stderr
    return done.stdout


def test_it_installs_what_the_program_asks_for():
    from netmq_example import mlagents_learn

    words = " ".join(INSTALLS).replace('"', "").split()
    assert {*" ".join(mlagents_learn.NEEDS.values()).split()} <= {*words}


@needs_ml_agents
def test_two_lines_put_the_kit_into_the_place_of_mlagents_envs(tmp_path):
    more = "import mlagents.trainers.learn, mlagents_envs.environment as found\nprint(found.__name__)\n"
    (tmp_path / "own.py").write_text(PLACE + more, encoding="utf-8")
    assert run(tmp_path, "own.py") == "netmq_example.mlagents_envs.environment\n"


@needs_ml_agents
@pytest.mark.long
@pytest.mark.parametrize("instead", ["", SAC], ids=["ppo", "sac"])
def test_a_drone_learns_to_hover(instead, tmp_path):
    yaml = pytest.importorskip("yaml")

    config = yaml.safe_load(CONFIG)
    config["behaviors"]["Hover"] |= yaml.safe_load(instead) or {}
    (tmp_path / "hover.py").write_text(SCENE, encoding="utf-8")
    (tmp_path / "hover.yaml").write_text(yaml.safe_dump(config), encoding="utf-8")
    printed = LINE.findall(run(tmp_path, "-m", *COMMAND.split(), "--seed=1"))
    means = [float(mean) for _, mean in printed]
    # As the page has it behind its YAML.
    promised = LINE.findall(PAGE.partition(instead or CONFIG)[2].partition("\n\n")[2].partition("```\n\n")[0])
    assert [step for step, _ in printed] == [step for step, _ in promised]
    assert means[-1] > 130 > 2 * means[0], means
    assert (tmp_path / "results" / "first" / "Hover.onnx").exists()
