"""Lesson 04, the background client: frames go on while a thread of its own talks to the server.

    python python/04_background_client/server.py       prints: listening on tcp://127.0.0.1:5554
    python python/04_background_client/client.py       or: dotnet run --project csharp-console -- 4

Bytes: UTF-8 text, two frames each way: [id][text], at most 65,536 bytes each. The client makes the id, a new one for
each request and the same one for its retries. `hello` is answered with `world`, `echo TEXT` with TEXT, anything else
with a text that begins with `error:`. A retry is answered from memory: what was done once is not done again.
Trouble on command: `--slow-on N` answers the Nth message 2 seconds late. Its memory ends with the process; lesson 02
keeps it on disk.
"""

import functools
import itertools
import sys
import time
from pathlib import Path

sys.path[:0] = map(str, Path(__file__).resolve().parents[:2])
import zmq

from netmq_example.program import listening, receive, reply_to, run, server_options, whole
from netmq_example.replies import id_and_text


def answer(text: str) -> str:
    """Your own answer goes here."""
    if text == "hello":
        return "world"
    return text[5:] if text.startswith("echo ") else f"error: expected hello or echo TEXT, got {text[:40]!r}"


# The last thousand answers: a retry has the same id, so it gets the same answer, and the work is not done twice.
@functools.lru_cache(maxsize=1000)
def remembered(request_id: bytes, text: bytes) -> bytes:
    return reply_to(answer, text)


def main() -> None:
    parser = server_options(__doc__, "tcp://127.0.0.1:5554")
    parser.add_argument("--slow-on", type=whole, default=0, metavar="N", help="answer the Nth message 2 seconds late")
    options = parser.parse_args()
    with listening(zmq.ROUTER, options) as socket:
        for number in itertools.count(1):
            way, request_id, text = id_and_text(receive(socket))
            reply = remembered(request_id, text) if request_id else b"error: expected two frames, [id][text]"
            if number == options.slow_on:
                time.sleep(2)
            socket.send_multipart([*way, reply])
            if not reply.startswith(b"error:"):
                print(f"{number}: sent {reply!r:.80}", flush=True)


if __name__ == "__main__":
    run(main)
