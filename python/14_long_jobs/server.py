"""Lesson 14, long jobs: the id outlives the connection. A goal, feedback, a result, and cancel.

    python python/14_long_jobs/server.py          prints: journal long_jobs.sqlite3, 0 jobs
                                                          listening on tcp://127.0.0.1:5564
    python python/14_long_jobs/client.py          or: dotnet run --project csharp-console -- 14

Bytes: messages of lesson 05, whose kind is the verb and whose value `job` is the client's id; DEALER and ROUTER.
    goal {kind, count, text}   cancel   status   forget                                   what a client sends
    accepted {position}   rejected {code, text}   feedback {done, total, text}   canceling   forgotten
    result {status: succeeded, canceled or aborted, done, total, text}                    what it is answered
What is finished so far comes along as an array. `seq` grows with each message about a job. A client that asked is told
what is new for 5 seconds; it asks again in time. What was told is in the journal, also after kill -9.
Trouble on command: --crash-on N ends the server when a job is at N: start it again yourself. Or end a worker, whose
number is printed; let the queue be full with --queue 1; have a job that is deaf to cancel: client.py --kind deaf.
"""

import argparse
import contextlib
import os
import re
import signal
import sys
from collections.abc import Callable
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))
import zmq

from netmq_example.jobs.jobs import Jobs, exchange
from netmq_example.jobs.journal import Journal

ENDPOINT, SOCKET, LARGEST = "tcp://127.0.0.1:5564", zmq.ROUTER, 65_536


def serve(socket: zmq.Socket[bytes], options: argparse.Namespace) -> None:
    jobs, limit = Jobs(options.journal, options.workers, options.queue, options.grace), options.crash_on or float("inf")
    with contextlib.closing(jobs.workers):
        # After a crash, and started in the same way, it goes on.
        before = [id for id, job in jobs.live.items() if job.news.values.get("done", 0) >= limit]
        while True:
            for client, news in exchange(jobs, socket):
                # This never waits: ROUTER drops what is for a client that has gone, or does not read: it asks again.
                socket.send_multipart([client, *news.frames()])
            if any(jobs.live[id].news.values.get("done", 0) >= limit for id in jobs.workers.busy if id not in before):
                os._exit(1)


def add_options(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("--journal", type=Journal, default="long_jobs.sqlite3", help="a file, made if there is none")
    parser.add_argument("--workers", type=number(1, 100), default=2, help="how many jobs are done at the same time")
    parser.add_argument("--queue", type=number(1, 10**6), default=100, help="how many may wait; one more is rejected")
    parser.add_argument(
        "--grace", type=number(0, 86400, float), default=2, help="seconds until a job deaf to cancel is killed"
    )
    parser.add_argument("--crash-on", type=number(0, 10**9), default=0, metavar="N", help="end when a job is at N")


def number(least: int, most: int, kind: type[int | float] = int) -> Callable[[str], float]:
    """The type of an option."""

    def read(text: str) -> float:
        digits, name = (r"\d{1,9}", "whole number") if kind is int else (r"\d{1,9}(\.\d{1,6})?", "number")
        if not re.fullmatch(digits, text, re.ASCII) or not least <= float(text) <= most:
            raise argparse.ArgumentTypeError(f"'{text}' is no {name} from {least} to {most}")
        return kind(text)

    return read


# From here on all servers of this kit are the same, as far as they need it.


def endpoint(text: str) -> str:
    """libzmq itself would listen on port 99999 - 65536, and for everybody, without a word."""
    port = re.fullmatch(r"tcp://[\w.*-]+:(\*|\d{1,5})", text, re.ASCII)
    if not port or int(port[1].replace("*", "0")) > 65535:
        raise argparse.ArgumentTypeError(f"bad endpoint '{text}': write it like {ENDPOINT}, port 0 to 65535")
    # Options are read one after the other, and this one may come first.
    told = any(word.startswith(("--keys", "--open-to-anyone")) for word in sys.argv)
    if not told and not re.match(r"tcp://(localhost|127\.[\d.]+):", text):
        raise argparse.ArgumentTypeError(f"'{text}' lets anyone in: lesson 15 has keys, --open-to-anyone has none")
    return text


def main() -> None:
    # In a pipe Windows would use another encoding, and a character that it lacks would end the program.
    sys.stdout.reconfigure(encoding="utf-8", errors="replace")  # type: ignore[union-attr]
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    parser.add_argument("--endpoint", type=endpoint, default=ENDPOINT, help="port 0 takes a free one")
    parser.add_argument("--open-to-anyone", action="store_true", help="also from other machines, without keys")
    add_options(parser)
    options = parser.parse_args()
    # SIGTERM, which kill and process managers send, ends the server as Ctrl-C does; on Windows that is SIGBREAK.
    signal.signal(getattr(signal, "SIGBREAK", signal.SIGTERM), signal.default_int_handler)
    with zmq.Context() as context, context.socket(SOCKET) as socket:
        # A reply that nobody fetches is dropped at the end; waiting for its delivery could take for ever.
        # Who announces more than the largest message is disconnected before it is in memory.
        socket.linger, socket.maxmsgsize, socket.rcvtimeo = 0, LARGEST, 200
        try:
            socket.bind(options.endpoint)
        except zmq.ZMQError as error:
            cure = "try --endpoint tcp://127.0.0.1:0, which takes a free port"
            sys.exit(f"cannot listen on {options.endpoint}: {zmq.strerror(error.errno or 0)}; {cure}")
        print(f"listening on {socket.getsockopt_string(zmq.LAST_ENDPOINT)}", flush=True)
        serve(socket, options)


if __name__ == "__main__":
    with contextlib.suppress(KeyboardInterrupt):
        main()
