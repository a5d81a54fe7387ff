"""Lesson 11's rays: the layout and the numbers of ML-Agents' ray sensor."""

from __future__ import annotations

from collections.abc import Callable

from tests.programs import Program

# Ahead, right, left; of each whether a wall, whether a coin, whether nothing was met, and how far it came.
NOTHING = "0 0 1 1"


def test_what_rays_meet(play: Callable[..., Program]) -> None:
    program = play("rays")
    assert program.wait() == 0, program.output
    assert program.lines == [
        f"thin: 1 0 0 0.75 0 1 0 0.5 {NOTHING}",
        # A thick one meets it half a metre earlier.
        f"thick: 1 0 0 0.625 0 1 0 0.375 {NOTHING}",
        f"without layer 3: 1 0 0 0.75 {NOTHING} {NOTHING}",
        # Ahead is now the coin, and to the left the wall.
        f"turned: 0 1 0 0.5 {NOTHING} 1 0 0 0.75",
        # Its rays are 1 m long.
        f"small: {NOTHING} {NOTHING} {NOTHING}",
    ]
