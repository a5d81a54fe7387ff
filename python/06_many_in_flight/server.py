"""Lesson 06, many in flight: no request waits for the reply to another, and replies come in any order.

    python python/06_many_in_flight/server.py       prints: listening on tcp://127.0.0.1:5556
    python python/06_many_in_flight/client.py       or: dotnet run --project csharp-console -- 6

Bytes: a request is two frames, [id][text], and so is its reply; text is UTF-8, and the id is the client's own: any
bytes, returned as they came. ROUTER puts one more in front, which says whose request it is: [client][id][text]. The
empty frame that REQ puts before the id comes back with the reply, too.
`echo TEXT` is answered with TEXT, `sleep 0.5` after half a second, anything else with a text that begins with `error:`.
A retry of a request at work is not done twice; a retry of an answered one is (lesson 02 has the cure).
`error: busy, try again later` refuses what is more than 64 of one client or 256 of all, and `echo` never.
Trouble on command: `sleep 60`, `--workers 1`.
"""

import contextlib
import re
import sys
import time
from pathlib import Path

sys.path[:0] = map(str, Path(__file__).resolve().parents[:2])
import zmq

from netmq_example.large import send_frames
from netmq_example.program import listening, run, server_options
from netmq_example.worker_threads import WorkerThreads

# So many may be at work or wait for a worker, and a quarter of them may be one client's. More are refused at once: to
# leave them unread would leave everything behind them unread as well, as long as the work takes.
MOST = 256


def answer(text: str) -> str:
    """Your own work goes here; a worker thread runs it. Threads wait side by side, but compute in turn."""
    if text.startswith("echo "):
        return text[5:]
    if sleep := re.fullmatch(r"sleep (\d{1,2}(?:\.\d{1,6})?)", text, re.ASCII):
        time.sleep(float(sleep[1]))
        return f"slept {sleep[1]}"
    return f"error: expected an id and 'echo TEXT' or 'sleep 0.5', got {text[:40]!r}"


def is_busy(at_work: list[list[bytes]], client: bytes) -> bool:
    """Whether a server with so much to do refuses this client."""
    return len(at_work) >= MOST or sum(peer == client for peer, *_ in at_work) >= MOST // 4


def main() -> None:
    parser = server_options(__doc__, "tcp://127.0.0.1:5556")
    parser.add_argument("--workers", type=int, choices=range(1, 33), default=4, metavar="N", help="how many threads")
    options = parser.parse_args()
    workers = WorkerThreads[list[bytes]](options.workers, answer)
    # What is under way: whose request, and its id.
    at_work: list[list[bytes]] = []
    with contextlib.closing(workers), listening(zmq.ROUTER, options) as socket:
        while True:
            zmq.select([socket, workers], [], [], 0.2)
            for way, reply in workers.finished():
                at_work.remove(way)
                # This never waits: ROUTER drops the reply to a client that has gone, or does not read.
                socket.send_multipart([*way, reply])
            with contextlib.suppress(zmq.Again):
                # Not until there are no more: the replies have their turn, too.
                for _ in range(MOST):
                    *way, text = socket.recv_multipart(zmq.NOBLOCK)
                    # [client][id], and of a REQ [client][][id]. To others the reply is that to an empty text.
                    text = text if len(way) == 2 or way[1:-1] == [b""] else b""
                    if not text or text.startswith(b"echo "):
                        # To hand an echo to a worker would cost more than to answer it, and so would send_multipart.
                        send_frames(socket, [*way[:3], workers.at_once(text)])
                    elif way not in at_work and is_busy(at_work, way[0]):
                        socket.send_multipart([*way, b"error: busy, try again later"])
                    elif way not in at_work:
                        at_work.append(way)
                        workers.begin(way, text)


if __name__ == "__main__":
    run(main)
