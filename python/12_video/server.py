"""Lesson 12, video: several views of a running game become films, on command.

    python python/12_video/server.py                      prints: listening on tcp://127.0.0.1:5562
    python python/12_video/client.py                      or: dotnet run --project csharp-console -- 12
    python python/12_video/server.py --film drive.gif --view front --seconds 5        or .png, .webp, .mp4

Films each game that comes, every view, and prints for each: film front_1.gif: 100 frames, 4.0 s, 0 skipped
Bytes: messages of lesson 05. The game says `hello` with its `views`, and their largest sizes as int32 [n, 2]; the reply
is `welcome`. A `begin` has `view`, `width`, `height` and `fps`, and is answered by `begun`. From then on each `frame`
has the id of that begin, `view`, `number`, `time`, in seconds since it began, and one array, uint8 [height, width, 3 or
4], with `bottom_up` the lowest row first; the reply is `took`. An `end` of a `view` is answered by `ended`, with
`frames`, `skipped` and `time`.
Trouble on command: `--slow 0.3` takes so long over each picture.
"""

import argparse
import contextlib
import re
import signal
import sys
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))
import zmq

try:
    from netmq_example.messages import LIMIT, Message, MessageError
    from netmq_example.video.film_writer import check_new
    from netmq_example.video.films import Films
except KeyboardInterrupt:
    # numpy takes a while.
    sys.exit()

ENDPOINT, SOCKET, LARGEST = "tcp://127.0.0.1:5562", zmq.ROUTER, 4 * LIMIT


class SlowFilms(Films):
    """As Films, but with a disk that is slow."""

    slow = 0.0

    def hear(self, message: Message) -> None:
        time.sleep(self.slow if message.kind == "frame" else 0)
        super().hear(message)


def film(films: Films, options: argparse.Namespace) -> None:
    """Some seconds of each view, or of one of them."""
    views = [options.view] if options.view or options.film else list(films.game.views)
    for view in views:
        films.begin_render(view, options.film or "", fps=options.fps)
    end = time.monotonic() + options.seconds
    while time.monotonic() < end and films.game.views:
        time.sleep(0.02)


def attempt(do: Callable[..., object], *what: Any) -> None:
    """What goes wrong with one game, or with one of its films, does not end this program."""
    try:
        do(*what)
    except (OSError, ValueError, MessageError) as error:
        # In one piece with its end: another thread prints as well.
        print(f"trouble: {str(error)!a:.200}\n", end="", flush=True)


def serve(socket: zmq.Socket[bytes], options: argparse.Namespace) -> None:
    """One game after the other."""
    with SlowFilms(socket=socket, report=lambda line: print(f"{line}\n", end="", flush=True)) as films:
        films.slow = options.slow
        while True:
            films.wait(float("inf"))
            attempt(film, films, options)
            # All that were begun, also when another one could not be.
            for view in list(films.films):
                attempt(films.end_render, view)


def add_options(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("--film", type=new_film, help="the file of one view, such as drive.gif")
    parser.add_argument("--view", default="", help="which view; all of them, or with --film the first")
    parser.add_argument("--seconds", type=seconds, default=4, help="how long to film")
    parser.add_argument("--fps", type=seconds, default=25, help="pictures a second")
    parser.add_argument("--slow", type=seconds, default=0, help="seconds to take over each picture")


def new_film(text: str) -> Path:
    try:
        check_new(Path(text))
    except ValueError as error:
        raise argparse.ArgumentTypeError(str(error)) from None
    return Path(text)


# From here on all servers of this kit are the same, as far as they need it.


def seconds(text: str) -> float:
    if not 0 <= float(text) < 86_400:
        raise ValueError
    return float(text)


def endpoint(text: str) -> str:
    """libzmq itself would listen on port 99999 - 65536, and for everybody, without a word."""
    port = re.fullmatch(r"tcp://[\w.*-]+:(\*|\d{1,5})", text, re.ASCII)
    if not port or int(port[1].replace("*", "0")) > 65535:
        raise argparse.ArgumentTypeError(f"bad endpoint '{text}': write it like {ENDPOINT}, port 0 to 65535")
    # Options are read one after the other, and this one may come first.
    told = any(word.startswith(("--keys", "--open-to-anyone")) for word in sys.argv)
    if not told and not re.match(r"tcp://(localhost|127\.[\d.]+):", text):
        raise argparse.ArgumentTypeError(f"'{text}' lets anyone in: lesson 15 has keys, --open-to-anyone has none")
    return text


def main() -> None:
    # In a pipe Windows would use another encoding, and a character that it lacks would end the program.
    sys.stdout.reconfigure(encoding="utf-8", errors="replace")  # type: ignore[union-attr]
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    parser.add_argument("--endpoint", type=endpoint, default=ENDPOINT, help="port 0 takes a free one")
    parser.add_argument("--open-to-anyone", action="store_true", help="also from other machines, without keys")
    add_options(parser)
    options = parser.parse_args()
    # SIGTERM, which kill and process managers send, ends the server as Ctrl-C does; on Windows that is SIGBREAK.
    signal.signal(getattr(signal, "SIGBREAK", signal.SIGTERM), signal.default_int_handler)
    with zmq.Context() as context, context.socket(SOCKET) as socket:
        # A reply that nobody fetches is dropped at the end; waiting for its delivery could take for ever.
        # Who announces more than the largest message is disconnected before it is in memory.
        socket.linger, socket.maxmsgsize, socket.rcvtimeo = 0, LARGEST, 200
        try:
            socket.bind(options.endpoint)
        except zmq.ZMQError as error:
            cure = "try --endpoint tcp://127.0.0.1:0, which takes a free port"
            sys.exit(f"cannot listen on {options.endpoint}: {zmq.strerror(error.errno or 0)}; {cure}")
        print(f"listening on {socket.getsockopt_string(zmq.LAST_ENDPOINT)}", flush=True)
        serve(socket, options)


if __name__ == "__main__":
    with contextlib.suppress(KeyboardInterrupt):
        main()
