"""Where a server prints to: it goes on whatever becomes of that.

    sys.stdout = unhindered(sys.stdout)

A full disk, a pipe that is closed, and one that nobody reads cost lines, and never the server. It needs only Python.
"""

import io
import os
import select
import stat
import sys
from typing import Any


class Lines(io.FileIO):
    """What a server prints. A pipe that nobody reads would soon hold the server up for ever."""

    patience = 0.5
    before: Any = None

    def write(self, data: Any) -> int:
        try:
            # In pieces: where there is room for anything, a pipe has room for so much.
            return super().write(data[:4096]) if self.has_room() else len(data)
        except OSError:
            return len(data)

    def has_room(self) -> bool:
        # On Windows only its reader can keep a pipe from being full.
        if sys.platform == "win32" or not stat.S_ISFIFO(os.fstat(self.fileno()).st_mode):
            return True
        _, room, _ = select.select([], [self], [], self.patience)
        # Once it was waited for in vain, the next lines do not wait.
        self.patience = Lines.patience if room else 0
        return bool(room)


def unhindered(stream: Any) -> Any:
    """The same for Lines; a stream that leads to no file is as it was, such as a notebook's, or none at all."""
    buffer = getattr(stream, "buffer", None)
    raw = getattr(buffer, "raw", buffer)
    if not isinstance(raw, io.FileIO) or raw.closed:
        return stream
    stream.flush()
    file = Lines(raw.fileno(), "w", closefd=False)
    # If nobody had it any more, it would close what this writes to.
    file.before = stream
    lines = io.BufferedWriter(file)
    at_once = stream.line_buffering or stream.write_through
    return io.TextIOWrapper(lines, stream.encoding, stream.errors, line_buffering=at_once)
