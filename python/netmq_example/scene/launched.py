"""This program ends when the one that launched it does, in whatever way. In C# it is Launcher.cs.

    watch_launcher()            from now on; without a launcher nothing happens

A training that is killed can end nobody. So it gives to each simulator that it launches a pipe, as its standard input,
in which nothing ever comes but one byte at the beginning; and the system closes it when the training ends. It needs
only Python.
"""

import functools
import os
import threading
import time

# Set for a program that was launched: the process id of the one that did it.
VARIABLE = "NETMQ_EXAMPLE_LAUNCHER"


@functools.cache
def watch_launcher() -> None:
    if os.environ.get(VARIABLE, "").isdecimal():
        threading.Thread(target=wait, args=(int(os.environ[VARIABLE]),), daemon=True).start()


def wait(launcher: int) -> None:
    try:
        # Without the byte it is no pipe of a training's: somebody has given this program another input.
        if not os.read(0, 1):
            while os.getppid() == launcher:
                time.sleep(0.5)
        while os.read(0, 1):
            pass
    except OSError:
        # The pipe is closed, too.
        pass
    # This program may be waiting for anything.
    os._exit(1)
