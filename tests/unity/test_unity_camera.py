"""Lesson 08 in the player: what only Unity has. Real cameras look at the scene, and a graphics card gives their
pictures back some frames later. tests/lessons/test_08_drive.py has what is the same for all clients.
"""

from __future__ import annotations

import hashlib
import io
import re
import threading
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest
import zmq

from kitlib.setup import dotnet
from tests.programs import ROOT, Program, leaves_nothing_to_collect, steady_endpoint
from tests.unity.test_unity_play import RUNTIMES, needs_mono

np = pytest.importorskip("numpy", reason="lesson 08 needs numpy: pip install numpy")
from tests.lessons.test_08_drive import Driver, Message, read, world  # noqa: E402

on_each_runtime = pytest.mark.parametrize("runtime", RUNTIMES)


@pytest.fixture(scope="session")
def harness(netmq: dotnet.NetMQ) -> Path:
    return dotnet.build(netmq, ROOT / "tests" / "unity" / "play")


@pytest.fixture
def drive(
    netmq: dotnet.NetMQ, harness: Path, start: Callable[..., Program]
) -> Iterator[Callable[..., tuple[Driver, Program]]]:
    """Plays tests/unity/play/Drives.cs against a driver: drive(answer, "count=10", runtime=".net")."""
    with zmq.Context() as context:
        drivers: list[Driver] = []

        def play(answer: Callable[[Any], Any], *words: str, runtime: str = ".net") -> tuple[Driver, Program]:
            if runtime == "mono":
                needs_mono()
            drivers.append(Driver(context, answer))
            program = {"mono": "mono", ".net": "dotnet"}[runtime]
            # Patient: an answer that comes too late, on a busy machine, counts here and not there.
            words = ("every=0", "tries=100", "timeout=60", f"endpoint={drivers[-1].endpoint}", *words)
            return drivers[-1], start(program, harness, "drive", *words)

        yield play
        for one in drivers:
            one.over.set()
            one.join()


def picture(frame: Any, camera: int = 0) -> Any:
    """Red, green and blue of each pixel, the top row first."""
    assert frame.values["bottom_up"] is True and frame.values["encoding"] == "raw"
    array = frame.arrays[camera]
    return np.frombuffer(bytes(array.data), np.uint8).reshape(240, 320, 4)[::-1, :, :3].astype(int)


def is_road(pixels: Any) -> Any:
    """Grass is green; neither tarmac nor paint is."""
    return pixels[..., 1] <= pixels[..., 0] + 10


@on_each_runtime
def test_the_car_goes_where_pythons_goes(runtime: str, drive: Callable[..., Any]) -> None:
    """Each place is compared to the last bit with that of a car of the test's own, and the picture is Unity's."""
    road = world.Road()
    car, places = world.Car.on(road), []

    def answer(frame: Any) -> dict[str, float]:
        number = len(places)
        action = {"throttle": 0.8, "brake": 0.3 if number % 60 < 5 else 0.0, "steer": (number % 7 - 3) / 10}
        car.step(**action)
        places.append((float(car.x), float(car.y)))
        return action

    _, client = drive(answer, "count=300", "lockstep=true", "positions", runtime=runtime)
    assert client.wait() == 0, client.output
    assert "done: 300 actions, 0 pictures skipped" in client.lines, client.lines[-3:]
    found = re.findall(r"^at (\d+) (\S+) (\S+) (True|False)$", client.output, re.MULTILINE)
    assert [(float(x), float(y)) for number, x, y, _ in found if number != "0"] == places
    assert all(stands == "True" for *_, stands in found), "the object is where the drive's car is"


