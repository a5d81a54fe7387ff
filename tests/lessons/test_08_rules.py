"""Lesson 08: what the package's classes cannot use is refused in one line that names it, by the class itself."""

from __future__ import annotations

import pytest

from netmq_example.errors import Timeout

np = pytest.importorskip("numpy", reason="lesson 08 needs numpy: kit.py run 8 installs it")
from netmq_example.camera import pictures  # noqa: E402
from netmq_example.camera.client import Action, DriverClient  # noqa: E402
from netmq_example.camera.recording import Recorder, recorded  # noqa: E402
from netmq_example.messages import Message  # noqa: E402
from netmq_example.worlds.road import Car, DrawnCamera, Road  # noqa: E402
from tests.lessons.test_08_see_and_steer import action, frame  # noqa: E402
from tests.programs import steady_endpoint  # noqa: E402

NAN = float("nan")
WHERE = "tcp://127.0.0.1:5558"
ROAD = Road()


def client(context, **other):
    return DriverClient(**{"context": context, "endpoint": WHERE, **other})


def asked_twice(context):
    one = client(context)
    try:
        one.send(Message("frame", 5))
        one.send(Message("frame", 6))
    finally:
        one.close()


WRONG = {
    "frame takes": lambda c: client(c).send(None),
    "until takes .* not nan": lambda c: client(c).receive(NAN),
    "until takes .* not None": lambda c: client(c).receive(None),
    "no picture is asked about": lambda c: client(c).receive(),
    "picture 5 is asked about": asked_twice,
    **{f"throttle takes .* not {v!r}": lambda c, v=v: Action(1, v, 0, 0) for v in (None, NAN, "1")},
    "frame takes .* not -1": lambda c: Action(-1, 0, 0, 0),
    **{f"milliseconds takes .* not {v!r}": lambda c, v=v: Action(1, 0, 0, 0, v) for v in (None, NAN, "x")},
    "steer takes .* not nan": lambda c: Action(1, 0, 0, NAN),
    "frame takes a Message": lambda c: pictures.pictures(None),
    "picture takes .* float64": lambda c: pictures.encode(np.zeros((8, 8, 3))),
    "picture takes .* object": lambda c: pictures.encode(None),
    "picture takes .*0, 8, 3": lambda c: pictures.encode(np.zeros((0, 8, 3), np.uint8)),
    "file takes": lambda c: pictures.decode(None),
    "folder takes .* not ''": lambda c: Recorder(""),
    "folder takes .* not 0": lambda c: Recorder(0),
    "folder takes .* not None": lambda c: next(recorded(None)),
    "frame takes a Message, not 0": lambda c: Recorder(None).add(0, Message("action")),
    "road takes": lambda c: DrawnCamera(None),
    "road takes a Road, not 0": lambda c: Car.on(0),
    **{f"at takes .* not {value!r}": lambda c, v=value: Car.on(ROAD, v) for value in (-1, len(ROAD.points), None, NAN)},
    "x takes .* not nan": lambda c: ROAD.nearest(NAN, 0),
    "speed takes .* not None": lambda c: Car(0, 0, 1, 0, None),
    "throttle takes .* not -2": lambda c: Car.on(ROAD).step(-2, 0, 0),
    "brake takes .* not 2": lambda c: Car.on(ROAD).step(0, 2, 0),
    "steer takes .* not None": lambda c: Car.on(ROAD).step(0, 0, None),
    "number takes .* not -1": lambda c: DrawnCamera(ROAD).draw(Car.on(ROAD), -1),
    "right takes .* not nan": lambda c: DrawnCamera(ROAD).draw(Car.on(ROAD), 0, NAN),
}


@pytest.mark.parametrize(("says", "call"), WRONG.items(), ids=WRONG)
def test_what_a_class_cannot_use_is_named(says, call, context):
    with pytest.raises((ValueError, TypeError), match=says) as refusal:
        call(context)
    assert "\n" not in str(refusal.value) and len(str(refusal.value)) < 200


def test_so_many_pictures_in_a_row_without_an_action_are_given_up(context, caplog):
    """And a picture after them is asked about on a new socket."""
    driver = client(context, endpoint=steady_endpoint(), timeout=0.1, tries=2)
    driver.send(Message("frame", 1))
    socket = driver.socket
    assert driver.receive() is None and driver.asked is None
    assert socket.closed, "a try that failed leaves no socket"
    driver.send(Message("frame", 2))
    with pytest.raises(Timeout, match=r"no reply from .* within 0\.2 s; is the server running\?"):
        driver.receive()
    assert [line[:15] for line in caplog.messages] == ["trouble: no rep"]


def test_where_there_is_no_pillow_recording_ends_and_driving_goes_on(tmp_path, monkeypatch, caplog):
    monkeypatch.setattr(pictures, "Image", None)
    recorder = Recorder(tmp_path)
    for _ in range(2):
        recorder.add(frame(1), action(1))
    (line,) = caplog.messages
    assert line.startswith("trouble: recording has stopped, the car drives on: JPEG needs Pillow")
