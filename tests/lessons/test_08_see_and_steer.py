"""Lesson 08, the Python programs: what they see, record, replay and learn, and all that can go wrong meanwhile.

What the clients do is in test_08_drive.py.
"""

import base64
import csv
import importlib
import importlib.util
import io
import itertools
import json
import math
import os
import random
import re
import struct
import sys
import time
from pathlib import Path

import pytest
import zmq

from kitlib.docs import guide
from netmq_example.errors import Timeout
from netmq_example.messages import Array, Message, MessageError
from tests.conftest import CLIENTS, PYTHON
from tests.lessons.conftest import ask as exchange
from tests.programs import PATIENT, ROOT, free_port, python_runs, steady_endpoint

KEY = "08_see_and_steer"
LESSON = ROOT / "python" / KEY
# In front: lesson 09 has a train.py, too.
sys.path.insert(0, str(LESSON))
np = pytest.importorskip("numpy", reason="lesson 08 needs numpy: kit.py run 8 installs it")
Image = pytest.importorskip("PIL.Image", reason="recording needs Pillow: pip install pillow")
driver, train = map(importlib.import_module, ("driver", "train"))
from netmq_example.camera import pictures as camera_pictures  # noqa: E402
from netmq_example.camera import recording  # noqa: E402
from netmq_example.camera.client import DriverClient  # noqa: E402
from netmq_example.camera.pictures import encode, pictures  # noqa: E402
from netmq_example.camera.recording import MOST_DRIVES, Recorder  # noqa: E402
from netmq_example.worlds import road as world  # noqa: E402

VALUES = {"run": "a test", "manual": False, "sim_time": 0.0, "wall_time": 0.0, "speed": 8.0}
VALUES |= {"throttle": 0.5, "brake": 0.0, "steer": 0.1, "cameras": "center", "encoding": "raw", "bottom_up": False}

GREY = np.full((24, 32, 3), 100, np.uint8)


def frame(number, *seen, **values):
    """The message about some pictures, top row first, or about JPEG files."""
    arrays = [
        Array("uint8", (len(one),), one) if isinstance(one, bytes) else Array("uint8", one.shape, one.copy())
        for one in seen or (GREY,)
    ]
    return Message("frame", number, VALUES | {"frame": number} | values, arrays)


def action(number, **values):
    return Message("action", number, {"frame": number, "throttle": 0.5, "brake": 0.0, "steer": 0.25} | values)


@pytest.fixture(scope="module")
def camera(road):
    return world.DrawnCamera(road)


@pytest.fixture(scope="module")
def road():
    return world.Road()


@pytest.fixture
def plain(camera, road):
    return camera.draw(world.Car.on(road), 0)[::-1]


@pytest.fixture
def ask(context):
    return lambda endpoint, message: Message.read(exchange(context, endpoint, *message.frames()))


def rows(folder, name="metadata.csv"):
    with (folder / name).open(newline="", encoding="utf-8") as file:
        return list(csv.DictReader(file))


def number_in(picture):
    """The squares along its upper edge."""
    return sum(int(picture[4, 8 * bit + 4].mean() > 128) << (15 - bit) for bit in range(16))


def check_recording(folder, lost=0):
    """Rows and pictures agree, but for so many that a kill may have cut off; returns the rows."""
    known, log, files = rows(folder), rows(folder, "driving_log.csv"), list((folder / "IMG").iterdir())
    cameras = [column for column in known[0] if column.endswith("file_name")]
    assert 0 <= len(known) - len(log) <= lost
    assert 0 <= len(files) - len(known) * len(cameras) <= lost * len(cameras)
    for row, column in itertools.product(known, cameras):
        picture = np.asarray(Image.open(folder / row[column]).convert("RGB"))
        assert picture.shape == (int(row["height"]), int(row["width"]), 3)
        if picture.shape[1] == 320:
            assert number_in(picture) == int(row["frame"]) == int(row[column][-10:-4]), "another picture than it says"
    for row, wrote in zip(known, log, strict=False):
        assert float(wrote["steering"]) == float(row["steer"])
        assert float(wrote["speed"]) == pytest.approx(float(row["speed"]) * 2.2369363)
    return known


# What is recorded


