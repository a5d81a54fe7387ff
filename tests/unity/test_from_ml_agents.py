"""kit.py unity PATH --from ml-agents: an ML-Agents project moves in, does so once, and can be taken back.

The projects are small, in the words of three eras: early 2020, 1.x and 2.x, and 3.x in Unity 6.
"""

import json
import os
import re
from pathlib import Path

import pytest

from kitlib.lessons import PACKAGE, KitError
from kitlib.unity import ml_agents, moving
from kitlib.unity.edits import Edit, applied, checksum, reversed_
from kitlib.unity.install import install
from kitlib.unity.inventory import LIBRARIES
from kitlib.unity.meta import own_guid
from kitlib.unity.scripts import ML_AGENTS, scripts, types
from tests.programs import python_runs
from tests.unity.conftest import put

TARGET = "Assets/NetMQExample"
OURS = {path.stem: own_guid(path) for path in PACKAGE.glob("MLAgents/**/*.cs")}
THEIRS = {name: guid for guid, name in ml_agents.FACTS["scripts"].items()}
KITS_ASSEMBLY = own_guid(ml_agents.ASSEMBLY)

AGENT = """using UnityEngine;
using Unity.MLAgents;
using Unity.MLAgents.Actuators;
using static Unity.MLAgents.Actuators.ActionSpec;
using Spec = Unity.MLAgents.Actuators.ActionSpec;

// Unity.MLAgents in a comment stays.
public class Ball : MonoBehaviour
{
    private global::Unity.MLAgents.Policies.BehaviorType type = Unity.MLAgents.Policies.BehaviorType.Default;
    private char quote = '"'; // using Unity.MLAgents;
    private string path = @"C:\\Unity.MLAgents\\";
}
"""


def component(name, more=""):
    script = f"{{fileID: 11500000, guid: {THEIRS[name]}, type: 3}}"
    return f"--- !u!114 &1\nMonoBehaviour:\n  m_Enabled: 1\n  m_Script: {script}\n  m_Name: \n{more}"


OF_A_MODEL = "  m_Model: {fileID: 11400000, guid: 0123, type: 3}\n  m_BehaviorType: 2\n"
SCENE = "%YAML 1.1\n" + component("BehaviorParameters", OF_A_MODEL) + component("TrainingAreaReplicator")
UNITY_6 = """  m_EditorClassIdentifier: Unity.ML-Agents::Unity.MLAgents.Policies.BehaviorParameters
      m_TargetAssemblyTypeName: Unity.MLAgents.Policies.BehaviorParameters, Unity.ML-Agents
"""
OLD = """using System;
using MLAgents;
using MLAgents.Policies;
namespace MLAgents { class Helper { } }
public class Old : MLAgents.Policies.BehaviorParameters
{
    public override void InitializeAgent() { }
    public override void CollectObservations() { AddVectorObs(1f); }
    public override void AgentAction(float[] action) { Done(); }
    public override void AgentReset() { }
}
"""
RAW = """using MLAgents.SideChannels;
class Log : SideChannel { protected override void OnMessageReceived(byte[] data) { } }
"""
MANIFEST = """{
  "dependencies": {
    "com.unity.ml-agents": "2.0.1",
    "com.unity.ugui": "1.0.0",
    "com.unity.barracuda": "3.0.0"
  }
}
"""


def listing(root):
    """Each file with its permissions."""
    return {
        path.relative_to(root).as_posix(): (path.read_bytes(), path.stat().st_mode)
        for path in root.rglob("*")
        if path.is_file()
    }


@pytest.fixture
def project(tmp_path):
    root = tmp_path / "My Game"
    put(root, {"ProjectSettings/ProjectVersion.txt": "m_EditorVersion: 2022.3.10f1\n"})
    put(root, {"Packages/manifest.json": MANIFEST, "Assets/Ball.cs": AGENT, "Assets/Main.unity": SCENE})
    return root


@pytest.fixture
def dlls(tmp_path):
    for _, _, inside in LIBRARIES:
        put(tmp_path / "dlls", {Path(inside).name: b"MZ"})
    return tmp_path / "dlls"


