"""Lesson 06, many in flight: nobody waits for an answer before asking again, and answers come in any order.

    python python/06_many_in_flight/server.py       prints: listening on tcp://127.0.0.1:5556
    python python/06_many_in_flight/client.py       or: dotnet run --project csharp-console -- 6

Bytes: a request is two frames, [id][text], and so is its reply; text is UTF-8, and the id is the client's own: any
bytes, returned as they came. ROUTER puts a third frame in front, which says whose request it is: [client][id][text].
No frame has more than 65,536 bytes.
`echo TEXT` is answered with TEXT, `sleep 0.5` and `primes 1000` are work, anything else gets `error: …`. More than
--queue requests of one client that wait for a worker are refused with `error: busy…`; so are all when 100 MB wait.
A retry of what waits or is at work is not done twice; one of what was answered is (lesson 02 has the cure).
Trouble on command: `sleep 3`, `--queue 2`, `--processes --kill-workers 0.5`, or stop the whole process with Ctrl-Z.
Take home: this file with router.py (who is served when) and workers.py (threads or processes that do the work).
"""

from __future__ import annotations

import argparse
import errno
import math
import re
import signal
import sys
import threading
import time

import zmq
from router import LIMIT, Router
from workers import Workers

# What begins so is answered by the router itself: handing it to a worker would cost more than this work.
AT_ONCE = (b"echo ",)


def work(text: bytes) -> bytes:
    """What a worker does for a request; put your own here. In threads it may wait, in processes it may compute."""
    if text.startswith(b"echo "):
        return text[5:]
    if sleep := re.fullmatch(rb"sleep (\d{1,2}(?:\.\d{1,6})?)", text):
        time.sleep(float(sleep[1]))
        return b"slept " + sleep[1]
    if primes := re.fullmatch(rb"primes (\d{1,6})", text):
        found = sum(all(n % d for d in range(2, math.isqrt(n) + 1)) for n in range(2, int(primes[1])))
        return str(found).encode()
    return b"error: expected an id and 'echo TEXT', 'sleep 0.5' or 'primes 1000', got %d bytes" % len(text)


def endpoint(text: str) -> str:
    """What --endpoint takes. libzmq itself would listen on port 99999 - 65536 without a word."""
    port = re.fullmatch(r"tcp://[^\s:]+:(\*|\d{1,5})", text)
    if not port or (port[1] != "*" and int(port[1]) > 65535):
        raise argparse.ArgumentTypeError(f"bad endpoint '{text}': write it like tcp://127.0.0.1:5556, port 0 to 65535")
    return text


def main() -> None:
    # In a pipe Windows would use another encoding, which lacks most letters.
    sys.stdout.reconfigure(encoding="utf-8", errors="replace")  # type: ignore[union-attr]
    parser = argparse.ArgumentParser(description="Answers many clients, and many requests of each, in any order.")
    parser.add_argument("--endpoint", type=endpoint, default="tcp://127.0.0.1:5556", help="port 0 takes a free one")
    parser.add_argument("--workers", type=int, default=4, help="how many requests are done at the same time")
    parser.add_argument("--processes", action="store_true", help="workers are processes: for work that computes")
    parser.add_argument("--queue", type=int, default=1000, help="how many requests of one client may wait")
    parser.add_argument("--kill-workers", type=float, metavar="S", help="a worker process dies every S seconds")
    options = parser.parse_args()
    if options.workers < 1 or options.queue < 1:
        parser.error("--workers and --queue take a whole number, 1 or more")
    if options.kill_workers is not None and not (options.processes and 0 < options.kill_workers < 86400):
        parser.error("--kill-workers takes seconds, and --processes: a thread cannot be killed")
    # SIGTERM, which kill and process managers send, ends the server as Ctrl-C does.
    signal.signal(signal.SIGTERM, signal.default_int_handler)
    with zmq.Context() as context, context.socket(zmq.ROUTER) as socket:
        # A reply that nobody fetches is dropped at the end; waiting for its delivery could take for ever.
        socket.linger = 0
        # A reply to a client that is gone is an error here. Without it, ROUTER drops it without a word.
        socket.router_mandatory = 1
        # libzmq hangs up on who sends a larger frame. It counts frames: a message may have any number of them.
        socket.maxmsgsize = LIMIT
        # Asks a silent client every 0.5 s whether it is there, and takes it for dead when 1 s brings no answer.
        # libzmq answers by itself on a thread of its own: a busy program is not a dead one.
        socket.heartbeat_ivl, socket.heartbeat_timeout = 500, 1000
        try:
            socket.bind(options.endpoint)
        except zmq.ZMQError as error:
            causes = {zmq.EADDRINUSE: "the port is taken", errno.EACCES: "the system reserves this port"}
            cause = causes.get(error.errno or 0, "this machine has no such address")
            where = options.endpoint
            sys.exit(f"cannot listen on {where}: {cause}; try --endpoint tcp://127.0.0.1:0, which takes a free one")
        workers = Workers(work, options.workers, options.processes)
        if options.kill_workers:
            threading.Thread(target=workers.kill_at_random, args=(options.kill_workers,), daemon=True).start()
        # Its sockets are made before the line that invites a Ctrl-C: one that comes in the middle of making a socket
        # leaves it half known to the context, which then waits for it at the end.
        router = Router(socket, workers, work, options.queue, AT_ONCE)
        print(f"listening on {socket.getsockopt_string(zmq.LAST_ENDPOINT)}", flush=True)
        router.serve()


if __name__ == "__main__":
    try:
        main()
    except KeyboardInterrupt:
        pass
