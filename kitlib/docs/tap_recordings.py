"""Records img/16_watched.html, and draws img/16_watched.png: python3 -m kitlib.docs.tap_recordings

The page plays in a browser without a server. It holds a recording of lesson 02, and one of lesson 08 by the name
#lesson_08. A tap stands between a lesson's client and server, and slows each message down so that an eye can follow.
In lesson 02 it drops a reply.
"""

from __future__ import annotations

import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

from kitlib.lessons import ROOT, find
from kitlib.programs import Program, ask_to_end
from kitlib.watch import tap_command

sys.path.append(str(ROOT / "python"))
from netmq_example.tap.arrows import BEGIN, END, HTML

# What the client and the tap are told.
RECORDINGS = {
    "02": ("--count 4 --timeout 1.5", "--slow 0.25 --drop 4"),
    # Picture for picture, so that the same drive is recorded each time; round a bend.
    "08": ("--lockstep --count 90 --start 700 --timeout 20", "--slow 0.02"),
}


def record(number: str, client_words: str, tap_words: str, folder: str, page: Path) -> None:
    """Run the lesson in this folder, behind a tap, which writes the page that shows what it saw when it ends."""
    lesson, free = find(number), ("--endpoint", "tcp://127.0.0.1:0")
    started = [Program([sys.executable, lesson.python / "server.py", *free], folder=Path(folder))]
    try:
        server = started[0].endpoints()["endpoint"]
        started.append(Program([*tap_command(lesson, sys.executable), *tap_words.split(), "--record", page, server]))
        words = ["--endpoint", started[1].endpoints()["endpoint"], *client_words.split()]
        started.append(Program([sys.executable, lesson.python / "client.py", *words]))
        started[2].wait_for("^done")
        ask_to_end(started[1].process)
        started[1].process.wait(60)
    finally:
        for program in started:
            program.end()


def take_picture(page: Path, picture: Path, folder: str) -> None:
    """What a browser shows of a page. Who asks for no motion sees a recording's end at once."""
    browser = next((found for name in ("chromium", "google-chrome", "chrome") if (found := shutil.which(name))), None)
    if not browser:
        return print(f"no Chromium here: {picture.name} stays as it is")
    words = ["--headless", "--no-sandbox", "--disable-gpu", "--force-prefers-reduced-motion", "--hide-scrollbars"]
    words += [f"--user-data-dir={folder}/profile", "--window-size=1000,620", f"--screenshot={picture}", page.as_uri()]
    # Drawn at twice the size, for fine screens.
    done = subprocess.run([browser, *words, "--force-device-scale-factor=2"], capture_output=True, timeout=120)
    done.check_returncode()
    return print(f"drew {picture.relative_to(ROOT).as_posix()}, {picture.stat().st_size:,} bytes")


def main() -> None:
    page, recorded = ROOT / "img" / "16_watched.html", ""
    with tempfile.TemporaryDirectory() as folder:
        for number, words in RECORDINGS.items():
            one = Path(folder) / f"{number}.html"
            record(number, *words, folder, one)
            packed = one.read_text(encoding="utf-8").partition(BEGIN)[2].partition(END)[0]
            begin = BEGIN if not recorded else BEGIN.replace("recording", f"lesson_{number}")
            recorded += f"{begin}{packed}{END}"
        page.write_text(HTML.read_text(encoding="utf-8").replace(BEGIN + END, recorded), encoding="utf-8", newline="\n")
        print(f"recorded {page.relative_to(ROOT).as_posix()}, {page.stat().st_size:,} bytes")
        take_picture(page, page.with_suffix(".png"), folder)


if __name__ == "__main__":
    main()
