"""Lesson 12, a film as MP4: ffmpeg makes it, if it is on the machine.

Its rate is constant, so a picture is repeated for as long as it was seen: its time is right to one picture of the film.
The file is written in fragments of a second, and ffmpeg ends it when this program is gone: a kill leaves a film that
plays.
It needs numpy and ffmpeg.
"""

import contextlib
import shutil
import subprocess
import tempfile
import threading
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np

# Seconds that ffmpeg may take over one picture, and then over its end.
TAKES, ENDS = 10.0, 30.0
# H.264 and most of its viewers want an even number of rows and columns, and colours at half the size.
EVEN = "pad=ceil(iw/2)*2:ceil(ih/2)*2,format=yuv420p"


class Mp4Film:
    """A new file, written by a process of its own."""

    def __init__(self, path: Path, fps: float) -> None:
        if not shutil.which("ffmpeg"):
            raise OSError(
                "an MP4 needs ffmpeg, which is not here: install it, or let the film end in .gif, .png or .webp"
            )
        # So it is known that it can be written, and that nothing is written over.
        path.open("xb").close()
        self.path, self.fps, self.frames, self.written, self.began = path, fps, 0, 0, 0.0
        self.process: subprocess.Popen[bytes] | None = None
        self.last = b""
        self.said = tempfile.TemporaryFile()  # noqa: SIM115, it lives as long as ffmpeg.

    def add(self, picture: Any, time: float) -> None:
        if not self.process:
            self.process, self.began = self.start(*picture.shape[:2]), time
        self.repeat(time)
        self.last, self.frames = np.ascontiguousarray(picture).tobytes(), self.frames + 1

    def close(self, time: float) -> None:
        if not self.process:
            self.path.unlink(missing_ok=True)
            return
        try:
            self.repeat(time)
        finally:
            # What is not written yet is written now.
            with contextlib.suppress(OSError), self.limited(TAKES):
                self.process.stdin.close()  # type: ignore[union-attr]
            with self.limited(ENDS):
                self.process.wait()
        if self.process.returncode:
            raise OSError(self.why())

    def start(self, height: int, width: int) -> subprocess.Popen[bytes]:
        raw = ["-f", "rawvideo", "-pix_fmt", "rgb24", "-s", f"{width}x{height}", "-r", f"{self.fps:g}", "-i", "-"]
        whole = ["-vf", EVEN, "-bf", "0", "-g", str(max(1, round(self.fps))), "-movflags", "frag_keyframe+empty_moov"]
        command = ["ffmpeg", "-nostdin", "-loglevel", "error", "-y", *raw, *whole, "-f", "mp4", str(self.path)]
        # In a session of its own: Ctrl-C is for this program, which then ends the film.
        return subprocess.Popen(command, stdin=subprocess.PIPE, stderr=self.said, start_new_session=True)

    def repeat(self, until: float) -> None:
        """The last picture, up to the one that is seen at that time."""
        wanted = round((until - self.began) * self.fps)
        for _ in range(wanted - self.written if self.last else 0):
            try:
                with self.limited(TAKES):
                    self.process.stdin.write(self.last)  # type: ignore[union-attr]
            except OSError:
                raise OSError(self.why()) from None
            self.written += 1

    @contextlib.contextmanager
    def limited(self, seconds: float) -> Iterator[None]:
        """To write to a process that reads nothing waits for ever: it is killed after so many seconds."""
        timer = threading.Timer(seconds, self.kill, [seconds])
        timer.start()
        try:
            yield
        finally:
            timer.cancel()

    def kill(self, seconds: float) -> None:
        self.said.write(f"killed, because it did nothing for {seconds:g} s\n".encode())
        self.process.kill()  # type: ignore[union-attr]

    def why(self) -> str:
        self.said.seek(0)
        lines = self.said.read().decode(errors="replace").split("\n")
        return f"ffmpeg has ended: {next(filter(None, lines), 'it does not say why')[:200]}"
