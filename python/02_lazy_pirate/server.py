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
    --crash-on N     does new request N and is gone before the reply; start the server again yourself
    --drop N         does request N and does not reply
"""

import itertools
import os
import re
import sys
from pathlib import Path

sys.path[:0] = map(str, Path(__file__).resolve().parents[:2])
import zmq

from netmq_example.asking import wrong_usage
from netmq_example.journal import LONGEST_ID_BYTES, Connection, Journal
from netmq_example.program import listening, receive, run, server_options, text_of, whole
from netmq_example.replies import id_and_text


def answer(db: Connection, text: str) -> str:
    """Your own work goes here. Its changes in the database and the journal's entry are one transaction."""
    if not (asked := re.fullmatch(r"add ([0-9]{1,9})|balance", text)):
        return "error: expected 'add 1' or 'balance'"
    db.execute("UPDATE account SET balance = balance + ?", (int(asked[1] or 0),))
    return str(db.execute("SELECT balance FROM account").fetchone()[0])


def main() -> None:
    parser = server_options(__doc__, "tcp://127.0.0.1:5552")
    parser.add_argument("--journal", default="lazy_pirate.sqlite3", help="a file, made if there is none")
    parser.add_argument("--crash-on", type=whole, default=0, metavar="N", help="do new request N, then crash")
    parser.add_argument("--drop", type=whole, default=0, metavar="N", help="do request N, then lose the reply")
    options = parser.parse_args()
    new = 0
    with wrong_usage(parser, "argument --journal: "):
        # Delete the file to begin at 0, while no server runs.
        journal = Journal(options.journal, schema="CREATE TABLE IF NOT EXISTS account AS SELECT 0 AS balance;")
        print(f"journal {options.journal}, balance {journal.value('SELECT balance FROM account')}", flush=True)
    # A REP socket must reply before it may receive again; a ROUTER may also stay silent.
    with listening(zmq.ROUTER, options) as socket:
        for number in itertools.count(1):
            way, request_id, text = id_and_text(receive(socket))
            reply = source = ""
            with journal.watched():
                if not 0 < len(request_id) <= LONGEST_ID_BYTES:
                    reply = f"error: expected two frames, [id][text], with an id of 1 to {LONGEST_ID_BYTES} bytes"
                elif reply := journal.find(request_id):
                    source = ", from the journal"
                else:
                    # A retry is no new work: the next server may hear several before it is through the first.
                    new += 1
                    reply = journal.do(request_id, text_of(text), answer)
            fault = ", crash" if new and new == options.crash_on else ", dropped" if number == options.drop else ""
            if reply and not reply.startswith("error:"):
                print(f"request {number}, {request_id[:10]!r}: {reply!r:.80}{source}{fault}", flush=True)
            if fault == ", crash":
                os._exit(1)
            if reply and number != options.drop:
                # This never waits: ROUTER drops the reply to a client that has gone, or does not read.
                socket.send_multipart([*way, reply.encode()])


if __name__ == "__main__":
    run(main)