def test_the_numbered_picture_is_the_recorded_one_and_a_replay_gives_the_same_actions(serve, runs, tmp_path):
    server, endpoint = serve(KEY, "--record", "runs")
    where, folder = ["--endpoint", endpoint, "--lockstep", *PATIENT], tmp_path / "runs"
    drives = [["--jpeg"], [], ["--jpeg", "--cameras", "left,right"]]
    for run in runs("python", KEY, [[*where, "--count", "30", *words] for words in drives]):
        assert run.code == 0, run
    server.wait_for("^recording to .*run_0003: left,right, 320 x 240$")
    folders = [folder / "run_0001", folder / "run_0002"]
    # Of raw pictures only JPEG files are left, and their actions are not quite the same to the bit.
    words = [[str(one), "--endpoint", endpoint, "--compare", *PATIENT] for one in folders]
    same, others = (run.lines for run in python_runs(LESSON / "replay.py", words))
    assert same[1:] == ["done: 30 of 30 pictures have an action; 0 differ from the recorded ones, by at most 0"]
    count, most = re.search(r"30 of 30 .*; (\d+) differ from the recorded ones, by at most (\S+)$", others[-1]).groups()
    assert int(count) > 15 and 0 < float(most) < 0.05
    assert len(others) == 12 and re.match(r"line \d+, frame \d+: steer \S+, then \S+$", others[1]), "ten, and the sum"
    for one in (*folders, folder / "run_0003"):
        assert [int(row["frame"]) for row in check_recording(one)] == list(range(30))


def recorded(folder, count, cameras="center", jpeg=False, size=8):
    """A recording made here, of pictures that are all one grey."""
    keeper, names = Recorder(folder), cameras.split(",")
    for number in range(count):
        picture = np.full((size, 2 * size, 3), number % 200, np.uint8)
        seen = [encode(picture) if jpeg else picture for _ in names]
        message = frame(number, *seen, cameras=cameras, encoding="jpeg" if jpeg else "raw", steer=number / 100)
        keeper.add(message, action(number, steer=-number / 7))
    return folder / "run_0001"


def test_three_kinds_of_reader_open_a_recording(tmp_path):
    """Udacity's simulator, and what was written for it, agree only on the order of the columns."""
    folder = recorded(tmp_path / "runs", 12)
    with (folder / "driving_log.csv").open(newline="", encoding="utf-8") as file:
        lines = list(csv.reader(file))
    # One that knows nothing of a header skips what is no number; one that drops the first line gets the same.
    numbers = [line for line in lines if re.fullmatch(r"[-+\d.e]+", line[3])]
    assert numbers == lines[1:] and all(len(line) == 7 for line in lines)
    assert lines[0] == ["center", "left", "right", "steering", "throttle", "brake", "speed"]
    assert [line[0].split("/")[-1] for line in numbers] == [f"center_{i:06}.jpg" for i in range(12)]
    # A third reads columns of numbers by their names.
    assert [float(row["steering"]) for row in rows(folder, "driving_log.csv")] == [i / 100 for i in range(12)]
    # An imagefolder: metadata.csv at its top, `file_name` or several of them, relative and with a slash.
    stereo = recorded(tmp_path / "stereo", 2, "left,right")
    for where, names in (folder, ["file_name"]), (stereo, ["left_file_name", "right_file_name"]):
        known = rows(where)
        assert [column for column in known[0] if column.endswith("file_name")] == names
        found = {path.relative_to(where).as_posix() for path in where.rglob("*.jpg")}
        assert {row[name] for row in known for name in names} == found
    assert [float(row["answered_steer"]) for row in rows(folder)] == [-i / 7 for i in range(12)], "to the last bit"


def test_other_sizes_and_two_cars_get_folders_of_their_own(serve, ask, tmp_path, plain):
    server, endpoint = serve(KEY, "--record", "runs")
    small = np.ascontiguousarray(plain[::2, ::2])
    for number in range(3):
        for run in ("one car", "another"):
            assert ask(endpoint, frame(number, plain, run=run)).kind == "action"
    assert ask(endpoint, frame(3, small, run="one car")).kind == "action"
    assert ask(endpoint, frame(2, plain, run="another")).kind == "action", "the same picture again"
    last = Path("runs/run_0003")
    server.wait_for(f"^recording to .*{re.escape(str(last))}: center, 160 x 120$")
    assert ask(endpoint, frame(4, small, run="one car")).kind == "action"
    # It answers before it records; by its next answer that is done.
    ask(endpoint, Message("nothing"))
    assert [len(rows(folder)) for folder in sorted((tmp_path / "runs").iterdir())] == [3, 3, 2]


# What is replayed


