"""Lesson 14, the journal's lock: of several servers that begin together with one journal one gets it.
"""

import random
import sqlite3
import time

ALONE = "PRAGMA locking_mode = EXCLUSIVE; BEGIN EXCLUSIVE; COMMIT"


def alone(path: str) -> sqlite3.Connection:
    """The file, which nobody else can open any more; sqlite3.Error if another one has it, after a second."""
    end = time.monotonic() + 1
    while True:
        # Who waits for the whole lock may hold a part of it, which the others need. Closing gives it back, and by
        # chance they do not all do so at once.
        db = sqlite3.connect(path, timeout=random.uniform(0.05, 0.3))
        try:
            db.executescript(ALONE)
            return db
        except sqlite3.Error as error:
            db.close()
            if error.sqlite_errorcode & 0xFF != sqlite3.SQLITE_BUSY or time.monotonic() > end:
                raise
            time.sleep(random.uniform(0, 0.1))
