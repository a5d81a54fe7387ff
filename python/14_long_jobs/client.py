"""Lesson 14, the client in Python: it prints the same lines as the one in C#.

    python python/14_long_jobs/client.py                          counts to 100, which takes 2 seconds
    python python/14_long_jobs/client.py --kind picture           or: --kind path
    python python/14_long_jobs/client.py --cancel-at 30           --cancel-at 100 may come too late
    python python/14_long_jobs/client.py --leave-at 30            then: --resume ID, here or in C#, or in both

A deaf job is killed: --kind deaf --count 1000 --cancel-at 1. The bytes are said in server.py.
"""

import argparse
import contextlib
import functools
import re
import sys
from pathlib import Path
from socket import getaddrinfo

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))
import zmq

from netmq_example.jobs.client import JobClient, Progress, new_id, share, words
from netmq_example.messages import Message, MessageError

ENDPOINT = "tcp://127.0.0.1:5564"


def follow(client: JobClient, request: Message, options: argparse.Namespace) -> Message | None:
    """Show what is new about the job. Its result, or nothing if this client leaves before."""
    progress, name, news = Progress(), f"job {client.job:.8}", request
    for news in client.watch(request):
        progress.show(printable(f"{name}: {words(news)}"), share(news))
        done = news.values["done"] if news.kind == "feedback" else 0
        if 0 < options.leave_at <= done:
            progress.show(f"left at {done}; come back with --resume {client.job}")
            return None
        if 0 < options.cancel_at <= done:
            client.cancel()
    return news


# From here on all clients of this kit are the same, but for their own options.


def printable(text: str) -> str:
    """What a peer sent, fit for one line of a terminal: no control characters, cut to a readable length."""
    return "".join(c if c.isprintable() else "?" for c in text[:200]) + ("…" if len(text) > 200 else "")


def endpoint(text: str) -> str:
    """libzmq itself takes port 99999 and an unknown host without a word, and waits."""
    parts = re.fullmatch(r"tcp://([\w.-]+):(\d{1,5})", text, re.ASCII)
    if not parts or not 0 < int(parts[2]) < 65536:
        raise argparse.ArgumentTypeError(f"bad endpoint '{text}': write it like {ENDPOINT}, port 1 to 65535")
    try:
        getaddrinfo(parts[1], None)
    except (OSError, UnicodeError):
        raise argparse.ArgumentTypeError(f"bad endpoint '{text}': unknown host '{parts[1]}'; check it") from None
    return text


def main() -> None:
    # In a pipe Windows would use another encoding, and a character that it lacks would end the program.
    sys.stdout.reconfigure(encoding="utf-8", errors="replace")  # type: ignore[union-attr]
    parser = argparse.ArgumentParser(description="Has a long job done, watches it, and comes back to it.")
    parser.add_argument("--endpoint", type=endpoint, default=ENDPOINT, help="the server")
    parser.add_argument("--kind", default="count", help="what to do: count, picture, path, deaf, or one of your own")
    parser.add_argument("--text", default="", help="what else your own kind has to know")
    parser.add_argument("--count", type=int, default=100, help="how far to count; or the side of the picture, the path")
    parser.add_argument("--resume", default="", metavar="ID", help="come back to this job and start none")
    parser.add_argument("--cancel-at", type=int, default=0, metavar="N", help="cancel the job when N is done")
    parser.add_argument("--leave-at", type=int, default=0, metavar="N", help="leave the job alone when N is done")
    parser.add_argument("--forget", action="store_true", help="have the server forget the job after its end")
    parser.add_argument("--timeout", type=float, default=1.0, help="seconds to wait for a word of the job")
    parser.add_argument("--tries", type=int, default=10, help="how often to connect anew before giving up")
    options = parser.parse_args()
    at_least = min(options.cancel_at, options.leave_at) >= 0 and min(options.count, options.tries) >= 1
    at_most = max(options.cancel_at, options.leave_at, options.count, options.tries) < 2**31
    if not (at_least and at_most and 0 < options.timeout < 86400):
        numbers = "--cancel-at, --leave-at take a whole number from 0, --count and --tries from 1"
        parser.error(f"{numbers}, --timeout seconds, more than 0")
    if not re.fullmatch("([0-9A-Za-z][0-9A-Za-z-]{0,63})?", options.resume):
        parser.error("--resume takes the id of a job, such as the one that --leave-at prints")
    with zmq.Context() as context:
        say = functools.partial(print, flush=True)
        limits = options.timeout, options.tries, say
        with contextlib.closing(JobClient(context, options.endpoint, options.resume or new_id(), *limits)) as client:
            print(f"asking {options.endpoint} for job {client.job}", flush=True)
            request = client.ask("status") if options.resume else client.goal(options.kind, options.count, options.text)
            try:
                result = follow(client, request, options)
                if options.forget and result:
                    follow(client, client.ask("forget"), options)
            except (TimeoutError, MessageError) as error:
                sys.exit(f"gave up: {printable(str(error))}")
    if result and result.values["status"] == "aborted":
        sys.exit("gave up: the job was aborted; see above")
    if result:
        finished = bytes(result.arrays[0].data) if result.arrays else b""
        print(f"done: {printable(result.values['status'])}, {len(finished)} bytes, sum {sum(finished)}")


if __name__ == "__main__":
    try:
        main()
    except KeyboardInterrupt:
        sys.exit("stopped")
