"""Lesson 02, the lazy pirate: ask again until it is answered, and never do it twice.

    python python/02_lazy_pirate/server.py         prints: journal lazy_pirate.sqlite3, balance 0
                                                           listening on tcp://127.0.0.1:5552
    python python/02_lazy_pirate/client.py         or: dotnet run --project csharp-console -- 2

Bytes: UTF-8 text, two frames each way: [id][text]. The client makes the id, a new one for each request, and every retry
of that request carries the same. `add 1` adds to the account, `balance` only asks. Both are answered with the balance,
anything else with a text that begins with `error:`.
What was done is in the journal before the reply leaves. So a retry is answered from there and not done again, even when
the server was killed in between. The journal is a SQLite file: delete it to begin at 0, while no server runs. Where it
cannot be used, as on a full disk, the server says so and does not reply, and the client asks again.
Trouble on command, where N counts the requests since the start:
    --crash-on N             does request N and is gone before the reply; start the server again yourself
    --drop N                 does request N and does not reply
    --slow-on N --delay S    does request N and replies S seconds later
    --late N                 replies to request N, and once more when the next request is there
Take home: this file.
"""

from __future__ import annotations

import argparse
import errno
import os
import re
import signal
import sqlite3
import sys
import time
import traceback

import zmq

# FULL: a commit is on the disk when it returns. NORMAL would survive kill -9 too, but not a power cut.
SCHEMA = """
    PRAGMA journal_mode = WAL; PRAGMA synchronous = FULL;
    CREATE TABLE IF NOT EXISTS account (balance INTEGER NOT NULL);
    INSERT INTO account SELECT 0 WHERE NOT EXISTS (SELECT * FROM account);
    CREATE TABLE IF NOT EXISTS journal (number INTEGER PRIMARY KEY, id BLOB UNIQUE NOT NULL, reply TEXT NOT NULL);
"""
# An entry has to outlive the last try of its client, and no longer. So many entries take 11 MB.
KEEP = 100_000


def answer(db: sqlite3.Connection, request_id: bytes, text: bytes) -> tuple[str, str]:
    """The reply to a request, and where it comes from: the journal, if this id was answered before."""
    asked = re.fullmatch(rb"add (\d{1,9})|balance", text)
    if not asked or not 0 < len(request_id) <= 100:
        return "error: expected two frames, an id of 1 to 100 bytes and 'add 1' or 'balance'", ""
    if known := db.execute("SELECT reply FROM journal WHERE id = ?", (request_id,)).fetchone():
        return known[0], ", from the journal"
    # One transaction: wherever the server is killed, the work and its entry are both there, or neither is.
    with db:
        db.execute("UPDATE account SET balance = balance + ?", (int(asked[1] or 0),))
        balance = str(db.execute("SELECT balance FROM account").fetchone()[0])
        db.execute("INSERT INTO journal (id, reply) VALUES (?, ?)", (request_id, balance))
        db.execute("DELETE FROM journal WHERE number <= last_insert_rowid() - ?", (KEEP,))
    return balance, ""


def serve(socket: zmq.Socket[bytes], db: sqlite3.Connection, trouble: argparse.Namespace) -> None:
    """Answer for ever. A REP socket must reply before it may receive again; a ROUTER may also stay silent."""
    fates = {trouble.crash_on: ", crash", trouble.drop: ", dropped", trouble.slow_on: f", {trouble.delay:g} s late"}
    number, reply, lines, opened = 0, [b""], Lines(), files(trouble.journal)
    while True:
        # A poll with a limit, because on Windows Ctrl-C does not interrupt a wait without one.
        if not socket.poll(200):
            continue
        # The frames up to the empty one are the way back to the client. REP keeps them out of sight.
        frames = socket.recv_multipart()
        body = frames.index(b"") + 1 if b"" in frames else len(frames)
        request_id, text = frames[body:] if len(frames) == body + 2 else (b"", b"")
        number += 1
        asked = f"request {number}, {short(request_id)}"
        if trouble.late and number == trouble.late + 1:
            socket.send_multipart(reply)
            print(f"request {trouble.late} is answered once more", flush=True)
        try:
            if files(trouble.journal) != opened:
                raise sqlite3.Error("it was deleted or replaced; put it back, or start the server again")
            balance, source = answer(db, request_id, text)
        except sqlite3.Error as error:
            # Nothing was done. The client asks again, and is answered as soon as this is over.
            lines.show(f"{asked}: no reply, cannot use the journal {trouble.journal}: {error}", bad=True)
            continue
        except Exception as error:
            # A mistake in `answer` is told to both sides, and ends neither.
            traceback.print_exc()
            balance, source = printable(f"error: {type(error).__name__}: {error}"), ""
        reply = [*frames[:body], request_id, balance.encode()]
        fate = f"{source}{fates.get(number, '')}"
        lines.show(f"{asked}: {printable(balance)}{fate}", bad=balance.startswith("error:"))
        if number == trouble.crash_on:
            os._exit(1)
        time.sleep(trouble.delay if number == trouble.slow_on else 0)
        if number != trouble.drop:
            # This never waits: ROUTER drops the reply to a client that has gone, or does not read.
            socket.send_multipart(reply)


