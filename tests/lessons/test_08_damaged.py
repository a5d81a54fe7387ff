"""Lesson 08 with what a person, a disk or a hostile peer may leave behind: each ends in one line, and nothing is lost
that could be kept.
"""

from __future__ import annotations

import os
import sys

import pytest

from tests.conftest import PYTHON
from tests.programs import ROOT, finished

np = pytest.importorskip("numpy", reason="lesson 08 needs numpy: pip install numpy")
pytest.importorskip("PIL", reason="to record needs Pillow: pip install pillow")
KEY = "08_see_and_steer"
LESSON = ROOT / "python" / KEY
from netmq_example.camera.recording import MOST_DRIVES, Recorder, recorded  # noqa: E402
from netmq_example.messages import Array, Message, read  # noqa: E402
from tests.lessons.conftest import ask  # noqa: E402


def frame(number, run="r", shape=(60, 80, 3)):
    values = {"frame": number, "run": run, "manual": False, "cameras": "center", "encoding": "raw", "bottom_up": True}
    values |= dict.fromkeys(("sim_time", "wall_time", "throttle", "brake", "steer", "speed"), 0.5)
    return Message("frame", number, values, [Array("uint8", shape, bytes(np.prod(shape)))])


def action(number):
    return Message("action", number, {"frame": number, "throttle": 0.5, "brake": 0.0, "steer": 0.25})


@pytest.fixture
def recording(tmp_path):
    """Twenty pictures."""
    keeper = Recorder(tmp_path)
    for number in range(20):
        keeper.add(frame(number), action(number))
    return tmp_path / "run_0001"


def lines(folder):
    return (folder / "metadata.csv").read_bytes().splitlines(keepends=True)


def damage(folder, how):
    table, rows = folder / "metadata.csv", lines(folder)
    picture = folder / "IMG" / "center_000005.jpg"
    if how == "binary":
        rows[6] = b"\xff\xfe\0" + rows[6]
    elif how == "a stray quote":
        rows[6] = b'"' + rows[6]
    elif how == "a huge cell":
        rows[6] = b"x" * 200_000 + rows[6]
    elif how == "a comma too many":
        rows[6] = rows[6].replace(b"\n", b",\n")
    elif how == "nan":
        rows[6] = rows[6].replace(b"0.25", b"nan")
    elif how == "cut in the middle":
        rows[20:] = [rows[20][:30]]
    elif how == "a pipe for a picture":
        picture.unlink()
        os.mkfifo(picture)
    elif how == "half a picture":
        picture.write_bytes(picture.read_bytes()[:200])
    elif how == "no picture":
        picture.unlink()
    elif how == "a mark at its beginning":
        rows[0] = "\ufeff".encode() + rows[0]
    table.write_bytes(b"".join(rows))


ALL = ["a mark at its beginning"]
ONE_LESS = [
    "binary",
    "a stray quote",
    "a huge cell",
    "a comma too many",
    "nan",
    "cut in the middle",
    "half a picture",
    "no picture",
]
if sys.platform != "win32":
    ONE_LESS.append("a pipe for a picture")


@pytest.mark.parametrize("how", [*ALL, *ONE_LESS])
def test_what_cannot_be_read_is_said_and_left_out(how, recording, capsys):
    damage(recording, how)
    found = [values["frame"] for _, values, *_ in recorded(recording)]
    said = capsys.readouterr().out.splitlines()
    lost = 19 if how == "cut in the middle" else 5
    assert found == [number for number in range(20) if how in ALL or number != lost]
    assert [line[:38] for line in said] == (
        [] if how in ALL else [f"trouble: line {lost + 2} of metadata.csv is left"[:38]]
    )


