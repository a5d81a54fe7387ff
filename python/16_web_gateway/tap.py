"""Lesson 16, the tap: between any client and any server of this kit, which stay as they are, and shows what they say.

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
It needs
aiohttp.
"""

import argparse
import asyncio
import contextlib
import itertools
import re
import signal
import socket
import sys
import threading
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))
from netmq_example.tap.arrows import Arrows, file, write
from netmq_example.tap.page import Page
from netmq_example.tap.passing import FATES, Link, Trouble

ENDPOINT = "tcp://127.0.0.1:5666"
NUMBERS = itertools.count(1)


def tap(listener: socket.socket, server: tuple[str, int], arrows: Arrows, trouble: Trouble) -> None:
    """Each client that comes gets a connection of its own to the server."""
    while True:
        client, _ = listener.accept()
        link = Link(next(NUMBERS), arrows, trouble)
        threading.Thread(target=link.run, args=(client, *server), daemon=True).start()


def server(text: str) -> tuple[str, tuple[str, int]]:
    """A lesson with two endpoints has names for them: snapshots=tcp://127.0.0.1:5657."""
    parts = re.fullmatch(r"(?:(\w+)=)?tcp://([\w.-]+):(\d{1,5})", text, re.ASCII)
    if not parts or not 0 < int(parts[3]) < 65536:
        raise argparse.ArgumentTypeError(f"bad endpoint '{text}': write it like tcp://127.0.0.1:5552, port 1 to 65535")
    return parts[1] or "endpoint", (parts[2], int(parts[3]))


def endpoint(text: str) -> tuple[str, int]:
    """Who can read and drop all messages is on this machine."""
    parts = re.fullmatch(r"tcp://(127\.0\.0\.1|localhost):(\d{1,5})", text, re.ASCII)
    if not parts or int(parts[2]) > 65535:
        why = f"the tap listens on this machine only: write it like {ENDPOINT}, port 0 to 65535"
        raise argparse.ArgumentTypeError(f"bad endpoint '{text}': {why}")
    return "127.0.0.1", int(parts[2])


def listen(address: tuple[str, int]) -> socket.socket:
    try:
        return socket.create_server(address)
    except OSError as error:
        cure = "try port 0, which takes a free one"
        sys.exit(f"cannot listen on {address[0]}:{address[1]}: {error.strerror}; {cure}")


def main() -> None:
    # In a pipe Windows would use another encoding, and a character that it lacks would end the program.
    sys.stdout.reconfigure(encoding="utf-8", errors="replace")  # type: ignore[union-attr]
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    parser.add_argument("servers", type=server, nargs="+", metavar="SERVER", help="where a server listens")
    parser.add_argument(
        "--endpoint", type=endpoint, default=ENDPOINT, metavar="E", help="for the client; port 0 takes a free one"
    )
    parser.add_argument("--page", type=int, default=0, metavar="PORT", help="of the page; 0, the default: a free one")
    parser.add_argument("--title", default="", help="what stands above the picture")
    parser.add_argument("--slow", type=float, default=0, metavar="S", help="each message is S seconds late, to look at")
    parser.add_argument("--record", type=file, metavar="FILE", help="an HTML file that shows it all again, at the end")
    for fate in FATES:
        parser.add_argument(f"--{fate}", type=int, metavar="N", help=f"{fate} message N")
    options = parser.parse_args()
    if not (0 <= options.page < 65536 and 0 <= options.slow < 60):
        parser.error("--page takes a port, 0 to 65535, --slow seconds, less than 60")
    if [name for name, _ in options.servers].count("endpoint") != 1:
        parser.error("one server has no name, as in: tap.py tcp://127.0.0.1:5557 snapshots=tcp://127.0.0.1:5657")
    # What kill and process managers send ends it as Ctrl-C does.
    for name in {"SIGTERM", "SIGBREAK"} & set(dir(signal)):
        signal.signal(getattr(signal, name), signal.default_int_handler)
    planned = {number: fate for fate in FATES if (number := getattr(options, fate))}
    arrows, trouble = Arrows(), Trouble(planned, slow=options.slow)
    page = Page(arrows, trouble, options.title or " ".join(f"{host}:{port}" for _, (host, port) in options.servers))
    shown = listen(("127.0.0.1", options.page))
    print(f"page at http://127.0.0.1:{shown.getsockname()[1]}/", flush=True)
    # The line that tells others that all is ready comes last.
    for name, address in sorted(options.servers, key=lambda each: each[0] == "endpoint"):
        host, port = options.endpoint if name == "endpoint" else (options.endpoint[0], 0)
        listener = listen((host, port))
        threading.Thread(target=tap, args=(listener, address, arrows, trouble), daemon=True).start()
        said = "listening" if name == "endpoint" else name
        print(f"{said} on tcp://{host}:{listener.getsockname()[1]}", flush=True)
    try:
        asyncio.run(page.serve(shown))
    finally:
        if options.record:
            write(options.record, arrows, page.title)


if __name__ == "__main__":
    with contextlib.suppress(KeyboardInterrupt):
        main()
