"""The end of a program with what started it. A server needs it for --until-eof alone."""

import os
import signal

from netmq_example.console import again


def at_eof() -> None:
    """Ctrl-C, as soon as nobody can write to standard input: who started this program closed it, or is gone."""
    try:
        while os.read(0, 4096):
            pass
    except OSError:
        # There is none.
        pass
    again(signal.SIGINT)
