"""The one entry to the kit: does all set-up, runs a lesson, runs the tests.

    python3 kit.py run 1         lesson 01: the Python server and the C# client, side by side
    python3 kit.py server 1      only its server: for two terminals
    python3 kit.py client 1      only its client, in the other one
    python3 kit.py guide         the guide in your browser, whose commands run by a button
    python3 kit.py test          every test that this machine can run
    python3 kit.py list          the lessons
    python3 kit.py doctor        what is on this machine, and what is missing
    python3 kit.py bench         how fast it is, beside what people would pick instead
    python3 kit.py copy 1 DIR    lesson 01's Python programs and what they import, for a folder of your own
    python3 kit.py unity PATH    put the scripts and NetMQ's DLLs into your own Unity project
    python3 kit.py play FILE.cs  a script of your own, as Unity would play it
    python3 kit.py pack          bring along what a classroom without internet needs

Each command explains itself with examples: python3 kit.py run --help
On Windows type `py` instead of `python3`. Ctrl-C stops everything that was started. --version says which kit this is.
"""

import sys

if sys.version_info < (3, 11):
    sys.exit(
        "kit.py needs Python 3.11 or later, this is %d.%d: get one from https://www.python.org,"
        " and then open a new terminal" % sys.version_info[:2]
    )

import os
import signal

# Where PYTHONSAFEPATH is set, a program's own folder is not on the path.
sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
os.environ.pop("PYTHONSAFEPATH", None)
# It would leave out each assert of a test, and the help of a program.
os.environ.pop("PYTHONOPTIMIZE", None)

if __name__ == "__main__" and signal.getsignal(signal.SIGINT) is signal.default_int_handler:
    # Until main() takes over nothing is there to be cleared up, and a Ctrl-C would only show a traceback.
    signal.signal(signal.SIGINT, signal.SIG_DFL)

from kitlib import commands

# Each is a module of kitlib/commands.
COMMANDS = ("run", "server", "client", "guide", "test", "list", "doctor", "bench", "copy", "unity", "play", "pack")

if __name__ == "__main__":
    sys.exit(commands.guarded(lambda: commands.start(COMMANDS, sys.argv[1:])))
