"""Films img/08_drive.gif, a drive of lesson 08: python3 -m kitlib.docs.drive_picture

The server records a lap in lock-step, so the film is the same each time; numpy and Pillow must be there.
"""

from __future__ import annotations

import sys
import tempfile
from pathlib import Path

from kitlib.lessons import ROOT, find
from kitlib.programs import Program

PICTURE = ROOT / "img" / "08_drive.gif"
# Where the road bends to both sides.
LAP, FIRST = 1200, 620


def main() -> None:
    lesson = find("8").python
    with tempfile.TemporaryDirectory() as folder:
        words = ["--endpoint", "tcp://127.0.0.1:0", "--record", folder]
        server = Program([sys.executable, lesson / "server.py", *words])
        try:
            endpoint = server.endpoints()["endpoint"]
            drive = ["--endpoint", endpoint, "--lockstep", "--count", str(LAP)]
            Program([sys.executable, lesson / "client.py", *drive]).wait_for("^done", 600)
            server.wait_for(f"recorded {LAP} pictures", 60)
        finally:
            server.end()
        recording = next(Path(folder).glob("run_*"))
        film = Program([sys.executable, lesson / "film.py", recording, PICTURE, "--first", str(FIRST)])
        film.wait_for("^wrote")
        print(film.lines[-1])


if __name__ == "__main__":
    main()
