"""Lesson 01, request-reply: one side asks, the other answers, strictly in turn.

    python python/01_request_reply/server.py       prints: listening on tcp://127.0.0.1:5551
    python python/01_request_reply/client.py       or: dotnet run --project csharp-console -- 1

Bytes: UTF-8 text, one frame each way. `Hello` is answered with `World`, anything else with a text that begins with
`error:`. Any ZeroMQ program that says Hello is answered, in whatever language it is written.
Trouble on command: `--delay 5` answers later than the client waits.
"""

import argparse
import contextlib
import re
import signal
import sys
import time
import traceback

import zmq

ENDPOINT, SOCKET, LARGEST = "tcp://127.0.0.1:5551", zmq.REP, 65_536


def answer(text: str) -> str:
    """Your own answer goes here."""
    # The clients of some older tutorials send the closing zero byte of a C string along.
    return "World" if text.rstrip("\0\r\n ") == "Hello" else f"error: expected Hello, got {text[:40]!r}"


def serve(socket: zmq.Socket[bytes], options: argparse.Namespace) -> None:
    """REP alternates strictly: receive, send, receive, send."""
    while True:
        reply = reply_to(b" ".join(receive(socket)))
        # Even a sleep of 0 takes as long as the whole reply.
        if options.delay:
            time.sleep(options.delay)
        # This never waits: REP drops the reply to a client that has gone, or does not read.
        socket.send(reply)
        if not (options.quiet or reply.startswith(b"error:")):
            print(f"sent {reply!r:.80}", flush=True)


def add_options(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("--delay", type=seconds, default=0, help="seconds to wait before each reply")
    parser.add_argument("--quiet", action="store_true", help="no line per reply: it takes longer than the reply")


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


def seconds(text: str) -> float:
    if not 0 <= float(text) < 86_400:
        raise ValueError
    return float(text)


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
