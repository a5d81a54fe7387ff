"""Lesson 08: what a user adds to it. Values of one's own go with a picture and come with an action, each said in one
place; `drive` gets all pictures and all telemetry; and a recording has columns for them. The blocks are the page's. The
fixtures are those of test_08_see_and_steer.py.
"""

# ruff: noqa: E402, F401, F811
import math
import shutil

import pytest

from kitlib.docs import guide
from netmq_example.messages import Message
from tests.conftest import CLIENTS, PYTHON
from tests.programs import PATIENT, ROOT, steady_endpoint

np = pytest.importorskip("numpy", reason="lesson 08 needs numpy: kit.py run 8 installs it")
pytest.importorskip("PIL.Image", reason="recording needs Pillow: pip install pillow")
from netmq_example.camera.recording import Recorder, recorded
from tests.lessons.test_08_see_and_steer import KEY, LESSON, action, ask, check_recording, driver, frame, rows

# Else several pictures are on their way before the first action comes.
LOCKSTEP = ["--lockstep", "true"]
SCRIPTS = ROOT / "unity" / "Assets" / "NetMQExample" / KEY
BLOCKS = [block for block in guide.blocks(ROOT / "docs" / "guide" / f"{KEY}.md") if block.body]
(CAR,) = (block.body for block in BLOCKS if "class MyCar" in block.body)
(MEMBERS,) = (block.body for block in BLOCKS if "void Telemetry" in block.body)
BOXES, DETECTOR = (block.body for block in BLOCKS if "test_a_detector_of_ones_own" in block.source)
(VALUES,) = (block.body for block in BLOCKS if '"zoom"' in block.body and block.language == "python")


def test_a_value_each_way(serve_own, ask, tmp_path, start, console, netmq):
    zoom = """Debug.Log($"zoom {action.Value("zoom", 1)}");"""
    more = """
        Debug.Log($"{action.Value("lamp")} {action.Value("no", 3)} {action.Value("text", 4)}{action.Text("lamp")}");"""
    members = MEMBERS.replace(zoom, zoom + more)
    scripts = {"MyCar.cs": CAR.replace(": DrivenBehaviour", ": ElectricCar"), "ElectricCar.cs": members}
    for name, text in scripts.items():
        (tmp_path / name).write_text(text, encoding="utf-8")
    server, endpoint = serve_own(KEY, VALUES.replace('"go"', '"go", "lamp": True'), "--record", "runs")
    files = [*(tmp_path / name for name in scripts), SCRIPTS / "CameraSender.cs", SCRIPTS / "RoadScene.cs"]
    player = start(
        PYTHON, ROOT / "kit.py", "play", *files, "--endpoint", endpoint, "--count", "5", "--timeout", "60", *LOCKSTEP
    )
    assert player.wait(300) == 0, player.output
    assert (
        player.lines.count("zoom 2") == player.lines.count("1 3 4") == 5 and player.lines.count("Python says go") == 1
    )
    server.wait_for(r"^speed 0\.0 m/s, battery 100\.0$")
    server.wait_for(r"^speed 0\.[1-9] m/s, battery 99\.6$")
    replay = start(PYTHON, LESSON / "replay.py", tmp_path / "runs" / "run_0001", "--endpoint", endpoint)
    assert replay.wait() == 0, replay.output
    # It answers before it records; by its next answer that is done.
    ask(endpoint, Message("nothing"))
    for run in ("run_0001", "run_0002"):
        known = rows(tmp_path / "runs" / run)
        assert [float(row["battery"]) for row in known] == pytest.approx([100, 99.9, 99.8, 99.7, 99.6])
        assert {(row["answered_zoom"], row["answered_text"]) for row in known} == {("2.0", "go")}


