"""Lesson 06, a second server: worker processes, a queue for each client, and heartbeats.

    python python/06_many_in_flight/server_processes.py --processes      for work that computes: `primes 100000`
    python python/06_many_in_flight/client.py --text "primes 100000"

Bytes: as in server.py, except that a frame may have 65,536 bytes. When --queue requests of one client wait for a
worker, or 100 MB of all clients, the next is refused with `error: busy…`. It prints how many clients there are.
Trouble on command: `--queue 2`, `--processes --kill-workers 0.5`, or stop a whole client with Ctrl-Z.
Take home: this file, router.py (who is served when), workers.py (threads or processes that do the work) and server.py.
"""

import argparse
import contextlib
import math
import re
import signal
import sys
import threading

import zmq
from router import LIMIT, Router
from server import ENDPOINT, QUICK, answer, endpoint
from workers import Workers


def work(text: bytes) -> bytes:
    """What a worker does for a request; put your own here. In threads it may wait, in processes it may compute."""
    if primes := re.fullmatch(rb"primes (\d{1,6})", text):
        found = sum(all(n % d for d in range(2, math.isqrt(n) + 1)) for n in range(2, int(primes[1])))
        return str(found).encode()
    return answer(text.decode(errors="replace")).encode()


def main() -> None:
    # In a pipe Windows would use another encoding, which lacks most letters.
    sys.stdout.reconfigure(encoding="utf-8", errors="replace")  # type: ignore[union-attr]
    parser = argparse.ArgumentParser(description="Answers many clients, and many requests of each, in any order.")
    parser.add_argument("--endpoint", type=endpoint, default=ENDPOINT, help="port 0 takes a free one")
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
        socket.linger, socket.maxmsgsize = 0, LIMIT
        # A reply to a client that is gone is an error here. Without it, ROUTER drops it without a word.
        socket.router_mandatory = 1
        # Asks a silent client every 0.5 s whether it is there, and takes it for dead when 1 s brings no answer.
        # libzmq answers by itself on a thread of its own: a busy program is not a dead one.
        socket.heartbeat_ivl, socket.heartbeat_timeout = 500, 1000
        try:
            socket.bind(options.endpoint)
        except zmq.ZMQError as error:
            sys.exit(f"cannot listen on {options.endpoint}: {zmq.strerror(error.errno or 0)}")
        workers = Workers(work, options.workers, options.processes)
        if options.kill_workers:
            threading.Thread(target=workers.kill_at_random, args=(options.kill_workers,), daemon=True).start()
        # Its sockets are made before the line that invites a Ctrl-C: one that comes in the middle of making a socket
        # leaves it half known to the context, which then waits for it at the end.
        router = Router(socket, workers, work, options.queue)
        router.at_once = (QUICK,)
        print(f"listening on {socket.getsockopt_string(zmq.LAST_ENDPOINT)}", flush=True)
        router.serve()


if __name__ == "__main__":
    with contextlib.suppress(KeyboardInterrupt):
        main()
