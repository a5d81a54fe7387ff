"""Lesson 06, many in flight: no request waits for the reply to another, and replies come in any order.

    python python/06_many_in_flight/server.py       prints: listening on tcp://127.0.0.1:5556
    python python/06_many_in_flight/client.py       or: dotnet run --project csharp-console -- 6

Bytes: a request is two frames, [id][text], and so is its reply; text is UTF-8, and the id is the client's own: any
bytes, returned as they came. ROUTER puts a third frame in front, which says whose request it is: [client][id][text].
`echo TEXT` is answered with TEXT, `sleep 0.5` after half a second, anything else with a text that begins with `error:`.
A retry of a request at work is not done twice; a retry of an answered one is (lesson 02 has the cure).
`error: busy, try again later` refuses what is more than 64 of one client or 256 of all, and `echo` never.
Trouble on command: `sleep 60`, `--workers 1`.
"""

import argparse
import contextlib
import re
import signal
import sys
import time
import traceback
from queue import SimpleQueue
from socket import socketpair
from threading import Thread

import zmq

ENDPOINT, SOCKET, LARGEST = "tcp://127.0.0.1:5556", zmq.ROUTER, 65_536
# So many may be at work or wait for a worker, and a quarter of them may be one client's. More are refused at once: to
# leave them unread would leave everything behind them unread as well, as long as the work takes.
MOST = 256
# What begins so is answered at once: to hand it to a worker would cost more than to answer it.
QUICK = b"echo "


def answer(text: str) -> str:
    """What a worker does for a request; your own goes here. Threads wait side by side, but compute in turn."""
    if text.startswith("echo "):
        return text[5:]
    if sleep := re.fullmatch(r"sleep (\d{1,2}(?:\.\d{1,6})?)", text, re.ASCII):
        time.sleep(float(sleep[1]))
        return f"slept {sleep[1]}"
    return f"error: expected an id and 'echo TEXT' or 'sleep 0.5', got {text[:40]!r}"


def serve(socket: zmq.Socket[bytes], options: argparse.Namespace) -> None:
    """This thread alone has the socket, and never works. The workers work, and never touch the socket."""
    requests, replies = SimpleQueue[tuple[bytes, bytes, bytes]](), SimpleQueue[tuple[bytes, bytes, bytes]]()
    # A byte through this pair wakes this thread, on every system. Both ends live as long as the workers, who have both.
    bell = socketpair()

    def work() -> None:
        for client, request_id, text in iter(requests.get, None):
            replies.put((client, request_id, reply_to(text)))
            bell[1].send(b"!")

    for _ in range(options.workers):
        # Ctrl-C ends these whatever they do. A ThreadPoolExecutor would first wait for what is at work.
        Thread(target=work, daemon=True).start()
    at_work: set[tuple[bytes, bytes]] = set()
    while True:
        if bell[0].fileno() in zmq.select([socket, bell[0]], [], [], 0.2)[0]:
            # One byte is one reply.
            for client, request_id, reply in [replies.get() for _ in bell[0].recv(4096)]:
                at_work.remove((client, request_id))
                # This never waits: ROUTER drops the reply to a client that has gone, or does not read.
                socket.send_multipart([client, request_id, reply])
        with contextlib.suppress(zmq.Again):
            # Not until there are no more: the replies have their turn, too.
            for _ in range(MOST):
                client, request_id = socket.recv(zmq.NOBLOCK), socket.recv()
                text, *surplus = socket.recv_multipart() if socket.getsockopt(zmq.RCVMORE) else [b""]
                if text.startswith(QUICK) and not surplus:
                    # Frame by frame: recv_multipart and send_multipart would make an echo take twice as long here.
                    socket.send(client, zmq.SNDMORE)
                    socket.send(request_id, zmq.SNDMORE)
                    socket.send(reply_to(text))
                elif (client, request_id) not in at_work:
                    if len(at_work) < MOST and sum(peer == client for peer, _ in at_work) < MOST // 4:
                        at_work.add((client, request_id))
                        # Other frames than two are no request, and the empty text is answered with an error.
                        requests.put((client, request_id, b"" if surplus else text))
                    else:
                        socket.send_multipart([client, request_id, b"error: busy, try again later"])


def add_options(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("--workers", type=int, choices=range(1, 33), default=4, metavar="N", help="how many threads")


# From here on all servers of this kit are the same, as far as they need it.


def reply_to(text: bytes) -> bytes:
    """A mistake in `answer` is told to both sides, and ends neither."""
    try:
        return answer(text.decode(errors="replace")).encode()
    except Exception as error:
        traceback.print_exc()
        return f"error: {error!r}".encode()


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