@pytest.fixture
def move(project, dlls, capsys):
    """move() moves the project in; what it said."""

    def call(yes=True, force=False):
        moving.move_in(project, yes, force, False, dlls)
        return capsys.readouterr().out

    return call


def changed(move, project, name):
    move()
    return (project / name).read_text(encoding="utf-8")


def test_it_says_all_before_it_changes_anything(move, project):
    before = listing(project)
    said = move(yes=False)
    assert listing(project) == before
    assert "would change Assets/Ball.cs: 6 names" in said
    assert "would change Assets/Main.unity: 1 component (BehaviorParameters 1)" in said
    assert "would change Packages/manifest.json: without com.unity.barracuda, com.unity.ml-agents" in said
    assert "Assets/Ball.cs:12: a text names ML-Agents" in said
    assert "Assets/Main.unity:7: a model in BehaviorParameters" in said
    assert "Assets/Main.unity:8: Behavior Type Inference Only" in said
    assert "Assets/Main.unity:12: TrainingAreaReplicator, which the kit lacks" in said
    assert said.endswith("nothing was changed yet: commit the project, then add --yes; --undo takes it back\n")


def test_names_of_a_script_change_and_its_comments_and_texts_do_not(move, project):
    text = changed(move, project, "Assets/Ball.cs")
    for line in (
        "using NetMQExample.MLAgents;",
        "using static NetMQExample.MLAgents.Actuators.ActionSpec;",
        "using Spec = NetMQExample.MLAgents.Actuators.ActionSpec;",
        "global::NetMQExample.MLAgents.Policies.BehaviorType type = NetMQExample.MLAgents.Policies.BehaviorType.",
        "// Unity.MLAgents in a comment stays.",
        "// using Unity.MLAgents;",
        '@"C:\\Unity.MLAgents\\"',
    ):
        assert line in text


def test_components_are_found_again_with_all_that_was_set(move, project):
    scene = changed(move, project, "Assets/Main.unity")
    assert scene == SCENE.replace(THEIRS["BehaviorParameters"], OURS["BehaviorParameters"])


def test_components_that_do_nothing_are_found_again_and_named(move, project):
    both = component("GridSensorComponent") + component("DemonstrationRecorder") * 2
    put(project, {"Assets/Stubs.prefab": f"%YAML 1.1\n{both}"})
    said = move()
    assert "Assets/Stubs.prefab:5: GridSensorComponent, which is found again and does not see" in said
    assert "Assets/Stubs.prefab:10: 2 times DemonstrationRecorder, which is found again and records nothing" in said


def test_unity_6_names_the_class_too(move, project):
    put(project, {"Assets/Six.prefab": "%YAML 1.1\n" + component("BehaviorParameters", UNITY_6)})
    text = changed(move, project, "Assets/Six.prefab")
    assert "NetMQExample::NetMQExample.MLAgents.Policies.BehaviorParameters\n" in text
    assert "NetMQExample.MLAgents.Policies.BehaviorParameters, NetMQExample\n" in text


def test_the_names_of_2020(move, project):
    put(project, {"Assets/Ball.cs": OLD, "Assets/Log.cs": RAW})
    said = move()
    text = (project / "Assets" / "Ball.cs").read_text()
    for line in (
        "using NetMQExample.MLAgents;",
        "using NetMQExample.MLAgents.Policies;",
        "namespace NetMQExample.MLAgents {",
        "class Old : NetMQExample.MLAgents.Policies.BehaviorParameters",
    ):
        assert line in text
    for line, words in ((7, "InitializeAgent is Initialize"), (9, "Done() is EndEpisode()"), (10, "AgentReset is")):
        assert f"Assets/Ball.cs:{line}: {words}" in said
    assert "using NetMQExample.RawSideChannels;" in (project / "Assets" / "Log.cs").read_text()


