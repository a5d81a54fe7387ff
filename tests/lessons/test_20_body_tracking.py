"""Application 20: the persons of a recording and of a webcam, the newest pose, a server that is started again.

tests/unity/test_unity_body.py has what only Unity has: the skeleton, the avatar and the smoothing.
"""

from __future__ import annotations

import re
import shutil
import time
from types import SimpleNamespace

import pytest
import zmq

from netmq_example.body import camera, people
from netmq_example.body import listener as body_listener
from tests.conftest import CLIENTS, PYTHON
from tests.programs import ROOT, finished, steady_endpoint

KEY = "20_body_tracking"
LESSON = ROOT / "python" / KEY
GERMAN = {"LANG": "de_DE.UTF-8", "LC_ALL": "de_DE.UTF-8"}
TERMINAL = pytest.mark.parametrize("kind", ["python", "csharp"])
each_client = pytest.mark.parametrize("kind", CLIENTS)
WALK = people.read(LESSON / "walk.csv")


@pytest.fixture
def listen(start, client_command):
    def listen(kind, endpoint, *options, **environment):
        return start(*client_command(kind, KEY, endpoint, *options), **environment)

    return listen


def message(number, body, person=0, seconds=1.5):
    numbers = [f"{value:.3f}" for landmark in body for value in landmark]
    return " ".join([f"pose/{person}/ {number} {seconds:.3f}", *numbers])


def knee(number, person):
    """The right knee's angle in the pose of this number, whole degrees."""
    _, there = WALK[(number - 1) % len(WALK)]
    return f"{body_listener.parse(message(number, there[person])).angle(24, 26, 28):.0f}"


# The recorded persons


@each_client
@pytest.mark.parametrize(("person", "environment"), [(0, {}), (1, GERMAN)], ids=["0", "1, german"])
def test_a_person_is_seen_to_move(kind, person, environment, serve, listen):
    """Each printed angle is that of the recording's pose of this number, whichever client it is."""
    _, endpoint = serve(KEY, **environment)
    words = ["--person", str(person), "--count", "25", "--every", "4"]
    client = listen(kind, endpoint, *words, **environment)
    assert client.wait() == 0, client.output
    first, *seen, last = client.lines
    assert first == f"listening to 'pose/{person}/' from {endpoint}"
    assert re.fullmatch(r"done: 25 poses, \d+ skipped", last)
    form = rf"person {person}: pose (\d+), right knee (\d+) degrees, \d+ ms late"
    found = [re.fullmatch(form, line) for line in seen]
    assert len(found) == 7 and all(found), client.output
    assert [match[2] for match in found] == [knee(int(match[1]), person) for match in found]
    assert len({match[2] for match in found}) > 2


def test_the_recording_is_what_the_walker_makes(start, tmp_path):
    shutil.copy(LESSON / "walker.py", tmp_path)
    walker = start(PYTHON, tmp_path / "walker.py", PYTHONPATH=str(ROOT / "python"))
    assert walker.wait() == 0, walker.output
    assert walker.lines == ["wrote walk.csv: 90 poses of 2 persons"]
    assert (tmp_path / "walk.csv").read_bytes() == (LESSON / "walk.csv").read_bytes()


def test_the_walker_writes_over_no_file_but_its_own(tmp_path):
    def walker(*words):
        return finished([PYTHON, LESSON / "walker.py", *words], cwd=tmp_path)

    there = tmp_path / "there.csv"
    there.write_text("mine", encoding="utf-8")
    for words, why in (
        (["--file", "there.csv"], "there.csv is there already: name a new file"),
        (["--file", "no/folder.csv"], "cannot write .+: No such file or directory"),
        (["x"], "unrecognized arguments: x"),
    ):
        done = walker(*words)
        assert done.returncode == 2 and re.search(f"error: {why}$", done.stderr.strip()), done.stderr
    assert there.read_text(encoding="utf-8") == "mine"
    done = walker("--file", "new.csv")
    assert done.stdout == "wrote new.csv: 90 poses of 2 persons\n"
    assert (tmp_path / "new.csv").read_bytes() == (LESSON / "walk.csv").read_bytes()


