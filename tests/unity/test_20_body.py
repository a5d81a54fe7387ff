"""Application 20 in the player: axes and smoothing to the bit on each runtime, the avatar, and what a frame costs."""

import importlib
import math
import re
import sys

import pytest
import zmq

from netmq_example.body import listener as body_listener
from tests.programs import ROOT, leaves_nothing_to_collect
from tests.unity.conftest import NEAREST

sys.path.append(str(ROOT / "python" / "20_body_tracking"))
walker = importlib.import_module("walker")
SCRIPTS = ROOT / "unity" / "Assets" / "NetMQExample" / "20_body_tracking"
GERMAN = {"LANG": "de_DE.UTF-8", "LC_ALL": "de_DE.UTF-8"}
# As in OneEuroFilter.cs.
CUTOFF, BETA, FASTEST = 1.5, 5.0, 6.0


def message(number, body, person=0):
    numbers = [f"{value:.3f}" for landmark in body for value in landmark]
    return " ".join([f"pose/{person}/ {number} {number / 30:.3f}", *numbers])


def walk(person=0):
    """To the millimetre, as it is published."""
    bodies = [there[person] for _, there in walker.persons()]
    return [[tuple(round(value, 3) for value in landmark) for landmark in body] for body in bodies]


class Filter:
    """The One Euro filter as its paper has it, with a limit of speed: written for this test, number by number."""

    def __init__(self):
        self.values: list[float] = []
        self.speeds: list[float] = []

    def step(self, target, dt):
        if not self.values:
            self.values, self.speeds = list(target), [0.0] * len(target)
        for i, wanted in enumerate(target):
            way = wanted - self.values[i]
            self.speeds[i] += share(1, dt) * (way / dt - self.speeds[i])
            move = share(CUTOFF + BETA * abs(self.speeds[i]), dt) * way
            self.values[i] += max(-FASTEST * dt, min(FASTEST * dt, move))
        return self.values


def share(frequency, dt):
    turned = 2 * math.pi * frequency * dt
    return turned / (turned + 1)


@pytest.mark.parametrize("runtime", ["mono", "dotnet"])
def test_axes_angles_and_smoothing_are_the_same_numbers_everywhere(runtime, play, tmp_path):
    """To the bit, but for the angle, whose arc cosine each runtime has its own of; and on a German machine."""
    corner = [(0.001 * i, 0.25, -0.5, 0.75) for i in range(33)]
    corner[24], corner[26], corner[28] = (0, 0, 0, 1), (0, 0.4, 0, 1), (0, 0.4, -0.3, 1)
    odd = ["pose/0/ 1 0.0 1", "pose/0/ x 0.0", message(5, corner).replace(" 0.750", " nan", 1), "news/ 1 0.0"]
    odd += [message(5, corner).replace(" 0.750", " 0,750", 1), message(5, corner) + " 1"]
    # Some languages read these as numbers, others do not.
    words = ("+5", ".5", "5.", "0.0123456789", "1e5", "1234567890", "Infinity", "\u0665", "0\0", "")
    odd += [message(5, corner).replace(" 0.750", f" {word}", 1) for word in words]
    odd += [
        f"pose/0/ {words}" for words in ("1 1", "1 -1.0", "-1 1.0", "1234567890123456789 1.0", "1\0 1.0", "1 1.0\0")
    ]
    odd += ["pose/x/ 1 1.0", "pose/0/x 1 1.0", "pose/0 1 1.0", "pose/\u0660/ 1 1.0"]
    # The last body is half a metre away, which the limit of speed makes a way of several frames.
    bodies = [corner, *walk()[:4], [(x + 0.5, y, z, v) for x, y, z, v in walk()[4]]]
    file = tmp_path / "messages.txt"
    said = [*odd, "pose/0/ 8 0.2", *(message(i, body) for i, body in enumerate(bodies, 1))]
    file.write_text("\n".join(said), encoding="utf-8")
    program = play("body", f"numbers={file}", runtime=runtime, **GERMAN)
    assert program.wait() == 0, program.output
    lines = [(line.split()[0], [float(word) for word in line.split()[1:]]) for line in program.lines]
    assert lines[: len(odd)] == [("pose", [])] * len(odd)
    assert [body_listener.parse(each) for each in odd] == [None] * len(odd)
    assert lines[len(odd)] == ("pose", [8.0, 0.2])
    assert body_listener.parse(said[len(odd)]) == (8, 0.2, [])
    told, model = iter(lines[len(odd) + 1 :]), Filter()
    knees = []
    for number, body in enumerate(bodies, 1):
        pose = body_listener.parse(message(number, body))
        places = [value for landmark in pose.landmarks for value in landmark[:3]]
        assert places[1] == -round(body[0][1], 3), "up is up"
        assert next(told) == ("pose", [pose.number, pose.seconds])
        assert next(told) == ("places", places)
        assert next(told) == ("visibility", [landmark[3] for landmark in pose.landmarks])
        name, knee = next(told)
        assert (name, knee) == ("knee", [pytest.approx(pose.angle(24, 26, 28), abs=1e-6)])
        knees += knee
        before = model.values[0] if model.values else 0
        for _ in range(2):
            smooth = model.step(places, 1 / 60)
        assert next(told) == ("smooth", smooth)
    assert knees[0] == pytest.approx(90, abs=1e-6)
    assert list(told) == []
    # Worked out by hand: two steps of a sixtieth of a second at the limit of 6 m/s, while half a metre was to go.
    assert smooth[0] - before == pytest.approx(0.2, abs=1e-9)


@pytest.fixture
def stage():
    """A publisher of the test's own, which sees subscriptions come; and where it is."""
    with zmq.Context() as context, context.socket(zmq.XPUB) as stream:
        stream.linger = 0
        port = stream.bind_to_random_port("tcp://127.0.0.1")
        yield stream, f"endpoint=tcp://127.0.0.1:{port}"