SPACE = ml_agents.spaces()["NNModel"]
# A script of a project that uses Unity's ML-Agents, and what becomes of it.
MOVED = [
    # MLAgents is a name of their own there.
    ("using Unity.MLAgents;\nusing MLAgents;\n", "using NetMQExample.MLAgents;\nusing MLAgents;\n"),
    ("namespace MLAgents { class X { } }\n", "namespace MLAgents { class X { } }\n"),
    # And one under Unity's goes along.
    ("namespace Unity.MLAgents.Mine { class X { } }\n", "namespace NetMQExample.MLAgents.Mine { class X { } }\n"),
    ("using Unity.MLAgents.Mine;\n", "using NetMQExample.MLAgents.Mine;\n"),
    # A using line that nothing needs is deleted.
    (
        "using Unity.MLAgents.Integrations.Match3; // why\nusing Unity.MLAgents.Inference.Utils;\r\nclass C { }\n",
        " // why\nclass C { }\n",
    ),
    *(
        (f"using {package};\nclass A {{ {used} }}\n", f"{kept}class A {{ {used.replace(package, SPACE)} }}\n")
        for package in ("Unity.Barracuda", "Unity.Sentis", "Unity.InferenceEngine", "Barracuda")
        for used, kept in (("", ""), (f"NNModel a; {package}.ModelAsset b;", f"using {SPACE};\n"))
    ),
]
MASK = "class C : Agent { void CollectDiscreteActionMasks(DiscreteActionMasker m) { } }\n"
# Scripts with a name that the kit lacks, and the line that says so.
LACKING = [
    (
        "using Unity.MLAgents.Integrations.Match3;\nclass D { AbstractBoard b; }\n",
        "1: the kit has no Unity.MLAgents.In",
    ),
    ("using Unity.MLAgents.Extensions.Sensors;\n", "1: the kit has no Unity.MLAgents.Extensions.Sensors"),
    (f"using Unity.MLAgents;\n{MASK}", "2: the kit has no DiscreteActionMasker: write WriteDiscreteActionMask("),
]


def test_what_becomes_of_a_script(move, project):
    """Also its encoding and the ends of its lines stay."""
    before = {f"Moved{number}": old.encode() for number, (old, _) in enumerate(MOVED)}
    after = {f"Moved{number}": new.encode() for number, (_, new) in enumerate(MOVED)}
    before |= {f"Lacking{number}": text.encode() for number, (text, _) in enumerate(LACKING)}
    for encoding in ("utf-8", "utf-8-sig", "cp1252", "utf-16"):
        for name, end in ((encoding, "\n"), (f"{encoding} of Windows", "\r\n")):
            text = f"using Unity.MLAgents;{end}// größer{end}"
            before[name] = text.encode(encoding)
            after[name] = text.replace("Unity", "NetMQExample").encode(encoding)
    put(project / "Assets", {f"{name}.cs": data for name, data in before.items()})
    said = move()
    assert {name: (project / "Assets" / f"{name}.cs").read_bytes() for name in after} == after
    for number, (_, words) in enumerate(LACKING):
        assert f"Assets/Lacking{number}.cs:{words}" in said


def test_an_inference_package_that_is_used_stays(move, project):
    own = "using Unity.Barracuda;\nclass A { IWorker worker; NNModel model; }\n"
    # As a helper does that ML-Agents' examples brought into many projects.
    loads = "using Unity.Sentis;\nclass B { ModelAsset model; ModelAssetData data; }\n"
    put(project, {"Assets/Own.cs": own, "Assets/Loads.cs": loads})
    said = move()
    assert (project / "Assets" / "Own.cs").read_text() == own
    assert (project / "Assets" / "Loads.cs").read_text() == loads
    assert "com.unity.barracuda" in (project / "Packages" / "manifest.json").read_text()
    assert "Assets/Own.cs: it uses com.unity.barracuda, which stays" in said


def test_assembly_definitions(move, project):
    by_name = '{\n  "name": "A",\n  "references": ["Unity.ML-Agents", "X", "Unity.ML-Agents.CommunicatorObjects"]\n}\n'
    by_guid = '{"name": "B", "references": [\n    "GUID:85e0054f8e64b47309646d35f8851f81"\n]}'
    both = '{"name": "C", "references": ["Unity.ML-Agents", "NetMQExample", "Unity.ML-Agents.Extensions"]}'
    put(project, {"Assets/A/A.asmdef": by_name, "Assets/B/B.asmdef": by_guid, "Assets/C/C.asmdef": both})
    said = move()

    def references(name):
        return json.loads((project / "Assets" / name / f"{name}.asmdef").read_text())["references"]

    assert references("A") == ["NetMQExample", "X"]
    assert references("B") == [f"GUID:{KITS_ASSEMBLY}"]
    assert references("C") == ["NetMQExample", "Unity.ML-Agents.Extensions"]
    assert "Assets/C/C.asmdef:1: the kit has no assembly Unity.ML-Agents.Extensions" in said


