"""Lesson 12: films of the lesson's own drive; the games' messages; and faults of both sides. The films
of a script are in test_12_films.py. Unity's views send as those of the terminal do.
"""

import importlib
import itertools
import signal
import sys
import time
from pathlib import Path

import pytest
import zmq

from tests.conftest import CLIENTS
from tests.programs import LIMIT, PATIENT, ROOT, steady_endpoint

np = pytest.importorskip("numpy", reason="lesson 12 needs numpy: kit.py run 12 installs it")
Image = pytest.importorskip("PIL.Image", reason="lesson 12 needs Pillow: kit.py run 12 installs it")
av = pytest.importorskip("av", reason="lesson 12 needs av: kit.py run 12 installs it")

KEY = "12_video"
from netmq_example.messages import Array, Message  # noqa: E402

sys.path.append(str(ROOT / "python" / KEY))
self_driving = importlib.import_module("self_driving")
SelfDriving, scaled = self_driving.SelfDriving, self_driving.scaled
each_terminal = pytest.mark.parametrize("kind", [kind for kind in CLIENTS if kind != "unity"])
SKY, GRASS = (150, 190, 230), (70, 120, 50)


def shown(path):
    """A film as Pillow or PyAV reads it: its pictures, and for how many milliseconds each is shown."""
    if Path(path).suffix == ".gif":
        pictures, times = [], []
        with Image.open(path) as film:
            for number in range(film.n_frames):
                film.seek(number)
                film.load()
                pictures.append(np.asarray(film.convert("RGB")))
                times.append(film.info["duration"])
        return pictures, times
    with av.open(path) as film:
        frames = list(film.decode(video=0))
        times = [1000 * float(frame.time) for frame in frames]
        # A film that was killed does not say when its last picture was over.
        times.append(max(times[-1], (film.duration or 0) / 1000))
    return [frame.to_ndarray(format="rgb24") for frame in frames], np.diff(times).tolist()


def close_to(pixels, colour):
    """An MP4 has some loss."""
    return (np.abs(pixels.astype(int) - colour) <= 12).all(axis=-1)


def growing(path, size=0):
    """Waits until a file has more bytes than that, and returns how many."""
    end = time.monotonic() + LIMIT
    while not path.exists() or path.stat().st_size <= size:
        assert time.monotonic() < end, f"{path} does not grow"
        time.sleep(0.01)
    return path.stat().st_size


# The lesson's own drive


def test_a_drive_becomes_two_films(serve, start_client, tmp_path):
    # Long enough for a car that has moved, on a machine that has other work.
    server, endpoint = serve(KEY, "--seconds", "5", "--fps", "3")
    # So many steps, and more if the films are not made by then.
    client = start_client("csharp", KEY, endpoint, "--count", "100", *PATIENT)
    assert client.wait() == 0, client.output
    assert int(client.wait_for(r"^done: (\d+) steps$")[1]) >= 100
    for view, sky, first in (("front", True, SKY), ("map", False, GRASS)):
        begun = server.wait_for(rf"^begin {view} 320 x 240$")
        line = server.wait_for(rf"^film {view}_1\.mp4: (\d+) frames, (\S+) s, (\d+) skipped$")
        assert f"{view}: {line[1]} pictures, {line[3]} skipped" in client.lines, begun
        pictures, times = shown(tmp_path / f"{view}_1.mp4")
        assert len(pictures) == int(line[1]) >= 2
        assert sum(times) == pytest.approx(1000 * float(line[2]), abs=60)
        assert float(line[2]) <= 60
        for picture in pictures:
            assert close_to(picture[30, 160], first) and picture.shape == (240, 320, 3)
            # In the one the sky is above the road, in the other there is none.
            assert close_to(picture, SKY).any() == sky
    assert not np.array_equal(pictures[0], pictures[-1]), "the car drives"


