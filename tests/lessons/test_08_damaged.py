"""Lesson 08 with what a person, a disk or a hostile peer may leave behind: each ends in one line, and nothing is lost
that could be kept.
"""

from __future__ import annotations

import os
import re
import sys
from pathlib import Path

import pytest

np = pytest.importorskip("numpy", reason="lesson 08 needs numpy: kit.py run 8 installs it")
pytest.importorskip("PIL", reason="to record needs Pillow: pip install pillow")
KEY = "08_see_and_steer"
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


MODELS = {"empty": b"", "text": b"weights", "half a zip": b"PK\x03\x04half", "large": bytes(64 * 1024 + 1)}


class Evil:
    """It does what it likes with whoever unpacks it."""

    def __init__(self, path):
        self.path = path

    def __reduce__(self):
        return Path.touch, (self.path,)


def test_what_is_no_model_ends_the_server_in_one_line(tmp_path, runs):
    """Before it listens: no client comes to wait for it."""
    size = 12 * 32 * 3 + 1
    for name, content in MODELS.items():
        (tmp_path / name).write_bytes(content)
    for name, weights in {"short": np.zeros(5), "nan": np.full(size, np.nan), "words": np.array(["a"] * size)}.items():
        np.savez(tmp_path / name, weights=weights)
    np.savez(tmp_path / "pickled", weights=np.array([Evil(tmp_path / "was run")], object))
    if sys.platform != "win32":
        os.mkfifo(tmp_path / "pipe")
    paths = [*tmp_path.iterdir()]
    words = ["--endpoint", "tcp://127.0.0.1:0", "--model"]
    for path, (code, lines) in zip(paths, runs("server", KEY, [[*words, str(path)] for path in paths]), strict=True):
        assert (code, len(lines)) == (1, 1), lines
        assert lines[0].startswith(f"no model in {path}: ")
        assert path.name not in ("large", "pipe") or "must be a regular file of at most 65536 bytes" in lines[0]
    assert not (tmp_path / "was run").exists()


def test_a_picture_that_cannot_be_used_is_refused_and_the_others_recorded(tmp_path, serve, context):
    """One too small to steer by, and one that no JPEG can hold."""
    path = tmp_path / "model.npz"
    np.savez(path, weights=np.zeros(12 * 32 * 3 + 1))
    _, endpoint = serve(KEY, "--model", str(path), "--record", "runs")
    for shape, says in (((3, 3, 3), "too few to steer by"), ((1, 70_000, 3), "uint8 [height, width, 3 or 4]")):
        reply = read(ask(context, endpoint, *frame(1, shape=shape).frames()))
        assert reply.values["code"] == "bad-shape" and says in reply.values["text"]
    for number in (2, 3):
        assert read(ask(context, endpoint, *frame(number).frames())).kind == "action"
    assert (tmp_path / "runs" / "run_0001" / "IMG" / "center_000002.jpg").exists()


def test_a_folder_that_cannot_be_written_to_is_named_and_the_recording_stops(tmp_path, capsys):
    (tmp_path / "file").write_text("a file", encoding="utf-8")
    places = [tmp_path / "file"]
    if sys.platform != "win32":
        places.append(tmp_path / "link")
        places[1].symlink_to("/nowhere/at/all")
    for place in places:
        keeper = Recorder(place)
        for number in range(3):
            keeper.add(frame(number), action(number))
        (line,) = capsys.readouterr().out.splitlines()
        assert re.match(f"trouble: recording has stopped, the car drives on: .*{place.name}", line)
    assert (tmp_path / "file").read_text(encoding="utf-8") == "a file"


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
