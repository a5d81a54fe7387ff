"""Lesson 08 in the player: what only Unity has. Real cameras look at the scene, and a graphics card gives their
pictures back some frames later. tests/lessons/test_08_drive.py has what is the same for all clients.
"""

import contextlib
import hashlib
import re
from collections.abc import Callable

import pytest
import zmq

from tests.programs import Program, leaves_nothing_to_collect
from tests.unity.conftest import NEAREST

np = pytest.importorskip("numpy", reason="lesson 08 needs numpy: pip install numpy")
from netmq_example.worlds import road as world  # noqa: E402
from tests.lessons.test_08_drive import Driver, driving  # noqa: E402

Drive = Callable[..., tuple[Driver, Program]]


@pytest.fixture
def drive(play):
    """Plays tests/unity/play/Drives.cs against a driver: drive(answer, "count=10", …)."""
    with zmq.Context() as context, contextlib.ExitStack() as drivers:

        def start(answer, *each, runtime="dotnet"):
            driver = drivers.enter_context(driving(context, answer))
            # Patient: an answer that comes too late, on a busy machine, counts here and not there.
            patient = f"every=0 tries=100 timeout=60 endpoint={driver.endpoint}"
            words = " -- ".join(f"{patient} {one}" for one in each)
            return driver, play("drive", *words.split(), runtime=runtime)

        yield start


def picture(frame, camera=0):
    """Red, green and blue of each pixel, the top row first."""
    assert frame.values["bottom_up"] is True and frame.values["encoding"] == "raw"
    array = frame.arrays[camera]
    return np.frombuffer(bytes(array.data), np.uint8).reshape(240, 320, 4)[::-1, :, :3].astype(int)


def is_road(pixels):
    """Grass is green; neither tarmac nor paint is."""
    return pixels[..., 1] <= pixels[..., 0] + 10


def test_the_car_goes_where_pythons_goes(drive):
    """Each place is compared to the last bit with that of a car of the test's own, and the picture is Unity's."""
    road = world.Road()
    car, places = world.Car.on(road), []

    def answer(frame):
        number = len(places)
        action = {"throttle": 0.8, "brake": 0.3 if number % 60 < 5 else 0.0, "steer": (number % 7 - 3) / 10}
        car.step(**action)
        places.append((float(car.x), float(car.y)))
        return action

    _, client = drive(answer, "count=100 lockstep=true positions", runtime=NEAREST)
    assert client.wait() == 0, client.output
    assert "done: 100 actions, 0 pictures skipped" in client.lines, client.lines[-3:]
    found = re.findall(r"^at (\d+) (\S+) (\S+) (True|False)$", client.output, re.MULTILINE)
    assert [(float(x), float(y)) for number, x, y, _ in found if number != "0"] == places
    assert all(stands == "True" for *_, stands in found), "the object is where the drive's car is"


def test_a_picture_is_upright_whatever_the_graphics_card_does(drive):
    """The same pictures where the card has the highest row first, and where it reads back only while Unity waits."""
    cards = ["", "topfirst", "noreadback", "topfirst noreadback"]
    driver, client = drive(lambda frame: {"steer": 0.3}, *(f"count=3 lockstep=true {card}" for card in cards))
    assert client.wait() == 0, client.output
    assert client.lines.count("pictures come with the highest row first here: they are turned over") == 2
    digests = [hashlib.sha256(bytes(frame.arrays[0].data)).hexdigest() for frame in driver.frames]
    assert len(digests) == 12 and digests == digests[:3] * 4
    seen = picture(driver.frames[0])
    assert (seen[0] == (150, 190, 230)).all(), "the sky"
    assert not (seen[-1] == (150, 190, 230)).all(axis=1).any() and is_road(seen[-1]).any(), "the ground"


def test_what_is_written_beside_a_picture_belongs_to_it(drive):
    """It arrives two frames after it was rendered: the sky says when that was."""
    driver, client = drive(lambda frame: {}, "count=30 cameras=left,right numbered")
    assert client.wait() == 0, client.output
    numbers = [frame.id for frame in driver.frames]
    # The first ones may have been rendered before the sky was told its number.
    for frame in driver.frames[5:]:
        for camera in range(2):
            red, green, blue = picture(frame, camera)[0, 0]
            assert (red + 256 * green, blue) == (frame.values["frame"], 200)
    assert len(set(numbers)) == 30 and numbers == sorted(numbers)
    skipped = int(client.wait_for(r"^done: 30 actions, (\d+) pictures skipped$")[1])
    assert skipped == numbers[-1] - numbers[0] + 1 - 30


def test_trouble_with_the_graphics_card_is_said_once(drive):
    _, client = drive(lambda frame: {}, "count=20 fail=5 lockstep=true", "count=20 fail=5", "nographics")
    assert client.wait() == 1, client.output
    trouble, again = "trouble: the graphics card gave no picture", "pictures again"
    said = [line for line in client.lines if "graphics card" in line or line == again or line.startswith("done")]
    assert [line.split(",")[0] for line in said] == [
        *[trouble, again, "done: 20 actions"] * 2,
        "gave up: a camera needs a graphics card: start Unity without -nographics",
    ]