@pytest.mark.parametrize("program", ["replay.py", "train.py", "film.py"])
@pytest.mark.parametrize("content", [b"", b"a,b,c\n1,2,3\n", "file_name\n".encode("utf-16"), None], ids=repr)
def test_what_is_no_recording_ends_in_one_line(program, content, tmp_path):
    folder = tmp_path / "foreign"
    folder.mkdir()
    if content is not None:
        (folder / "metadata.csv").write_bytes(content)
    words = [PYTHON, LESSON / program, folder, *(["x.gif"] if program == "film.py" else [])]
    done = finished(words, cwd=tmp_path)
    assert done.returncode == 1, done.stderr
    assert done.stderr.count("\n") == 1 and "Traceback" not in done.stderr, done.stderr


MODELS = {"empty": b"", "text": b"weights", "half a zip": b"PK\x03\x04half"}


@pytest.mark.parametrize("name", [*MODELS, "too short", "not finite", "no numbers"])
def test_what_is_no_model_ends_the_server_in_one_line(name, tmp_path):
    path = tmp_path / "model.npz"
    if name in MODELS:
        path.write_bytes(MODELS[name])
    else:
        size = 5 if name == "too short" else 12 * 32 * 3 + 1
        np.savez(path, weights=np.array(["left"] * size) if name == "no numbers" else np.full(size, np.nan))
    words = [PYTHON, LESSON / "server.py", "--endpoint", "tcp://127.0.0.1:0", "--model", path]
    done = finished(words)
    # Before it listens: no client comes to wait for it.
    assert (done.returncode, done.stdout) == (1, "")
    assert done.stderr.startswith(f"no model in {path}: ") and done.stderr.count("\n") == 1


def test_a_picture_too_small_to_steer_by_is_refused(tmp_path, serve, context):
    path = tmp_path / "model.npz"
    np.savez(path, weights=np.zeros(12 * 32 * 3 + 1))
    _, endpoint = serve(KEY, "--model", str(path))
    reply = read(ask(context, endpoint, *frame(1, shape=(3, 3, 3)).frames()))
    assert reply.kind == "error" and "too few to steer by" in reply.values["text"]
    assert read(ask(context, endpoint, *frame(2).frames())).kind == "action"


def test_a_picture_that_no_jpeg_can_hold_is_refused_and_the_others_recorded(tmp_path, serve, context):
    _, endpoint = serve(KEY, "--record", "runs")
    reply = read(ask(context, endpoint, *frame(1, shape=(1, 70_000, 3)).frames()))
    assert reply.values["code"] == "bad-shape"
    assert read(ask(context, endpoint, *frame(2).frames())).kind == "action"
    assert read(ask(context, endpoint, *frame(3).frames())).kind == "action"
    assert (tmp_path / "runs" / "run_0001" / "IMG" / "center_000002.jpg").exists()


@pytest.mark.skipif(sys.platform == "win32", reason="a link to nowhere")
def test_a_folder_that_leads_nowhere_stops_the_recording_and_not_the_car(tmp_path, serve, context):
    (tmp_path / "runs").symlink_to("/nowhere/at/all")
    server, endpoint = serve(KEY, "--record", "runs")
    for number in range(3):
        assert read(ask(context, endpoint, *frame(number).frames())).kind == "action"
    server.wait_for("^trouble: recording has stopped, the car drives on: ")


def test_so_many_cars_are_recorded_and_no_more(tmp_path, capsys):
    keeper = Recorder(tmp_path)
    for number in range(3):
        for car in range(MOST_DRIVES + 5):
            keeper.add(frame(number, f"car {car}"), action(number))
    folders = list(tmp_path.glob("run_*"))
    assert len(folders) == MOST_DRIVES and all(len(lines(folder)) == 4 for folder in folders)
    assert sum(line.startswith(f"trouble: {MOST_DRIVES} cars") for line in capsys.readouterr().out.splitlines()) == 1


def test_numbers_that_go_back_are_recorded_and_none_twice(tmp_path):
    keeper = Recorder(tmp_path)
    for number in (5, 3, 5, 2**53 - 1, 4):
        keeper.add(frame(number), action(number))
    assert [values["frame"] for _, values, *_ in recorded(tmp_path / "run_0001")] == [5, 3, 2**53 - 1, 4]
