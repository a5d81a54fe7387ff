"""The state of each job, which survives the end of the server: a SQLite file.

    journal = Journal("long_jobs.sqlite3")                                logs: journal long_jobs.sqlite3, 0 jobs
    journal.save([news])                                                  False while it cannot be used
    goal, news = journal.find(job)                                        or None

An entry is the goal and the newest message about the job, as it is sent: with what is finished, if there is a
checkpoint. It is kept for 24 hours after the end. Delete the file to forget all jobs, while no server runs. Of several
servers that begin together with one journal one gets it. Error says that it cannot be used; when that comes later,
as on a full disk, it is logged once.
"""

import logging
import random
import sqlite3
import time
from pathlib import Path
from typing import Any

from netmq_example import check
from netmq_example.jobs.client import ENDS, check_news, job_id
from netmq_example.journal import cannot_use, files_of, refuse_memory, refuse_replaced
from netmq_example.messages import EXACT, LIMIT, Message, MessageError, take

# By this number in its header the file is known for a journal of jobs.
APPLICATION_ID = 1_246_708_275
EXCLUSIVE = "PRAGMA locking_mode = EXCLUSIVE; BEGIN EXCLUSIVE; COMMIT"
# FULL: a commit is on the disk when it returns. NORMAL would survive kill -9 too, but not a power cut.
SCHEMA = f"""
    PRAGMA journal_mode = WAL; PRAGMA synchronous = FULL; PRAGMA application_id = {APPLICATION_ID};
    CREATE TABLE IF NOT EXISTS jobs (number INTEGER PRIMARY KEY, id TEXT UNIQUE NOT NULL, goal BLOB NOT NULL,
        news BLOB NOT NULL, data BLOB, ended REAL);
    CREATE INDEX IF NOT EXISTS jobs_by_end ON jobs (ended);
"""
ENTRY = "SELECT id, goal, news, data FROM jobs"
KEEP_SECONDS = 24 * 3600
# From so much on somebody has set the clock, as a board without a battery does when it has found the network.
SET_SECONDS = 60
# Of the number of a job's newest message, to which each that follows adds one.
MOST_SEQ = EXACT // 2
# How long to wait for another server that has the file.
LOCK_SECONDS = 1.0

log = logging.getLogger("netmq_example.jobs")
Place = str | Path


def open_exclusively(path: str) -> sqlite3.Connection:
    """The file, which nobody else can open any more; sqlite3.Error if another one has it, after a second."""
    end = time.monotonic() + LOCK_SECONDS
    while True:
        # One that waits for the whole lock may hold a part of it, which the others need. Closing gives it back, and by
        # chance they do not all do so at once.
        db = sqlite3.connect(path, timeout=random.uniform(0.05, 0.3))
        try:
            db.executescript(EXCLUSIVE)
            return db
        except sqlite3.Error as error:
            db.close()
            if error.sqlite_errorcode & 0xFF != sqlite3.SQLITE_BUSY or time.monotonic() > end:
                raise
            time.sleep(random.uniform(0, 0.1))


def clock() -> float:
    """It grows when the system's clock is set forward, or the machine has slept."""
    return time.time() - time.monotonic()


def entry(job: Any, goal: Any, news: Any, data: Any) -> tuple[Message, Message]:
    """A row; MessageError unless it holds what `save` has written: a file is trusted no more than a peer."""
    begun, newest = Message.read([goal]), Message.read([news] if data is None else [news, data])
    for name, kind in {"kind": str, "count": int, "text": str}.items():
        take(begun.values, name, kind)
    check_news(newest)
    try:
        job_id("a row's id", job)
        check.count("seq", newest.values.get("seq", 0), least=0, most=MOST_SEQ)
    except ValueError as error:
        raise MessageError("bad-value", str(error)) from None
    for message in (begun, newest):
        if take(message.values, "job", str) != job:
            raise MessageError("bad-job", f"it is about another job than {job!a:.80}")
    return begun, newest


