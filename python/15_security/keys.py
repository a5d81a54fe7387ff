"""Lesson 15, keys: makes a pair for each side, and keeps the list of the clients that may come in.

    python python/15_security/keys.py make server           keys/server.key and keys/server.key_secret
    python python/15_security/keys.py enrol alice=FILE      lets that key in, as alice; FILE is her client.key

All its verbs, and what the files are: netmq_example/security/keys.py.
"""

import sys
from pathlib import Path

sys.path[:0] = map(str, Path(__file__).resolve().parents[:2])
from netmq_example.program import run
from netmq_example.security.keys import main

if __name__ == "__main__":
    run(main, stopped="stopped")