def test_the_recorded_persons_are_of_human_size_and_begin_where_they_end():
    for person in (0, 1):
        bodies = [there[person] for _, there in WALK]
        for before, body in zip([bodies[-1], *bodies], bodies, strict=False):
            steps = [
                abs(a - b) for one, other in zip(before, body, strict=True) for a, b in zip(one, other, strict=True)
            ]
            assert max(steps) < 0.3, "a jump"
            assert 0.4 < body[0][1] * -1 < 0.8 and body[0][2] < body[8][2], (
                "MediaPipe: up is negative, near is negative"
            )
            assert body[23][:3] == pytest.approx([-x for x in body[24][:3]]), "the origin is between the hips"
    # Person 1 looks into the camera: the left hand is on the right of the picture.
    assert all(there[1][11][0] > 0 > there[1][12][0] for _, there in WALK)


def test_a_recording_of_ones_own_is_played_over_and_over(serve, listen, tmp_path):
    """With a person who is not there at first: nobody is something else than silence."""
    body = WALK[0][1][0]
    people.write(tmp_path / "mine.csv", [(0.0, [body, []]), (0.02, [body, body])])
    assert people.read(tmp_path / "mine.csv") == [(0.0, [body, []]), (0.02, [body, body])]
    _, endpoint = serve(KEY, "--recording", str(tmp_path / "mine.csv"))
    client = listen("python", endpoint, "--person", "1", "--count", "20", "--every", "1")
    assert client.wait() == 0, client.output
    for line in client.lines[1:-1]:
        number = int(re.match(r"person 1: pose (\d+), ", line)[1])
        assert ("nobody is there" in line) == (number % 2 == 1), line


HEADER = ",".join(people.HEADER) + "\n"


@pytest.mark.parametrize(
    ("content", "says"),
    [
        (None, "cannot read 'mine.csv': .*No such file"),
        (b"\xff\xfe", "cannot read 'mine.csv': .*decode"),
        (b"", "'mine.csv' is no recording: it must begin with the line seconds,person,x0,y0,z0,v0"),
        (b"a,b\n1,2\n", "'mine.csv' is no recording"),
        (HEADER.encode(), "'mine.csv' is a recording of nothing: below its first line there is no person"),
        ((HEADER + "0.0,0,1\n").encode(), "line 2 of the recording must be seconds, person 0 and 132 numbers"),
        ((HEADER + "0.0,1" + ",1" * 132 + "\n").encode(), "line 2 of the recording must be seconds, person 0"),
        ((HEADER + "x,0" + ",1" * 132 + "\n").encode(), "line 2 of the recording"),
        ((HEADER + "0.0,0" + ",nan" * 132 + "\n").encode(), "line 2 of the recording"),
        ((HEADER + "inf,0" + ",1" * 132 + "\n").encode(), "line 2 of the recording"),
        ((HEADER + "0.0,0" + ",1e300" * 132 + "\n").encode(), "line 2 of the recording"),
    ],
    ids=["missing", "no text", "empty", "another table", "nothing", "short", "order", "time", "nan", "inf", "huge"],
)
def test_what_is_no_recording_is_said_in_one_line(content, says, start, tmp_path):
    if content is not None:
        (tmp_path / "mine.csv").write_bytes(content)
    server = start(
        PYTHON, LESSON / "server.py", "--endpoint", "tcp://127.0.0.1:0", "--recording", tmp_path / "mine.csv"
    )
    assert server.wait() == 2
    assert re.search(f"argument --recording: {says}", server.lines[-1]), server.output
    assert "Traceback" not in server.output


