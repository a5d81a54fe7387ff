"""A journal of what a server has done: each request is done once, however often it arrives.

    journal = Journal("lazy_pirate.sqlite3")             prints: journal lazy_pirate.sqlite3, balance 0
    with journal.watched():
        reply = journal.find(request_id) or journal.do(request_id, text, answer)

It is a SQLite file, which also has the account that this server keeps: delete it to begin at 0, while no server runs.
"""

import contextlib
import os
import sqlite3
from argparse import ArgumentTypeError
from collections.abc import Callable, Iterator

from netmq_example import check
from netmq_example.replies import sendable, told

# FULL: a commit is on the disk when it returns. NORMAL would survive kill -9 too, but not a power cut.
SCHEMA = """
    PRAGMA journal_mode = WAL; PRAGMA synchronous = FULL;
    CREATE TABLE IF NOT EXISTS account (balance INTEGER NOT NULL);
    INSERT INTO account SELECT 0 WHERE NOT EXISTS (SELECT * FROM account);
    CREATE TABLE IF NOT EXISTS journal (number INTEGER PRIMARY KEY, id BLOB UNIQUE NOT NULL, reply TEXT NOT NULL);
"""
# An entry has to outlive the last try of its client, and no longer. So many entries take 11 MB.
KEPT_ENTRIES = 100_000
LONGEST_ID_BYTES = 100
# While another program has the file locked, everybody here waits, and so does Ctrl-C: not for long.
LOCKED_SECONDS = 0.5
# A statement that is wrong, or that a rule of a table refuses: nothing is the matter with the file.
MISTAKES = (sqlite3.SQLITE_ERROR, sqlite3.SQLITE_CONSTRAINT, sqlite3.SQLITE_MISMATCH, sqlite3.SQLITE_TOOBIG)
# What does the work of a request: your own.
Answer = Callable[[sqlite3.Connection, str], str]


class Journal:
    """The requests that were done, by their ids, and the account that they change. Use it on one thread."""

    def __init__(self, path: str) -> None:
        """May be the type of an option: a journal that cannot be used is wrong usage."""
        self.path = check.instance("path", path, str)
        self.usable = True
        try:
            # To SQLite these names mean a journal in memory, which forgets.
            if path in ("", ":memory:"):
                raise sqlite3.Error("it needs the name of a file")
            self.db = sqlite3.connect(path, timeout=LOCKED_SECONDS)
            self.db.executescript(SCHEMA)
            self.db.execute("SELECT number, id, reply FROM journal LIMIT 1")
            balance = self.db.execute("SELECT balance FROM account").fetchone()[0]
            if not isinstance(balance, int):
                raise sqlite3.Error("its balance is no whole number")
        except sqlite3.Error as error:
            raise ArgumentTypeError(f"cannot use the journal {path}: {error}; try --journal another.sqlite3") from None
        self.opened = self.files()
        print(f"journal {path}, balance {balance}", flush=True)

    @contextlib.contextmanager
    def watched(self) -> Iterator[None]:
        """Around find() and do(): while the journal cannot be used they end this block, and it prints why, once."""
        try:
            yield
        except sqlite3.Error as error:
            if self.usable:
                print(f"cannot use the journal {self.path}: {error}; no replies until this is fixed", flush=True)
            self.usable = False

    def find(self, request_id: bytes) -> str:
        """The reply to this request, if it was done already, else an empty text."""
        self.ready(request_id)
        known = self.db.execute("SELECT reply FROM journal WHERE id = ?", (request_id,)).fetchone()
        if known and not isinstance(known[0], str):
            raise sqlite3.Error(f"the reply to request {request_id!r:.40} is no text; delete that row")
        return known[0] if known else ""

    def do(self, request_id: bytes, text: str, answer: Answer) -> str:
        """Do the work of a request, and write its reply down.

        It is one transaction: wherever the server is killed, the work and its entry are both there, or neither is.
        """
        self.ready(request_id)
        reply = ""
        try:
            with self.db:
                # An empty reply would look like none.
                reply = check.text("reply", answer(self.db, text))
                # Before it is written down: no client would ever get it.
                sendable(reply)
                # A mistake may be asked again. Were it written down, a flood of mistakes would drive out what was done.
                if reply.startswith("error:"):
                    # What it changed before would be changed once more by each retry.
                    self.db.rollback()
                    return reply
                self.db.execute("INSERT INTO journal (id, reply) VALUES (?, ?)", (request_id, reply))
                self.db.execute("DELETE FROM journal WHERE number <= last_insert_rowid() - ?", (KEPT_ENTRIES,))
        except Exception as error:
            # Python's own errors about a statement have no code. With a reply the work is done: it is the journal's.
            code = getattr(error, "sqlite_errorcode", sqlite3.SQLITE_ERROR)
            if isinstance(error, sqlite3.Error) and (reply or code & 0xFF not in MISTAKES):
                raise
            # A mistake in the work is reported to both sides, and ends neither; what it changed is taken back.
            return told(error)
        if not self.usable:
            print(f"the journal {self.path} can be used again", flush=True)
        self.usable = True
        return reply

    def ready(self, request_id: bytes) -> None:
        check.instance("request_id", request_id, bytes)
        if not 0 < len(request_id) <= LONGEST_ID_BYTES:
            raise ValueError(f"request_id takes 1 to {LONGEST_ID_BYTES} bytes, not {len(request_id)}")
        if self.files() != self.opened:
            raise sqlite3.Error("it was deleted or replaced; put it back, or start the server again")

    def files(self) -> list[int]:
        """Which files these are, by their numbers: the journal, and what SQLite has not yet moved into it."""
        try:
            return [os.stat(self.path + end).st_ino for end in ("", "-wal")]
        except OSError:
            return []
