"""Lesson 14, a worker: what its process does, from a goal to a result.

It sends `feedback` between two steps, and then one `result`. A thread of its own listens to the server: it hears a
cancel, for which the work looks between two steps, and the end of the server, which ends the process at once.
"""

import os
import signal
import sys
import threading
import time
import traceback
from multiprocessing.connection import Connection
from pathlib import Path
from queue import SimpleQueue

# In its own lesson's folder; at home it lies beside this file.
sys.path.append(str(Path(__file__).resolve().parents[1] / "05_messages"))
from messages import EXACT, Message, read, take
from work import KINDS, Kind, Step, WorkError

# Feedback is a state: nobody needs it more often. So a checkpoint is at most so many seconds old.
INTERVAL = 0.1


def send(pipe: Connection, message: Message) -> None:
    for frame in message.frames():
        pipe.send_bytes(frame)
    pipe.send_bytes(b"")


def receive(pipe: Connection) -> Message:
    return read(list(iter(pipe.recv_bytes, b"")))


def labour(pipe: Connection, kinds: dict[str, Kind]) -> None:
    """What a worker's process does. It has the kinds of work that the server has."""
    KINDS.update(kinds)
    # Ctrl-C in a terminal reaches it too; when to end, the server says.
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    goals, cancel = SimpleQueue[Message](), threading.Event()

    def listen() -> None:
        try:
            while True:
                if (message := receive(pipe)).kind == "cancel":
                    cancel.set()
                else:
                    # A cancel that came too late for the job before is none of this one.
                    cancel.clear()
                    goals.put(message)
        finally:
            # The server ended or was killed. Nobody waits for the work any more, and it may be deaf.
            os._exit(1)

    threading.Thread(target=listen, daemon=True).start()
    while True:
        goal = goals.get()
        try:
            send(pipe, perform(pipe, goal, cancel))
        except OSError:
            # Nobody reads it.
            os._exit(1)


def check(step: Step) -> None:
    """What cannot be told to clients, whatever is said with it, ends the job here, where the work is written."""
    facts = {"job": "x" * 64, "seq": EXACT - 1, "status": "succeeded", "text": step.text}
    arrays = [step.checkpoint] if step.checkpoint else []
    told = read(Message("canceling", values=facts | {"done": step.done, "total": step.total}, arrays=arrays).frames())
    for name, kind in (("done", int), ("total", int), ("text", str)):
        take(told.values, name, kind)


def perform(pipe: Connection, goal: Message, cancel: threading.Event) -> Message:
    """Does the job, and returns its result."""
    job, total, text = goal.values["job"], goal.values["count"], goal.values["text"]
    finished = bytes(goal.arrays[0].data) if goal.arrays else b""
    told, step = 0.0, Step(goal.values["done"], total, checkpoint=goal.arrays[0] if goal.arrays else None)

    def said(step: Step, kind: str, **values: str) -> Message:
        facts = {"job": job, "done": step.done, "total": step.total, "text": step.text}
        return Message(kind, values=facts | values, arrays=[step.checkpoint] if step.checkpoint else [])

    try:
        for new in KINDS[goal.values["kind"]].work(total, finished, text):
            check(new)
            step = new
            if cancel.is_set():
                return said(step, "result", status="canceled")
            if time.monotonic() >= told + INTERVAL:
                told = time.monotonic()
                send(pipe, said(step, "feedback"))
        return said(step, "result", status="succeeded")
    except WorkError as error:
        return said(step, "result", status="aborted", text=f"{error!s:.200}")
    except Exception as error:
        # A mistake in the work: its place is for whoever writes it.
        traceback.print_exc()
        return said(step, "result", status="aborted", text=f"{error!r:.200}")
