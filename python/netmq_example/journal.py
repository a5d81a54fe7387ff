"""A journal of what a server has done: each request is done once, however often it arrives.

    with Journal("mine.sqlite3", schema="CREATE TABLE IF NOT EXISTS stock (item TEXT, number INTEGER);") as journal:
        with journal.watched():
            reply = journal.find(request_id) or journal.do(request_id, text, answer)

It is a SQLite file, which also has the tables that `answer` changes.
"""

import contextlib
import logging
import os
import sqlite3
from collections.abc import Callable, Iterator
from typing import Any

from netmq_example import check
from netmq_example.errors import Error, Misfit
from netmq_example.one_process import OneProcess
from netmq_example.program import sendable
from netmq_example.trouble import ends_program, told

# FULL: a commit is on the disk when it returns. NORMAL would survive kill -9 too, but not a power cut.
SCHEMA = """
    PRAGMA journal_mode = WAL; PRAGMA synchronous = FULL;
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
Connection = sqlite3.Connection
Answer = Callable[[Connection, str], str]

log = logging.getLogger("netmq_example.server")


class Journal(OneProcess):
    """The requests that were done, by their ids. Use it on one thread at a time."""

    def __init__(self, path: str | os.PathLike[str], *, schema: str = "") -> None:
        """A file, made if there is none. `schema` is SQL for the tables of your own, which may be there already.

        Error: it cannot be used.
        """
        self.path = path = os.fspath(check.instance("path", path, str, os.PathLike))
        self.usable = True
        try:
            refuse_memory(path)
            self.db = sqlite3.connect(path, timeout=LOCKED_SECONDS, check_same_thread=False)
            self.db.executescript(SCHEMA + check.instance("schema", schema, str))
            self.db.execute("SELECT number, id, reply FROM journal LIMIT 1")
        except sqlite3.Error as error:
            raise cannot_use(path, error) from None
        self.opened = files_of(path)

    @contextlib.contextmanager
    def watched(self) -> Iterator[None]:
        """Around find() and do(): while the journal cannot be used they end this block, and why is logged, once."""
        try:
            yield
        except sqlite3.Error as error:
            if self.usable:
                log.error("cannot use the journal %s: %s; no replies until this is fixed", self.path, error)
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
                reply = answer(self.db, text)
                # Before it is written down: no client would ever get it.
                if not sendable(reply):
                    raise Misfit("answer returned an empty text, which would look like no reply")
                # A mistake may be asked again. Were it written down, a flood of mistakes would drive out what was done.
                if reply.startswith("error:"):
                    # Each retry would repeat its changes so far.
                    self.db.rollback()
                    return reply
                self.db.execute("INSERT INTO journal (id, reply) VALUES (?, ?)", (request_id, reply))
                self.db.execute("DELETE FROM journal WHERE number <= last_insert_rowid() - ?", (KEPT_ENTRIES,))
        except BaseException as error:
            if ends_program(error):
                raise
            # Python's own errors about a statement have no code. With a reply the work is done: it is the journal's.
            code = getattr(error, "sqlite_errorcode", sqlite3.SQLITE_ERROR)
            if isinstance(error, sqlite3.Error) and (reply or code & 0xFF not in MISTAKES):
                raise
            # A mistake in the work is reported to both sides, and ends neither; what it changed is taken back.
            return told(error)
        if not self.usable:
            log.info("the journal %s can be used again", self.path)
        self.usable = True
        return reply

    def value(self, query: str) -> Any:
        """The first value that a query of your own finds. Error: it cannot be asked."""
        try:
            return self.db.execute(query).fetchone()[0]
        except (sqlite3.Error, TypeError) as error:
            raise cannot_use(self.path, error) from None

    def ready(self, request_id: bytes) -> None:
        self.check_process()
        check.instance("request_id", request_id, bytes)
        if not 0 < len(request_id) <= LONGEST_ID_BYTES:
            raise ValueError(f"request_id takes 1 to {LONGEST_ID_BYTES} bytes, not {len(request_id)}")
        refuse_replaced(self.path, self.opened)

    def close(self) -> None:
        """Close the file. Twice is once."""
        self.db.close()


def files_of(path: str) -> list[int]:
    """Which files these are, by their numbers: the journal, and what SQLite has not yet moved into it."""
    try:
        return [os.stat(path + end).st_ino for end in ("", "-wal")]
    except OSError:
        return []


def refuse_memory(path: str) -> None:
    """To SQLite these names mean a journal in memory, which forgets."""
    if path in ("", ":memory:"):
        raise sqlite3.Error("it needs the name of a file")


def refuse_replaced(path: str, opened: list[int]) -> None:
    if files_of(path) != opened:
        raise sqlite3.Error("it was deleted or replaced; put it back, or start the server again")


def cannot_use(path: str, why: Exception) -> Error:
    return Error(f"cannot use the journal {path}: {why}; try another file")