def test_who_has_no_line_in_a_picture_is_not_there(tmp_path):
    one, two = ("".join(f"0.0,{person}" + ",0.5" * 132 + "\n" for person in persons) for persons in ([0], [0, 1]))
    (tmp_path / "mine.csv").write_text(HEADER + two + one.replace("0.0,", "0.5,", 1))
    assert [[len(body) for body in there] for _, there in people.read(tmp_path / "mine.csv")] == [[33, 33], [33, 0]]


def test_a_recording_that_excel_has_saved_is_read(tmp_path):
    """It puts a byte order mark in front, and writes CR LF."""
    row = "0.0,0" + ",0.5" * 132 + "\n"
    (tmp_path / "mine.csv").write_bytes((HEADER + row).replace("\n", "\r\n").encode("utf-8-sig"))
    assert people.read(tmp_path / "mine.csv") == [(0.0, [[(0.5,) * 4] * 33])]


# A server that goes, and one that the test decides for


@each_client
def test_a_server_that_is_started_again(kind, serve, listen):
    """Its numbers begin anew, and the client says so and goes on."""
    endpoint = steady_endpoint()
    server, _ = serve(KEY, endpoint=endpoint)
    client = listen(kind, endpoint, "--count", "40", "--every", "1", "--timeout", "25")
    # So many that the new one's number is certainly lower.
    client.wait_for("^person 0: pose .*", start=20)
    server.kill()
    serve(KEY, endpoint=endpoint)
    client.wait_for("^person 0: the server was started again$")
    assert client.wait() == 0, client.output
    assert client.lines.count("person 0: the server was started again") == 1


def test_seconds_go_on_where_numbers_begin_anew(serve):
    """They are the computer's: else each pose of a server that was started again would seem to be late."""
    begin = time.monotonic()
    server, endpoint = serve(KEY)
    with zmq.Context() as context, context.socket(zmq.SUB) as stream:
        stream.linger = 0
        stream.subscribe("pose/0/")
        stream.connect(endpoint)
        assert stream.poll(100_000), server.output
        seconds = body_listener.parse(stream.recv().decode()).seconds
    assert begin - 0.001 < seconds < time.monotonic() + 0.001


@pytest.fixture
def stage():
    """An XPUB, which sees subscriptions come; and where it is."""
    with zmq.Context() as context, context.socket(zmq.XPUB) as stream:
        stream.linger = 0
        yield stream, f"tcp://127.0.0.1:{stream.bind_to_random_port('tcp://127.0.0.1')}"


def subscribed(stream, to):
    assert stream.poll(100_000), "nobody subscribed"
    assert stream.recv() == b"\x01" + to


@TERMINAL
def test_the_newest_wins(kind, stage, listen):
    """While the client works on 1 the others arrive; it takes the last of them, and counts the rest."""
    stream, endpoint = stage
    client = listen(kind, endpoint, "--count", "2", "--every", "1", "--work", "5")
    subscribed(stream, b"pose/0/")
    body = WALK[0][1][0]
    stream.send_string(message(1, body))
    client.wait_for("^person 0: pose 1, right knee")
    for number in range(2, 101):
        stream.send_string(message(number, body))
    assert client.wait() == 0, client.output
    assert client.lines[2].startswith("person 0: pose 100, right knee")
    assert client.lines[3:] == ["done: 2 poses, 98 skipped"]


@TERMINAL
def test_an_old_pose_is_seen(kind, stage, listen):
    """The second one was on its way for two seconds longer than the first, by the server's clock."""
    stream, endpoint = stage
    client = listen(kind, endpoint, "--count", "2", "--every", "1")
    subscribed(stream, b"pose/0/")
    body = WALK[0][1][0]
    stream.send_string(message(1, body, seconds=100.0))
    client.wait_for("^person 0: pose 1, right knee .*, 0 ms late$")
    stream.send_string(message(2, body, seconds=98.0))
    assert int(client.wait_for(r"^person 0: pose 2, .*, (\d+) ms late$")[1]) >= 2000
    assert client.wait() == 0, client.output