def test_a_recording_that_was_cut_off_is_replayed_as_far_as_it_is_there(serve, tmp_path):
    folder = recorded(tmp_path / "mine", 10)
    table = folder / "metadata.csv"
    table.write_text(table.read_text(encoding="utf-8")[:-70], encoding="utf-8")
    (folder / "IMG" / "center_000002.jpg").unlink()
    half = folder / "IMG" / "center_000005.jpg"
    half.write_bytes(half.read_bytes()[:300])
    pipe = folder / "IMG" / "center_000007.jpg"
    pipe.unlink()
    if sys.platform != "win32":
        os.mkfifo(pipe)
    _, endpoint = serve(KEY)
    nobody = ["--endpoint", f"tcp://127.0.0.1:{free_port()}", "--timeout", "0.2"]
    there, alone = python_runs(
        LESSON / "replay.py", [[str(folder), "--endpoint", endpoint, *PATIENT], [str(folder), *nobody]]
    )
    found = (re.match(r"trouble: line (\d+) of metadata.csv", line) for line in there.lines)
    assert [int(line[1]) for line in found if line] == [4, 7, 9, 11]
    assert "center_000002.jpg" in there.lines[1] and "no JPEG picture" in there.lines[2]
    assert (there.code, there.lines[-1]) == (0, "done: 6 of 6 pictures have an action")
    assert alone.code == 1
    assert re.fullmatch(r"gave up: no reply from tcp://\S+ within 0.8 s; is the server running\?", alone.lines[-1])


DAMAGES = {
    "binary": lambda row: b"\xff\xfe\0" + row,
    "a stray quote": lambda row: b'"' + row,
    "a huge cell": lambda row: b"x" * 200_000 + row,
    "a comma too many": lambda row: row.replace(b"\n", b",\n"),
    "nan": lambda row: row.replace(b"8.0", b"nan"),
    "a number that no message has": lambda row: row.replace(b",5,", b",9007199254740992,", 1),
}


@pytest.mark.parametrize("damage", DAMAGES.values(), ids=DAMAGES)
def test_a_row_that_cannot_be_read_is_said_and_left_out(damage, tmp_path, caplog):
    """And Excel's mark at the beginning is none."""
    folder = recorded(tmp_path, 9)
    columns, *lines = (folder / "metadata.csv").read_bytes().splitlines(keepends=True)
    lines[5] = damage(lines[5])
    (folder / "metadata.csv").write_bytes(b"".join(["\ufeff".encode(), columns, *lines]))
    found = [(row.values["frame"], *row.pictures) for row in recording.recorded(folder)]
    assert found == [(number, "center") for number in (0, 1, 2, 3, 4, 6, 7, 8)]
    (said,) = caplog.messages
    assert said.startswith("trouble: line 7 of metadata.csv is left out")


FOREIGN = {"empty": b"", "other": b"a,b,c\n1,2,3\n", "utf-16": "file_name\n".encode("utf-16")}


@pytest.mark.parametrize("name", ["replay.py", "train.py", "film.py"])
def test_what_is_no_recording_is_named_in_one_line(name, tmp_path):
    folders = [tmp_path, tmp_path / "nowhere"]
    for word, content in FOREIGN.items():
        folders.append(tmp_path / word)
        folders[-1].mkdir()
        (folders[-1] / "metadata.csv").write_bytes(content)
    more = [str(tmp_path / "x.gif")] if name == "film.py" else []
    for folder, run in zip(
        folders, python_runs(LESSON / name, [[str(folder), *more] for folder in folders]), strict=True
    ):
        (line,) = (line for line in run.lines if not line.startswith(("asking", "trouble: line 2 of")))
        assert run.code == 1 and str(folder) in line


def test_a_film_is_made_of_a_recording(tmp_path):
    folder, film = str(recorded(tmp_path, 12, size=100)), str(tmp_path / "x.gif")
    made, short, none, wrong = python_runs(
        LESSON / "film.py",
        [[folder, film], [folder, film, "--count", "1"], [folder, film, "--first", "12"], [folder, film + ".txt"]],
    )
    assert re.fullmatch(r"wrote .*x.gif: 3 pictures, 0\.\d MB", made.lines[0]), made
    assert ": 1 pictures" in short.lines[0]
    assert (none.code, none.lines) == (1, [f"no film of {folder}: it has no picture there; try a smaller --first"])
    assert wrong.code == 1 and wrong.lines[0].endswith("; give it a name that ends in .gif")


# What is learned


def look(camera, car):
    """Every fourth pixel of what the drawn camera sees, top row first: sixteen times as fast, for many laps."""
    ahead, right = camera.ahead[::4], camera.right[::4, ::4]
    x = car.x + car.ahead_x * ahead + car.ahead_y * right
    y = car.y + car.ahead_y * ahead - car.ahead_x * right
    columns = np.clip((x / world.CELL).astype(int), 0, camera.ground.shape[1] - 1)
    lines = np.clip((y / world.CELL).astype(int), 0, camera.ground.shape[0] - 1)
    picture = np.empty((60, 80, 3), np.uint8)
    picture[:] = world.SKY
    picture[: len(x)] = camera.colours[camera.ground[lines, columns]]
    return picture[::-1]


