"""Lesson 12, video: several views of a running game become films, on command.

    python python/12_video/server.py                      prints: listening on tcp://127.0.0.1:5562
    python python/12_video/client.py                      or: dotnet run --project csharp-console -- 12
    python python/12_video/server.py --film drive.mp4 --view front --seconds 5        or .webm, .gif

Films each game that comes, every view, and prints for each: film front_1.mp4: 100 frames, 4.0 s, 0 skipped
Bytes: messages of lesson 05, see netmq_example/video/films.py.
Trouble on command: `--slow 0.3` takes so long over each picture.
"""

import math
import sys
import time
from pathlib import Path

sys.path[:0] = map(str, Path(__file__).resolve().parents[:2])
import zmq

from netmq_example.extras import importing
from netmq_example.program import listening, option, run, seconds, server_options, show

with importing("numpy, pillow and av; kit.py run 12 installs them"):
    from netmq_example.errors import Error
    from netmq_example.messages import LIMIT, Message
    from netmq_example.video.film_writer import new_path
    from netmq_example.video.films import Films


class SlowFilms(Films):
    """As Films, but with a disk that is slow."""

    slow = 0.0

    def hear(self, message: Message) -> None:
        if message.kind == "frame":
            time.sleep(self.slow)
        super().hear(message)


def film(films: Films, view: str, path: Path | None, fps: float, seconds: float) -> None:
    """Some seconds of each view, or of one of them."""
    for each in [view] if view or path else list(films.game.views):
        films.begin_render(each, path or "", fps=fps)
    end = time.monotonic() + seconds
    while time.monotonic() < end and films.game.views:
        time.sleep(0.02)


def main() -> None:
    parser = server_options(__doc__, "tcp://127.0.0.1:5562")
    parser.add_argument("--film", type=lambda text: option(new_path, text, Path), help="of one view, such as drive.mp4")
    parser.add_argument("--view", default="", help="which view; all of them, or with --film the first")
    parser.add_argument("--seconds", type=seconds, default=4, help="how long to film")
    parser.add_argument("--fps", type=seconds, default=25, help="pictures a second")
    parser.add_argument("--slow", type=seconds, default=0, help="seconds to take over each picture")
    options = parser.parse_args()
    with listening(zmq.ROUTER, options, largest=4 * LIMIT) as socket, SlowFilms(socket=socket) as films:
        films.slow = options.slow
        # One game after the other.
        while True:
            films.wait(math.inf)
            try:
                film(films, options.view, options.film, options.fps, options.seconds)
            except (OSError, ValueError, Error) as error:
                # Trouble with one game, or with one of its films, does not end this program.
                show(f"trouble: {str(error)!a:.200}")
            # All that were begun, also when another one could not be.
            films.end_all()


if __name__ == "__main__":
    run(main)