class Filmer:
    """Python's side, of the test's own making: a ROUTER that says what it likes."""

    def __init__(self, context):
        self.socket = context.socket(zmq.ROUTER)
        self.socket.linger = 0
        self.endpoint = f"tcp://127.0.0.1:{self.socket.bind_to_random_port('tcp://127.0.0.1')}"
        self.peer, self.ids = b"", itertools.count(1)

    def next(self, *kinds):
        end = time.monotonic() + LIMIT
        while time.monotonic() < end:
            if self.socket.poll(100):
                peer, *frames = self.socket.recv_multipart()
                message = Message.read(frames)
                if message.kind == "hello":
                    self.peer = peer
                if message.kind in kinds:
                    return message
        raise AssertionError(f"no {kinds} came")

    def say(self, kind, id=None, **values):
        id = next(self.ids) if id is None else id
        self.socket.send_multipart([self.peer, *Message(kind, id, values).frames()])
        return id

    def greet(self):
        hello = self.next("hello")
        self.say("welcome", hello.id)
        return dict(zip(hello.values["views"].split(","), hello.arrays[0].numpy().tolist(), strict=True))

    def begin(self, view, **values):
        id = self.say("begin", **{"view": view, "width": 0, "height": 0, "fps": 100.0, **values})
        answer = self.next("begun", "error")
        assert answer.id == id
        return answer

    def refused(self, **values):
        answer = self.begin(**values)
        return f"{answer.values['code']}: {answer.values['text']}"


@pytest.fixture
def filmer(context):
    one = Filmer(context)
    yield one
    one.socket.close()


@each_terminal
def test_a_python_that_leaves_behind_each_welcome_is_not_asked_at_once(kind, filmer, start_client):
    """It was asked 300 times a second, with a line each."""
    start_client(kind, KEY, filmer.endpoint)
    end = None
    hellos = 0
    while not end or time.monotonic() < end:
        filmer.greet()
        filmer.say("close")
        hellos += 1
        end = end or time.monotonic() + 1
    assert hellos < 10


@each_terminal
def test_pictures_are_equal_to_the_byte(kind, filmer, start_client):
    """With those of a drive of the test's own, at the step whose number is drawn into the front view."""
    start_client(kind, KEY, filmer.endpoint, "--count", "0")
    assert filmer.greet() == {"front": [320, 240], "map": [320, 240]}
    drive, maps = SelfDriving(), []
    for view, size in (("front", (320, 240)), ("map", (107, 80))):
        begun = filmer.begin(view, width=size[0], height=size[1])
        last = 0.0
        for number in range(1, 6):
            frame = filmer.next("frame")
            assert (frame.id, frame.values["view"], frame.values["bottom_up"]) == (begun.id, view, True)
            assert frame.values["number"] >= number and frame.values["time"] >= last
            last = frame.values["time"]
            pixels = frame.arrays[0].numpy()
            filmer.say("took", begun.id, view=view, number=frame.values["number"])
            if view == "front":
                step = int("".join("1" if pixels[-1, 8 * bit, 0] else "0" for bit in range(16)), 2)
                while drive.steps < step:
                    drive.step()
                    maps.append(scaled(drive.map(), 107, 80).tobytes())
                assert np.array_equal(pixels, drive.front())
            else:
                while pixels.tobytes() not in maps:
                    assert drive.steps < 3000, "a map of no step"
                    drive.step()
                    maps.append(scaled(drive.map(), 107, 80).tobytes())
        filmer.say("end", view=view)
        filmer.next("ended")


@each_terminal
def test_two_pictures_are_on_the_way_and_the_game_goes_on(kind, filmer, start_client):
    start_client(kind, KEY, filmer.endpoint, "--count", "0")
    filmer.greet()
    # In the first pause a busy machine may see too few pictures.
    for pause in (600, 6_000, 60_000):
        begun = filmer.begin("front")
        first, second = (filmer.next("frame", "ended") for _ in range(2))
        assert [first.kind, second.kind] == ["frame", "frame"]
        # A game does not believe that pictures were taken which never came.
        for number in range(100_000, 100_020):
            filmer.say("took", begun.id, view="front", number=number)
        assert not filmer.socket.poll(pause), "a third picture"
        filmer.say("took", begun.id, view="front", number=first.values["number"])
        third = filmer.next("frame")
        assert third.values["number"] > second.values["number"]
        end = filmer.say("end", view="front")
        for frame in (second, third):
            filmer.say("took", begun.id, view="front", number=frame.values["number"])
        while (message := filmer.next("frame", "ended")).kind == "frame":
            last = message.values["number"]
        values = message.values
        assert message.id == end
        assert values["frames"] <= 7, "two sent, one more, and four that waited"
        assert values["frames"] + values["skipped"] >= last
        assert values["time"] > 0.5
        if values["skipped"] >= 10:
            break
    assert values["skipped"] >= 10


