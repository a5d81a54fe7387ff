"""A package that is missing is named with its cure."""

import importlib
import re
import sys

import pytest

from netmq_example.extras import importing, without
from tests.programs import EACH_RUN, ROOT, InTurn, finished


def needed(module):
    try:
        importlib.import_module(module)
    except ImportError as error:
        raise without(error) from None


def test_a_package_that_is_there_and_broken_is_not_to_be_installed(tmp_path, monkeypatch):
    monkeypatch.syspath_prepend(tmp_path)
    (tmp_path / "brokenpackage.py").write_text("raise ImportError('another ABI: see its page')")
    with pytest.raises(ImportError, match=r"^another ABI: see its page$"):
        needed("brokenpackage")
    with pytest.raises(ImportError, match=r"pip install nosuchpackage$"):
        needed("nosuchpackage.part")
    with pytest.raises(SystemExit, match=r"^another ABI: see its page: this lesson needs it$"), importing("it"):
        needed("brokenpackage")


# As if all that a program needs besides pyzmq were not installed.
ABSENT = """
import sys
for name in ("numpy", "gymnasium", "pettingzoo", "PIL", "aiohttp", "socketio", "ray", "av", "mediapipe", "cv2"):
    sys.modules[name] = None
"""
PROGRAMS = sorted(ROOT.glob("python/[0-9]*/*.py"))


def test_a_program_without_what_it_needs_says_what_is_missing():
    with InTurn([sys.executable, "-c", ABSENT + EACH_RUN]) as run:
        for path in PROGRAMS:
            if "__main__" in (text := path.read_text(encoding="utf-8")):
                code, lines = run(path, "--help")
                said = len(lines) == 1 and bool(re.fullmatch(r"[^:]+: this lesson needs .+", lines[0]))
                assert said == (code == 1) == ("importing(" in text), (path, code, lines)


LIKE_ML_AGENTS = ["base_env", "environment", "envs.unity_gym_env", "envs.unity_parallel_env", "envs.unity_aec_env"]


def test_a_class_of_ml_agents_without_numpy_says_how_to_install_it():
    program = f"{ABSENT}\nimport importlib\nimportlib.import_module('netmq_example.mlagents_envs.' + sys.argv[1])"
    for module in LIKE_ML_AGENTS:
        words = [sys.executable, "-c", program, module]
        done = finished(words, cwd=ROOT / "python")
        assert done.returncode == 1 and re.search(r"numpy.*: \S+ -m pip install numpy$", done.stderr.strip()), module
