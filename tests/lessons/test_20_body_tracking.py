"""Application 20: the persons of a recording and of a webcam, the newest pose, a server that is started again.

tests/unity/test_20_body.py has what only Unity has: the skeleton, the avatar and the smoothing.
"""

import importlib
import itertools
import re
import sys
import time

import pytest
import zmq

from netmq_example.body import camera, people
from netmq_example.body import listener as body_listener
from tests.conftest import CLIENTS, PYTHON
from tests.lessons.conftest import where
from tests.programs import ROOT

KEY = "20_body_tracking"
LESSON = ROOT / "python" / KEY
GERMAN = {"LANG": "de_DE.UTF-8", "LC_ALL": "de_DE.UTF-8"}
each_client = pytest.mark.parametrize("kind", CLIENTS)
# walker.py is beside the server.
sys.path.append(str(LESSON))
WALK = importlib.import_module("walker").persons()


def message(number, body, person=0, seconds=1.5):
    numbers = [f"{value:.3f}" for landmark in body for value in landmark]
    return " ".join([f"pose/{person}/ {number} {seconds:.3f}", *numbers])


def knee(number, person):
    """The right knee's angle in the pose of this number, whole degrees."""
    _, there = WALK[(number - 1) % len(WALK)]
    return f"{body_listener.parse(message(number, there[person])).angle(24, 26, 28):.0f}"


# Persons without a webcam


def test_a_person_is_seen_to_move(serve, start_client, connect):
    """Each printed angle is that of the walker's pose of this number, whichever client it is."""
    begin = time.monotonic()
    _, endpoint = serve(KEY, **GERMAN)
    clients = []
    for kind, person in ("python", 0), ("python", 1), ("csharp", 1), ("unity", 1):
        words = ["--person", str(person), "--count", "25", "--every", "4"]
        clients.append((person, start_client(kind, KEY, endpoint, *words, "--timeout", "60", **GERMAN)))
    for person, client in clients:
        assert client.wait() == 0, client.output
        first, *seen, last = client.lines
        assert first == f"listening to 'pose/{person}/' from {endpoint}"
        assert re.fullmatch(r"done: 25 poses, \d+ skipped", last)
        form = rf"person {person}: pose (\d+), right knee (\d+) degrees, \d+ ms late"
        found = [re.fullmatch(form, line) for line in seen]
        assert len(found) == 7 and all(found), client.output
        assert [match[2] for match in found] == [knee(int(match[1]), person) for match in found]
        # A walker has a straight leg for half a second, which is 15 poses.
        assert len({match[2] for match in found}) > 1
    # Seconds are the computer's: else each pose of a server that was started again would seem to be late.
    seconds = body_listener.parse(connect(endpoint, zmq.SUB, "pose/0/").recv().decode()).seconds
    assert begin - 0.001 < seconds < time.monotonic() + 0.001


def test_a_recording_of_ones_own_is_played_over_and_over(serve, tmp_path):
    """With a person who is not there at first: nobody is something else than silence."""
    body = [(0.5, -0.25, 0.125, 1.0)] * 33
    people.write(tmp_path / "mine.csv", [(0.0, [body, []]), (0.02, [body, body])])
    assert people.read(tmp_path / "mine.csv") == [(0.0, [body, []]), (0.02, [body, body])]
    _, endpoint = serve(KEY, "--recording", str(tmp_path / "mine.csv"))
    numbers = set()
    with body_listener.BodyListener(endpoint, "pose/1/") as listener:
        while len(numbers) < 6 or {number % 2 for number in numbers} != {0, 1}:
            pose = listener.receive(100)
            assert len(pose.landmarks) == (0 if pose.number % 2 else 33)
            numbers.add(pose.number)


HEADER = ",".join(people.HEADER) + "\n"
WRONG_ROWS = [
    "0.0,0,1",
    "0.0,1" + ",1" * 132,
    *(row + ",1" * 131 for row in ("x,0,1", "0.0,0,nan", "inf,0,1", "0.0,0,1e300")),
]
NO_RECORDINGS: list[tuple[bytes | None, str]] = [
    (None, "cannot read 'mine.csv': .*No such file"),
    (b"\xff\xfe", "cannot read 'mine.csv': .*decode"),
    (b"a,b\n1,2\n", "'mine.csv' is no recording: it must begin with the line seconds,person,x0,y0,z0,v0"),
    (HEADER.encode(), "'mine.csv' is a recording of nothing: below its first line there is no person"),
    *(
        (f"{HEADER}{row}\n".encode(), "line 2 of the recording must be seconds, person 0 and 132 n")
        for row in WRONG_ROWS
    ),
]