@TERMINAL
def test_a_pose_that_comes_twice_is_no_restart(kind, stage, listen):
    stream, endpoint = stage
    client = listen(kind, endpoint, "--count", "3", "--every", "1")
    subscribed(stream, b"pose/0/")
    for number in (1, 1, 3):
        begin = len(client.lines)
        stream.send_string(message(number, []))
        client.wait_for(f"^person 0: pose {number}, nobody is there$", start=begin)
    assert client.wait() == 0, client.output
    assert client.lines[-1] == "done: 3 poses, 1 skipped" and len(client.lines) == 5


@each_client
def test_what_is_no_pose_is_passed_over(kind, stage, listen):
    stream, endpoint = stage
    client = listen(kind, endpoint, "--count", "2", "--every", "1", "--timeout", "25", "--person", "12")
    subscribed(stream, b"pose/12/")
    body = WALK[0][1][0]
    good = message(7, body, 12)
    for wrong in ("", " x", " 1", good[8:-1] + "nan", good[8:] + " 1", good[8:].replace(".", ",")):
        stream.send_string("pose/12/" + wrong)
    stream.send(b"pose/12/ \xff\x00")
    stream.send_string(message(8, [], 12))
    client.wait_for("^person 12: pose 8, nobody is there$")
    stream.send_string(good.replace(" 7 ", " 9 "))
    assert client.wait() == 0, client.output
    assert re.fullmatch(r"person 12: pose 9, right knee \d+ degrees, \d+ ms late", client.lines[2])
    assert client.lines[3:] == ["done: 2 poses, 0 skipped"]


@TERMINAL
def test_a_stream_without_a_pose_is_given_up(kind, stage, listen):
    """However much of something else comes."""
    stream, endpoint = stage
    client = listen(kind, endpoint, "--timeout", "5")
    subscribed(stream, b"pose/0/")
    while client.process.poll() is None:
        stream.send_string("pose/0/ something else")
    assert client.wait() == 1
    assert client.lines[-1] == f"gave up: no pose from {endpoint} within 5 s; is that this server?"


# The webcam, with a stand-in for MediaPipe and OpenCV: what camera.py uses of them, as their documentation has it

STAND_IN = '''
from types import SimpleNamespace
class Landmark(SimpleNamespace): pass
class ImageFormat: SRGB = 1
class Image:
    def __init__(self, image_format, data): assert (image_format, data) == (1, "RGB of a picture")
def body(x, mark):
    """Of one person: in the world, whose nose says who it is, and in the picture."""
    world = [Landmark(x=mark, y=0.25, z=-0.5, visibility=0.9, presence=0.9) for i in range(33)]
    return world, [Landmark(x=x, y=0.5, z=0.0, visibility=0.9, presence=0.9) for i in range(33)]
class PoseLandmarker:
    """Two persons, left and right, in another order in each picture; every fifth time the right one is away."""
    times = []
    @classmethod
    def create_from_options(cls, options):
        assert options.num_poses == 2 and options.running_mode == "VIDEO", options
        with open(options.base_options.model_asset_path) as model:
            if model.read() == "a web page": raise RuntimeError("Unable to open zip archive.")
        return cls()
    def __enter__(self): return self
    def __exit__(self, *error): pass
    def detect_for_video(self, image, milliseconds):
        assert not self.times or milliseconds > self.times[-1]
        self.times.append(milliseconds)
        there = [body(0.2, 1.0), body(0.8, 2.0)]
        if len(self.times) % 5 == 0: there.pop()
        if len(self.times) % 2 == 0: there.reverse()
        return SimpleNamespace(pose_world_landmarks=[w for w, _ in there], pose_landmarks=[p for _, p in there])
def hand(side, score, mark):
    """A Category of its side, and its 21 world landmarks, which have neither visibility nor presence."""
    category = SimpleNamespace(category_name=side, score=score, index=0, display_name=side)
    return [category], [Landmark(x=mark, y=0.02, z=-0.01, visibility=None, presence=None) for i in range(21)]
class HandLandmarker(PoseLandmarker):
    """A left hand, and one that looks less like one; the right hand comes and goes."""
    times = []
    @classmethod
    def create_from_options(cls, options):
        assert options.num_hands == 2 and options.running_mode == "VIDEO", options
        return cls()
    def detect_for_video(self, image, milliseconds):
        self.times.append(milliseconds)
        there = [hand("Left", 0.98, 0.05), hand("Left", 0.6, 9.0)]
        if len(self.times) % 2: there.append(hand("Right", 0.875, -0.05))
        return SimpleNamespace(handedness=[s for s, _ in there], hand_world_landmarks=[h for _, h in there],
                               hand_landmarks=None)
vision = SimpleNamespace(PoseLandmarker=PoseLandmarker, PoseLandmarkerOptions=SimpleNamespace,
                         HandLandmarker=HandLandmarker, HandLandmarkerOptions=SimpleNamespace,
                         RunningMode=SimpleNamespace(VIDEO="VIDEO"))
tasks = SimpleNamespace(vision=vision, BaseOptions=SimpleNamespace)
'''
OPENCV = """
import time
from types import SimpleNamespace
COLOR_BGR2RGB = 4
def cvtColor(picture, code):
    assert (picture, code) == ("BGR of a picture", 4)
    return "RGB of a picture"
class VideoCapture:
    def __init__(self, device): self.device = device
    def read(self):
        time.sleep(0.02)
        return (True, "BGR of a picture") if self.device == 0 else (False, None)
"""


