"""A low floor, floors above each other, and separate rooms: the package as its real imports show it."""

import subprocess
import sys
from pathlib import Path

from tests.house.test_style import imports_of, python_lines
from tests.programs import LIMIT, ROOT

PACKAGE = ROOT / "python" / "netmq_example"

# Environments: they need what the clients and servers have, and never the other way round.
ABOVE = {
    *("wire", "locator", "envs", "scene", "fleet", "worlds", "video", "sb3", "mlagents_envs", "mlagents_learn"),
    *("records", "spaces", "space_bytes", "space_numbers", "trees", "split_mix", "locator_reader"),
    *("simulation", "side_channel", "environment", "base_env", "exception", "cross_entropy"),
}
ROOMS = {"jobs", "fleet", "body", "talk"}

# The server of lesson 01 runs up to its first receive, which ends it as Ctrl-C would.
FIRST_RECEIVE = """
import runpy, sys, zmq
def stop(*_, **__): raise KeyboardInterrupt
zmq.Socket.recv = zmq.Socket.recv_multipart = zmq.Socket.poll = stop
sys.argv = [sys.argv[1], "--endpoint", "tcp://127.0.0.1:0"]
try: runpy.run_path(sys.argv[0], run_name="__main__")
except SystemExit: pass
print(*(module.__file__ for name, module in sys.modules.items() if name.startswith("netmq_example")), sep="\\n")
"""


def room(path):
    """The folder of the package in which a module lies, or the module itself."""
    return path.relative_to(PACKAGE).parts[0].removesuffix(".py")


def needs():
    """Each module's room and another one that it imports, as (path, its room, the other room)."""
    for path in PACKAGE.rglob("*.py"):
        for name in imports_of(path):
            package, _, rest = str(name).partition(".")
            if package == "netmq_example" and rest:
                yield path.relative_to(PACKAGE).as_posix(), room(path), rest.partition(".")[0]


def test_clients_and_servers_need_no_environments():
    assert {(path, other) for path, own, other in needs() if own not in ABOVE and other in ABOVE} == set()


def test_the_rooms_of_lessons_14_17_20_and_21_need_nothing_of_each_other():
    assert {(path, other) for path, own, other in needs() if {own, other} <= ROOMS and own != other} == set()


def test_the_floor_of_lesson_01_is_low():
    server = ROOT / "python" / "01_request_reply" / "server.py"
    words = [sys.executable, "-c", FIRST_RECEIVE, server]
    done = subprocess.run(words, capture_output=True, text=True, timeout=LIMIT, check=False)
    files = [line for line in done.stdout.splitlines() if str(PACKAGE) in line]
    code = {file: len(python_lines(Path(file).read_text(encoding="utf-8"))) for file in files}
    assert "listening on " in done.stdout, done.stderr
    assert 1 < len(code) <= 7 and sum(code.values()) <= 350, code