def test_what_is_no_recording_is_said_in_one_line(runs, tmp_path):
    words = [["--model", "pose.task"], ["--hands", "hands.task"]]
    for number, (content, _) in enumerate(NO_RECORDINGS):
        file = tmp_path / str(number) / "mine.csv"
        file.parent.mkdir()
        if content is not None:
            file.write_bytes(content)
        words.append(["--recording", str(file)])
    alone, alone_too, *found = runs("server", KEY, [["--endpoint", "tcp://127.0.0.1:0", *each] for each in words])
    for run in alone, alone_too:
        assert run.code == 1 and run.lines[-1].startswith("no poses: --model and --hands need --camera"), run
    for run, (_, says) in zip(found, NO_RECORDINGS, strict=True):
        assert run.code == 2 and re.search(f"argument --recording: {says}", run.lines[-1]), run
        assert "Traceback" not in str(run.lines)


def test_a_recording_that_excel_has_saved_is_read(tmp_path):
    """It puts a byte order mark in front, and writes CR LF; a person without a line in a picture is not there."""
    rows = [f"{when},{person}" + ",0.5" * 132 + "\n" for when, person in ((0.0, 0), (0.0, 1), (0.5, 0))]
    (tmp_path / "mine.csv").write_bytes((HEADER + "".join(rows)).replace("\n", "\r\n").encode("utf-8-sig"))
    body = [(0.5,) * 4] * 33
    assert people.read(tmp_path / "mine.csv") == [(0.0, [body, body]), (0.5, [body, []])]


# A server that goes, and one that the test decides for


def test_the_newest_wins(fake, start_client):
    """While the clients work on 1 the others arrive; each takes the last of them, and counts the rest."""
    stream, endpoint = fake, where(fake)
    # The second one's subscription is shown as well.
    stream.xpub_verbose = True
    words = ["--count", "2", "--every", "1", "--work", "3", "--timeout", "60"]
    clients = [start_client(kind, KEY, endpoint, *words) for kind in ("python", "csharp")]
    assert [stream.recv() for _ in clients] == [b"\x01pose/0/"] * 2
    body = WALK[0][1][0]
    stream.send_string(message(1, body))
    for client in clients:
        client.wait_for("^person 0: pose 1, right knee")
    for number in range(2, 101):
        stream.send_string(message(number, body))
    for client in clients:
        assert client.wait() == 0, client.output
        assert client.lines[2].startswith("person 0: pose 100, right knee")
        assert client.lines[3:] == ["done: 2 poses, 98 skipped"]


@each_client
def test_poses_that_are_late_come_twice_or_are_none(kind, fake, start_client):
    stream, endpoint = fake, where(fake)
    client = start_client(kind, KEY, endpoint, "--count", "6", "--every", "1", "--timeout", "60", "--person", "12")
    assert stream.recv() == b"\x01pose/12/"

    def seen(number, body, line, seconds=100.0):
        begin = len(client.lines)
        stream.send_string(message(number, body, 12, seconds))
        return client.wait_for(f"^person 12: pose {number}, {line}$", start=begin)

    body = WALK[0][1][0]
    seen(7, body, r"right knee \d+ degrees, 0 ms late")
    # It was on its way for two seconds longer than the first, by the server's clock.
    assert int(seen(8, body, r"right knee \d+ degrees, (\d+) ms late", 98.0)[1]) >= 2000
    good = message(9, body, 12)
    for wrong in ("", " x", " 1", good[8:-1] + "nan", good[8:] + " 1", good[8:].replace(".", ",")):
        stream.send_string("pose/12/" + wrong)
    stream.send(b"pose/12/ \xff\x00")
    # The same one once more is no start of a server, and none that was skipped.
    seen(8, [], "nobody is there")
    seen(11, [], "nobody is there")
    # Of another server's clock nothing is known yet.
    seen(2, body, r"right knee \d+ degrees, 0 ms late", 1.0)
    seen(3, [], "nobody is there", 1.0)
    assert client.wait() == 0, client.output
    assert client.lines[5] == "person 12: the server was started again"
    assert client.lines[8:] == ["done: 6 poses, 2 skipped"]


