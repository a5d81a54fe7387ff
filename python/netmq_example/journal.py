"""Lesson 02, the server's journal: each request is done once, however often it arrives.

    journal = Journal("lazy_pirate.sqlite3")             prints: journal lazy_pirate.sqlite3, balance 0
    reply, source = journal.reply(request_id, text, answer)

It is a SQLite file: delete it to begin at 0, while no server runs. When it cannot be used, as on a full disk, it prints
that once, and no work is done until it can be used again.
"""

import os
import sqlite3
import traceback
from argparse import ArgumentTypeError
from collections.abc import Callable

# FULL: a commit is on the disk when it returns. NORMAL would survive kill -9 too, but not a power cut.
SCHEMA = """
    PRAGMA journal_mode = WAL; PRAGMA synchronous = FULL;
    CREATE TABLE IF NOT EXISTS account (balance INTEGER NOT NULL);
    INSERT INTO account SELECT 0 WHERE NOT EXISTS (SELECT * FROM account);
    CREATE TABLE IF NOT EXISTS journal (number INTEGER PRIMARY KEY, id BLOB UNIQUE NOT NULL, reply TEXT NOT NULL);
"""
# An entry has to outlive the last try of its client, and no longer. So many entries take 11 MB.
KEEP = 100_000
# What does the work of a request: your own.
Answer = Callable[[sqlite3.Connection, str], str]


class Journal:
    """What was done, by the ids of the requests, and the account that they change."""

    def __init__(self, path: str) -> None:
        """May be the type of an option: a journal that cannot be used is wrong usage."""
        self.path, self.usable = path, True
        try:
            # To SQLite these names mean a journal in memory, which forgets.
            if path in ("", ":memory:"):
                raise sqlite3.Error("it needs the name of a file")
            # While another program has it locked, everybody here waits, and so does Ctrl-C: not for long.
            self.db = sqlite3.connect(path, timeout=0.5)
            self.db.executescript(SCHEMA)
            self.db.execute("SELECT number, id, reply FROM journal LIMIT 1")
            balance = self.db.execute("SELECT balance FROM account").fetchone()[0]
        except sqlite3.Error as error:
            raise ArgumentTypeError(f"cannot use the journal {path}: {error}; try --journal another.sqlite3") from None
        self.opened = self.files()
        print(f"journal {path}, balance {balance}", flush=True)

    def reply(self, request_id: bytes, text: str, answer: Answer) -> tuple[str, str]:
        """The reply and where it comes from. While the journal cannot be used there is none, and nothing was done."""
        try:
            if self.files() != self.opened:
                raise sqlite3.Error("it was deleted or replaced; put it back, or start the server again")
            found = self.once(request_id, text, answer)
        except sqlite3.Error as error:
            if self.usable:
                print(f"cannot use the journal {self.path}: {error}; no replies until it is over", flush=True)
            self.usable = False
            return "", ""
        except Exception as error:
            # A mistake in the work is told to both sides, and ends neither; what it changed is taken back.
            traceback.print_exc()
            return f"error: {error!r}", ""
        if not self.usable:
            print(f"the journal {self.path} can be used again", flush=True)
        self.usable = True
        return found

    def once(self, request_id: bytes, text: str, answer: Answer) -> tuple[str, str]:
        if not 0 < len(request_id) <= 100:
            return "error: expected two frames, an id of 1 to 100 bytes and a request", ""
        if known := self.db.execute("SELECT reply FROM journal WHERE id = ?", (request_id,)).fetchone():
            return known[0], ", from the journal"
        # One transaction: wherever the server is killed, the work and its entry are both there, or neither is.
        with self.db:
            reply = answer(self.db, text)
            # A mistake may be asked again. Were it written down, a flood of mistakes would drive out what was done.
            if not reply.startswith("error:"):
                self.db.execute("INSERT INTO journal (id, reply) VALUES (?, ?)", (request_id, reply))
                self.db.execute("DELETE FROM journal WHERE number <= last_insert_rowid() - ?", (KEEP,))
        return reply, ""

    def files(self) -> list[int]:
        """Which files these are, by their numbers: the journal, and what SQLite has not yet moved into it."""
        try:
            return [os.stat(self.path + end).st_ino for end in ("", "-wal")]
        except OSError:
            return []
