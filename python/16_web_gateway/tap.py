"""Lesson 16, the tap: it stands between any client and any server of this kit, and shows the messages in a page.

    python python/02_lazy_pirate/server.py
    python python/16_web_gateway/tap.py tcp://127.0.0.1:5552                  prints: page at http://127.0.0.1:PORT/
                                                                                      listening on tcp://127.0.0.1:5666
    python python/02_lazy_pirate/client.py --endpoint tcp://127.0.0.1:5666    goes through it
Or all at once: python3 kit.py run 2 --watch

It makes two TCP connections of one and passes the bytes on, one whole message after the other. So the ZeroMQ sockets
stay those of the client and the server, with their identities, subscriptions and heartbeats, whatever kinds they are.
(ROUTER and DEALER in between, or XSUB and XPUB, would be another tap for each kind, and would deliver what a closed
connection loses.)
Trouble on command, for message N, or in the page for the next one:
    --drop N     is not passed on            --double N   is passed on twice
    --delay N    a second later              --cut N      is not passed on, and its connection is closed
"""

import argparse
import asyncio
import functools
import itertools
import re
import socket
import sys
import threading
import time
from pathlib import Path

sys.path[:0] = map(str, Path(__file__).resolve().parents[:2])
from netmq_example import check
from netmq_example.asking import at_least_one, client_endpoint
from netmq_example.extras import importing
from netmq_example.program import option, run, seconds, show
from netmq_example.tap.arrows import Arrows, recording
from netmq_example.tap.passing import FAULTS, Faults, Link
from netmq_example.trouble import Trouble

with importing("aiohttp: pip install aiohttp, or let kit.py run 1 --watch do it"):
    from netmq_example.tap.page import Page, own_origin

ENDPOINT = "tcp://127.0.0.1:5666"
NUMBERS = itertools.count(1)
PAUSE_SECONDS = 0.1


def tap(listener: socket.socket, server: tuple[str, int], arrows: Arrows, faults: Faults) -> None:
    """Each client that comes gets a connection of its own to the server."""
    report = Trouble(show)
    while True:
        try:
            client, _ = listener.accept()
        except OSError as error:
            # As many connections as files may be open: those that knock come in when others have gone.
            report(f"no room for one more client: {error.strerror}")
            time.sleep(PAUSE_SECONDS)
            continue
        link = Link(next(NUMBERS), arrows, faults)
        threading.Thread(target=link.run, args=(client, *server), daemon=True).start()


def server(text: str) -> tuple[str, tuple[str, int]]:
    """A lesson with two endpoints has names for them: snapshots=tcp://127.0.0.1:5657."""
    name, _, endpoint = text.rpartition("=")
    if not re.fullmatch(r"\w*", name):
        raise argparse.ArgumentTypeError(f"bad name '{name}': write it like snapshots=tcp://127.0.0.1:5657")
    host, _, port = client_endpoint("tcp://127.0.0.1:5552")(endpoint).removeprefix("tcp://").rpartition(":")
    return name or "endpoint", (host, int(port))


def own_endpoint(text: str) -> tuple[str, int]:
    """Anybody who reaches it can read and drop all messages."""
    parts = re.fullmatch(r"tcp://(127\.0\.0\.1|localhost):(\d{1,5})", text, re.ASCII)
    if not parts or int(parts[2]) > 65535:
        cure = f"the tap listens on this machine only: write it like {ENDPOINT}, port 0 to 65535"
        raise argparse.ArgumentTypeError(f"bad endpoint '{text}': {cure}")
    return "127.0.0.1", int(parts[2])


def port_number(text: str) -> int:
    return option(functools.partial(check.count, least=0, most=65535), text, int)


def origin(text: str) -> str:
    return option(own_origin, text, str)


def slow_seconds(text: str) -> float:
    if (slow := seconds(text)) >= 60:
        raise argparse.ArgumentTypeError(f"it takes seconds, less than 60, not {text!r:.40}")
    return slow


def file(text: str) -> Path:
    """A file that cannot be written is named now, and not when all has been seen."""
    try:
        Path(text).touch()
    except (OSError, ValueError) as error:
        raise argparse.ArgumentTypeError(f"cannot write {text!r}: {error}; choose another file") from None
    return Path(text)


def listen(host: str, port: int) -> socket.socket:
    try:
        return socket.create_server((host, port))
    except OSError as error:
        sys.exit(f"cannot listen on {host}:{port}: {error.strerror}; try port 0, which takes a free one")


def main() -> None:
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    parser.add_argument("servers", type=server, nargs="+", metavar="SERVER", help="where a server listens")
    parser.add_argument("--endpoint", type=own_endpoint, default=ENDPOINT, help="for the client; port 0: a free one")
    parser.add_argument("--page", type=port_number, default=0, metavar="PORT", help="of the page; 0: a free one")
    parser.add_argument("--title", default="", help="what stands above the picture")
    parser.add_argument("--slow", type=slow_seconds, default=0, metavar="S", help="each message is S seconds late")
    parser.add_argument("--record", type=file, metavar="FILE", help="an HTML file that shows it all again, at the end")
    parser.add_argument("--frame", type=origin, metavar="ORIGIN", help="whose page may show this one in a frame")
    for fault in FAULTS:
        parser.add_argument(f"--{fault}", type=at_least_one, metavar="N", help=f"{fault} message N")
    options = parser.parse_args()
    if [name for name, _ in options.servers].count("endpoint") != 1:
        parser.error("one server has no name, as in: tap.py tcp://127.0.0.1:5557 snapshots=tcp://127.0.0.1:5657")
    planned = {getattr(options, fault): fault for fault in FAULTS if getattr(options, fault)}
    arrows = Arrows()
    faults = Faults(planned, slow=options.slow)
    title = options.title or " ".join(f"{host}:{port}" for _, (host, port) in options.servers)
    page = Page(arrows, faults, title, options.frame or "")
    shown = listen("127.0.0.1", options.page)
    print(f"page at http://127.0.0.1:{shown.getsockname()[1]}/", flush=True)
    # The line that tells others that all is ready comes last.
    for name, address in sorted(options.servers, key=lambda each: each[0] == "endpoint"):
        host, port = options.endpoint if name == "endpoint" else (options.endpoint[0], 0)
        listener = listen(host, port)
        threading.Thread(target=tap, args=(listener, address, arrows, faults), daemon=True).start()
        word = "listening" if name == "endpoint" else name
        print(f"{word} on tcp://{host}:{listener.getsockname()[1]}", flush=True)
    try:
        asyncio.run(page.serve(shown))
    finally:
        if options.record:
            write(options.record, recording(arrows, title))


def write(path: Path, text: str) -> None:
    try:
        path.write_text(text, encoding="utf-8", newline="\n")
    except OSError as error:
        sys.exit(f"cannot write {path}: {error.strerror}; no recording")


if __name__ == "__main__":
    run(main)
