"""Lesson 08, the clients' side: what a drive is made of, whoever answers. The Python programs are in
test_08_see_and_steer.py.
"""

import contextlib
import hashlib
import itertools
import os
import re
import signal
import statistics
import sys
import time

import pytest

from netmq_example.messages import Message
from tests.conftest import CLIENTS
from tests.lessons.conftest import answering
from tests.programs import LIMIT, PATIENT, ROOT, Program

KEY = "08_see_and_steer"
world = pytest.importorskip("netmq_example.worlds.road", reason="lesson 08 needs numpy: kit.py run 8 installs it")

each_client = pytest.mark.parametrize("kind", CLIENTS)
TERMINAL = [kind for kind in CLIENTS if kind != "unity"]
# Where the golden drives begin: towards the right, the left and the lower edge of the ground. So many steps each.
STARTS = (450, 1500, 1900)
STEPS = 40
# Of all their pictures, one after the other.
GOLDEN = "03143488f6c9f5f0bbfafe3b9e67b01167ae476117b69d914533de294ba493bb"


class Driver:
    """Answers each picture as it is told, and keeps what was sent."""

    def __init__(self, answer):
        self.answer, self.frames, self.endpoint = answer, [], ""

    def __call__(self, request):
        frame = Message.read(request)
        self.frames.append(frame)
        values = {"frame": frame.id, "throttle": 0.5, "brake": 0.0, "steer": 0.0}
        return Message("action", frame.id, values | self.answer(frame)).frames()

    def until(self, wanted):
        """Waits for a picture whose values are as wanted."""
        end = time.monotonic() + LIMIT
        for at in itertools.count():
            while at == len(self.frames):
                assert time.monotonic() < end, self.frames[-1:]
                time.sleep(0.005)
            if wanted(self.frames[at].values):
                return


@contextlib.contextmanager
def driving(context, answer):
    driver = Driver(answer)
    with answering(context, driver) as driver.endpoint:
        yield driver


@pytest.fixture
def driver(context):
    with contextlib.ExitStack() as stack:
        yield lambda answer: stack.enter_context(driving(context, answer))


def after(seconds, number=0, longer=0.0):
    """Answers after a time, and picture number so and so after another one."""
    turn = itertools.count(1)

    def answer(frame):
        time.sleep(longer if next(turn) == number else seconds)
        return {}

    return answer


def lesson(road, camera, start):
    """Each picture of a drive to a point of the road some 6 m ahead, and the action that answers it."""
    car = world.Car.on(road, start)
    for number in range(STEPS):
        picture = camera.draw(car, number).tobytes()
        at = road.nearest(car.x, car.y)[0]
        x, y = road.points[(at + 40) % len(road.points)] - (car.x, car.y)
        steer = 2 * (x * car.ahead_y - y * car.ahead_x) / (x * x + y * y) / world.CURVATURE
        action = {
            "throttle": 0.7,
            "brake": 0.5 if 20 <= number < 25 else 0.0,
            "steer": min(1.0, max(-1.0, float(steer) + 0.1 * (number % 7 - 3))),
        }
        yield picture, action
        car.step(**action)


def test_the_steps_are_the_golden_ones(driver, runs):
    """Each picture is compared to the byte with the one of a world of the test's own, and all with the kept sum."""
    road = world.Road()
    camera = world.DrawnCamera(road)
    steps = [step for start in STARTS for step in lesson(road, camera, start)]
    assert hashlib.sha256(b"".join(picture for picture, _ in steps)).hexdigest() == GOLDEN
    for kind in TERMINAL:
        expected, other = iter(enumerate(steps)), []

        def answer(frame, expected=expected, other=other):
            number, (picture, action) = next(expected)
            if frame.values["frame"] != number % STEPS or bytes(frame.arrays[0].data) != picture:
                other.append(number)
            return action

        words = ["--endpoint", driver(answer).endpoint, "--count", str(STEPS), "--lockstep", *PATIENT]
        for code, lines in runs(kind, KEY, [[*words, "--start", str(start)] for start in STARTS]):
            assert (code, lines[-1]) == (0, f"done: {STEPS} actions, 0 pictures skipped"), lines
        assert (other, next(expected, None)) == ([], None), kind