@pytest.mark.parametrize("end", ["\n", "\r\n"])
@pytest.mark.parametrize("indent", ["  ", "\t"])
def test_the_manifest_keeps_its_look(indent, end, move, project):
    lines = ["{", '_"dependencies": {', '__"com.unity.ml-agents": "file:../x",', '__"größe": "1"', "_}", "}"]
    text = "\ufeff" + end.join(lines).replace("_", indent)
    put(project, {"Packages/manifest.json": text})
    move()
    after = (project / "Packages" / "manifest.json").read_bytes().decode()
    kept = text.replace(f'{indent * 2}"com.unity.ml-agents": "file:../x",{end}', "")
    assert after.startswith(kept.partition('"1"')[0]) and after.endswith(f"{end}{indent}}}{end}}}")


def test_what_ml_agents_brought_and_the_project_uses_is_named(move, project):
    """Unity would take it away with ML-Agents."""
    use = "using Unity.Barracuda;\nusing Unity.Mathematics;\nusing Unity.MLAgents;\nclass A { IWorker worker; }\n"
    put(project, {"Assets/Ball.cs": use})
    put(project, {"Packages/manifest.json": '{"dependencies": {\n  "com.unity.ml-agents": "2.0.1",\n  "z": "1"}}'})
    names = ("com.unity.barracuda", "com.unity.burst", "com.unity.mathematics")
    lock = {name: {"version": "3.0.0", "depth": 1} for name in names}
    lock |= {"com.unity.ml-agents": {"version": "2.0.1", "depth": 0, "dependencies": dict.fromkeys(names, "1")}}
    said = move(yes=False)
    assert "Assets/Ball.cs: it uses com.unity.mathematics, which came with ML-Agents: add it in Unity's Pack" in said
    put(project, {"Packages/packages-lock.json": json.dumps({"dependencies": lock})})
    assert "without com.unity.ml-agents, with com.unity.barracuda, com.unity.mathematics\n" in move()
    found = json.loads((project / "Packages" / "manifest.json").read_text())["dependencies"]
    assert found.items() >= {"com.unity.barracuda": "3.0.0", "com.unity.mathematics": "3.0.0", "z": "1"}.items()
    assert not {"com.unity.ml-agents", "com.unity.burst"} & found.keys()


def test_what_only_ml_agents_brought_is_added(move, project):
    """Its own packages leave with it, and the kit needs some of them."""
    brought = {"com.unity.modules.physics": "1.0.0"}
    both = {"com.unity.modules.jsonserialize": "1.0.0"}
    lock = {name: {"depth": 1} for name in brought | both}
    lock |= {"com.unity.ml-agents": {"depth": 0, "dependencies": brought | both}}
    lock |= {"com.unity.ugui": {"depth": 0, "dependencies": both}}
    put(project, {"Packages/packages-lock.json": json.dumps({"dependencies": lock})})
    unsafe = "Library/PackageCache/com.unity.barracuda@3.0.0/System.Runtime.CompilerServices.Unsafe.dll"
    put(project, {unsafe: b"MZ", f"{unsafe}.meta": "guid: 1"})
    move()
    found = json.loads((project / "Packages" / "manifest.json").read_text())["dependencies"]
    assert brought.items() <= found.items() and not both.keys() & found.keys(), "ugui brings it as well"
    assert (project / TARGET / "Plugins" / Path(unsafe).name).exists()


def test_the_second_run_does_nothing_and_undo_takes_back_all(move, project, capsys):
    (project / "Assets" / "Ball.cs").chmod(0o755)
    before = listing(project)
    move()
    # A script that comes later is moved, too, and the first run is not forgotten.
    put(project, {"Assets/Later.cs": "using Unity.MLAgents;\n"})
    move()
    after = listing(project)
    assert "nothing to change" in move()
    assert listing(project) == after
    assert "nothing to change" in move(yes=False)
    moving.undo(project, force=False)
    assert listing(project) == {**before, "Assets/Later.cs": (b"using Unity.MLAgents;\n", after["Assets/Later.cs"][1])}
    assert not (project / TARGET).exists()
    with pytest.raises(KitError, match="nothing was moved in here"):
        moving.undo(project, force=False)


