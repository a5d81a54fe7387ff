"""Lesson 08, the arrow keys of a terminal, or W A S D, as a steering wheel: the C# version is Keyboard.cs.

A terminal tells when a key is pressed, and not when it is let go: what was set stays set.
"""

import os
import sys

from drive import Drive

KEYS = {b"\x1b[A": "up", b"\x1b[B": "down", b"\x1b[C": "right", b"\x1b[D": "left", b" ": "space", b"\n": "enter"}
KEYS |= {b"\xe0H": "up", b"\xe0P": "down", b"\xe0M": "right", b"\xe0K": "left", b"\r": "enter"}
KEYS |= {b"w": "up", b"s": "down", b"d": "right", b"a": "left", b"W": "up", b"S": "down", b"D": "right", b"A": "left"}


class Keyboard:
    """A key takes over, Enter gives back. `with` gives the terminal back as it was."""

    def __init__(self, wanted: bool) -> None:
        self.wanted = wanted
        self.throttle = self.brake = self.steer = 0.0
        self.rest = b""

    def look(self, drive: Drive) -> None:
        """Take what was pressed since the last call."""
        self.rest += pressed() if self.wanted else b""
        while self.rest:
            code = next((code for code in KEYS if self.rest.startswith(code)), None)
            if code is None and any(known.startswith(self.rest) for known in KEYS):
                return
            # A byte that begins no key is left out.
            self.rest = self.rest[len(code) if code else 1 :]
            key = KEYS[code] if code else ""
            if key in ("left", "right"):
                self.steer = min(1.0, max(-1.0, self.steer + (0.1 if key == "right" else -0.1)))
            elif key in ("up", "down"):
                # Rounded, so that it comes back to 0 on its way from forwards to backwards.
                self.throttle = min(1.0, max(-1.0, round(self.throttle + (0.2 if key == "up" else -0.2), 1)))
                self.brake = 0.0
            elif key == "space":
                self.throttle, self.brake = 0.0, 1.0
            if key == "enter":
                drive.give_back()
            elif key:
                drive.take_over(self.throttle, self.brake, self.steer)

    def __enter__(self) -> "Keyboard":
        if self.wanted and sys.platform != "win32":
            import termios
            import tty

            self.before = termios.tcgetattr(sys.stdin)
            # Each key at once and without an echo; Ctrl-C stays what it is.
            tty.setcbreak(sys.stdin)
        return self

    def __exit__(self, *_: object) -> None:
        if self.wanted and sys.platform != "win32":
            import termios

            termios.tcsetattr(sys.stdin, termios.TCSADRAIN, self.before)


def pressed() -> bytes:
    """The bytes of all keys that wait to be read."""
    if sys.platform == "win32":
        import msvcrt

        found = b""
        while msvcrt.kbhit():
            found += msvcrt.getch()
        # An arrow of the number block begins with 0.
        return found.replace(b"\0", b"\xe0")
    import select

    return os.read(sys.stdin.fileno(), 1024) if select.select([sys.stdin], [], [], 0)[0] else b""
