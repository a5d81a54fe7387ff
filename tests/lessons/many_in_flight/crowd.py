"""Many clients in one process, for the test of lesson 06: plain DEALER sockets that never retry.

    python tests/lessons/many_in_flight/crowd.py ENDPOINT CLIENTS REQUESTS WINDOW "sleep 0.01|echo hello"

Counts what the server sends for each request. Prints a line every 1000 replies, and what it saw as JSON at the end.
"""

from __future__ import annotations

import json
import sys
import time

import zmq


def main() -> None:
    endpoint, texts = sys.argv[1], sys.argv[5].encode().split(b"|")
    clients, requests, window = map(int, sys.argv[2:5])
    seen = {"answered": 0, "worker died": 0, "wrong": 0, "twice": 0, "missing": 0, "clients out of order": 0}
    with zmq.Context() as context:
        poller = zmq.Poller()
        asked, replies, order = {}, {}, {}
        for _ in range(clients):
            socket = context.socket(zmq.DEALER)
            socket.linger = 0
            socket.connect(endpoint)
            poller.register(socket, zmq.POLLIN)
            asked[socket], replies[socket], order[socket] = 0, [0] * requests, []
        # Silence is what ends it: long enough for a busy machine, and for one more reply than there should be.
        last = time.monotonic()
        open_requests = clients * requests
        while time.monotonic() < last + (60 if open_requests else 1):
            for socket in asked:
                while asked[socket] < requests and asked[socket] - len(order[socket]) < window:
                    number = asked[socket]
                    socket.send_multipart([b"%d" % number, texts[number % len(texts)]])
                    asked[socket] += 1
            for socket, _ in poller.poll(200):
                last = time.monotonic()
                request_id, reply = socket.recv_multipart()
                number = int(request_id)
                replies[socket][number] += 1
                order[socket].append(number)
                seen["twice"] += replies[socket][number] > 1
                open_requests -= replies[socket][number] == 1
                if reply.startswith(b"error: the worker died"):
                    seen["worker died"] += 1
                elif reply.startswith(b"error"):
                    seen["wrong"] += 1
                else:
                    seen["answered"] += 1
                if (seen["answered"] + seen["worker died"]) % 1000 == 0:
                    print(f"replies: {seen['answered'] + seen['worker died']}", flush=True)
        seen["missing"] = sum(counts.count(0) for counts in replies.values())
        seen["clients out of order"] = sum(numbers != sorted(numbers) for numbers in order.values())
        for socket in asked:
            socket.close()
    print(json.dumps(seen), flush=True)


if __name__ == "__main__":
    main()