def test_undo_keeps_what_was_there_before(move, project, dlls):
    install(project, "4", dlls=dlls)
    before = listing(project)
    move()
    moving.undo(project, force=False)
    assert listing(project) == before


def test_a_file_that_was_changed_since_is_not_undone(move, project, capsys):
    move()
    mine = project / "Assets" / "Ball.cs"
    mine.write_text(mine.read_text() + "// more\n")
    after = listing(project)
    with pytest.raises(KitError, match=r"^Assets/Ball\.cs was changed since: nothing was undone; --force undoes the"):
        moving.undo(project, force=False)
    assert listing(project) == after
    moving.undo(project, force=True)
    assert mine.read_text().endswith("// more\n")
    assert (project / "Assets" / "Main.unity").read_text() == SCENE
    assert "left for you: Assets/Ball.cs was changed since, and stays" in capsys.readouterr().out


def test_the_notes_of_anybody_write_nothing_elsewhere(move, project, tmp_path):
    move()
    outside = tmp_path / "outside.txt"
    outside.write_text("b")
    notes = project / moving.NOTES
    entry = {"before": checksum(b"a"), "after": checksum(b"b"), "edits": [[0, "a", "b"]]}
    found = json.loads(notes.read_text())
    found["moves"][0]["files"]["../outside.txt"] = entry
    found["moves"][0]["copied"].append("../outside.txt")
    notes.write_text(json.dumps(found))
    moving.undo(project, force=True)
    assert outside.read_text() == "b"


@pytest.mark.skipif(os.name == "nt", reason="links need a right there")
def test_a_link_and_a_pipe_are_no_files_of_the_project(move, project, tmp_path):
    os.mkfifo(project / "Assets" / "pipe.cs")
    outside = tmp_path / "shared"
    put(outside, {"Mine.cs": AGENT})
    (project / "Assets" / "Shared").symlink_to(outside)
    (project / "Assets" / "Mine.cs").symlink_to(outside / "Mine.cs")
    move()
    assert (outside / "Mine.cs").read_text() == AGENT and (project / "Assets" / "Mine.cs").is_symlink()
    (project / "Assets").rename(tmp_path / "Assets")
    (project / "Assets").symlink_to(tmp_path / "Assets")
    with pytest.raises(KitError, match=r"^Assets is a link to .*: nothing was changed"):
        move()


def test_a_read_only_file_is_named_before_anything_changes(move, project, monkeypatch):
    before = listing(project)
    monkeypatch.setattr(os, "access", lambda path, mode: Path(path).name != "Main.unity")
    with pytest.raises(KitError, match=r"^Assets/Main\.unity is read-only: nothing was changed"):
        move()
    assert listing(project) == before


def test_files_that_are_no_text_are_named_with_the_cure(move, project):
    # Unity writes a GUID's bytes with their halves swapped.
    swapped = bytes.fromhex(re.sub("(.)(.)", r"\2\1", THEIRS["BehaviorParameters"]))
    put(project, {"Assets/Binary.unity": b"\0\0" + swapped, "Assets/Terrain.asset": b"\0\0\0"})
    put(project, {"Assets/Far.prefab": b"version https://git-lfs.github.com/spec/v1\n"})
    said = move()
    assert "Assets/Binary.unity: it is no text" in said and "Force Text" in said
    assert "Assets/Far.prefab: only Git LFS's note" in said
    assert "Terrain" not in said