@pytest.fixture
def webcam(start, tmp_path):
    """Starts the server with --camera, and with MediaPipe and OpenCV or without."""

    def begin(*words, there=True):
        (tmp_path / "model.task").touch()
        missing = "raise ImportError('not here', name=__name__)"
        for name, text in (("mediapipe", STAND_IN), ("cv2", OPENCV)):
            (tmp_path / f"{name}.py").write_text(text if there else missing, encoding="utf-8")
        command = [PYTHON, LESSON / "server.py", "--endpoint", "tcp://127.0.0.1:0", "--camera", *words]
        return start(*command, "--model", tmp_path / "model.task", PYTHONPATH=str(tmp_path))

    return begin


def test_a_webcam_is_recorded_as_the_page_says(webcam, start, tmp_path):
    """The program on the page, with fewer pictures; and what `watch` yields is no picture with its time."""
    webcam().kill()
    page = (ROOT / "docs" / "guide" / f"{KEY}.md").read_text(encoding="utf-8")
    (program,) = re.findall("```python\n(import itertools.*?)```", page, re.DOTALL)
    assert "pose_landmarker_lite.task" in program and " 300)" in program
    (tmp_path / "mine.py").write_text(program.replace("pose_landmarker_lite", "model").replace(" 300)", " 7)"))
    recorder = start(PYTHON, "mine.py", folder=tmp_path, PYTHONPATH=str(ROOT / "python"))
    assert recorder.wait() == 0, recorder.output
    recorded = people.read(tmp_path / "mine.csv")
    assert [[len(body) for body in there] for _, there in recorded] == [[33, 33 * (i != 4)] for i in range(7)]
    assert sorted(recorded) == recorded and recorded[0][0] < recorded[-1][0]
    with pytest.raises(TypeError, match="a picture is"):
        people.write(tmp_path / "mine.csv", people.play(WALK))


def test_a_model_without_a_camera_is_wrong(start):
    for words in (["--model", "pose.task"], ["--hands", "hands.task"]):
        server = start(PYTHON, LESSON / "server.py", "--endpoint", "tcp://127.0.0.1:0", *words)
        assert server.wait() == 1
        assert server.lines[-1].startswith("no poses: --model and --hands need --camera"), server.output