def laps(camera, road, act, begin, count, keep=lambda *_: None):
    """Drives so many times around; returns how far off the middle it was at the most."""
    car, off, done, last, number = world.Car.on(road, begin), 0.0, 0, begin, 0
    while done < count * len(road.points):
        assert number < count * 3000, "it does not get around"
        picture = look(camera, car)
        action = act(picture, car.speed)
        keep(number, picture, car, action)
        car.step(*action)
        at, apart = road.nearest(car.x, car.y)
        off, number = max(off, apart), number + 1
        assert off < world.HALF_WIDTH, f"off the road at point {at}, after {done / len(road.points):.1f} laps"
        done += (at - last + 1000) % len(road.points) - 1000
        last = at
    return off


def test_what_was_learned_from_a_lap_stays_on_the_road_and_a_server_drives_by_it(
    tmp_path, camera, road, serve, ask, plain, caplog
):
    """By the driver's steering, or by a person's where one drives."""
    keeper = Recorder(tmp_path / "runs")

    def keep(number, picture, car, action):
        if number % 6 == 0:
            told = dict(zip(("throttle", "brake", "steer"), action, strict=True))
            manual = number % 12 == 0
            seen = frame(number, picture, speed=car.speed, manual=manual, steer=action[2] if manual else -1.0)
            keeper.add(seen, Message("action", number, told | ({"steer": 1.0} if manual else {})))

    caplog.set_level("INFO", "netmq_example")
    assert laps(camera, road, driver.follow_road, 0, 1, keep) < 1
    begun, hundred, *_ = caplog.messages
    where = tmp_path / "runs" / "run_0001"
    assert (begun, hundred) == (f"recording to {where}: center, 80 x 60", f"recorded 100 pictures to {where}")
    out = tmp_path / "steering.npz"
    folder, few = str(tmp_path / "runs" / "run_0001"), str(recorded(tmp_path / "few", 99, size=50))
    done, other, too_few, nowhere = python_runs(
        LESSON / "train.py",
        [
            [folder, "--out", str(out)],
            [folder, "--out", str(tmp_path / "other.npz"), "--seed", "1"],
            [few, "--out", str(out)],
            [folder, "--out", str(tmp_path / "no" / "where")],
        ],
    )
    assert done.code == 0 and re.fullmatch(r"read \d+ pictures, \d+ s", done.lines[0]), done
    assert float(re.search(r"its steering is off by (\S+)", done.lines[-2])[1]) < 0.05
    assert done.lines[-1] == f"wrote {out}"
    assert other.lines[-2] != done.lines[-2], "another seed chooses others"
    assert too_few.lines[-1] == "99 pictures are too few to learn from: record a lap or more"
    assert nowhere.code == 1 and nowhere.lines[-1].endswith("; give another file with --out")
    act = train.load(out)
    laps(camera, road, lambda picture, speed: act({"center": picture}, {"speed": speed}), 1000, 0.5)
    _, endpoint = serve(KEY, "--model", str(out))
    action = ask(endpoint, frame(5, plain))
    assert action.values["steer"] == act({"center": plain}, {"speed": 8.0})[2] != driver.follow_road(plain, 8.0)[2]


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


CHANGES = {
    "jpeg": lambda picture: np.asarray(Image.open(io.BytesIO(encode(picture)))),
    "dark": lambda picture: (picture * 0.15).astype(np.uint8),
    "bright": lambda picture: np.minimum(picture * 1.4, 255).astype(np.uint8),
    "warm": lambda picture: np.minimum(picture * np.array([1.15, 1, 0.8]) * 0.9, 255).astype(np.uint8),
    "cold": lambda picture: np.minimum(picture * np.array([0.85, 1, 1.15]) * 0.8, 255).astype(np.uint8),
    "small": lambda picture: picture[::2, ::2],
    "large": lambda picture: picture.repeat(2, 0).repeat(2, 1),
    "alpha": lambda picture: np.dstack([picture, np.full(picture.shape[:2], 255, np.uint8)]),
}


@pytest.mark.parametrize("change", CHANGES)
def test_the_driver_sees_the_road_in_any_light_and_size(change, camera, road):
    for at in range(0, len(road.points), 191):
        car = world.Car.on(road, at)
        car.x, car.y = car.x + random.Random(at).uniform(-1, 1), car.y + random.Random(-at).uniform(-1, 1)
        picture = camera.draw(car, at)[::-1]
        steer = driver.follow_road(CHANGES[change](picture), 8.0)[2]
        assert steer == pytest.approx(driver.follow_road(picture, 8.0)[2], abs=0.1), at


