"""The gRPC client of the performance lab, in Python; it takes the same lines as lab/csharp/Program.cs.

echo grpc ENDPOINT SIZE SECONDS       sends and has it back, again and again
close
"""

from __future__ import annotations

import json
import sys
import time

import grpc

UNLIMITED = [("grpc.max_receive_message_length", -1), ("grpc.max_send_message_length", -1)]


def measure(channel: grpc.Channel, size: int, seconds: float) -> dict[str, object]:
    """Messages, seconds, and each wait in microseconds."""
    echo, payload = channel.unary_unary("/lab/Echo"), bytes([1]) * size
    waits: list[float] = []
    start = now = time.perf_counter()
    while not waits or now < start + seconds:
        before = now
        assert echo(payload, timeout=20) == payload
        now = time.perf_counter()
        waits.append(round((now - before) * 1e6, 1))
    return {"messages": len(waits), "seconds": now - start, "waits": waits}


def main() -> None:
    channels: dict[str, grpc.Channel] = {}
    for line in sys.stdin:
        words = line.split()
        answer: dict[str, object] = {}
        if words[0] != "close":
            target = words[2].removeprefix("tcp://")
            channel = channels.setdefault(target, grpc.insecure_channel(target, UNLIMITED))
            answer = measure(channel, int(words[3]), float(words[4]))
        print(json.dumps(answer), flush=True)


if __name__ == "__main__":
    main()