def test_a_person_takes_over_and_gives_back(drive):
    # In lock-step each step has a picture, and none has a dozen steps to itself on a busy machine.
    driver, client = drive(lambda frame: {"steer": 0.25}, "count=80 press=10 lockstep=true", runtime=NEAREST)
    assert client.wait() == 0, client.output
    said = [line for line in client.lines if line.endswith(" drives")]
    assert said == ["a person drives", "Python drives"]
    by_hand = [frame.values for frame in driver.frames if frame.values["manual"]]
    assert (by_hand[10]["steer"], by_hand[10]["throttle"]) == (-0.5, 1), "both pressed"
    assert (by_hand[-1]["steer"], by_hand[-1]["throttle"]) == (0, 0), "let go, and not yet given back"
    assert driver.frames[-1].values["steer"] == 0.25


def test_down_brakes_while_the_car_rolls_and_then_drives_backwards(drive):
    driver, client = drive(lambda frame: {"throttle": 1}, "count=120 down=30 lockstep=true")
    assert client.wait() == 0, client.output
    by_hand = [frame.values for frame in driver.frames if frame.values["manual"]]
    told = [(values["throttle"], values["brake"]) for values in by_hand]
    turn = told.index((-1, 0))
    assert turn > 3 and set(told[:turn]) == {(0, 1)} and set(told[turn:]) == {(-1, 0)}
    speeds = [values["speed"] for values in by_hand]
    assert speeds[0] > 1 > 0.1 >= speeds[turn - 1] >= 0 > -0.5 > speeds[-1]


def test_what_python_says_is_shown_in_the_inspector_and_logged_once(drive):
    _, client = drive(lambda frame: {"text": "go"} if frame.id % 2 else {}, "count=20 lockstep=true")
    assert client.wait() == 0, client.output
    assert client.lines.count("Python says go") == client.lines.count("the inspector shows go") == 1


def test_a_sender_that_was_switched_off_begins_again(drive):
    """A camera of one's own is the eye, also then, and goes on showing the game itself."""
    driver, client = drive(lambda frame: {}, "count=30 cameras=left,right disable=15 eye")
    assert client.wait() == 0, client.output
    assert sum(line.startswith("asking ") for line in client.lines) == 2
    assert "trouble: the graphics card gave no picture" not in client.lines
    client.wait_for("^done: 30 actions")
    numbers = [frame.id for frame in driver.frames]
    assert len(set(numbers)) == len(numbers) == numbers.index(max(numbers)) + 1, "each picture is newer than the last"
    client.wait_for("^the eye goes on as it was: True$")
    assert all((picture(frame, camera) == (200, 0, 0)).all() for frame in driver.frames for camera in range(2))


@pytest.mark.xdist_group("times")
def test_what_a_frame_costs(drive, capsys):
    """The main thread's share but for rendering, which is the graphics card's; every picture is 320 x 240, raw."""
    _, client = drive(lambda frame: {}, "frames=60 count=100000 cameras=left,right")
    assert client.wait(120) == 0, client.output
    cost = client.wait_for("^cost: .*")[0]
    with capsys.disabled():
        print(f"\n{cost}")
    assert leaves_nothing_to_collect(cost), cost


@pytest.mark.xdist_group("times")
@pytest.mark.parametrize("runtime", ["dotnet", "mono"])
def test_a_picture_and_its_action_leave_nothing_to_collect(play, runtime, capsys):
    """On the network thread, with another number in each field of the action."""
    with zmq.Context() as context, driving(context, lambda frame: {"steer": 0.001 * (frame.id % 900)}) as driver:
        program = play("pictures", driver.endpoint, runtime=runtime)
        assert program.wait(120) == 0, program.output
    cost, steer = program.wait_for(r"^cost: (.*); steer (\S+)$").groups()
    with capsys.disabled():
        print(f"\n{runtime}: {cost}")
    # Garbage of a picture would be in each of the 100 frames. A few have an object of 24 bytes, by which NetMQ tells
    # its other thread how many were read, or a small buffer, where a busy machine has not given back the last one.
    count, dirty = map(int, re.search(r"(\d+) bytes allocated in (\d+) frames", cost).groups())
    assert dirty <= 30 and count < 100 * 24, cost
    # Mono prints fifteen digits.
    assert float(steer) == pytest.approx(0.001 * (driver.frames[-1].id % 900), abs=1e-9)


def test_a_view_is_upright_and_leaves_nothing(play):
    """Its camera sees one layer, on which nothing is by itself; and a new picture can go where the last one was.

    A sensor that is started twice is one.
    """
    program = play("cameras")
    assert program.wait() == 0, program.output
    for shape, red, blue in (("7, 3", "200 0 0", "0 0 200"), ("7", "60", "23")):
        line = f"[4, {shape}]: {' '.join([red] * 14 + [blue] * 14)}"
        assert program.lines.count(line) == 4, program.output
    # The red of its world, and what the next picture is read into.
    left = [line.split()[1:] for line in program.lines if line.startswith("left: ")]
    assert [one.count("Material:0.78,0.00,0.00") for one in left] == [1] * 4
    others = [[part for part in one if not part.startswith("Material:")] for one in left]
    assert others == [[], [], ["Texture2D"], ["Texture2D"]]
    assert program.lines.count("the camera draws to the screen again: True") == 4
    assert program.lines.count("it follows: (92.00, 4.00, 7.00) (0.97, -0.26, 0.00)") == 4, program.output
    for frames, count in re.findall(r"^cost: (\d+) frames: .* (\d+) bytes allocated", program.output, re.MULTILINE):
        assert int(count) < 1000 * int(frames)
    assert [line for line in program.lines if line.startswith(("the eye", "sensors"))] == [
        "the eye draws: False",
        "sensors: 1",
        "sensors: 0",
    ] * 4