def test_lerobots_reader_gets_the_pictures(start, connect, ask, plain):
    """It reads as LeRobot's ZMQCamera does: src/lerobot/cameras/zmq/camera_zmq.py of huggingface/lerobot."""
    words = ["--endpoint", "tcp://127.0.0.1:0", "--publish", "tcp://127.0.0.1:0"]
    bridge = start(PYTHON, LESSON / "lerobot_camera.py", *words)
    endpoint = bridge.wait_for(r"^listening on (\S+)")[1]
    published = bridge.wait_for(r"^publishing on (\S+)")[1]
    camera = connect(published, zmq.SUB, "")
    for number in itertools.count():
        assert ask(endpoint, frame(number, plain, wall_time=12.5)).values["frame"] == number
        if camera.poll(100):
            break
        assert number < 200, "nothing is published"
    data = json.loads(camera.recv_string())
    assert data["timestamps"] == {"center": 12.5}
    file = np.frombuffer(base64.b64decode(data["images"]["center"]), np.uint8)
    # cv2.imdecode gives blue first, and LeRobot says of it that red comes first.
    seen = np.asarray(Image.open(io.BytesIO(file.tobytes())))[:, :, ::-1]
    assert np.abs(seen.astype(int) - plain).mean() < 4


# Everything that can go wrong


def test_a_kill_loses_at_most_the_last_picture(serve, tmp_path, start_client):
    """Of either side, while it records."""
    endpoint, chance = steady_endpoint(), random.Random(8)
    words = ["--count", "100000", "--timeout", "0.3", "--tries", "1000"]
    client = start_client("python", KEY, endpoint, *words)
    for number in (1, 2, 3):
        server, _ = serve(KEY, "--record", "runs", endpoint=endpoint)
        server.wait_for(f"^recording to .*run_000{number}")
        folder = tmp_path / "runs" / f"run_000{number}"
        while len(rows(folder)) < 5:
            time.sleep(0.01)
        time.sleep(chance.random() / 10)
        if number < 3:
            server.kill()
        else:
            client.kill()
            assert server.stop() == 0, server.output
        assert len(check_recording(folder, lost=number < 3)) >= 5