@on_each_runtime
def test_a_lap_by_what_the_camera_sees(
    runtime: str, netmq: dotnet.NetMQ, harness: Path, serve: Callable[..., Any], start: Callable[..., Program]
) -> None:
    """The road is some 300 m long, and nobody but the camera tells the lesson's own server where it is.

    In lock-step: else a busy machine steers by what was seen a second ago, and leaves the road.
    """
    if runtime == "mono":
        needs_mono()
    endpoint = serve("08_see_and_steer")[1]
    program = {"mono": "mono", ".net": "dotnet"}[runtime]
    words = ["every=0", "count=2200", "positions", "lockstep=true", "timeout=60"]
    client = start(program, harness, "drive", f"endpoint={endpoint}", *words)
    assert client.wait(500) == 0, client.output[-2000:]
    road = world.Road()
    found = re.findall(r"^at \d+ (\S+) (\S+) ", client.output, re.MULTILINE)
    near = [road.nearest(float(x), float(y)) for x, y in found[::5]]
    assert max(off for _, off in near) < world.HALF_WIDTH
    assert {at // 200 for at, _ in near} == set(range(10)), "all corners of the road"


def test_a_picture_is_upright_whatever_the_graphics_card_does(drive: Callable[..., Any]) -> None:
    """The same pictures where the card has the highest row first, and where it reads back only while Unity waits."""
    digests = []
    for words in ([], ["topfirst"], ["noreadback"], ["topfirst", "noreadback"]):
        driver, client = drive(lambda frame: {"steer": 0.3}, "count=30", "lockstep=true", *words)
        assert client.wait() == 0, client.output
        said = "pictures come with the highest row first here: they are turned over" in client.lines
        assert said == ("topfirst" in words), client.output
        digests.append(hashlib.sha256(b"".join(bytes(frame.arrays[0].data) for frame in driver.frames)).hexdigest())
        seen = picture(driver.frames[-1])
        assert (seen[0] == (150, 190, 230)).all(), "the sky"
        assert not (seen[-1] == (150, 190, 230)).all(axis=1).any() and is_road(seen[-1]).any(), "the ground"
    assert len(set(digests)) == 1


@on_each_runtime
def test_what_is_written_beside_a_picture_belongs_to_it(runtime: str, drive: Callable[..., Any]) -> None:
    """It arrives two frames after it was rendered: the sky says when that was."""
    driver, client = drive(lambda frame: {}, "count=100", "cameras=left,right", "numbered", runtime=runtime)
    assert client.wait() == 0, client.output
    numbers = [frame.id for frame in driver.frames]
    # The first ones may have been rendered before the sky was told its number.
    for frame in driver.frames[5:]:
        for camera in range(2):
            red, green, blue = picture(frame, camera)[0, 0]
            assert (red + 256 * green, blue) == (frame.values["frame"], 200)
    assert len(set(numbers)) == 100 and numbers == sorted(numbers)
    skipped = int(client.wait_for(r"^done: 100 actions, (\d+) pictures skipped$")[1])
    assert skipped == numbers[-1] - numbers[0] + 1 - 100


def test_two_cameras_see_as_two_eyes(drive: Callable[..., Any]) -> None:
    """In the left one's picture all stands further to the right, and the more so the nearer it is."""
    driver, client = drive(lambda frame: {}, "count=3", "cameras=left,right", "lockstep=true")
    assert client.wait() == 0, client.output

    def right_edge(camera: int, row: int) -> float:
        return float(np.flatnonzero(is_road(picture(driver.frames[0], camera)[row]))[-1])

    # 0.15 m, seen from 5 m: some 6 of 208 pixels, which are as wide as they are far away.
    near, far = (right_edge(0, row) - right_edge(1, row) for row in (130, 90))
    assert near > far >= 1


def test_jpeg_is_made_of_the_same_picture(drive: Callable[..., Any]) -> None:
    images = pytest.importorskip("PIL.Image", reason="reads a JPEG file")
    driver, client = drive(lambda frame: {}, "count=3", "jpeg=true", "lockstep=true")
    assert client.wait() == 0, client.output
    frame = driver.frames[0]
    assert (frame.values["encoding"], frame.values["bottom_up"]) == ("jpeg", False)
    seen = np.asarray(images.open(io.BytesIO(bytes(frame.arrays[0].data))).convert("RGB")).astype(int)
    assert seen.shape == (240, 320, 3)
    assert abs(seen[4, 160] - (150, 190, 230)).max() < 25 and is_road(seen[236, 160])


@pytest.mark.parametrize("mode", ["lockstep=true", "lockstep=false"])
def test_an_error_of_the_graphics_card_is_said_once(mode: str, drive: Callable[..., Any]) -> None:
    _, client = drive(lambda frame: {}, "count=80", "fail=20", mode)
    assert client.wait() == 0, client.output
    trouble = [line for line in client.lines if "graphics card" in line]
    assert trouble == ["trouble: the graphics card gave no picture"]
    assert client.lines.index("pictures again") > client.lines.index(trouble[0])
    client.wait_for("^done: 80 actions")


def test_without_a_graphics_card_it_says_so(drive: Callable[..., Any]) -> None:
    _, client = drive(lambda frame: {}, "nographics")
    assert client.wait() == 1
    gave_up = [line for line in client.lines if line.startswith("gave up")]
    assert gave_up == ["gave up: a camera needs a graphics card: start Unity without -nographics"]


@on_each_runtime
def test_a_person_takes_over_and_gives_back(runtime: str, drive: Callable[..., Any]) -> None:
    # In lock-step each step has a picture, and none has a dozen steps to itself on a busy machine.
    driver, client = drive(lambda frame: {"steer": 0.25}, "count=300", "press=60", "lockstep=true", runtime=runtime)
    assert client.wait() == 0, client.output
    said = [line for line in client.lines if line.endswith(" drives")]
    assert said == ["a person drives", "Python drives"]
    by_hand = [frame.values for frame in driver.frames if frame.values["manual"]]
    assert (by_hand[10]["steer"], by_hand[10]["throttle"]) == (-0.5, 1), "both pressed"
    assert (by_hand[-1]["steer"], by_hand[-1]["throttle"]) == (0, 0), "let go, and not yet given back"
    assert driver.frames[-1].values["steer"] == 0.25


def test_a_sender_that_was_switched_off_begins_again(drive: Callable[..., Any]) -> None:
    driver, client = drive(lambda frame: {}, "count=60", "disable=30")
    assert client.wait() == 0, client.output
    assert sum(line.startswith("asking ") for line in client.lines) == 2
    assert "trouble: the graphics card gave no picture" not in client.lines
    client.wait_for("^done: 60 actions")
    numbers = [frame.id for frame in driver.frames]
    assert len(set(numbers)) == len(numbers) == numbers.index(max(numbers)) + 1, "each picture is newer than the last"


def test_a_camera_of_ones_own_is_the_eye(drive: Callable[..., Any]) -> None:
    """It is seen with, also when the sender begins again, and goes on showing the game itself."""
    driver, client = drive(lambda frame: {}, "count=60", "cameras=left,right", "disable=30", "eye")
    assert client.wait() == 0, client.output
    client.wait_for("^done: 60 actions")
    client.wait_for("^the eye goes on as it was: True$")
    assert all((picture(frame, camera) == (200, 0, 0)).all() for frame in driver.frames for camera in range(2))


def test_size_and_rate_are_the_cars(drive: Callable[..., Any]) -> None:
    """A picture for each five of the world's steps, or later; those that another one has overtaken are skipped."""
    driver, client = drive(lambda frame: {}, "count=12", "width=64", "height=48", "steps=5")
    assert client.wait() == 0, client.output
    assert {tuple(frame.arrays[0].shape) for frame in driver.frames} == {(48, 64, 4)}
    apart = [late.id - early.id for early, late in zip(driver.frames, driver.frames[1:], strict=False)]
    assert min(apart) >= 5
    client.wait_for(f"^done: 12 actions, {sum(each // 5 - 1 for each in apart)} pictures skipped$")


def answer_at(context: zmq.Context[Any], endpoint: str, over: threading.Event, speeds: list[float], most: int) -> None:
    with context.socket(zmq.REP) as socket:
        socket.linger = 0
        socket.bind(endpoint)
        while not over.is_set() and len(speeds) < most:
            if socket.poll(50):
                frame = read(socket.recv_multipart())
                speeds.append(frame.values["speed"])
                action = {"frame": frame.id, "throttle": 1.0, "brake": 0.0, "steer": 0.0}
                socket.send_multipart(Message("action", frame.id, action).frames())


def test_a_driver_that_goes_and_comes_back(start: Callable[..., Program], harness: Path) -> None:
    """Another one takes its place on the same port: the car has braked, and drives on."""
    endpoint = steady_endpoint()
    client = start("dotnet", harness, "drive", f"endpoint={endpoint}", "every=0", "count=200", "timeout=0.4")
    speeds: list[list[float]] = [[], []]
    with zmq.Context() as context:
        for there in speeds:
            over = threading.Event()
            # The first one is gone after 50, however late this thread notices.
            most = 50 if there is speeds[0] else 10_000
            thread = threading.Thread(target=answer_at, args=(context, endpoint, over, there, most), daemon=True)
            begin = len(client.lines)
            thread.start()
            if there is speeds[0]:
                while len(there) < 50:
                    assert client.process.poll() is None, client.output
                    time.sleep(0.01)
                over.set()
                thread.join()
                # On a busy machine the car may have braked before.
                drove = [i for i, line in enumerate(client.lines) if line == "an action again: driving on"]
                begin = max(drove, default=0)
                client.wait_for("^trouble: no reply from .* within 0.4 s; is the server running", start=begin)
                client.wait_for("^trouble: no action for 0.5 s: braking$", start=begin)
        client.wait_for("^an action again: driving on$", start=begin)
        assert client.wait() == 0, client.output
        over.set()
        thread.join()
    client.wait_for("^done: 200 actions")
    # An action that came too late is none.
    assert len(speeds[0]) + len(speeds[1]) >= 200
    assert max(speeds[1][-50:]) > 5


@pytest.mark.xdist_group("times")
@pytest.mark.parametrize("cameras", ["center", "left,right"])
def test_what_a_frame_costs(
    cameras: str, drive: Callable[..., Any], capsys: pytest.CaptureFixture[str], pytestconfig: pytest.Config
) -> None:
    """The main thread's share but for rendering, which is the graphics card's; every picture is 320 x 240, raw.

    60 a second: five seconds of them, and with --long a minute.
    """
    frames = 3600 if pytestconfig.getoption("--long") else 300
    _, client = drive(lambda frame: {}, f"frames={frames}", "count=100000", f"cameras={cameras}")
    assert client.wait(120) == 0, client.output
    cost = client.wait_for("^cost: .*")[0]
    with capsys.disabled():
        print(f"\n{cameras}: {cost}")
    assert leaves_nothing_to_collect(cost), cost


@pytest.mark.parametrize("words", [[], ["topfirst"], ["noreadback"], ["topfirst", "noreadback"]], ids=" ".join)
def test_a_view_is_upright_and_leaves_nothing(words: list[str], harness: Path, start: Callable[..., Program]) -> None:
    """Its camera sees one layer, on which nothing is by itself; and a new picture can go where the last one was."""
    program = start("dotnet", harness, "cameras", *words)
    assert program.wait() == 0, program.output
    for shape, red, blue in (("7, 3", "200 0 0", "0 0 200"), ("7", "60", "23")):
        program.wait_for(rf"^\[4, {shape}\]: " + " ".join([red] * 14 + [blue] * 14) + "$")
    # The red of its world, and what the next picture is read into.
    left = sorted(program.wait_for("^left: (.*)$")[1].split())
    assert left == ["Material:0.78,0.00,0.00", *(["Texture2D"] if "noreadback" in words else [])]
    looks, allocated = map(int, program.wait_for(r"^cost: (\d+) frames: .* (\d+) bytes allocated").groups())
    assert allocated < 1000 * looks


def test_a_sensor_that_is_started_twice_is_one(harness: Path, start: Callable[..., Program]) -> None:
    program = start("dotnet", harness, "cameras")
    assert program.wait() == 0, program.output
    assert [line for line in program.lines if line.startswith(("the eye", "sensors"))] == [
        "the eye draws: False",
        "sensors: 1",
        "sensors: 0",
    ]