def files(journal: str) -> list[int]:
    """Which files these are, by their numbers: the journal, and what SQLite has not yet moved into it."""
    try:
        return [os.stat(journal + end).st_ino for end in ("", "-wal")]
    except OSError:
        return []


class Lines:
    """Prints what happens, and of what is bad at most one line a second: a flood of it makes no flood of lines."""

    next, left_out = 0.0, 0

    def show(self, line: str, bad: bool) -> None:
        now = time.monotonic()
        if bad and now < self.next:
            self.left_out += 1
            return
        if self.left_out and now >= self.next:
            print(f"… {self.left_out:,} more in the last second", flush=True)
            self.left_out = 0
        if bad:
            self.next = now + 1
        print(line, flush=True)


def printable(text: str) -> str:
    """What a peer sent, fit for one line of a terminal: no control characters, cut to a readable length."""
    return "".join(c if c.isprintable() else "?" for c in text[:200]) + ("…" if len(text) > 200 else "")


def short(request_id: bytes) -> str:
    """An id as it is printed: of the long random number in it, the beginning is enough."""
    return re.sub(r"^([0-9a-f]{8})[0-9a-f]{24}-", r"\1…-", printable(request_id.decode(errors="replace")))


def main() -> None:
    # In a pipe Windows would use another encoding, and a character that it lacks would end the program.
    sys.stdout.reconfigure(encoding="utf-8", errors="replace")  # type: ignore[union-attr]
    parser = argparse.ArgumentParser(description="Keeps an account, and does each request once.")
    parser.add_argument("--endpoint", default="tcp://127.0.0.1:5552", help="port 0 takes a free one")
    parser.add_argument("--journal", default="lazy_pirate.sqlite3", help="the SQLite file, made if there is none")
    for name in ("crash-on", "drop", "slow-on", "late"):
        parser.add_argument(f"--{name}", type=int, default=0, metavar="N", help="trouble at request N: see this file")
    parser.add_argument("--delay", type=float, default=2.0, help="seconds that --slow-on takes")
    options = parser.parse_args()
    # libzmq itself would listen on port 99999 - 65536 without a word.
    port = re.fullmatch(r"tcp://[^\s:]+:(\*|\d{1,5})", options.endpoint)
    if not port or int(port[1].replace("*", "0")) > 65535:
        parser.error(f"bad endpoint '{options.endpoint}': write it like tcp://127.0.0.1:5552, port 0 to 65535")
    # To SQLite these names mean a journal in memory, which forgets.
    if options.journal in ("", ":memory:"):
        parser.error("--journal takes the name of a file")
    if not 0 <= options.delay < 86400:
        parser.error("--delay takes seconds, 0 or more")
    # SIGTERM, which kill and process managers send, ends the server as Ctrl-C does.
    signal.signal(signal.SIGTERM, signal.default_int_handler)
    with zmq.Context() as context, context.socket(zmq.ROUTER) as socket:
        # A reply that nobody fetches is dropped at the end; waiting for its delivery could take for ever.
        socket.linger = 0
        # Who announces more is disconnected before it is in memory.
        socket.maxmsgsize = 65536
        try:
            socket.bind(options.endpoint)
        except zmq.ZMQError as error:
            causes = {zmq.EADDRINUSE: "the port is taken", errno.EACCES: "the system reserves this port"}
            cause = causes.get(error.errno or 0, "this machine has no such address")
            where = options.endpoint
            sys.exit(f"cannot listen on {where}: {cause}; try --endpoint tcp://127.0.0.1:0, which takes a free one")
        try:
            # While another program has it locked, everybody here waits, and so does Ctrl-C: not for long.
            db = sqlite3.connect(options.journal, timeout=0.5)
            db.executescript(SCHEMA)
            db.execute("SELECT number, id, reply FROM journal LIMIT 1")
            print(f"journal {options.journal}, balance {db.execute('SELECT balance FROM account').fetchone()[0]}")
            print(f"listening on {socket.getsockopt_string(zmq.LAST_ENDPOINT)}", flush=True)
            serve(socket, db, options)
        except sqlite3.Error as error:
            sys.exit(f"cannot use the journal {options.journal}: {error}; try --journal another.sqlite3")


if __name__ == "__main__":
    try:
        main()
    except KeyboardInterrupt:
        pass