def test_what_is_not_the_projects_own_is_left_alone(move, project):
    theirs = {
        "Library/PackageCache/com.unity.ml-agents@2.0.1/Runtime/Agent.cs": "namespace Unity.MLAgents { }\n",
        "Packages/com.unity.ml-agents/package.json": '{"name": "com.unity.ml-agents"}',
        "Packages/com.unity.ml-agents/Runtime/Agent.cs": "namespace Unity.MLAgents { }\n",
        "Packages/com.unity.ml-agents/Runtime/OurSensor.cs.meta": f"guid: {'e' * 32}\n",
        "Assets/ML-Agents/Scripts/Agent.cs": "namespace MLAgents { }\n",
        "Assets/ML-Agents/Scripts/Agent.cs.meta": f"guid: {THEIRS['Agent']}\n",
        "Assets/ML-Agents/Editor/AgentEditor.cs": "using Unity.MLAgents;\n",
        "Assets/Samples~/Sample.cs": "using Unity.MLAgents;\n",
    }
    put(project, theirs)
    put(project, {"Packages/mine/package.json": '{"name": "mine"}', "Packages/mine/Mine.cs": "using Unity.MLAgents;\n"})
    put(project, {"Assets/Field.unity": f"%YAML 1.1\n  m_Script: {{fileID: 11500000, guid: {'e' * 32}, type: 3}}\n"})
    said = move()
    assert "Packages/com.unity.ml-agents/Runtime/OurSensor.cs: a scene or a prefab of yours uses it" in said
    for name, text in theirs.items():
        assert (project / name).read_text() == text
    assert (project / "Packages" / "mine" / "Mine.cs").read_text() == "using NetMQExample.MLAgents;\n"
    for folder in ("Packages/com.unity.ml-agents", "Assets/ML-Agents/Editor", "Assets/ML-Agents/Scripts"):
        assert f"{folder}: this is ML-Agents itself: delete it in Unity" in said


def test_a_project_without_ml_agents_stays_as_it_is(move, project):
    (project / "Assets" / "Ball.cs").unlink()
    (project / "Assets" / "Main.unity").unlink()
    put(project, {"Packages/manifest.json": '{"dependencies": {"com.unity.sentis": "2.0.0"}}'})
    put(project, {"Assets/Task.cs": "class Task { void Run() { Done(); } ISensor sensor; }\n"})
    before = listing(project)
    said = move()
    assert "nothing to change" in said and "left for you" not in said
    assert listing(project) == before


@pytest.mark.parametrize(
    ("version", "why"),
    [
        ("2019.4", r"NetMQ needs 2021\.2"),
        ("2021.3", "ML-Agents' shape needs 2022.3 or later: nothing was copied; open a copy"),
    ],
)
def test_an_older_unity_is_refused_before_a_word_of_changes(version, why, move, project, capsys):
    put(project, {"ProjectSettings/ProjectVersion.txt": f"m_EditorVersion: {version}.1f1\n"})
    before = listing(project)
    refusal = f"this project is for Unity {version}; {why}"
    last = move(yes=False).splitlines()[-1]
    assert re.search(f"nothing was changed yet: --yes will refuse: {refusal}", last)
    with pytest.raises(KitError, match=f"^{refusal}"):
        move()
    assert listing(project) == before and not capsys.readouterr().out


@pytest.mark.parametrize("yes", [False, True])
def test_a_setting_that_does_not_compile_is_left_for_you(yes, move, project):
    settings = "PlayerSettings:\n  apiCompatibilityLevelPerPlatform:\n    Standalone: 3\n"
    put(project, {"ProjectSettings/ProjectSettings.asset": settings})
    assert move(yes).count("left for you: set Project Settings, Player, Api Compatibility Level to") == 1


def test_what_uses_ml_agents_dlls_is_named_in_every_script(move, project):
    remote = "using System;\nusing Google.Protobuf;\nclass A { Grpc.Core.Channel c; } // My.Grpc.Core\n"
    put(project, {"Assets/A.cs": remote, "Assets/B.cs": "class B { My.Grpc.Core.X x; }\n"})
    said = move(yes=False)
    assert said.count("left for you: Assets/A.cs:2: Google.Protobuf came with ML-Agents") == 1
    assert "B.cs" not in said
    put(project, {"Assets/Plugins/Google.Protobuf.dll": b"MZ"})
    assert "left for you: Assets/A.cs:3: Grpc.Core came with ML-Agents" in move(yes=False)


