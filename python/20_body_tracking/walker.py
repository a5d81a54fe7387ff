"""Application 20, two persons without a webcam: made up here, so that there is something to see.

for people, hands in play(persons()): ...

Person 0 walks on the spot, turned half to the side. Person 1 faces the camera, raises its arms and bends its knees.
"""

import math

from netmq_example.body.people import Landmark, Pictures

PICTURES_A_SECOND = 30
SECONDS = 3
# A place in metres from the middle of the hips: forward, to the person's left, up.
Place = tuple[float, float, float]


def bend(start: Place, length: float, forward: float, left: float = 0) -> Place:
    """The end of a limb that hangs down, swung forward and to the left by these angles."""
    down = length * math.cos(forward)
    return (start[0] + length * math.sin(forward), start[1] + down * math.sin(left), start[2] - down * math.cos(left))


def limbs(side: int, arm: float, raised: float, elbow: float, thigh: float, knee: float) -> list[Place]:
    """One side's shoulder, elbow, wrist, three fingers, hip, knee, ankle, heel and toes; side 1 is left, -1 right."""
    shoulder = (0.0, 0.18 * side, 0.5)
    hip = (0.0, 0.1 * side, 0.0)
    middle = bend(shoulder, 0.28, arm, raised * side)
    wrist = bend(middle, 0.25, arm + elbow, raised * side)
    fingers = [bend(wrist, 0.09, arm + elbow + spread, raised * side) for spread in (-0.3, 0, 0.3)]
    shin = bend(hip, 0.42, thigh)
    ankle = bend(shin, 0.41, thigh - knee)
    feet = [(ankle[0] + ahead, ankle[1], ankle[2] - 0.06) for ahead in (-0.05, 0.16)]
    return [shoulder, middle, wrist, *fingers, hip, shin, ankle, *feet]


def body(left: list[Place], right: list[Place], turn: float) -> list[Landmark]:
    """The 33 landmarks in MediaPipe's order and axes: x to the right of the picture, y down, z away from the camera."""
    eyes = [(0.09, side * out, 0.735) for side in (1, -1) for out in (0.02, 0.035, 0.05)]
    rest = [(0.0, 0.075, 0.72), (0.0, -0.075, 0.72), (0.09, 0.025, 0.655), (0.09, -0.025, 0.655)]
    head = [(0.11, 0.0, 0.7), *eyes, *rest]
    places = [*head, *(place for pair in zip(left, right, strict=True) for place in pair)]
    cos, sin = math.cos(turn), math.sin(turn)
    # Turned by 0 one looks into the camera, and has the left hand on the right of the picture.
    return [(left * cos + ahead * sin, -up, left * sin - ahead * cos, 0.99) for ahead, left, up in places]


def walking(seconds: float) -> list[Landmark]:
    def step(side: int, phase: float) -> list[Place]:
        knee = 0.12 + 0.9 * max(0.0, math.cos(phase))
        return limbs(side, -0.45 * math.sin(phase), 0.08, 0.45, 0.5 * math.sin(phase), knee)

    return body(step(1, 2 * math.pi * seconds), step(-1, 2 * math.pi * seconds + math.pi), turn=0.9)


def bending(seconds: float) -> list[Landmark]:
    wave = (1 - math.cos(2 * math.pi * seconds / 1.5)) / 2

    def side(number: int) -> list[Place]:
        return limbs(number, 0.05, 0.15 + 2.2 * wave, 0.05, 0.8 * wave, 1.5 * wave)

    return body(side(1), side(-1), turn=0)


def persons() -> Pictures:
    """Three seconds, which end where they begin; as people.read returns a recording."""
    times = [step / PICTURES_A_SECOND for step in range(PICTURES_A_SECOND * SECONDS)]
    return [(seconds, [walking(seconds), bending(seconds)]) for seconds in times]