def test_who_stands_where_in_the_picture_keeps_the_topic(webcam):
    """MediaPipe lists them in any order: an avatar must not become the other one."""
    server = webcam()
    endpoint = server.wait_for(r"^listening on (\S+)")[1]
    seen = {"0": [], "1": []}
    with zmq.Context() as context, context.socket(zmq.SUB) as stream:
        stream.linger = 0
        stream.subscribe("pose/")
        stream.connect(endpoint)
        while min(map(len, seen.values())) < 20:
            assert stream.poll(100_000), server.output
            person, number, rest = re.fullmatch(
                r"pose/(\d)/ (\d+) \d+\.\d{3}((?: \S+)*)", stream.recv().decode()
            ).groups()
            assert not rest or rest.split()[1:4] == ["0.250", "-0.500", "0.900"], "MediaPipe's axes, as they are"
            seen[person].append((int(number), rest.split()[:1]))
    # Person 0 is who was listed first at first: the left one.
    assert {tuple(mark) for _, mark in seen["0"]} == {("1.000",)}
    for number, mark in seen["1"]:
        assert mark == ([] if number % 5 == 0 else ["2.000"]), "nobody, and then the same one again"
    assert server.stop() == 0


def test_a_newcomer_takes_nobodys_place():
    """Whom MediaPipe lists first, and close to where the other one stands."""
    marks = {x: [SimpleNamespace(x=x, y=0.5, z=0.0, visibility=0.9) for _ in range(33)] for x in (0.2, 0.4)}
    listed = SimpleNamespace(pose_landmarks=[marks[0.4], marks[0.2]], pose_world_landmarks=[marks[0.4], marks[0.2]])
    people, places = camera.in_order(listed, [(0.2, 0.5), None])
    assert [body[0][0] for body in people] == [0.2, 0.4] and places == [(0.2, 0.5), (0.4, 0.5)]


def test_hands_have_topics_of_their_own(webcam, tmp_path):
    """Byte by byte; and of two left hands it is the one that looks more like one."""
    server = webcam("--hands", str(tmp_path / "model.task"))
    endpoint = server.wait_for(r"^listening on (\S+)")[1]
    with zmq.Context() as context, context.socket(zmq.SUB) as stream:
        stream.linger = 0
        stream.subscribe("hand/")
        stream.connect(endpoint)
        seen = set()
        while len(seen) < 3:
            assert stream.poll(100_000), server.output
            topic, number, seconds, *rest = stream.recv().decode().split(" ")
            assert re.fullmatch(r"\d+\.\d{3}", seconds)
            there = topic == "hand/left/" or int(number) % 2 == 1
            sign, sure = ("", "0.980") if topic == "hand/left/" else ("-", "0.875")
            assert rest == [f"{sign}0.050", "0.020", "-0.010", sure] * 21 * there
            seen.add((topic, there))
    assert server.stop() == 0


@each_client
def test_a_hand_is_heard(kind, stage, listen):
    """An index finger that is bent by a right angle; then no hand; and what is no hand is passed over."""
    stream, endpoint = stage
    client = listen(kind, endpoint, "--hand", "left", "--count", "2", "--every", "1", "--timeout", "25")
    subscribed(stream, b"hand/left/")
    marks = [(0.001 * i, 0.02, 0.01, 0.98) for i in range(21)]
    marks[5], marks[6], marks[7] = (0, 0.1, 0, 1), (0, 0, 0, 1), (0, 0, -0.1, 1)
    text = message(7, marks).replace("pose/0/", "hand/left/")
    stream.send_string(text + " 0.000")
    stream.send_string(text)
    assert client.wait_for("^left hand: pose 7, finger 90 degrees, 0 ms late$")
    assert body_listener.parse(text).landmarks[1] == (0.001, -0.02, 0.01, 0.98)
    stream.send_string("hand/left/ 8 1.5")
    assert client.wait() == 0, client.output
    assert client.lines[0] == f"listening to 'hand/left/' from {endpoint}"
    assert client.lines[2:] == ["left hand: pose 8, nobody is there", "done: 2 poses, 0 skipped"]


