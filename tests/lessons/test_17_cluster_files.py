"""Lesson 17's files for Slurm and Kubernetes: the job script runs, with an srun that starts its tasks here; and kubectl
reads the manifest as Kubernetes' own types.
"""

import os
import subprocess
import time

import pytest

from tests.conftest import PYTHON
from tests.programs import LIMIT, ROOT, Mark, finds_processes, finished, steady_port

FILES = ROOT / "docs" / "guide" / "17_files"
SCRIPT, MANIFEST = FILES / "slurm.sh", FILES / "kubernetes.yaml"
posix = pytest.mark.skipif(os.name == "nt", reason="Slurm's machines are not Windows")
pytest.importorskip("gymnasium", reason="lesson 17 needs gymnasium: kit.py run 17 installs it")

# As Slurm's: so many tasks of the command, whose processes all end with it.
SRUN = """#!/bin/bash
set -m
trap 'for task in $(jobs -p); do kill -- -$task; done; exit 143' TERM
tasks=${1#--ntasks=}; shift
for _ in $(seq "$tasks"); do "$@" & done
wait
"""
# One simulator dies, in the middle of its first episode.
MORTAL = """#!/bin/bash
if [[ $1 == */client.py ]] && mkdir "$0.died" 2> /dev/null; then set -- "$@" --crash-after 20; fi
exec "$REAL" "$@"
"""


@posix
@finds_processes
def test_the_job_script_runs_a_hub_its_simulators_and_a_trainer(start, tmp_path):
    mark, keys = Mark(), str(tmp_path / "keys")
    for words in (["make", "server"], ["make", "client"], ["enrol", f"fleet={keys}/client.key"]):
        subprocess.run(
            [PYTHON, ROOT / "python" / "15_security" / "keys.py", *words, "--keys", keys], check=True, timeout=LIMIT
        )
    programs = {"srun": SRUN, "hostname": "#!/bin/sh\necho localhost\n", "mortal": MORTAL}
    for name, text in programs.items():
        (tmp_path / name).write_text(text, encoding="utf-8")
        (tmp_path / name).chmod(0o755)
    job = start(
        "bash",
        SCRIPT,
        PATH=f"{tmp_path}{os.pathsep}{os.environ['PATH']}",
        PYTHON=str(tmp_path / "mortal"),
        REAL=str(PYTHON),
        KEYS=keys,
        PORT=str(steady_port()),
        SLURM_NTASKS="3",
        SLURM_JOB_ID="1",
        EPISODES="4",
        **mark.environment,
    )
    assert job.wait(240) == 0, job.output
    job.wait_for("^crash after 20 steps, as told$")
    job.wait_for("^done: 4 episodes, sum [0-9]+$")
    # Everything was told to end; what does not, is named by the failure.
    end = time.monotonic() + 30
    while (left := mark.processes()) and time.monotonic() < end:
        time.sleep(0.05)
    assert left == {}


def documents():
    yaml = pytest.importorskip("yaml", reason="reads the manifest: pip install pyyaml")
    return list(yaml.safe_load_all(MANIFEST.read_text(encoding="utf-8")))


def test_the_parts_of_the_manifest_fit_each_other():
    service, *others = sorted(documents(), key=lambda each: each["kind"] != "Service")
    found = {each["metadata"]["name"]: each["spec"]["template"] for each in others}
    assert found.keys() == {"hub", "simulator", "trainer"}
    containers = {}
    for each in others:
        template = each["spec"]["template"]
        if each["kind"] == "Deployment":
            assert each["spec"]["selector"]["matchLabels"] == template["metadata"]["labels"]
        (container,) = template["spec"]["containers"]
        containers[each["metadata"]["name"]] = container
        mounted = {mount["name"] for mount in container["volumeMounts"]}
        assert mounted == {volume["name"] for volume in template["spec"]["volumes"]}
        # Its own parser would say what is wrong with its options, before anything is done.
        program, *_ = [word for word in container["command"] if word.endswith(".py")]
        done = finished([PYTHON, ROOT / program, *container["args"], "--no-such-option"])
        said = done.stderr.splitlines()[-1].replace("unknown host 'hub'", "")
        assert done.returncode == 2
        assert said.endswith(("unrecognized arguments: --no-such-option", "'tcp://hub:5567': ; check it")), said
    assert service["spec"]["selector"] == found["hub"]["metadata"]["labels"]
    assert [port["port"] for port in service["spec"]["ports"]] == [5567]
    assert [port["containerPort"] for port in containers["hub"]["ports"]] == [5567]
    args = containers["trainer"]["args"]
    (simulators,) = [each["spec"]["replicas"] for each in others if each["metadata"]["name"] == "simulator"]
    assert int(args[args.index("--areas") + 1]) == simulators