def test_a_stream_without_a_pose_is_given_up(fake, start_client):
    """However much of something else comes."""
    stream, endpoint = fake, where(fake)
    clients = [start_client(kind, KEY, endpoint, "--timeout", "3") for kind in ("python", "csharp")]
    while any(client.process.poll() is None for client in clients):
        stream.send_string("pose/0/ something else")
        time.sleep(0.01)
    for client in clients:
        assert client.wait() == 1
        assert client.lines[-1] == f"gave up: no pose from {endpoint} within 3 s; is that this server?"


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
            # What MediaPipe 1.2 raises for a page, half a download, a model of another kind and a bare .tflite.
            kinds = {each.__name__: each for each in (RuntimeError, ValueError, FileNotFoundError, KeyError, OSError)}
            kind, _, text = model.read().partition(": ")
            if kind in kinds: raise kinds[kind](text)
        cls.times = []
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
OPENCV = '''
import time
from types import SimpleNamespace
COLOR_BGR2RGB = 4
def cvtColor(picture, code):
    assert (picture, code) == ("BGR of a picture", 4)
    return "RGB of a picture"
CAP_PROP_POS_MSEC = 0
class VideoCapture:
    """A webcam, which only one has at a time, and films of three pictures."""
    taken = False
    def __init__(self, device):
        self.device, self.count = device, 0
        self.mine = device == 0 and not VideoCapture.taken
        VideoCapture.taken |= self.mine
    def release(self): VideoCapture.taken &= not self.mine
    def get(self, what): return 20.0 * self.count
    def read(self):
        time.sleep(0.02)
        self.count += 1
        if self.device == "rtsp://me:secret@camera/1" and self.count > 1: return False, None
        there = self.mine or isinstance(self.device, str) and self.count <= 3
        return (True, "BGR of a picture") if there else (False, None)
'''


@pytest.fixture
def webcam(tmp_path, monkeypatch):
    """A folder with MediaPipe and OpenCV, which are found here as well, and a model."""
    for name, text in (("mediapipe", STAND_IN), ("cv2", OPENCV)):
        (tmp_path / f"{name}.py").write_text(text, encoding="utf-8")
        monkeypatch.delitem(sys.modules, name, raising=False)
    monkeypatch.syspath_prepend(str(tmp_path))
    (tmp_path / "model.task").touch()
    yield tmp_path
    for name in ("mediapipe", "cv2"):
        sys.modules.pop(name, None)


def test_a_webcam_is_recorded_as_the_page_says(webcam, start):
    """The program on the page, with fewer pictures; and what `watch` yields is no picture with its time."""
    page = (ROOT / "docs" / "guide" / f"{KEY}.md").read_text(encoding="utf-8")
    (program,) = re.findall("```python\n(import itertools.*?)```", page, re.DOTALL)
    assert "pose_landmarker_lite.task" in program and " 300)" in program
    (webcam / "mine.py").write_text(program.replace("pose_landmarker_lite", "model").replace(" 300)", " 7)"))
    recorder = start(PYTHON, "mine.py", folder=webcam, PYTHONPATH=str(ROOT / "python"))
    assert recorder.wait() == 0, recorder.output
    recorded = people.read(webcam / "mine.csv")
    assert [[len(body) for body in there] for _, there in recorded] == [[33, 33 * (i != 4)] for i in range(7)]
    assert sorted(recorded) == recorded and recorded[0][0] < recorded[-1][0]
    with pytest.raises(TypeError, match="a picture is"):
        people.write(webcam / "mine.csv", people.play(WALK))


def test_who_stands_where_in_the_picture_keeps_the_topic(webcam):
    """MediaPipe lists them in any order: an avatar must not become the other one."""
    watching = camera.watch(0, webcam / "model.task", 2)
    for number, (there, hands) in enumerate(itertools.islice(watching, 10), 1):
        # Person 0 is the one that was listed first at first: the left one.
        left, right = there
        assert left[0] == (1.0, 0.25, -0.5, 0.9), "MediaPipe's axes, as they are"
        assert [body[0] for body in right[:1]] == ([] if number % 5 == 0 else [2.0]), "nobody, then the same one again"
        assert hands == {}
    assert all(later > earlier for earlier, later in itertools.pairwise(sys.modules["mediapipe"].PoseLandmarker.times))


def test_a_film_is_watched_to_its_end_and_a_stream_as_long_as_it_lasts(webcam, start):
    (webcam / "walk.mp4").touch()
    assert len([*camera.watch(webcam / "walk.mp4", webcam / "model.task", 2)]) == 3
    stream = camera.watch("rtsp://me:secret@camera/1", webcam / "model.task", 2)
    assert next(stream)
    with pytest.raises(people.SourceError, match=r"^'rtsp://camera/1' gives no picture: is it a film's file or a "):
        next(stream)
    words = ["--endpoint", "tcp://127.0.0.1:0", "--model", "model.task", "--camera", "walk.mp4"]
    server = start(PYTHON, LESSON / "server.py", *words, folder=webcam, PYTHONPATH=str(webcam))
    assert server.wait() == 0 and server.lines[-1] == "the film is over", server.output


