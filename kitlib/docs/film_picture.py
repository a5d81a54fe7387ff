"""Films img/12_front.gif and img/12_map.gif, two views of lesson 12: python3 -m kitlib.docs.film_picture

The drive and its films take six seconds of real time; numpy and Pillow must be there.
"""

from __future__ import annotations

import shutil
import sys
import tempfile
from pathlib import Path

from kitlib.lessons import ROOT, find
from kitlib.programs import Program


def main() -> None:
    lesson = find("12").python
    with tempfile.TemporaryDirectory() as folder:
        words = ["--endpoint", "tcp://127.0.0.1:0", "--fps", "10"]
        server = Program([sys.executable, lesson / "server.py", *words], folder=Path(folder))
        try:
            client = Program([sys.executable, lesson / "client.py", "--endpoint", server.endpoints()["endpoint"]])
            client.wait_for("^done", 60)
            for view in ("front", "map"):
                server.wait_for(f"^film {view}_1.gif")
                print(server.lines[-1])
                shutil.copy(Path(folder) / f"{view}_1.gif", ROOT / "img" / f"12_{view}.gif")
        finally:
            server.end()


if __name__ == "__main__":
    main()
