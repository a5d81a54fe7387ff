"""Lesson 02, the lazy pirate: retry until there is a reply, and never do the work twice.

    python python/02_lazy_pirate/server.py         prints: journal lazy_pirate.sqlite3, balance 0
                                                           listening on tcp://127.0.0.1:5552
    python python/02_lazy_pirate/client.py         or: dotnet run --project csharp-console -- 2

Bytes: UTF-8 text, two frames each way: [id][text]. The client makes the id, a new one for each request, and every retry
of that request carries the same. `add 1` adds to the account, `balance` only asks. Both are answered with the balance,
anything else with a text that begins with `error:`.
What was done is in the journal before the reply leaves. So a retry is answered from there and not done again, even if
the server was killed in between.
Trouble on command, where N counts the requests since the start:
    --crash-on N     does request N and is gone before the reply; start the server again yourself
    --drop N         does request N and does not reply
"""

import argparse
import contextlib
import itertools
import os
import re
import signal
import sqlite3
import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))
import zmq

from netmq_example.journal import Journal

ENDPOINT, SOCKET, LARGEST = "tcp://127.0.0.1:5552", zmq.ROUTER, 65_536


def answer(db: sqlite3.Connection, text: str) -> str:
    """Your own work goes here. What it changes in the database is valid together with the journal's entry."""
    if not (asked := re.fullmatch(r"add ([0-9]{1,9})|balance", text)):
        return "error: expected 'add 1' or 'balance'"
    db.execute("UPDATE account SET balance = balance + ?", (int(asked[1] or 0),))
    return str(db.execute("SELECT balance FROM account").fetchone()[0])


def serve(socket: zmq.Socket[bytes], options: argparse.Namespace) -> None:
    """A REP socket must reply before it may receive again; a ROUTER may also stay silent."""
    fates = {options.crash_on: ", crash", options.drop: ", dropped"}
    for number in itertools.count(1):
        frames = receive(socket)
        # Those up to the empty one are the way back to the client. REP keeps them out of sight.
        body = frames.index(b"") + 1 if b"" in frames else 1
        request_id, text = frames[body:] if len(frames) == body + 2 else (b"", b"")
        reply, source = options.journal.reply(request_id, text.decode(errors="replace"), answer)
        if reply and not reply.startswith("error:"):
            print(f"request {number}, {request_id[:10]!r}: {reply!r:.80}{source}{fates.get(number, '')}", flush=True)
        if number == options.crash_on:
            os._exit(1)
        if reply and number != options.drop:
            # This never waits: ROUTER drops the reply to a client that has gone, or does not read.
            socket.send_multipart([*frames[:body], request_id, reply.encode()])


def add_options(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("--journal", type=Journal, default="lazy_pirate.sqlite3", help="a file, made if there is none")
    for name, what in (("crash-on", "do request N, then crash"), ("drop", "do request N, then lose the reply")):
        parser.add_argument(f"--{name}", type=int, default=0, metavar="N", help=what)


# From here on all servers of this kit are the same, as far as they need it.


def receive(socket: zmq.Socket[bytes]) -> list[bytes]:
    """The frames of the next message. It waits in slices: on Windows Ctrl-C does not interrupt a longer wait."""
    while True:
        with contextlib.suppress(zmq.Again):
            return socket.recv_multipart()


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
