"""Lesson 01, request-reply: one side asks, the other answers, strictly in turn.

    python python/01_request_reply/server.py       prints: listening on tcp://127.0.0.1:5551
    python python/01_request_reply/client.py       or: dotnet run --project csharp-console -- 1

Bytes: UTF-8 text, one frame each way. `Hello` is answered with `World`, anything else with a text that begins with
`error:`. Any ZeroMQ program that says Hello is answered, in whatever language it is written.
Trouble on command: `--delay 5` answers later than the client waits.
"""

import sys
import time
from pathlib import Path

sys.path[:0] = map(str, Path(__file__).resolve().parents[:2])
import zmq

from netmq_example.program import listening, receive, reply_to, run, seconds, server_options


def answer(text: str) -> str:
    """Your own answer goes here."""
    # The clients of some older tutorials send the closing zero byte of a C string along.
    return "World" if text.rstrip("\0\r\n ") == "Hello" else f"error: expected Hello, got {text[:40]!r}"


def main() -> None:
    parser = server_options(__doc__, "tcp://127.0.0.1:5551")
    parser.add_argument("--delay", type=seconds, default=0, help="seconds to wait before each reply")
    parser.add_argument("--quiet", action="store_true", help="no line per reply: it takes longer than the reply")
    options = parser.parse_args()
    with listening(zmq.REP, options) as socket:
        # REP alternates strictly: receive, send, receive, send.
        while True:
            # One frame is what a client sends. Of more than one all are answered, as an error.
            request = b" ".join(receive(socket))
            reply = reply_to(answer, request)
            # Even a sleep of 0 takes as long as the whole reply.
            if options.delay:
                time.sleep(options.delay)
            # This never waits: REP drops the reply to a client that has gone, or does not read.
            socket.send(reply)
            # The client prints an error; a flood of wrong requests must not fill this terminal.
            if not (options.quiet or reply.startswith(b"error:")):
                print(f"sent {reply!r:.80}", flush=True)


if __name__ == "__main__":
    run(main)
