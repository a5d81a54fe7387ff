"""A recording of persons: a CSV file, with a line for each pose of each person.

seconds,person,x0,y0,z0,v0,x1,…,v32      33 landmarks, numbered and in metres as MediaPipe has them; v: visibility

write(Path("mine.csv"), [(0.0, [body, []]), (0.033, [body, other])])         [] is nobody
for people, hands in play(read(Path("mine.csv"))): ...                       each picture when it is due, for ever
"""

import csv
import itertools
import math
import time
from collections.abc import Iterable, Iterator
from pathlib import Path

from netmq_example import arguments, check

# x, y, z, and how sure it is that this landmark is seen, from 0 to 1.
Landmark = tuple[float, float, float, float]
# The persons of one picture: 33 landmarks each, and none for one who is not there.
People = list[list[Landmark]]
# "hand/left" and "hand/right": 21 landmarks each, and none for one that is not there. Nobody knows whose they are.
Hands = dict[str, list[Landmark]]
# With the time of each, in seconds.
Pictures = list[tuple[float, People]]
LANDMARKS = 33
# Of a recording, all of which is in memory: some hours.
LARGEST_BYTES = 256 * 1024 * 1024
HEADER = ["seconds", "person", *(f"{name}{i}" for i in range(LANDMARKS) for name in "xyzv")]


class SourceError(ValueError):
    """Why there are no persons to be had: one line for the user."""


def as_text(landmarks: list[Landmark]) -> list[str]:
    """Four words for each, in millimetres: a webcam does not know more. SourceError names one that is no place."""
    for number, landmark in enumerate(landmarks):
        # Nor is NaN below 1000. No body is a kilometre long.
        if len(landmark) != 4 or not all(abs(value) < 1000 for value in landmark):
            cure = "one that is not seen has its last place, or 0, 0, 0, and visibility 0"
            raise SourceError(f"landmark {number} is {' '.join(map(str, landmark)):.60}, and not four numbers: {cure}")
    return [f"{value:.3f}" for landmark in landmarks for value in landmark]


def write(path: Path, pictures: Iterable[tuple[float, People]]) -> None:
    """The persons of each picture, with its time: `watch` and `play` know of no times."""
    with Path(check.instance("path", path, str, Path)).open("w", encoding="utf-8", newline="") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(HEADER)
        for seconds, people in pictures:
            # `watch` yields pairs too, of which nothing would be written.
            if not check.is_number(seconds):
                raise TypeError("a picture is (seconds, people), such as (time.monotonic(), people)")
            for person, body in enumerate(people):
                if len(body) not in (0, LANDMARKS):
                    raise ValueError(f"a person has {LANDMARKS} landmarks, or none, not {len(body)}")
                writer.writerow([f"{seconds:.3f}", person, *(as_text(body) or [""] * 4 * LANDMARKS)])


def read(path: Path) -> Pictures:
    """Each picture's time and persons. Each person has a line, in order; for nobody it is empty, or left out."""
    path = Path(check.instance("path", path, str, Path))
    try:
        # Excel puts a mark in front of what it saves.
        with arguments.regular_file(path, LARGEST_BYTES).open(encoding="utf-8-sig", newline="") as file:
            rows = list(csv.reader(file))
    except (OSError, ValueError, csv.Error) as error:
        raise SourceError(f"cannot read {path.name!r:.80}: {error!s:.80}; name another file") from None
    if rows[:1] != [HEADER]:
        cure = "it must begin with the line seconds,person,x0,y0,z0,v0,…"
        raise SourceError(f"{path.name!r:.80} is no recording: {cure}")
    if len(rows) < 2:
        raise SourceError(f"{path.name!r:.80} is a recording of nothing: below its first line there is no person")
    pictures = []
    for seconds, lines in itertools.groupby(enumerate(rows[1:], start=2), key=lambda line: line[1][:1]):
        people = [read_body(number, row, person) for person, (number, row) in enumerate(lines)]
        pictures.append((float(seconds[0]), people))
    # A person without a line in a picture is not there: that is said, which is not the same as silence.
    most = max(len(people) for _, people in pictures)
    return [(seconds, people + [[]] * (most - len(people))) for seconds, people in pictures]


def read_body(number: int, row: list[str], person: int) -> list[Landmark]:
    try:
        values = [float(word) for word in row[2:]] if any(row[2:]) else []
        known = len(row) == len(HEADER) and int(row[1]) == person and math.isfinite(float(row[0]))
        # No body is a kilometre long: listeners would take none of its poses.
        if known and all(abs(value) < 1000 for value in values):
            return [(x, y, z, v) for x, y, z, v in zip(*(values[i::4] for i in range(4)), strict=True)]
    except (ValueError, IndexError):
        pass
    raise SourceError(f"line {number} of the recording must be seconds, person {person} and {4 * LANDMARKS} numbers")


def begun(pictures: Iterator[tuple[People, Hands]]) -> Iterator[tuple[People, Hands]]:
    """The same, once the first of them is there."""
    return itertools.chain([next(pictures)], pictures)


def play(pictures: Pictures) -> Iterator[tuple[People, Hands]]:
    """Each picture when it is due, over and over. There are no hands in a recording."""
    if not pictures or not isinstance(pictures, list):
        raise ValueError(f"pictures takes a list of at least one picture, as read() returns it, not {pictures!r:.40}")
    due = time.monotonic()
    # The last picture is shown as long as the one before it; then comes the first.
    gaps = [later[0] - earlier[0] for earlier, later in itertools.pairwise(pictures)] or [1.0]
    for (_, people), gap in itertools.cycle(zip(pictures, [*gaps, gaps[-1]], strict=False)):
        yield people, {}
        due += min(max(gap, 0.001), 1)
        time.sleep(max(0, due - time.monotonic()))