def test_a_model_in_a_field_is_named(move, project):
    model = "0123456789abcdef0123456789abcdef"
    put(project, {"Assets/Big.onnx.meta": f"fileFormatVersion: 2\r\nguid: {model}\r\n"})
    field = f"  small: {{fileID: 0}}\n  big: {{fileID: 1, guid: {model}, type: 3}}\n"
    of_the_agent = component("BehaviorParameters", f"  m_Model: {{fileID: 1, guid: {model}, type: 3}}\n")
    put(project, {"Assets/Swap.prefab": f"%YAML 1.1\n{field}", "Assets/Agent.prefab": f"%YAML 1.1\n{of_the_agent}"})
    said = move()
    assert "left for you: Assets/Swap.prefab:3: a model in a field: Python plays it" in said
    assert "Assets/Agent.prefab:7: a model in BehaviorParameters" in said and said.count("a model in a field") == 1


def test_dlls_that_packages_bring_are_deleted_by_the_run_after_the_import(move, project):
    unsafe = "System.Runtime.CompilerServices.Unsafe.dll"
    mine = project / TARGET / "Plugins" / unsafe
    before = listing(project)
    assert "open the project in Unity, then run this again" in move()
    assert mine.exists()
    # Its lock still has ML-Agents, which has brought one of them: that one stays.
    old = {"com.unity.ml-agents": {"version": "2.0.1", "depth": 0, "dependencies": {"com.unity.burst": "1"}}}
    old |= {"com.unity.burst": {"depth": 1}}
    put(project, {"Packages/packages-lock.json": json.dumps({"dependencies": old})})
    put(project, {f"Library/PackageCache/com.unity.burst@1/{unsafe}{end}": b"MZ" for end in ("", ".meta")})
    move()
    assert mine.exists()
    ugui = {"com.unity.ugui": {"depth": 0, "dependencies": {"com.unity.burst": "1"}}, "com.unity.burst": {"depth": 1}}
    put(project, {"Packages/packages-lock.json": json.dumps({"dependencies": ugui})})
    assert f"deleted {TARGET}/Plugins/{unsafe}: another package brings it" in move()
    assert not mine.exists()
    moving.undo(project, force=False)
    left = listing(project)
    assert {name: left[name] for name in before} == before and not (project / TARGET).exists()


def test_the_copied_scripts_are_no_lessons_examples():
    names = {Path(name).name for name in scripts(ML_AGENTS) if name.endswith(".cs")}
    assert names >= {path.name for path in PACKAGE.glob("MLAgents/**/*.cs")}
    assert names >= {"Academy.cs", "SideChannel.cs", "RawBytesChannel.cs", "RawSideChannel.cs", "NetMQConnection.cs"}
    examples = {"CartPole", "CartPoleAgent", "CoinCar", "RoadCar", "Pursuit", "SideChannelClient", "StringLogChannel"}
    assert not {f"{name}.cs" for name in examples} & names


def test_each_component_of_the_kit_is_found():
    """Each of ML-Agents' components that the kit has is one class, with its GUID in the table."""
    for name in OURS.keys() & set(ml_agents.FACTS["types"]["names"].split()):
        (path,) = PACKAGE.glob(f"MLAgents/**/{name}.cs")
        is_component = re.search(rf"(?<!abstract )class {name} : \w*(Behaviour|SensorComponent\w*)\b", path.read_text())
        assert name in types(path) and (name in THEIRS or not is_component)


def test_edits_are_taken_back_in_order():
    edits = [Edit(0, "a", "xyz"), Edit(2, "c", ""), Edit(4, "", "!")]
    data = applied(b"abcd", edits)
    assert data == b"xyzbd!" and applied(data, reversed_(edits)) == b"abcd"
    with pytest.raises(ValueError, match="there is no 'c' at 2"):
        applied(b"abxd", edits)


WRONG = [
    ("nowhere --from ml-agents", "no Unity project: there is no such folder"),
    ("nowhere --yes", "--yes and --undo are for --from ml-agents"),
    ("nowhere --from gymize", "ml-agents"),
    ("--package X.unitypackage --from ml-agents", "--from is for a project"),
]


def test_a_wrong_word_is_answered_in_one_line():
    runs = python_runs("kit.py", [["unity", *words.split()] for words, _ in WRONG])
    for (words, why), (code, lines) in zip(WRONG, runs, strict=True):
        assert code and len(lines) == 1 and why in lines[0], (words, lines)