@pytest.mark.parametrize("full", range(5))
def test_nothing_half_written_stays(full, tmp_path, monkeypatch, plain, caplog):
    """The disk is full from the second picture on, at each place where something is written."""
    keeper = Recorder(tmp_path)
    assert keeper.add(frame(1, plain, plain, cameras="left,right"), action(1)) is None
    drive = next(iter(keeper.drives.values()))
    writes = itertools.count()
    real = Path.write_bytes

    class Full:
        def __init__(self, file):
            self.file = file

        def __getattr__(self, name):
            return getattr(self.file, name)

        def write(self, line):
            return self.file.write(line[: len(line) // 2] if next(writes) == full else line)

    def half(path, content):
        if next(writes) == full:
            real(path, content[:100])
            raise OSError(28, "No space left on device")
        return real(path, content)

    monkeypatch.setattr(Path, "write_bytes", half)
    for table in (drive.metadata, drive.log):
        table.file = Full(table.file)
    keeper.add(frame(2, plain, plain, cameras="left,right"), action(2))
    assert [len(rows(drive.folder, name)) for name in ("metadata.csv", "driving_log.csv")] == [1 + (full == 4)] * 2
    assert len(list((drive.folder / "IMG").iterdir())) == 2 * (1 + (full == 4))
    assert ("No space left on device" in caplog.text) == (full < 4)


def test_a_folder_that_cannot_be_written_to_is_named_and_the_recording_stops(tmp_path, caplog):
    (tmp_path / "file").write_text("a file", encoding="utf-8")
    places = [tmp_path / "file"]
    if sys.platform != "win32":
        places.append(tmp_path / "link")
        places[1].symlink_to("/nowhere/at/all")
    for place in places:
        keeper = Recorder(place)
        for number in range(3):
            keeper.add(frame(number), action(number))
        (line,) = caplog.messages
        caplog.clear()
        assert re.match(f"trouble: recording has stopped, the car drives on: .*{place.name}", line)
    assert (tmp_path / "file").read_text(encoding="utf-8") == "a file"


def test_so_many_cars_are_recorded_and_no_more(tmp_path, caplog):
    keeper = Recorder(tmp_path)
    for number in range(3):
        for car in range(MOST_DRIVES + 5):
            keeper.add(frame(number, run=f"car {car}"), action(number))
    folders = list(tmp_path.glob("run_*"))
    assert len(folders) == MOST_DRIVES and all(len(rows(folder)) == 3 for folder in folders)
    assert sum(line.startswith(f"trouble: {MOST_DRIVES} cars") for line in caplog.messages) == 1


def test_numbers_that_go_back_are_recorded_and_none_twice(tmp_path):
    keeper = Recorder(tmp_path)
    for number in (5, 3, 5, 2**53 - 1, 4):
        keeper.add(frame(number), action(number))
    assert [int(row["frame"]) for row in rows(tmp_path / "run_0001")] == [5, 3, 2**53 - 1, 4]


WRONG = {
    "mono for stereo": (frame(7, GREY, cameras="left,right"), "bad-cameras"),
    "stereo for mono": (frame(7, GREY, GREY), "bad-cameras"),
    "no such encoding": (frame(7, GREY, encoding="png"), "bad-encoding"),
    "two sizes": (frame(7, GREY, GREY[::2], cameras="left,right"), "bad-shape"),
    "grey": (frame(7, GREY[:, :, 0]), "bad-shape"),
    "nothing": (frame(7, GREY[:0]), "bad-shape"),
    "floats": (Message("frame", 7, VALUES | {"frame": 7}, [Array("float32", (1, 1, 3), bytes(12))]), "bad-shape"),
    "raw said to be jpeg": (frame(7, GREY, encoding="jpeg"), "bad-shape"),
    "another number": (frame(7, GREY, frame=8), "wrong-frame"),
    "half a number": (frame(7, GREY, frame=7.5), "wrong-type"),
    "no speed": (frame(7, GREY, speed="fast"), "wrong-type"),
    "another kind": (Message("echo", 7), "unknown-kind"),
}


def test_what_is_no_picture_is_refused_by_name_and_the_server_serves_on(serve, ask, context, plain):
    server, endpoint = serve(KEY, "--record", "runs")
    for name, (message, code) in WRONG.items():
        reply = ask(endpoint, message)
        assert (reply.kind, reply.id, reply.values.get("code")) == ("error", 7, code), name
    header, data = frame(7, GREY).frames()
    for frames, code in (
        ([header, bytes(data)[:1000]], "bad-shape"),
        ([header], "bad-frames"),
        ([header.replace(b"8.0", b"NaN"), data], "bad-json"),
        ([header.replace(b"8.0", b"1e999"), data], "bad-value"),
    ):
        reply = Message.read(exchange(context, endpoint, *frames))
        assert reply.values.get("code") == code
    huge = ask(endpoint, frame(8, plain, speed=1e308, steer=-1e308)).values
    assert all(math.isfinite(huge[name]) for name in ("throttle", "brake", "steer"))
    assert server.stop() == 0
    assert "Traceback" not in server.output


@pytest.mark.parametrize("kind", ["raw", "jpeg", "with alpha", "upside down"])
def test_nobody_draws_into_a_picture_that_the_recorder_needs(kind):
    seen = encode(GREY) if kind == "jpeg" else np.dstack([GREY, GREY[..., :1]]) if kind == "with alpha" else GREY
    encoding = "jpeg" if kind == "jpeg" else "raw"
    parts = frame(1, seen, encoding=encoding, bottom_up=kind == "upside down").frames()
    # As received: in memory that could be written.
    (picture,) = pictures(Message.read([bytearray(part) for part in parts])).values()
    with pytest.raises(ValueError, match="read-only"):
        picture[:2] = 0
    assert (picture == GREY).all()


LEROBOT = """
# LeRobot's own names, as 0.4.4 and 0.6.1 have them.
class ZMQCameraConfig:
    def __init__(self, server_address, port=5555, camera_name="zmq_camera", timeout_ms=5000):
        self.words = (server_address, port, camera_name)
class ZMQCamera:
    def __init__(self, config):
        assert config.words == ("127.0.0.1", 5555, "center")
    def connect(self): pass
    def read(self): return __import__("numpy").zeros((240, 320, 3), "uint8")
class LeRobotDataset:
    @classmethod
    def create(cls, repo_id, fps, features, root=None, robot_type=None, use_videos=True):
        made = cls()
        made.features, made.frames, made.fps = features, 0, fps
        return made
    def add_frame(self, frame):
        assert frame.pop("task") and frame.keys() == self.features.keys()
        for name, value in frame.items():
            kind = self.features[name]["dtype"]
            assert value.shape == self.features[name]["shape"] and value.dtype == ("uint8" if kind == "image" else kind)
        self.frames += 1
    def save_episode(self): print("saved", self.frames, "at", self.fps)
    def finalize(self): print("whole")
"""


def test_lerobot_gets_what_the_page_gives_it(tmp_path, plain, start):
    page = guide.blocks(ROOT / "docs" / "guide" / f"{KEY}.md")
    camera, dataset = (block.body for block in page if "test_lerobot_gets" in block.source)
    recorder = Recorder(tmp_path / "runs")
    for number in (1, 2, 3):
        recorder.add(frame(number, plain), action(number))
    if importlib.util.find_spec("lerobot"):
        where = {"PYTHONPATH": str(ROOT / "python"), "HF_HUB_OFFLINE": "1"}
    else:
        for name in ("cameras/zmq.py", "datasets/lerobot_dataset.py"):
            (tmp_path / "lerobot" / name).parent.mkdir(parents=True)
            (tmp_path / "lerobot" / name).write_text(LEROBOT, encoding="utf-8")
        where = {"PYTHONPATH": os.pathsep.join([str(tmp_path), str(ROOT / "python")])}
        eye = start(PYTHON, "-c", camera, folder=tmp_path, **where)
        assert eye.wait() == 0 and eye.lines == ["(240, 320, 3)"], eye.output
    made = start(PYTHON, "-c", dataset, folder=tmp_path, **where)
    assert made.wait() == 0, made.output
    assert importlib.util.find_spec("lerobot") or made.lines == ["saved 2 at 50", "whole"]


def test_a_picture_that_cannot_be_used_is_refused_and_the_others_recorded(tmp_path, serve, ask):
    """One too small to steer by, and one that no JPEG can hold."""
    path = tmp_path / "model.npz"
    np.savez(path, weights=np.zeros(12 * 32 * 3 + 1))
    _, endpoint = serve(KEY, "--model", str(path), "--record", "runs")
    for shape, says in (((3, 3, 3), "too few to steer by"), ((1, 70_000, 3), "uint8 [height, width, 3 or 4]")):
        reply = ask(endpoint, frame(1, np.zeros(shape, np.uint8)))
        assert reply.values["code"] == "bad-shape" and says in reply.values["text"]
    for number in (2, 3):
        assert ask(endpoint, frame(number)).kind == "action"
    assert (tmp_path / "runs" / "run_0001" / "IMG" / "center_000002.jpg").exists()


def test_so_many_pictures_in_a_row_without_an_action_are_given_up(context, caplog):
    """And a picture after them is asked about on a new socket."""
    one = DriverClient(steady_endpoint(), context=context, timeout=0.1, tries=2)
    with pytest.raises(ValueError, match="no picture is asked about"):
        one.receive()
    one.send(Message("frame", 1))
    with pytest.raises(ValueError, match="picture 1 is asked about"):
        one.send(Message("frame", 2))
    socket = one.socket
    assert one.receive() is None and one.asked is None
    assert socket.closed, "a try that failed leaves no socket"
    one.send(Message("frame", 2))
    with pytest.raises(Timeout, match=r"no reply from .* within 0\.2 s; is the server running\?"):
        one.receive()
    assert [line[:15] for line in caplog.messages] == ["trouble: no rep"]


def test_where_there_is_no_pillow_recording_ends_and_driving_goes_on(tmp_path, monkeypatch, caplog):
    monkeypatch.setattr(camera_pictures, "Image", None)
    keeper = Recorder(tmp_path)
    for _ in range(2):
        keeper.add(frame(1), action(1))
    (line,) = caplog.messages
    assert line.startswith("trouble: recording has stopped, the car drives on: JPEG needs Pillow")
    with pytest.raises(MessageError, match=r"^no-pillow: JPEG needs Pillow: pip install pillow"):
        camera_pictures.decode(b"")


# JPEG files that no camera wrote are refused before they cost time


def jpeg(width, height, name="JPEG", mode="RGB", **more):
    file = io.BytesIO()
    Image.new(mode, (width, height)).save(file, name, **more)
    return file.getvalue()


def claiming(width, height):
    """A small file whose header claims an enormous picture."""
    data = bytearray(jpeg(8, 8))
    at = data.index(b"\xff\xc0") + 5
    data[at : at + 4] = struct.pack(">HH", height, width)
    return bytes(data)


def slow(scans, size=4096):
    """A progressive JPEG with so many scans that say nothing, each of which costs a pass over the whole picture."""
    data = bytearray(jpeg(8, 8, progressive=True))
    at = data.index(b"\xff\xc2") + 5
    data[at : at + 4] = struct.pack(">HH", size, size)
    # Its only code, a bit 0, says that in 2**14 blocks and as many as the next 14 bits say all is as it was.
    table = b"\xff\xc4" + struct.pack(">HB16BB", 20, 0x10, 1, *[0] * 15, 0xE0)
    bits = ("0" + "10" * 7) * (size * size // 64 // 27_306 + 1)
    bits += "0" * (-len(bits) % 8)
    nothing = int(bits, 2).to_bytes(len(bits) // 8, "big").replace(b"\xff", b"\xff\0")
    scan = b"\xff\xda" + struct.pack(">HBBBBBB", 8, 1, 1, 0, 1, 63, 0) + nothing
    return bytes(data[: data.index(b"\xff\xda")]) + table + scan * scans + b"\xff\xd9"


def notes(count):
    """A small JPEG with so many notes of applications before its pixels; Pillow puts them together one by one."""
    data = jpeg(8, 8)
    return data[:2] + b"\xff\xe1\x00\x09Exif\0\0x" * count + data[2:]


JPEGS = {
    "60,000 scans": (lambda: slow(60_000), "too-big"),
    "3,000,000 notes": (lambda: notes(3_000_000), "too-big"),
    "padding": (lambda: b"\xff\xd8" + b"\xff" * 60_000_000, "bad-jpeg"),
    "marks without an end": (lambda: b"\xff\xd8" + b"\xff\xd0" * 30_000_000, "bad-jpeg"),
    "ten scans": (lambda: slow(10), None),
    "ten notes": (lambda: notes(10), None),
    "its beginning": (lambda: b"\xff\xd8\xff", "bad-jpeg"),
    "other bytes": (lambda: b"x" * 5000, "bad-jpeg"),
    "cut off": (lambda: jpeg(64, 64)[:-200], "bad-jpeg"),
    "a PNG": (lambda: jpeg(8, 8, "PNG"), "bad-jpeg"),
    "a bomb": (lambda: claiming(60_000, 60_000), "bad-jpeg"),
    # Arithmetic coding, which takes ten times as long to decode, is not even begun.
    "what no camera writes": (lambda: jpeg(64, 64).replace(b"\xff\xc0", b"\xff\xc9"), "bad-jpeg: .* not in order"),
    "a large one": (lambda: claiming(6_000, 6_000), "too-big"),
    "a good one": (lambda: jpeg(8, 8), None),
    "grey": (lambda: jpeg(8, 8, mode="L"), None),
    "CMYK": (lambda: jpeg(8, 8, mode="CMYK"), None),
}


@pytest.mark.parametrize(("make", "why"), JPEGS.values(), ids=JPEGS.keys())
@pytest.mark.timeout(60)
def test_a_jpeg_of_every_sort(make, why):
    """One that would take a minute or more ends at the test's limit."""
    seen = frame(5, make(), encoding="jpeg")
    if why is None:
        assert pictures(seen)["center"].shape[2] == 3
        return
    with pytest.raises(MessageError, match=f"^{why}") as refusal:
        pictures(seen)
    assert len(refusal.value.text) < 300


# Values of one's own go with a picture and come with an action, each said in one place; `drive` gets all pictures and
# all telemetry; and a recording has columns for them. The blocks are the page's.


# Else several pictures are on their way before the first action comes.
LOCKSTEP = ["--lockstep", "true"]
SCRIPTS = ROOT / "unity" / "Assets" / "NetMQExample" / KEY
BLOCKS = [block for block in guide.blocks(ROOT / "docs" / "guide" / f"{KEY}.md") if block.body]
(CAR,) = (block.body for block in BLOCKS if "class MyCar" in block.body)
(MEMBERS,) = (block.body for block in BLOCKS if "void Telemetry" in block.body)
BOXES, DETECTOR = (block.body for block in BLOCKS if "test_a_detector_of_ones_own" in block.source)
(ADDED,) = (block.body for block in BLOCKS if '"zoom"' in block.body and block.language == "python")


def test_a_value_each_way(serve_own, ask, tmp_path, start, console, netmq):
    zoom = """Debug.Log($"zoom {action.Value("zoom", 1)}");"""
    more = """
        Debug.Log($"{action.Value("lamp")} {action.Value("no", 3)} {action.Value("text", 4)}{action.Text("lamp")}");"""
    members = MEMBERS.replace(zoom, zoom + more)
    scripts = {"MyCar.cs": CAR.replace(": DrivenBehaviour", ": ElectricCar"), "ElectricCar.cs": members}
    for name, text in scripts.items():
        (tmp_path / name).write_text(text, encoding="utf-8")
    server, endpoint = serve_own(KEY, ADDED.replace('"go"', '"go", "lamp": True'), "--record", "runs")
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
    found = list(recording.recorded(tmp_path / "run_0001"))
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
    assert [row.values.get("battery") for row in recording.recorded(tmp_path / "run_0001")] == [1, None, None]


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
