"""ZeroMQ and nothing else, for the performance lab: a ROUTER that echoes, and an XPUB that publishes.

Bytes: one frame each way. Its first byte says what to do: 1 answers with the same bytes, 0 does nothing, 2 publishes, 3
answers with the first 200 bytes.
"""

from __future__ import annotations

from collections import Counter

import zmq


def publish(publisher: zmq.Socket[bytes], message: bytes, subscribed: Counter[bytes]) -> None:
    """Bytes 1 to 4 say to how many subscribers, whose topic ends there; bytes 5 to 8 say how many messages."""
    subscribers, count = (int.from_bytes(message[start : start + 4], "little") for start in (1, 5))
    while publisher.poll(0) or subscribed[message[:5]] < subscribers:
        # XPUB receives what subscribers ask for: a byte 1 to subscribe, or 0 to end it, and the topic.
        request = publisher.recv()
        subscribed[request[1:]] += 1 if request[0] else -1
    for _ in range(count):
        publisher.send(message)


def main() -> None:
    with zmq.Context() as context, context.socket(zmq.ROUTER) as router, context.socket(zmq.XPUB) as publisher:
        router.linger = publisher.linger = 0
        # Frames of a stream wait in the operating system and at the sender, not in this memory.
        router.rcvhwm = 16
        router.sndhwm = publisher.sndhwm = 0
        # Each subscriber that comes or goes is told, not only the first and the last.
        publisher.xpub_verboser = 1
        router.bind("tcp://127.0.0.1:*")
        publisher.bind("tcp://127.0.0.1:*")
        endpoints = [socket.getsockopt_string(zmq.LAST_ENDPOINT) for socket in (router, publisher)]
        print(f"publishing on {endpoints[1]}", flush=True)
        print(f"listening on {endpoints[0]}", flush=True)
        subscribed = Counter[bytes]()
        while True:
            client, message = router.recv_multipart(copy=False)
            first = message.buffer[0]
            if first == 1:
                router.send_multipart([client, message], copy=False)
            elif first == 3:
                router.send_multipart([client, message.bytes[:200]])
            elif first == 2:
                publish(publisher, message.bytes, subscribed)


if __name__ == "__main__":
    try:
        main()
    except KeyboardInterrupt:
        pass