def test_hands_have_topics_of_their_own(webcam, start, connect):
    """Byte by byte; and of two left hands it is the one that looks more like one."""
    model = webcam / "model.task"
    words = ["--endpoint", "tcp://127.0.0.1:0", "--camera", "--model", model, "--hands", model]
    server = start(PYTHON, LESSON / "server.py", *words, PYTHONPATH=str(webcam))
    endpoint = server.wait_for(r"^listening on (\S+)")[1]
    stream, seen = connect(endpoint, zmq.SUB, ""), set()
    while len(seen) < 5:
        topic, number, seconds, *rest = stream.recv().decode().split(" ")
        assert re.fullmatch(r"\d+\.\d{3}", seconds)
        if topic.startswith("hand/"):
            there = topic == "hand/left/" or int(number) % 2 == 1
            sign, sure = ("", "0.980") if topic == "hand/left/" else ("-", "0.875")
            assert rest == [f"{sign}0.050", "0.020", "-0.010", sure] * 21 * there
            seen.add((topic, there))
        else:
            assert rest[1:4] in ([], ["0.250", "-0.500", "0.900"])
            seen.add((topic, True))
    assert seen == {("pose/0/", True), ("pose/1/", True), ("hand/left/", True), *{("hand/right/", it) for it in (0, 1)}}
    assert server.stop() == 0


@each_client
def test_a_hand_is_heard(kind, fake, start_client):
    """An index finger that is bent by a right angle; then no hand; and what is no hand is passed over."""
    stream, endpoint = fake, where(fake)
    client = start_client(kind, KEY, endpoint, "--hand", "left", "--count", "2", "--every", "1", "--timeout", "25")
    assert stream.recv() == b"\x01hand/left/"
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


def test_without_a_webcam_or_a_model_it_says_what_is_wrong(webcam):
    def says(pattern, device=0, model="model.task", **more):
        with pytest.raises(people.SourceError, match=pattern):
            next(camera.watch(device, webcam / model, 2, **more))

    says("^webcam 7 gives no picture: is it plugged in, not in use elsewhere, and allowed in the .* settings[?]$", 7)
    says("^there is no model 'none.task': take one from https://", model="none.task")
    says("^there is no model 'none.task': take one from https://", hands=webcam / "none.task")
    missing = "libEGL.so.1: cannot open shared object file: No such file or directory"
    cure = "; on Debian and Ubuntu: apt install libgl1 libegl1 libgles2 libglib2.0-0$"
    long, short = "no such\nfile in it" + "!" * 900, ".?no such.{,3}file in it!{100,150}; take one from https://"
    for text, pattern in [
        ("RuntimeError: Unable to open zip archive.", "Unable to open zip archive.; take one from https://"),
        *((f"{kind}: {long}", short) for kind in ("FileNotFoundError", "KeyError", "ValueError", "OSError")),
        (f"OSError: {missing}", missing + cure),
    ]:
        (webcam / "bad.task").write_text(text, encoding="utf-8")
        says(f"^MediaPipe does not take the model 'bad.task': {pattern}", model="bad.task")
    for module in ("mediapipe", "cv2"):
        absent = rf"^no {module}: \S+ -m pip install mediapipe; or leave out --camera$"
        for error, pattern in (
            (f"ImportError({missing!r})", f"^{module} does not start: {missing}{cure}"),
            (f"OSError({missing!r})", f"^{module} does not start: {missing}{cure}"),
            ("ModuleNotFoundError('not here', name=__name__)", absent),
        ):
            (webcam / f"{module}.py").write_text(f"raise {error}  # {pattern}", encoding="utf-8")
            sys.modules.pop(module, None)
            importlib.invalidate_caches()
            says(pattern)


def test_a_landmark_without_a_place_is_named_and_never_written(tmp_path):
    body = [(0.0, 0.0, 0.0, 0.5)] * 33
    for wrong in ((float("nan"),) * 4, (0.0, 0.0, float("inf"), 1.0), (0.0, 1e9, 0.0, 1.0), (0.0, 0.0, 0.0)):
        body[26] = wrong
        with pytest.raises(people.SourceError, match=r"^landmark 26 is .*, and not four numbers: .* visibility 0$"):
            people.as_text(body)
        with pytest.raises(people.SourceError, match=r"^landmark 26 is "):
            people.write(tmp_path / "mine.csv", [(0.0, [body])])
