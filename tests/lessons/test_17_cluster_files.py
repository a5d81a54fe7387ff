"""Lesson 17's files for Slurm and Kubernetes: the job script runs, with an srun that starts its tasks here; and kubectl
reads the manifest as Kubernetes' own types.
"""

from __future__ import annotations

import json
import os
import re
import shutil
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


def options(text):
    return dict(re.findall(r"^#SBATCH --([a-z-]+)=(\S+)$", text, re.MULTILINE))


@posix
def test_the_job_script_is_one_for_slurm():
    """Slurm reads its options up to the first command, each in a comment that begins with #SBATCH."""
    text = SCRIPT.read_text(encoding="utf-8")
    assert text.startswith("#!/bin/bash\n")
    first = next(line for line in text.splitlines() if line and not line.startswith("#"))
    head, rest = text.split(first, 1)
    assert options(head).keys() == {"job-name", "ntasks", "cpus-per-task", "time", "output"}
    assert int(options(head)["ntasks"]) > 1 and re.fullmatch(r"\d\d:\d\d:\d\d", options(head)["time"])
    assert "#SBATCH" not in rest
    done = finished(["bash", "-n", SCRIPT])
    assert (done.returncode, done.stderr) == (0, "")


# What Kubernetes requires: https://kubernetes.io/docs/reference/kubernetes-api/
VERSIONS = {"Service": "v1", "Deployment": "apps/v1", "Job": "batch/v1"}


def documents():
    yaml = pytest.importorskip("yaml", reason="reads the manifest: pip install pyyaml")
    return list(yaml.safe_load_all(MANIFEST.read_text(encoding="utf-8")))


def test_the_manifest_has_what_kubernetes_requires():
    found = documents()
    assert sorted(each["metadata"]["name"] for each in found) == ["hub", "hub", "simulator", "trainer"]
    (service,) = [each for each in found if each["kind"] == "Service"]
    templates = []
    for each in found:
        assert each["apiVersion"] == VERSIONS[each["kind"]]
        if each["kind"] == "Service":
            continue
        template = each["spec"]["template"]
        templates.append(template)
        if each["kind"] == "Deployment":
            assert each["spec"]["selector"]["matchLabels"] == template["metadata"]["labels"]
        else:
            assert template["spec"]["restartPolicy"] in ("Never", "OnFailure")
        (container,) = template["spec"]["containers"]
        assert {"name", "image"} <= container.keys()
        mounted = {mount["name"] for mount in container["volumeMounts"]}
        assert mounted == {volume["name"] for volume in template["spec"]["volumes"]}
    ports = [
        port["containerPort"]
        for template in templates
        if template["metadata"]["labels"] == service["spec"]["selector"]
        for port in template["spec"]["containers"][0]["ports"]
    ]
    assert ports == [port["port"] for port in service["spec"]["ports"]] == [5567]
    areas = next(each["spec"]["template"]["spec"]["containers"][0]["args"] for each in found if each["kind"] == "Job")
    (simulators,) = [each["spec"]["replicas"] for each in found if each["metadata"]["name"] == "simulator"]
    assert int(areas[areas.index("--areas") + 1]) == simulators


def test_the_manifests_programs_take_their_options():
    """Their own parsers do: what is wrong would be said by them, before anything is done."""
    for each in documents():
        if each["kind"] != "Service":
            (container,) = each["spec"]["template"]["spec"]["containers"]
            program, *_ = [word for word in container["command"] if word.endswith(".py")]
            done = finished([PYTHON, ROOT / program, *container["args"], "--no-such-option"])
            said = done.stderr.splitlines()[-1].replace("unknown host 'hub'", "")
            assert done.returncode == 2
            assert said.endswith(("unrecognized arguments: --no-such-option", "'tcp://hub:5567': ; check it")), said


def lost(written, kept, where=""):
    """What is written in the manifest and not in what Kubernetes' types hold of it."""
    if isinstance(written, dict):
        return [
            fault
            for key, value in written.items()
            for fault in (lost(value, kept[key], f"{where}.{key}") if key in kept else [f"{where}.{key}"])
        ]
    if isinstance(written, list):
        return [
            fault
            for i, (left, right) in enumerate(zip(written, kept, strict=True))
            for fault in lost(left, right, f"{where}[{i}]")
        ]
    return [] if written == kept else [f"{where}: {written!r} became {kept!r}"]


def typed(document):
    """The manifest as kubectl has it after it was read into Kubernetes' types: what is unknown there is left out."""
    # It prints what it has changed. Of a Service that is its selector, whatever it was.
    change = ["selector", "app=hub"] if document["kind"] == "Service" else ["image", "*=another"]
    done = finished(
        ["kubectl", "set", change[0], "--local", "-f", "-", change[1], "-o", "json"], input=json.dumps(document)
    )
    assert done.returncode == 0, done.stderr
    return json.loads(done.stdout.replace('"another"', '"netmq-example:1"'))


@pytest.mark.skipif(not shutil.which("kubectl"), reason="needs kubectl")
def test_kubectl_takes_all_of_the_manifest():
    for document in documents():
        assert lost(document, typed(document)) == []
    wrong = documents()[1]
    wrong["spec"]["template"]["spec"]["containers"][0]["comand"] = ["python"]
    assert lost(wrong, typed(wrong)) == [".spec.template.spec.containers[0].comand"]
