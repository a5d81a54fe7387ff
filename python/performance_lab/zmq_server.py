"""ZeroMQ and nothing else, for the performance lab: a ROUTER that echoes, and an XPUB that publishes.

Bytes: one frame each way. Its first byte says what to do: 1 answers with the same bytes, 0 does nothing, 2 publishes.
"""

from __future__ import annotations

import zmq


def publish(publisher: zmq.Socket[bytes], message: bytes, subscribed: int) -> int:
    """Bytes 1 to 4 say how many messages, bytes 5 to 8 to how many subscribers: it waits until they are there."""
    count, subscribers = (int.from_bytes(message[start : start + 4], "little") for start in (1, 5))
    while publisher.poll(0) or subscribed < subscribers:
        # XPUB receives what subscribers ask for: a byte 1 to subscribe, or 0 to end it, and the topic.
        subscribed += 1 if publisher.recv()[0] else -1
    for _ in range(count):
        publisher.send(message)
    return subscribed


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
        subscribed = 0
        while True:
            client, message = router.recv_multipart(copy=False)
            first = message.buffer[0]
            if first == 1:
                router.send_multipart([client, message], copy=False)
            elif first == 2:
                subscribed = publish(publisher, message.bytes, subscribed)


if __name__ == "__main__":
    try:
        main()
    except KeyboardInterrupt:
        pass
