"""Persons and hands in front of a webcam, or in a film: MediaPipe finds them, and nothing else here needs it.

    for people, hands in watch(0, Path("pose_landmarker_lite.task"), persons=2):
        print(people[0][26], hands)                             a landmark of the first person, or IndexError for nobody

It needs mediapipe, which brings OpenCV, and a model: MODELS says where it is. SourceError says what is missing.
Landmarks are as in people.py. MediaPipe's classes are in ai.google.dev/edge/mediapipe/solutions/vision/pose_landmarker.
"""

import contextlib
import math
import re
import time
from collections.abc import Generator, Iterator
from pathlib import Path
from typing import Any

from netmq_example import arguments, check
from netmq_example.body.people import LANDMARKS, Hands, Landmark, People, SourceError
from netmq_example.extras import pip_install

MODELS = "https://ai.google.dev/edge/mediapipe/solutions/vision"
# A person's place in the picture, from 0 to 1; None before it is known.
Place = tuple[float, float] | None


def device(text: str) -> int | str:
    """The type of an option: a webcam's number, a stream's address, or a film's file."""
    return int(text) if text.isdecimal() else arguments.text("device", text)


def watch(
    device: int | str | Path, model: Path, persons: int, hands: Path | None = None
) -> Generator[tuple[People, Hands], None, None]:
    """The persons of each picture, each always in the same place of the list; and with a model for them the hands.

    `device` is a webcam's number, a stream's address, or a film's file, which is played once. close() frees it.
    """
    device = str(device) if isinstance(device, str | Path) and str(device) else check.count("device", device, least=0)
    check.count("persons", persons)
    model = Path(check.instance("model", model, str, Path))
    hands = hands if hands is None else Path(check.instance("hands", hands, str, Path))
    for file in filter(None, (model, hands)):
        if not file.is_file():
            cure = f"take one from {MODELS}, and name it with its option"
            raise SourceError(f"there is no model {file.name!r:.80}: {cure}")
    with starting("cv2"):
        import cv2
    film = isinstance(device, str) and Path(device).is_file()
    with contextlib.ExitStack() as stack:
        camera = cv2.VideoCapture(device)
        # In a notebook an error would keep it, and no other call could have it.
        stack.callback(camera.release)
        there, picture = camera.read()
        if not there:
            raise no_picture(device)
        # MediaPipe takes seconds to start, and prints much: that there is no webcam was said before.
        with starting("mediapipe"):
            import mediapipe
        bodies = stack.enter_context(landmarker(mediapipe, "Pose", model, num_poses=persons))
        fingers = stack.enter_context(landmarker(mediapipe, "Hand", hands, num_hands=2)) if hands else None
        places: list[Place] = [None] * persons
        start = time.monotonic()
        milliseconds = -1
        while there:
            # OpenCV has blue first.
            colours = cv2.cvtColor(picture, cv2.COLOR_BGR2RGB)
            image = mediapipe.Image(image_format=mediapipe.ImageFormat.SRGB, data=colours)
            # MediaPipe wants each picture later than the one before.
            milliseconds = max(milliseconds + 1, int(1000 * (time.monotonic() - start)))
            people, places = in_order(bodies.detect_for_video(image, milliseconds), places)
            yield people, read_hands(fingers.detect_for_video(image, milliseconds)) if fingers else {}
            there, picture = camera.read()
            if film:
                time.sleep(max(0, start + camera.get(cv2.CAP_PROP_POS_MSEC) / 1000 - time.monotonic()))
            elif not there:
                raise no_picture(device)


def no_picture(device: int | str) -> SourceError:
    if isinstance(device, int):
        cure = "is it plugged in, not in use elsewhere, and allowed in the system's privacy settings?"
        return SourceError(f"webcam {device} gives no picture: {cure}")
    # Without the password that an address may have.
    shown = re.sub("//[^/]*@", "//", device)
    return SourceError(f"{shown!a:.200} gives no picture: is it a film's file or a stream's address, and whole?")


@contextlib.contextmanager
def starting(name: str) -> Iterator[None]:
    try:
        yield
    except ModuleNotFoundError as error:
        cure = pip_install("mediapipe")
        raise SourceError(f"no {error.name}: {cure}; or leave out --camera") from None
    except (ImportError, OSError) as error:
        raise SourceError(f"{name} does not start: {with_cure(error, 'leave out --camera')}") from None


def with_cure(error: Exception, cure: str) -> str:
    """In one line, and what to do; a server without a screen lacks libraries, which is another cure."""
    text = " ".join(str(error).split())[:160]
    if "shared object" in text:
        cure = "on Debian and Ubuntu: apt install libgl1 libegl1 libgles2 libglib2.0-0"
    return f"{text}; {cure}"


def landmarker(mediapipe: Any, kind: str, model: Path, **options: int) -> Any:
    vision = mediapipe.tasks.vision
    base = mediapipe.tasks.BaseOptions(model_asset_path=str(model))
    made = getattr(vision, f"{kind}LandmarkerOptions")(
        base_options=base, running_mode=vision.RunningMode.VIDEO, **options
    )
    try:
        return getattr(vision, f"{kind}Landmarker").create_from_options(made)
    except (OSError, LookupError, RuntimeError, ValueError) as error:
        cure = with_cure(error, f"take one from {MODELS}")
        raise SourceError(f"MediaPipe does not take the model {model.name!r:.80}: {cure}") from None


def in_order(result: Any, places: list[Place]) -> tuple[People, list[Place]]:
    """MediaPipe lists the persons in any order: the nearest to a place of the picture before is its person."""
    people: People = [[] for _ in places]
    after = list(places)
    bodies = result.pose_world_landmarks
    hips = [(marks[23], marks[24]) for marks in result.pose_landmarks]
    # Their middle in the picture. Of world landmarks it is always 0.
    middles = [((left.x + right.x) / 2, (left.y + right.y) / 2) for left, right in hips]
    free = set(range(len(places)))
    new = set(range(len(bodies)))
    # The nearest pair first: a newcomer must not take the place of one who stands still.
    pairs = [(distance(middles[i], places[person]), person, i) for person in free for i in new]
    for _, person, i in sorted(pairs):
        if person in free and i in new:
            free.remove(person)
            new.remove(i)
            people[person] = read_landmarks(bodies[i])
            after[person] = middles[i]
    return people, after


def distance(place: tuple[float, float], before: Place) -> float:
    # A place that nobody had yet is taken before one that is far from where its person was.
    return math.dist(place, before) if before else 0.3


def read_landmarks(body: Any) -> list[Landmark]:
    return [(mark.x, mark.y, mark.z, mark.visibility) for mark in body[:LANDMARKS]]


def read_hands(result: Any) -> Hands:
    """A left and a right one. In place of a visibility, which hands have not, is how sure it is which of both it is."""
    hands: Hands = {"hand/left": [], "hand/right": []}
    # Of two left hands the surest one: it comes last.
    found = zip(result.handedness, result.hand_world_landmarks, strict=True)
    for sides, hand in sorted(found, key=lambda one: one[0][0].score):
        hands[f"hand/{sides[0].category_name.lower()}"] = [(mark.x, mark.y, mark.z, sides[0].score) for mark in hand]
    return hands