@each_client
def test_an_action_names_its_picture(kind, driver, runs):
    """One for a picture that was never sent, or one that is no action, is not followed; the next one is. And several
    cameras are as many pictures."""
    never = 1_000_000
    wrong = {2: {"frame": never}, 4: {"steer": "left"}}
    turn = itertools.count(1)
    odd = driver(lambda frame: wrong.get(next(turn), {"steer": 1e300, "throttle": -7}))
    mute = driver(lambda frame: {"brake": True} if frame.id % 2 else {"throttle": "nan"})
    several = {cameras: driver(lambda frame: {}) for cameras in ("left,right", "left,center,right")}
    first, second, *others = runs(
        kind,
        KEY,
        [
            ["--endpoint", odd.endpoint, "--count", "10", "--timeout", "20"],
            ["--endpoint", mute.endpoint, "--tries", "4", "--timeout", "20"],
            *(
                ["--endpoint", there.endpoint, "--count", "2", "--cameras", cameras, *PATIENT]
                for cameras, there in several.items()
            ),
        ],
    )
    assert first.code == 0, first
    asked = odd.frames[1].id
    assert f"trouble: wrong-frame: an action for picture {never}, but {asked} was asked about" in first.lines
    assert "trouble: no-action: the reply is no action, or without a number 'steer'" in first.lines
    last = odd.frames[-1].values
    assert (last["steer"], last["throttle"]) == (1, -1), "clamped, and sent back as what was in force"
    assert second.code == 1, second
    assert sum("trouble: no-action" in line for line in second.lines) == 3
    assert any("gave up: no-action" in line for line in second.lines)
    for (cameras, there), run in zip(several.items(), others, strict=True):
        assert run.code == 0, run
        for frame in there.frames:
            assert frame.values["cameras"] == cameras
            seen = [bytes(array.data) for array in frame.arrays]
            assert len(set(seen)) == len(seen) == cameras.count(",") + 1, "each from its own place"


# Forwards, through a standstill to backwards, braked, held, backwards again and forwards through it.
GEARS = [(1, 0)] * 30 + [(-0.5, 0)] * 90 + [(-1, 1)] * 30 + [(0, 0.2)] * 5 + [(-1, 0.25)] * 40 + [(0.8, 0)] * 60


def test_a_car_has_a_reverse_gear_and_the_brake_ends_at_a_standstill(driver, runs):
    """To the last bit the same in each language."""
    car = world.Car.on(world.Road())
    speeds = [0.0]
    for throttle, brake in GEARS:
        car.step(throttle, brake, 0.5)
        speeds.append(car.speed)
    assert max(speeds[30], 2) == speeds[30] and speeds[120] < -1, "it has turned round without a brake"
    assert speeds[122] < 0 and set(speeds[150:156]) == {0}, "full throttle is no match for the brake, and nothing rolls"
    assert speeds[195] < -0.5 and speeds[-1] > 1
    for kind in TERMINAL:
        there = driver(lambda frame: dict(zip(("throttle", "brake"), GEARS[frame.id], strict=True), steer=0.5))
        words = ["--endpoint", there.endpoint, "--count", str(len(GEARS)), "--lockstep", *PATIENT]
        (run,) = runs(kind, KEY, [words])
        assert run.code == 0, run
        assert [frame.values["speed"] for frame in there.frames] == speeds[:-1], kind


@each_client
def test_what_python_says_is_printed_once(kind, driver, runs):
    said = ["go", "go", "", "a\x1b[2Jb", 7, "go"]
    there = driver(lambda frame: {"text": said[frame.id]} if frame.id < len(said) else {})
    words = ["--endpoint", there.endpoint, "--count", "9", "--lockstep", *PATIENT]
    ((code, lines),) = runs(kind, KEY, [words])
    assert code == 0, lines
    heard = [line for line in lines if line.startswith("Python says")]
    assert [heard[0], *heard[2:]] == ["Python says go", heard[2], "Python says go"] and len(heard) == 4
    assert heard[1] == "Python says " and "\x1b" not in heard[2]


@each_client
def test_a_slow_driver_gets_the_newest_picture_and_its_actions_have_an_age(kind, driver, start, client_command):
    there = driver(after(0.2))
    command = client_command(kind, KEY, there.endpoint, "--count", "5", "--every", "1")
    client = start(*command, LC_ALL="de_DE.UTF-8", LANG="de_DE.UTF-8")
    assert client.wait() == 0, client.output
    # Also on a German machine.
    client.wait_for(r"^frame \d+: age \d+, \d+\.\d ms; steer 0\.00, speed \d\.\d m/s, 0\.\d m off the middle$")
    ages = [int(age) for age in re.findall(r"age (\d+)", client.output)]
    # A client that got no processor has made fewer of them meanwhile.
    assert len(ages) == 5 and statistics.median(ages) >= 9, "0.2 s are ten steps"
    numbers = [frame.id for frame in there.frames]
    # One after the other would be 1; of a client that got no processor meanwhile the newest is not so new.
    assert statistics.median(after - before for before, after in itertools.pairwise(numbers)) > 1
    skipped = int(client.wait_for(r"done: 5 actions, (\d+) pictures skipped")[1])
    assert skipped >= sum(after - before - 1 for before, after in itertools.pairwise(numbers[:5]))