@pytest.mark.parametrize(
    ("words", "there", "says"),
    [
        ([], False, r"no poses: no (cv2|mediapipe): \S+ -m pip install mediapipe opencv-python; or leave out --camera"),
        (["7"], True, "no poses: webcam 7 gives no picture: is it plugged in, or does another program use it?"),
    ],
    ids=["no MediaPipe", "no webcam"],
)
def test_without_a_webcam_it_says_what_is_missing(words, there, says, webcam):
    server = webcam(*words, there=there)
    assert server.wait() == 1, server.output
    assert re.search(says, server.lines[-1]), server.output
    assert "Traceback" not in server.output


def test_without_a_model_it_says_what_is_wrong(webcam, tmp_path, start):
    webcam().kill()
    (tmp_path / "page.task").write_text("a web page", encoding="utf-8")
    for model, says in (
        ("none.task", "there is no model 'none.task': take one from https://"),
        ("page.task", "MediaPipe does not take the model 'page.task': Unable to open zip archive."),
    ):
        command = [PYTHON, LESSON / "server.py", "--endpoint", "tcp://127.0.0.1:0", "--camera", "--model", model]
        server = start(*command, folder=tmp_path, PYTHONPATH=str(tmp_path))
        assert server.wait() == 1
        assert f"no poses: {says}" in server.lines[-1], server.output
        assert "Traceback" not in server.output


# What a method cannot use

NAN = float("nan")
POSE = body_listener.parse(message(1, WALK[0][1][0]))
NOBODY = body_listener.parse(message(1, []))


def listener(socket=None, endpoint="tcp://127.0.0.1:1", topic="pose/0/", timeout=1.0):
    """Waits for a pose on a socket of its own, unless it is given one."""
    with zmq.Context() as context, context.socket(zmq.SUB) as own:
        own.linger = 0
        return body_listener.BodyListener(own if socket is None else socket, endpoint, topic).receive(timeout)


WRONG = {
    "socket": [lambda value: listener(socket=value), 0, "", zmq.SUB],
    "endpoint": [lambda value: listener(endpoint=value), None, 0, "", "tcp://127.0.0.1:99999"],
    "topic": [lambda value: listener(topic=value), None, 0, "", "pose/0", "pose/-1/"],
    "timeout": [lambda value: listener(timeout=value), None, 0, -1, NAN, ""],
    "a": [lambda value: POSE.angle(value, 1, 2), None, -1, NAN, "", 33],
    "a ": [lambda value: NOBODY.angle(value, 1, 2), 0],
    "c": [lambda value: POSE.angle(0, 1, value), None, 33],
    "message": [body_listener.parse, None, 0, b"pose"],
    "path": [people.read, None, 0, NAN],
    "path ": [lambda value: people.write(value, []), None, 0, NAN],
    "seconds": [lambda value: people.write("never.csv", [(value, [])]), None, NAN, ""],
    "landmarks": [lambda value: people.write("never.csv", [(0.0, [value])]), [(0.0,) * 4], [(0.0,) * 4] * 21],
    "pictures": [lambda value: next(people.play(value)), None, 0, "", []],
    "device": [lambda value: next(camera.watch(value, "m.task", 1)), None, -1, NAN, ""],
    "model": [lambda value: next(camera.watch(0, value, 1)), None, 0],
    "persons": [lambda value: next(camera.watch(0, "m.task", value)), None, 0, -1, NAN, ""],
    "hands": [lambda value: next(camera.watch(0, "m.task", 1, value)), 0, NAN],
}


@pytest.mark.parametrize(
    ("name", "call", "value"),
    [(name, call, value) for name, (call, *values) in WRONG.items() for value in values],
    ids=lambda value: None if callable(value) else f"{value!r:.20}",
)
def test_what_a_method_cannot_use_is_named(name, call, value, monkeypatch, tmp_path):
    monkeypatch.chdir(tmp_path)
    with pytest.raises((ValueError, TypeError), match=rf"\b{name.strip()}\b") as caught:
        call(value)
    assert "\n" not in str(caught.value)
