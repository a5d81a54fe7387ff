"""Lesson 12, the client in Python: the C# version is FilmedDrive, and it prints the same lines.

    python python/12_video/client.py                 a car drives six seconds or more, and may be filmed
    python python/12_video/client.py --count 3000    for a minute

Bytes: as in server.py.
"""

import argparse
import re
import sys
import threading
import time
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from socket import getaddrinfo

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))

try:
    from self_driving import SelfDriving, scaled

    from netmq_example.video.view_sender import FilmView, ViewSender
except KeyboardInterrupt:
    # numpy takes a while.
    sys.exit("stopped")

ENDPOINT, STEP = "tcp://127.0.0.1:5562", 0.02


def play(sender: ViewSender, count: int) -> str:
    """The game has a loop of its own, and a thread for the network."""
    drive = SelfDriving()
    views = {FilmView("front", 320, 240): drive.front, FilmView("map", 320, 240): drive.map}
    over = threading.Event()
    with ThreadPoolExecutor(1) as pool:
        try:
            network = pool.submit(sender.run, list(views), over)
            while not sender.connected and not network.done():
                time.sleep(0.01)
            began = time.monotonic()
            # Not in the middle of a film.
            while not network.done() and (not 0 < count <= drive.steps or any(view.film for view in views)):
                drive.step()
                for view, draw in views.items():
                    if picture := view.due():
                        view.take(picture, scaled(draw(), picture.film.width, picture.film.height))
                time.sleep(max(0, began + drive.steps * STEP - time.monotonic()))
        finally:
            over.set()
        network.result()
    return f"done: {drive.steps} steps"


# From here on all clients of this kit are the same, but for their own options.


def printable(text: str) -> str:
    """What a peer sent, fit for one line of a terminal: no control characters, cut to a readable length."""
    return "".join(c if c.isprintable() else "?" for c in text[:200]) + ("…" if len(text) > 200 else "")


def endpoint(text: str) -> str:
    """libzmq itself takes port 99999 and an unknown host without a word, and waits."""
    parts = re.fullmatch(r"tcp://([\w.-]+):(\d{1,5})", text, re.ASCII)
    if not parts or not 0 < int(parts[2]) < 65536:
        raise argparse.ArgumentTypeError(f"bad endpoint '{text}': write it like {ENDPOINT}, port 1 to 65535")
    try:
        getaddrinfo(parts[1], None)
    except (OSError, UnicodeError):
        raise argparse.ArgumentTypeError(f"bad endpoint '{text}': unknown host '{parts[1]}'; check it") from None
    return text


def main() -> None:
    # In a pipe Windows would use another encoding, and a character that it lacks would end the program.
    sys.stdout.reconfigure(encoding="utf-8", errors="replace")  # type: ignore[union-attr]
    parser = argparse.ArgumentParser(description="Drives a car whose views can be filmed.")
    parser.add_argument("--endpoint", type=endpoint, default=ENDPOINT, help="where Python films")
    parser.add_argument("--count", type=int, default=300, help="end after so many steps, and the films; 0: never")
    parser.add_argument("--timeout", type=float, default=30, help="seconds to wait for Python")
    options = parser.parse_args()
    if options.count < 0 or not 0 < options.timeout < 86400:
        parser.error("--count takes whole numbers from 0, --timeout seconds, more than 0")
    print(f"asking {options.endpoint}", flush=True)
    sender = ViewSender(options.endpoint, options.timeout, lambda line: print(printable(line), flush=True))
    try:
        print(play(sender, options.count))
    except TimeoutError as error:
        sys.exit(f"gave up: {printable(str(error))}")


if __name__ == "__main__":
    try:
        main()
    except KeyboardInterrupt:
        sys.exit("stopped")