@each_client
def test_a_car_without_actions_brakes_and_drives_on_when_they_come_again(kind, driver, start_client):
    # Longer than a client may be without a processor: it brakes for the time that it has seen pass.
    there = driver(after(0.0, 30, 4))
    client = start_client(kind, KEY, there.endpoint, "--count", "40", "--timeout", "20")
    client.wait_for("^trouble: no action for 0.5 s: braking$")
    begin = len(client.lines)
    assert client.wait() == 0, client.output
    client.wait_for("^an action again: driving on$", start=begin - 1)
    before, behind = there.frames[29], there.frames[30]
    # One that got no processor may have braked before, too, and stand.
    assert behind.values["brake"] == 1 and 0 <= behind.values["speed"] <= max(0, before.values["speed"] - 0.1)


@each_client
def test_in_lockstep_the_world_waits_and_brakes_for_the_action_that_does_not_come(kind, driver, start_client):
    """A server that is away for a time: each picture is the step after the last one."""
    # A busy machine takes a second for a new connection, and for a look at what has come.
    there = driver(after(0.02, 20, 6))
    words = ["--lockstep", "--count", "30", "--timeout", "3"]
    client = start_client(kind, KEY, there.endpoint, *words)
    assert client.wait() == 0, client.output
    client.wait_for("^trouble: no reply from")
    # The messages to the sleeping server come on connections that are closed by now, in any order.
    frames = {frame.id: frame.values for frame in there.frames}
    assert sorted(frames) == list(range(len(there.frames))), "each step's picture, and each once"
    assert [frames[number]["brake"] for number in (19, 20, max(frames))] == [0, 1, 0]
    assert client.lines[-1] == "done: 30 actions, 0 pictures skipped"


def driven_by_a_person(**wanted):
    return lambda values: values["manual"] and {name: values[name] for name in wanted} == pytest.approx(wanted)


@pytest.mark.skipif(sys.platform == "win32", reason="a terminal of the test's own: pty")
@pytest.mark.parametrize("kind", TERMINAL)
def test_a_person_takes_over_and_gives_back(kind, driver, client_command):
    import pty
    import termios

    there = driver(lambda frame: {"steer": 0.25})
    master, slave = pty.openpty()
    command = client_command(kind, KEY, there.endpoint, "--drive", "--count", "100000")
    client = Program(command, stdin=slave, TERM="xterm")
    try:
        client.wait_for("^asking")
        there.until(lambda values: values["steer"] == 0.25)
        left, right, up, down = (b"\x1b[" + key for key in (b"D", b"C", b"A", b"B"))
        os.write(master, 3 * left + right + 2 * up + down)
        client.wait_for("^a person drives$")
        there.until(driven_by_a_person(steer=-0.2, throttle=0.2, brake=0))
        os.write(master, b" ")
        there.until(driven_by_a_person(steer=-0.2, throttle=0, brake=1))
        os.write(master, up)
        there.until(driven_by_a_person(steer=-0.2, throttle=0.2, brake=0))
        # The letters are their brothers, small and capital; and below 0 it drives backwards.
        os.write(master, b"ssA")
        there.until(driven_by_a_person(steer=-0.3, throttle=-0.2, brake=0))
        there.until(lambda values: values["speed"] < 0)
        os.write(master, b"wd" + 9 * b"S")
        there.until(driven_by_a_person(steer=-0.2, throttle=-1, brake=0))
        os.write(master, b"\r")
        client.wait_for("^Python drives$")
        there.until(lambda values: not values["manual"] and values["steer"] == 0.25)
        client.process.terminate()
        client.wait()
        assert termios.tcgetattr(slave)[3] & termios.ECHO, "the terminal shows again what is typed"
    finally:
        client.kill()
        os.close(master)
        os.close(slave)


@pytest.mark.skipif(sys.platform == "win32", reason="a terminal of the test's own: pty")
def test_keys_reach_the_client_that_kit_py_runs():
    import pty

    pytest.importorskip("PIL", reason="kit.py run 8 needs Pillow: pip install pillow")
    master, slave = pty.openpty()
    words = ["run", "8", "--client", "python", "--endpoint", "tcp://127.0.0.1:0", "--options", "--drive --count 100000"]
    run = Program([sys.executable, ROOT / "kit.py", *words], stdin=slave, TERM="xterm")
    try:
        run.wait_for("^client . frame")
        os.write(master, b"w")
        run.wait_for("^client . a person drives$")
        assert run.stop(signal.SIGINT) in (0, 130)
    finally:
        run.kill()
        os.close(master)
        os.close(slave)