# A main camera, and a cube above the middle of what it sees.
LOOK = """
using UnityEngine;

public sealed class Look : MonoBehaviour
{
    private void Awake()
    {
        var camera = new GameObject("Main Camera").AddComponent<Camera>();
        camera.tag = "MainCamera";
        camera.clearFlags = CameraClearFlags.SolidColor;
        camera.backgroundColor = Color.black;
        GameObject.CreatePrimitive(PrimitiveType.Cube).transform.position = new Vector3(0, 2, 6);
    }

    private void Update()
    {
        var boxes = FindObjectOfType<Detector>().Boxes;
        if (boxes.Length == 0) return;
        Debug.Log($"{FindObjectOfType<Detector>().Names[0]} {string.Join(" ", boxes)}");
        Application.Quit();
    }
}
"""


def test_a_detector_of_ones_own(tmp_path, start, netmq):
    endpoint = steady_endpoint()
    for name, text in ("boxes.py", BOXES), ("Detector.cs", DETECTOR), ("Look.cs", LOOK):
        (tmp_path / name).write_text(text.replace("tcp://127.0.0.1:5555", endpoint), encoding="utf-8")
    start(PYTHON, tmp_path / "boxes.py", PYTHONPATH=str(ROOT / "python"))
    player = start(PYTHON, ROOT / "kit.py", "play", tmp_path / "Look.cs", tmp_path / "Detector.cs")
    assert player.wait(300) == 0, player.output
    (seen,) = (line.split() for line in player.lines if line.startswith("bright "))
    left, top, width, height = map(float, seen[1:])
    # In the middle from left to right, and in the upper half: no row is the wrong way up.
    assert left + width / 2 == pytest.approx(320, abs=1) and top > 0 and top + height < 180, player.output


# As one has it who comes from a driving trainer: a function of the images and four numbers, which returns three.
TRAINER = """
def agent(images, speed, throttle, steer, brake):
    print("telemetry:", *(image.shape for image in images), end=" ")
    print(f"speed {speed:.2f} throttle {throttle:.2f} steer {steer:.2f} brake {brake:.2f}", flush=True)
    return [0.5, 0.0, 0.0]


def drive(pictures, telemetry):
    numbers = (telemetry[name] for name in ("speed", "throttle", "steer", "brake"))
    return agent(list(pictures.values()), *numbers)
"""


@pytest.mark.parametrize("kind", CLIENTS)
def test_what_the_user_of_a_driving_trainer_types(kind, serve_own, ask, runs, tmp_path):
    server, endpoint = serve_own(KEY, TRAINER, "--record", "runs")
    words = ["--endpoint", endpoint, "--count", "12", "--cameras", "left,right", "--lockstep", *PATIENT]
    ((code, lines),) = runs(kind, KEY, [words])
    assert code == 0, lines
    sizes = r"\(240, 320, 3\) \(240, 320, 3\)"
    server.wait_for(f"^telemetry: {sizes} speed 0.00 throttle 0.00 steer 0.00 brake 1.00$")
    server.wait_for(f"^telemetry: {sizes} speed 0.43 throttle 0.50 steer 0.00 brake 0.00$")
    # It answers before it records; by its next answer that is done.
    ask(endpoint, Message("nothing"))
    # The pictures of a scene have no number in them.
    known = (rows if kind == "unity" else check_recording)(tmp_path / "runs" / "run_0001")
    assert [int(row["frame"]) for row in known] == list(range(12))
    assert {(row["left_file_name"][:8], row["right_file_name"][:9]) for row in known} == {("IMG/left", "IMG/right")}
    assert {row["answered_throttle"] for row in known} == {"0.5"}


NAN = """
def drive(pictures, telemetry):
    speed = telemetry["speed"]
    return speed / 8, 0.0, float("nan") if speed > 8 else 7
"""