def publish(stream, bodies, first, program):
    """One pose after the other, each once the script has logged the one before it: so none is skipped."""
    for number, body in enumerate(bodies, first):
        begin = len(program.lines)
        stream.send_string(message(number, body))
        program.wait_for(f"^person 0: pose {number}, ", start=begin)


def test_an_avatar_does_what_the_person_does(play, stage):
    """Each limb points where its landmarks say; hips, chest and face look where the person's do, and the knees too."""
    stream, endpoint = stage
    # Turned half to the side in mid-step, and as it comes.
    body = walk()[7]
    # The smoothing needs some frames to get there: it stands still meanwhile.
    program = play("body", endpoint, "count=40", "every=1", "timeout=60", runtime=NEAREST)
    assert stream.poll(20_000) and stream.recv() == b"\x01pose/0/"
    publish(stream, [body] * 40, 1, program)
    assert program.wait() == 0, program.output
    said = {
        match[1]: tuple(map(float, match[2].split()))
        for line in program.lines
        if (match := re.match(r"(\w+ (?:points|looks)) (.+)", line))
    }
    places = [(x, -y, z) for x, y, z, _ in body]

    def between(a, b):
        way = [there - here for here, there in zip(places[a], places[b], strict=True)]
        return pytest.approx([part / math.hypot(*way) for part in way], abs=2e-3)

    for side, shift in (("Left", 0), ("Right", 1)):
        for bone, a, b in (("UpperArm", 11, 13), ("LowerArm", 13, 15), ("UpperLeg", 23, 25), ("LowerLeg", 25, 27)):
            assert said[f"{side}{bone} points"] == between(a + shift, b + shift), f"{side}{bone}"
    assert said["LeftFoot points"] == between(27, 31)
    assert "RightFoot points" not in said, "a character without toes"
    # The walker is turned by 0.9 from looking into the camera, which in Unity is to look along -z.
    ahead = (math.sin(0.9), 0, -math.cos(0.9))
    assert said["Hips looks"] == pytest.approx(ahead, abs=5e-3)
    assert said["Spine looks"] == pytest.approx(ahead, abs=5e-3)
    assert said["Head looks"] == pytest.approx(ahead, abs=0.05), "eyes and nose are not quite as high as the ears"
    shin = said["LeftLowerLeg looks"]
    assert shin[0] * math.sin(0.9) - shin[2] * math.cos(0.9) > 0.5, "the knee bends ahead"


@pytest.mark.parametrize(
    ("lacks", "said"),
    [
        # Unity hides them where Optimize Game Objects is ticked: it is human, and has no Transform for any bone.
        (
            "bones=hidden",
            "character has no bones in the scene: in its import settings untick Rig, Optimize Game Objects",
        ),
        # In the editor, where one can drag a character into the field.
        ("character=none", "PoseAvatar: drag a character into its field"),
    ],
)
def test_what_an_avatar_lacks_is_said_once_with_its_cure(lacks, said, play):
    program = play("body", "endpoint=tcp://127.0.0.1:9", lacks, "timeout=0.3")
    program.wait_for("^trouble: nothing from ")
    assert sum(line.endswith(said) for line in program.lines) == 1, program.output
    assert "NullReference" not in program.output


def test_a_restart_of_the_server_makes_no_jump(play, stage):
    """After it the person stands two metres away: the body gets there, and no joint is faster than the limit."""
    stream, endpoint = stage
    body = walk()[0]
    program = play("body", endpoint, "count=60", "every=1", "timeout=60")
    assert stream.poll(20_000) and stream.recv() == b"\x01pose/0/"
    publish(stream, [body] * 10, 1, program)
    publish(stream, [[(x + 2, y, z, v) for x, y, z, v in body]] * 50, 1, program)
    assert program.wait() == 0, program.output
    assert program.lines.count("person 0: the server was started again") == 1
    fastest = float(program.wait_for(r"^fastest ([\d.]+) m/s$")[1])
    assert 1 < fastest <= FASTEST * 1.01


@pytest.mark.xdist_group("times")
def test_what_a_frame_costs(play, serve, capsys):
    """A second of a person as avatar and skeleton at once."""
    _, endpoint = serve("20_body_tracking")
    program = play("body", f"endpoint={endpoint}", "count=0", "every=0", "frames=60")
    assert program.wait(120) == 0, program.output
    cost = program.wait_for("^cost: .*")[0]
    with capsys.disabled():
        print(f"\nbody: {cost}")
    assert leaves_nothing_to_collect(cost), cost


def test_a_skeleton_shows_a_hand(play, stage):
    """21 spheres, and lines that reach each of them from the wrist; the avatar says that it wants a person."""
    stream, endpoint = stage
    program = play("body", endpoint, "hand=right", "count=1", "every=1", "timeout=60")
    assert stream.poll(20_000) and stream.recv() == b"\x01hand/right/"
    marks = [(0.01 * i, 0.0, 0.0, 0.9) for i in range(21)]
    stream.send_string(message(1, marks).replace("pose/0/", "hand/right/"))
    assert program.wait() == 0, program.output
    assert "an avatar needs a person: leave the field Hand of BodyTracker empty" in program.lines
    assert any(line.startswith("right hand: pose 1, finger 180 degrees") for line in program.lines), program.output
    hand = (SCRIPTS / "BodyLines.cs").read_text(encoding="utf-8").partition(" Hand =")[2]
    pairs = re.findall(r"\((\d+), (\d+)\)", hand)
    assert len(pairs) == 21 and {int(end) for pair in pairs for end in pair} == set(range(21))
    assert f"skeleton: 21 joints, {len(pairs)} lines" in program.lines
