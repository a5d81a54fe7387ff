"""No program takes a `tree` or `messages` of somebody else's for the kit's, nor an older copy of the package."""

import os

from tests.conftest import PYTHON
from tests.programs import ROOT, finished

# RLlib brings dm_tree, which is `tree`; scikit-hep has `vector`, and many a project its own environment.py. The last is
# what an earlier `pip install .` has left.
NAMES = """
    tree vector messages environment connection game infos spaces fit merge program keys check errors camera jobs
    journal people simulation simulator agents areas trainers workers netmq_example
"""


def test_nobody_elses_module_is_taken_for_one_of_the_kit(tmp_path):
    for name in NAMES.split():
        (tmp_path / f"{name}.py").write_text(f"raise RuntimeError('{name} of others was imported')", encoding="utf-8")
    environment = {**os.environ, "PYTHONPATH": str(tmp_path)}
    for program in sorted((ROOT / "python").glob("[0-9]*/server.py")):
        said = finished([PYTHON, program, "--help"], env=environment).stderr
        # Where a package is missing, some say so.
        assert "of others was imported" not in said, said