class Journal:
    """The jobs by their ids. Use it on one thread."""

    def __init__(self, path: Place) -> None:
        self.path = str(check.instance("the journal's path", path, str, Path))
        self.usable = True
        try:
            refuse_memory(self.path)
            # From here on no other server gets it: it would do the same jobs.
            self.db = open_exclusively(self.path)
            whose = self.db.execute("PRAGMA application_id").fetchone()[0]
            if whose != APPLICATION_ID and self.db.execute("SELECT 1 FROM sqlite_master").fetchone():
                raise sqlite3.Error("it is another program's")
            self.db.executescript(SCHEMA)
            # A file can be damaged: whatever a row holds, the others go on.
            self.db.setlimit(sqlite3.SQLITE_LIMIT_LENGTH, 2 * LIMIT)
            self.db.text_factory = lambda text: text.decode(errors="replace")
            jobs = self.db.execute("SELECT count(id), count(goal), count(news), count(data) FROM jobs").fetchone()[0]
        except (sqlite3.Error, ValueError) as error:
            raise cannot_use(self.path, error) from None
        self.opened = files_of(self.path)
        self.clock = clock()
        log.info("journal %s, %s jobs", self.path, jobs)

    def add(self, goal: Message, news: Message) -> bool:
        row = goal.values["job"], goal.frames()[0], news.frames()[0]
        return self.write("INSERT INTO jobs (id, goal, news) VALUES (?, ?, ?)", [row])

    def save(self, news: list[Message]) -> bool:
        """All of them or none."""
        now = time.time()
        rows: list[tuple[object, ...]] = []
        for message in news:
            header, *arrays = message.frames()
            data = arrays[0] if arrays else None
            ended = now if message.kind in ("result", "forgotten") else None
            rows.append((header, data, ended, message.values["job"]))
        return self.write("UPDATE jobs SET news = ?, data = ?, ended = ? WHERE id = ?", rows)

    def find(self, job: str) -> tuple[Message, Message] | None:
        found = self.db.execute(f"{ENTRY} WHERE id = ?", (job,)).fetchone()
        return entry(*found) if found else None

    def open(self) -> list[tuple[Message, Message]]:
        """The jobs that have not ended, oldest first. An entry that cannot be read stays as it is."""
        found: list[tuple[Message, Message]] = []
        try:
            for (number,) in self.db.execute("SELECT number FROM jobs WHERE ended IS NULL ORDER BY number").fetchall():
                try:
                    goal, news = entry(*self.db.execute(f"{ENTRY} WHERE number = ?", (number,)).fetchone())
                    if news.kind in ENDS:
                        raise MessageError("ended", "it has ended, and the row does not say when")
                    found.append((goal, news))
                except (MessageError, sqlite3.DataError) as error:
                    log.warning("cannot read row %s of the journal, and leave it alone: %s", number, error)
        except sqlite3.Error as error:
            raise cannot_use(self.path, error) from None
        return found

    def close(self) -> None:
        """Let the file go, which another server may have from now on."""
        self.db.close()

    def write(self, statement: str, rows: list[tuple[object, ...]]) -> bool:
        try:
            refuse_replaced(self.path, self.opened)
            set_right = clock() - self.clock
            # One transaction: wherever the server is killed, all of it is there, or nothing.
            with self.db:
                if set_right > SET_SECONDS:
                    # A job that has just ended must not be older than it is kept.
                    self.db.execute("UPDATE jobs SET ended = ended + ?", (set_right,))
                self.db.executemany(statement, rows)
                self.db.execute("DELETE FROM jobs WHERE ended < ?", (time.time() - KEEP_SECONDS,))
            self.clock = clock()
        except sqlite3.Error as error:
            if self.usable:
                log.error("cannot use the journal %s: %s; nothing new until this is fixed", self.path, error)
            self.usable = False
            return False
        if not self.usable:
            log.info("the journal %s can be used again", self.path)
        self.usable = True
        return True
