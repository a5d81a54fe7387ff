"""Lesson 04, the background client: frames go on while a thread of its own talks to the server.

    python python/04_background_client/server.py       prints: listening on tcp://127.0.0.1:5554
    python python/04_background_client/client.py       or: dotnet run --project csharp-console -- 4

Bytes: UTF-8 text, two frames each way: [id][text], at most 65,536 bytes each. The client makes the id, a new one for
each request and the same one for its retries. `hello` is answered with `world`, `echo TEXT` with TEXT, anything else
with a text that begins with `error:`. A retry is answered from memory: what was done once is not done again.
Trouble on command: `--slow-on N` answers the Nth message 2 seconds late. Its memory ends with the
process; lesson 02 keeps it on disk.
"""

import argparse
import contextlib
import functools
import itertools
import re
import signal
import sys
import time
import traceback

import zmq

ENDPOINT, SOCKET, LARGEST = "tcp://127.0.0.1:5554", zmq.REP, 65_536


def answer(text: str) -> str:
    """Your own answer goes here."""
    if text == "hello":
        return "world"
    return text[5:] if text.startswith("echo ") else f"error: expected hello or echo TEXT, got {text[:40]!r}"


# The last thousand answers: a retry has the same id, so it gets the same answer, and the work is not done twice.
remembered = functools.lru_cache(maxsize=1000)(lambda request_id, text: reply_to(text))


def serve(socket: zmq.Socket[bytes], options: argparse.Namespace) -> None:
    for number in itertools.count(1):
        # Whoever sends other than two frames gets the error of an empty text.
        request_id, text = frames if len(frames := receive(socket)) == 2 else (b"", b"")
        reply = remembered(request_id, text)
        if number == options.slow_on:
            time.sleep(2)
        socket.send_multipart([request_id, reply])
        if not reply.startswith(b"error:"):
            print(f"{number}: sent {reply!r:.80}", flush=True)


def add_options(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("--slow-on", type=int, default=0, metavar="N", help="answer the Nth message 2 seconds late")


# From here on all servers of this kit are the same, as far as they need it.


def reply_to(text: bytes) -> bytes:
    """A mistake in `answer` is told to both sides, and ends neither."""
    try:
        return answer(text.decode(errors="replace")).encode()
    except Exception as error:
        traceback.print_exc()
        return f"error: {error!r}".encode()


def receive(socket: zmq.Socket[bytes]) -> list[bytes]:
    """The frames of the next message. It waits in slices: on Windows Ctrl-C does not interrupt a longer wait."""
    while True:
        with contextlib.suppress(zmq.Again):
            return socket.recv_multipart()


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