def test_a_driver_that_says_nan_is_told_so(serve_own, ask):
    _, endpoint = serve_own(KEY, NAN)
    assert ask(endpoint, frame(1)).values == {"frame": 1, "throttle": 1, "brake": 0, "steer": 7}
    reply = ask(endpoint, frame(2, speed=9.0))
    assert (reply.kind, reply.id, reply.values["code"]) == ("error", 2, "error-in-driver")
    assert reply.values["text"].endswith("drive returns steer nan, which is not finite')")
    assert ask(endpoint, frame(3)).kind == "action"


def test_what_a_driver_returns():
    assert driver.as_action([1, 0, np.float32(0.5)]) == {"throttle": 1, "brake": 0, "steer": 0.5}
    told = {"throttle": 1, "brake": 0, "steer": np.array(0.5), "text": "go", "lamp": True}
    assert driver.as_action(told) == told and type(driver.as_action(told)["steer"]) is float
    three = {"throttle": 1, "brake": 0, "steer": 0}
    for wrong, said in (
        ((1, 0), "returns throttle, brake, steer"),
        (None, "not None"),
        ({"throttle": 1, "steer": 0}, "no number 'brake'"),
        ({**three, "steer": "left"}, "no number 'steer'"),
        ({**three, "zoom": math.nan}, "returns zoom nan, which is not finite"),
    ):
        with pytest.raises(ValueError, match=said):
            driver.as_action(wrong)


TEXTS = ['a, "b"', "two\r\nlines", "", "ü", "nan", "7"]


def test_any_text_is_read_back(tmp_path):
    """But for the end of a line, which becomes a blank, a number, which becomes one, and nothing, which is none."""
    keeper = Recorder(tmp_path)
    for number, text in enumerate(TEXTS):
        keeper.add(frame(number, said=text, lamp=True, gear=-1), action(number, text=text, zoom=1e-7))
    found = list(recorded(tmp_path / "run_0001"))
    expected = ['a, "b"', "two  lines", None, "ü", "nan", 7]
    assert [row.values.get("said") for row in found] == [row.answered.get("text") for row in found] == expected
    assert {(row.values["lamp"], row.values["gear"], row.answered["zoom"]) for row in found} == {(True, -1, 1e-7)}


def test_what_has_no_column_is_said_once(tmp_path, caplog):
    """A value that comes later, and one that would be read as something else, have none."""
    keeper = Recorder(tmp_path)
    keeper.add(frame(0, battery=1, height=3, my_file_name="x"), action(0))
    for number in (1, 2):
        keeper.add(frame(number, wind=2), action(number, zoom=1))
    said = [line.split(":")[1] for line in caplog.messages]
    assert said == [f" '{name}' is not recorded" for name in ("height", "my_file_name", "wind", "answered_zoom")]
    assert [row["battery"] for row in rows(tmp_path / "run_0001")] == ["1", "", ""]
    assert [row.values.get("battery") for row in recorded(tmp_path / "run_0001")] == [1, None, None]


ODD_CAR = """using System.Collections.Generic;
using NetMQExample;

public sealed class MyCar : DrivenBehaviour
{
    private int asked;

    public override double Speed => 0;
    public override void Telemetry(IDictionary<string, object> values)
    {
        if (asked++ == 0) values["place"] = transform.position;
        else values["steer"] = 1.0;
    }
    public override void Step(double throttle, double brake, double steer) { }
}
"""


def test_a_value_that_cannot_go_is_named(serve, tmp_path, start, console, netmq):
    """One of no type that goes, and then one whose name each picture has."""
    _, endpoint = serve(KEY)
    mine = tmp_path / "MyCar.cs"
    mine.write_text(ODD_CAR, encoding="utf-8")
    files = [mine, SCRIPTS / "CameraSender.cs"]
    player = start(PYTHON, ROOT / "kit.py", "play", *files, "--endpoint", endpoint, "--tries", "2")
    assert player.wait(300) == 1, player.output
    wrong_type = player.lines.index("trouble: wrong-type: value 'place' must be text, a number, true or false")
    assert "gave up: bad-name: each picture has 'steer': give yours another name" in player.lines[wrong_type:]