@each_terminal
def test_pictures_on_demand_and_what_is_refused_with_its_cure(kind, filmer, start_client):
    start_client(kind, KEY, filmer.endpoint, "--count", "0")
    filmer.greet()
    begun = filmer.begin("front", fps=0.0)
    assert begun.kind == "begun" and not filmer.socket.poll(300), "none by itself"
    for number in range(1, 4):
        filmer.say("look", view="front")
        assert filmer.next("frame").values["number"] == number
        filmer.say("took", begun.id, view="front", number=number)
    filmer.say("end", view="front")
    assert filmer.next("ended").values["frames"] == 3
    assert filmer.refused(view="side") == "unknown-view: there is no view 'side'; there are: front, map"
    for wrong in ({"width": 321}, {"height": -1}, {"width": 2**40}):
        assert filmer.refused(view="map", **wrong) == "bad-size: map is at most 320 x 240"
    for rate in (-1.0, 1001.0):
        refused = filmer.refused(view="map", fps=rate)
        assert refused == "bad-rate: fps is at most 1000, and 0 for pictures on demand alone"
    for request in ("end", "look"):
        filmer.say(request, view="map")
        assert filmer.next("error").values["code"] == "not-filmed"
    assert filmer.begin("map", fps=1.0).kind == "begun"
    assert filmer.refused(view="map") == "busy-view: map is being filmed already: end that film first"
    # Half a message: its array is missing. The game says hello again, with a new socket.
    peer, half = filmer.peer, Message("begin", 1, {"view": "map"}, [Array("uint8", (1,), b"x")]).frames()[:1]
    filmer.socket.send_multipart([peer, *half])
    filmer.greet()
    assert filmer.peer != peer
    assert filmer.begin("map").kind == "begun", "the film before it is over"


# Faults


@each_terminal
def test_python_is_killed_and_comes_back(kind, serve, start_client, tmp_path):
    endpoint = steady_endpoint()
    server, _ = serve(KEY, "--seconds", "60", "--view", "front", endpoint=endpoint)
    client = start_client(kind, KEY, endpoint, "--count", "0")
    film = tmp_path / "front_1.mp4"
    for _ in range(4):
        growing(film, film.stat().st_size if film.exists() else 0)
    server.kill()
    pictures, times = shown(film)
    assert len(pictures) >= 3 and max(times) > 0, "it plays"
    # A client that was about to send just then says the latter.
    client.wait_for("^trouble: (Python is gone|no connection): no more pictures are taken$")
    again, _ = serve(KEY, "--seconds", "1", "--view", "front", endpoint=endpoint)
    again.wait_for(r"^film front_2\.mp4: [1-9]")
    assert len([line for line in client.lines if line.startswith("trouble")]) == 1
    assert len(shown(film)[0]) == len(pictures), "nothing is written over"


def test_the_game_is_killed_and_another_one_comes(serve, start_client, tmp_path):
    server, endpoint = serve(KEY, "--seconds", "60", "--view", "map")
    client = start_client("python", KEY, endpoint, "--count", "0")
    film = tmp_path / "map_1.mp4"
    for _ in range(3):
        growing(film, film.stat().st_size if film.exists() else 0)
    client.kill()
    line = server.wait_for(r"^trouble: the game is gone; film map_1\.mp4: (\d+) frames")
    pictures, times = shown(film)
    assert len(pictures) == int(line[1]) >= 2 and sum(times) > 0
    said = len(server.lines)
    start_client("python", KEY, endpoint, "--count", "0")
    for number in range(2, 7):
        film = tmp_path / f"map_{number}.mp4"
        server.wait_for("^begin map ", start=said)
        growing(film, film.stat().st_size if film.exists() else 0)
        assert server.stop() == 0
        assert shown(film)[0]
        # On a busy machine the game may not answer within the second that is left for it, and is tried once more.
        if not server.lines[-1].startswith("trouble: the game is gone; "):
            break
        said, (server, _) = 0, serve(KEY, "--seconds", "60", "--view", "map", endpoint=endpoint)
    assert server.lines[-1].startswith(f"film map_{number}.mp4: "), "the server ends its film"


@pytest.mark.skipif(sys.platform == "win32", reason="Windows has no Ctrl-C for another program")
def test_ctrl_c_does_not_wait_for_python(start_client, filmer):
    client = start_client("python", KEY, filmer.endpoint, "--timeout", "600")
    # Which is never answered.
    filmer.next("hello")
    assert client.stop(signal.SIGINT) == 1
    assert client.lines[-1] == "stopped"
