"""Lesson 12, the client in Python. In C# it is FilmedDrive.cs, which prints the same lines.

    python python/12_video/client.py                 a car drives six seconds or more, and may be filmed
    python python/12_video/client.py --count 3000    for a minute

Bytes: messages of lesson 05, see netmq_example/video/films.py.
"""

import sys
import threading
import time
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

sys.path[:0] = map(str, Path(__file__).resolve().parents[:2])
from netmq_example.asking import client_options
from netmq_example.extras import importing
from netmq_example.program import run, whole

with importing("numpy; kit.py run 12 installs it", stopped="stopped"):
    from self_driving import SelfDriving, scaled

    from netmq_example.video.view_sender import FilmView, ViewSender

STEP_SECONDS = 0.02


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
                    picture = view.due()
                    if picture:
                        view.take(picture, scaled(draw(), picture.film.width, picture.film.height))
                time.sleep(max(0, began + drive.steps * STEP_SECONDS - time.monotonic()))
        finally:
            over.set()
        network.result()
    return f"done: {drive.steps} steps"


def main() -> None:
    parser = client_options("Drives a car whose views can be filmed.", "tcp://127.0.0.1:5562", timeout=30)
    parser.add_argument("--count", type=whole, default=300, help="end after so many steps, and the films; 0: never")
    options = parser.parse_args()
    print(f"asking {options.endpoint}", flush=True)
    print(play(ViewSender(options.endpoint, timeout=options.timeout), options.count))


if __name__ == "__main__":
    run(main, stopped="stopped")
