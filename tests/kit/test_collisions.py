"""No program takes a `tree` or `messages` of somebody else's for the kit's, nor an older copy of the package."""

import json
import os

from tests.conftest import PYTHON
from tests.programs import ROOT, finished

# RLlib brings dm_tree, which is `tree`; scikit-hep has `vector`, and many a project its own environment.py. The last is
# what an earlier `pip install .` has left.
NAMES = """
    tree vector messages environment connection game infos spaces fit merge program keys check errors camera jobs
    journal people simulation simulator agents areas trainers workers netmq_example
"""
# Every program with --help, as if it were started by itself, and then every module, if there is one root; printed is
# what came of each.
EACH = """
import contextlib, importlib, io, json, pathlib, runpy, sys

def came_of(act):
    said = io.TextIOWrapper(io.BytesIO(), encoding="utf-8")
    try:
        with contextlib.redirect_stdout(said), contextlib.redirect_stderr(said):
            act()
    except SystemExit as end:
        return str(end.code or "fine")
    except BaseException as error:
        return repr(error)
    return "fine"

roots, outcomes = [pathlib.Path(word) for word in sys.argv[1:]], {}
# With PYTHONSAFEPATH Python does not look for modules beside a program.
safe = sys.flags.safe_path
others = sys.path[:] if safe else sys.path[1:]
for program in sorted(path for root in roots for path in root.glob("[0-9]*/*.py")):
    if "__main__" in (text := program.read_text(encoding="utf-8")):
        sys.path[:] = others if safe else [str(program.parent), *others]
        sys.argv[:] = [str(program), "--help"]
        # One without options would do its work: it is imported.
        name = "__main__" if "parse_args" in text else "program_of_a_lesson"
        outcomes[str(program)] = came_of(lambda: runpy.run_path(str(program), run_name=name))
        # The next one looks for the package itself, and what lies beside it may have the same name.
        for name in list(sys.modules):
            if name.split(".")[0] == "netmq_example" or (program.parent / f"{name}.py").exists():
                del sys.modules[name]
if len(roots) == 1:
    sys.path[:] = [str(roots[0]), *others]
    for module in sorted(roots[0].glob("netmq_example/**/*.py")):
        name = ".".join(module.relative_to(roots[0]).with_suffix("").parts)
        outcomes[name] = came_of(lambda: importlib.import_module(name))
print(json.dumps(outcomes))
"""


def outcomes(folder, *roots, **environment):
    """The end of each program and module of these roots, started in this folder."""
    (folder / "each.py").write_text(EACH, encoding="utf-8")
    done = finished([PYTHON, "each.py", *(roots or [ROOT / "python"])], cwd=folder, env={**os.environ, **environment})
    assert done.returncode == 0, done.stderr
    return json.loads(done.stdout)


def test_nobody_elses_module_is_taken_for_one_of_the_kit(tmp_path):
    """Modules that come before the kit's own on the path, and packages behind it."""
    before, behind = tmp_path / "before", tmp_path / "behind"
    for folder, form in (before, "{}.py"), (behind, "{}/__init__.py"):
        for name in NAMES.split():
            stub = folder / form.format(name)
            stub.parent.mkdir(parents=True, exist_ok=True)
            stub.write_text(f"raise RuntimeError('{name} of {folder.name} was imported')", encoding="utf-8")
    path = f"import sys\nsys.path.insert(0, {str(before)!r})\nsys.path.append({str(behind)!r})\n"
    (before / "sitecustomize.py").write_text(path, encoding="utf-8")
    found = outcomes(tmp_path, PYTHONPATH=str(before))
    assert found[str(ROOT / "python" / "01_request_reply" / "server.py")] == "fine"
    # Where a package is missing, some say so, with the stubs and without.
    assert found == outcomes(tmp_path, PYTHONSAFEPATH="1")
