"""Lesson 02, the lazy pirate: retry until there is a reply, and never do the work twice.

    python python/02_lazy_pirate/server.py         prints: journal lazy_pirate.sqlite3, balance 0
                                                           listening on tcp://127.0.0.1:5552
    python python/02_lazy_pirate/client.py         or: dotnet run --project csharp-console -- 2

Bytes: UTF-8 text, two frames each way: [id][text]. The client makes the id, a new one for each request, and every retry
of that request carries the same. `add 1` adds to the account, `balance` only asks. Both are answered with the balance,
anything else with a text that begins with `error:`.
The journal has each request that was done before its reply leaves. So a retry gets the old reply and is not done
again, even if the server was killed in between.
Trouble on command, where N counts the requests since the start:
    --crash-on N     does request N and is gone before the reply; start the server again yourself
    --drop N         does request N and does not reply
"""

import argparse
import itertools
import os
import re
import sqlite3
import sys
from pathlib import Path

sys.path[:0] = map(str, Path(__file__).resolve().parents[:2])
import zmq

from netmq_example.errors import Error
from netmq_example.journal import LONGEST_ID_BYTES, Journal
from netmq_example.program import listening, receive, run, server_options, text_of, whole
from netmq_example.replies import envelope

# What this server keeps: an account. Delete the journal to begin at 0, while no server runs.
SCHEMA = """
    CREATE TABLE IF NOT EXISTS account (balance INTEGER NOT NULL);
    INSERT INTO account SELECT 0 WHERE NOT EXISTS (SELECT * FROM account);
"""


def answer(db: sqlite3.Connection, text: str) -> str:
    """Your own work goes here. Its changes in the database and the journal's entry are one transaction."""
    asked = re.fullmatch(r"add ([0-9]{1,9})|balance", text)
    if not asked:
        return "error: expected 'add 1' or 'balance'"
    db.execute("UPDATE account SET balance = balance + ?", (int(asked[1] or 0),))
    return str(db.execute("SELECT balance FROM account").fetchone()[0])


def journal(path: str) -> Journal:
    """The type of an option: a journal that cannot be used is wrong usage."""
    try:
        opened = Journal(path, schema=SCHEMA)
        balance = opened.db.execute("SELECT balance FROM account").fetchone()[0]
        print(f"journal {path}, balance {int(balance)}", flush=True)
    except (Error, sqlite3.Error, TypeError, ValueError) as error:
        raise argparse.ArgumentTypeError(str(error)) from None
    return opened


def main() -> None:
    parser = server_options(__doc__, "tcp://127.0.0.1:5552")
    parser.add_argument("--journal", type=journal, default="lazy_pirate.sqlite3", help="a file, made if there is none")
    parser.add_argument("--crash-on", type=whole, default=0, metavar="N", help="do request N, then crash")
    parser.add_argument("--drop", type=whole, default=0, metavar="N", help="do request N, then lose the reply")
    options = parser.parse_args()
    # A REP socket must reply before it may receive again; a ROUTER may also stay silent.
    with listening(zmq.ROUTER, options) as socket:
        for number in itertools.count(1):
            frames = receive(socket)
            way, body = envelope(frames)
            request_id, text = body if len(body) == 2 else (b"", b"")
            reply = source = ""
            with options.journal.watched():
                if not 0 < len(request_id) <= LONGEST_ID_BYTES:
                    reply = f"error: expected two frames, [id][text], with an id of 1 to {LONGEST_ID_BYTES} bytes"
                elif reply := options.journal.find(request_id):
                    source = ", from the journal"
                else:
                    reply = options.journal.do(request_id, text_of(text), answer)
            fate = {options.crash_on: ", crash", options.drop: ", dropped"}.get(number, "")
            if reply and not reply.startswith("error:"):
                print(f"request {number}, {request_id[:10]!r}: {reply!r:.80}{source}{fate}", flush=True)
            if number == options.crash_on:
                os._exit(1)
            if reply and number != options.drop:
                # This never waits: ROUTER drops the reply to a client that has gone, or does not read.
                socket.send_multipart([*way, *filter(None, [request_id]), reply.encode()])


if __name__ == "__main__":
    run(main)
