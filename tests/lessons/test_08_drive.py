"""Lesson 08, the clients' side: what a drive is made of, whoever answers. The Python programs are in
test_08_see_and_steer.py.
"""

from __future__ import annotations

import hashlib
import itertools
import os
import re
import statistics
import sys
import threading
import time

import pytest
import zmq

from netmq_example.messages import Message, read
from tests.conftest import CLIENTS
from tests.programs import LIMIT, Program

KEY = "08_see_and_steer"
world = pytest.importorskip("netmq_example.worlds.road", reason="lesson 08 needs numpy: pip install numpy")

each_client = pytest.mark.parametrize("kind", CLIENTS)
each_terminal = pytest.mark.parametrize("kind", [kind for kind in CLIENTS if kind != "unity"])
# Of all pictures of the golden drive, one after the other.
GOLDEN = "3430496ace460455426501b8cac70763ff0a8a9df952484991fe21f4b4ce9af2"


class Driver(threading.Thread):
    """Answers each picture as it is told, and keeps what was sent. None: not at all."""

    def __init__(self, context, answer):
        super().__init__(daemon=True)
        self.socket, self.answer, self.frames = context.socket(zmq.REP), answer, []
        self.socket.linger, self.socket.rcvtimeo = 0, 100
        self.endpoint = f"tcp://127.0.0.1:{self.socket.bind_to_random_port('tcp://127.0.0.1')}"
        self.over = threading.Event()
        self.start()

    def until(self, wanted):
        """Waits for a picture whose values are as wanted."""
        end = time.monotonic() + LIMIT
        for at in itertools.count():
            while at == len(self.frames):
                assert time.monotonic() < end, self.frames[-1:]
                time.sleep(0.005)
            if wanted(self.frames[at].values):
                return

    def run(self):
        with self.socket:
            while not self.over.is_set():
                try:
                    frame = read(self.socket.recv_multipart())
                except zmq.Again:
                    continue
                self.frames.append(frame)
                values = {"frame": frame.id, "throttle": 0.5, "brake": 0.0, "steer": 0.0}
                self.socket.send_multipart(Message("action", frame.id, values | self.answer(frame)).frames())


@pytest.fixture
def driver(context):
    drivers = []

    def start(answer):
        drivers.append(Driver(context, answer))
        return drivers[-1]

    yield start
    for one in drivers:
        one.over.set()
        one.join()


def after(seconds, number=0, longer=0.0):
    """Answers after a time, and picture number so and so after another one."""
    turn = itertools.count(1)

    def answer(frame):
        time.sleep(longer if next(turn) == number else seconds)
        return {}

    return answer


class Teacher:
    """Drives a car of its own, in step with the client's, towards a point of the road some 6 m ahead."""

    def __init__(self):
        self.road = world.Road()
        self.car, self.camera, self.number = world.Car.on(self.road), world.DrawnCamera(self.road), 0
        self.digest, self.other = hashlib.sha256(), []

    def __call__(self, frame):
        picture = self.camera.draw(self.car, self.number).tobytes()
        self.digest.update(picture)
        if frame.values["frame"] != self.number or bytes(frame.arrays[0].data) != picture:
            self.other.append(frame.id)
        at = self.road.nearest(self.car.x, self.car.y)[0]
        x, y = self.road.points[(at + 40) % len(self.road.points)] - (self.car.x, self.car.y)
        steer = 2 * (x * self.car.ahead_y - y * self.car.ahead_x) / (x * x + y * y) / world.CURVATURE
        action = {
            "throttle": 0.7,
            "brake": 0.5 if self.number % 200 < 10 else 0.0,
            "steer": min(1.0, max(-1.0, float(steer) + 0.1 * (self.number % 7 - 3))),
        }
        self.car.step(**action)
        self.number += 1
        return action


# Each side draws a thousand pictures.
@pytest.mark.timeout(900)
@each_terminal
def test_a_thousand_steps_are_the_golden_ones(kind, driver, start, client_command):
    """Each picture is compared to the byte with the one of a world of the test's own, and all with the kept sum."""
    teacher = Teacher()
    there = driver(teacher)
    client = start(*client_command(kind, KEY, there.endpoint, "--count", "1000", "--lockstep", "--timeout", "60"))
    assert client.wait(800) == 0, client.output
    assert client.lines[-1] == "done: 1000 actions, 0 pictures skipped"
    assert teacher.other == []
    assert teacher.road.nearest(teacher.car.x, teacher.car.y)[1] < 1
    assert teacher.digest.hexdigest() == GOLDEN


@each_client
def test_an_action_names_its_picture(kind, driver, start, client_command):
    """One for a picture that was never sent, or one that is no action, is not followed; the next one is."""
    never = 1_000_000
    wrong = {2: {"frame": never}, 4: {"steer": "left"}}
    turn = itertools.count(1)
    there = driver(lambda frame: wrong.get(next(turn), {"steer": 1e300, "throttle": -7}))
    client = start(*client_command(kind, KEY, there.endpoint, "--count", "10", "--timeout", "20"))
    assert client.wait() == 0, client.output
    asked = there.frames[1].id
    client.wait_for(f"^trouble: wrong-frame: an action for picture {never}, but {asked} was asked about$")
    client.wait_for("^trouble: no-action: the reply is no action, or without a number 'steer'$")
    last = there.frames[-1].values
    assert (last["steer"], last["throttle"]) == (1, 0), "clamped, and sent back as what was in force"


@each_client
def test_a_driver_that_never_answers_with_numbers_is_given_up(kind, driver, start, client_command):
    there = driver(lambda frame: {"brake": True} if frame.id % 2 else {"throttle": "nan"})
    client = start(*client_command(kind, KEY, there.endpoint, "--tries", "4", "--timeout", "20"))
    assert client.wait() == 1, client.output
    assert sum("trouble: no-action" in line for line in client.lines) == 3
    assert any("gave up: no-action" in line for line in client.lines)


@each_client
def test_a_slow_driver_gets_the_newest_picture_and_its_actions_have_an_age(kind, driver, start, client_command):
    there = driver(after(0.2))
    client = start(*client_command(kind, KEY, there.endpoint, "--count", "8", "--every", "1"))
    assert client.wait() == 0, client.output
    ages = [int(age) for age in re.findall(r"age (\d+)", client.output)]
    # A client that got no processor has made fewer of them meanwhile.
    assert len(ages) == 8 and statistics.median(ages) >= 9, "0.2 s are ten steps"
    numbers = [frame.id for frame in there.frames]
    # One after the other would be 1; of a client that got no processor meanwhile the newest is not so new.
    assert statistics.median(after - before for before, after in itertools.pairwise(numbers)) > 1
    skipped = int(client.wait_for(r"done: 8 actions, (\d+) pictures skipped")[1])
    assert skipped >= sum(after - before - 1 for before, after in itertools.pairwise(numbers[:8]))


@each_client
def test_a_car_without_actions_brakes_and_drives_on_when_they_come_again(kind, driver, start, client_command):
    # Longer than a client may be without a processor: it brakes for the time that it has seen pass.
    there = driver(after(0.0, 100, 4))
    client = start(*client_command(kind, KEY, there.endpoint, "--count", "150", "--timeout", "20"))
    client.wait_for("^trouble: no action for 0.5 s: braking$")
    begin = len(client.lines)
    assert client.wait() == 0, client.output
    client.wait_for("^an action again: driving on$", start=begin - 1)
    before, behind = there.frames[99], there.frames[100]
    # One that got no processor may have braked before, too, and stand.
    assert behind.values["brake"] == 1 and 0 <= behind.values["speed"] <= max(0, before.values["speed"] - 0.1)


@each_client
def test_in_lockstep_the_world_waits_and_brakes_for_the_action_that_does_not_come(kind, driver, start, client_command):
    """A server that is away for a time: each picture is the step after the last one."""
    # A busy machine takes a second for a new connection, and for a look at what has come.
    there = driver(after(0.02, 50, 6))
    words = ["--lockstep", "--count", "100", "--timeout", "3"]
    client = start(*client_command(kind, KEY, there.endpoint, *words))
    assert client.wait() == 0, client.output
    client.wait_for("^trouble: no reply from")
    # What was sent while the server slept comes on connections that are closed by now, in any order.
    frames = {frame.id: frame.values for frame in there.frames}
    assert sorted(frames) == list(range(len(there.frames))), "each step's picture, and each once"
    assert [frames[number]["brake"] for number in (49, 50, max(frames))] == [0, 1, 0]
    assert client.lines[-1] == "done: 100 actions, 0 pictures skipped"


@pytest.mark.skipif(sys.platform == "win32", reason="a terminal of the test's own: pty")
@each_terminal
def test_a_person_takes_over_and_gives_back(kind, driver, start, client_command):
    import pty
    import termios

    there = driver(lambda frame: {"steer": 0.25})
    master, slave = pty.openpty()
    command = client_command(kind, KEY, there.endpoint, "--drive", "--count", "100000")
    client = Program(command, stdin=slave, TERM="xterm")
    try:
        client.wait_for("^asking")
        there.until(lambda values: values["steer"] == 0.25)
        for _ in range(3):
            os.write(master, b"\x1b[D")
        client.wait_for("^a person drives$")
        there.until(lambda values: values["manual"] and values["steer"] == pytest.approx(-0.3))
        os.write(master, b" ")
        there.until(lambda values: values["manual"] and values["brake"] == 1)
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


@each_client
@pytest.mark.parametrize("cameras", ["left,right", "left,center,right"])
def test_several_cameras_are_as_many_pictures(kind, cameras, driver, start, client_command):
    there = driver(lambda frame: {})
    client = start(*client_command(kind, KEY, there.endpoint, "--count", "3", "--cameras", cameras))
    assert client.wait() == 0, client.output
    for frame in there.frames:
        assert frame.values["cameras"] == cameras
        pictures = [bytes(array.data) for array in frame.arrays]
        assert len(set(pictures)) == len(pictures) == cameras.count(",") + 1, "each from its own place"


def test_a_german_machine_writes_the_same_numbers(driver, start, client_command):
    there = driver(lambda frame: {"steer": 0.25})
    words = ["--count", "3", "--every", "1", "--timeout", "1.5"]
    client = start(*client_command("csharp", KEY, there.endpoint, *words), LC_ALL="de_DE.UTF-8", LANG="de_DE.UTF-8")
    assert client.wait() == 0, client.output
    client.wait_for(r"^frame \d+: age \d+, \d+\.\d ms; steer 0\.25, speed \d\.\d m/s, 0\.\d m off the middle$")
    assert there.frames[-1].values["steer"] == 0.25
