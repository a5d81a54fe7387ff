"""Lesson 15, security: the server knows every client by its key.

    python python/15_security/server.py       prints: listening on tcp://127.0.0.1:5565
    python python/15_security/client.py       or: dotnet run --project csharp-console -- 15

It answers `Hello` with `Hello alice`, if alice's public key is in keys/allowed. A key that is not is refused, before it
can say a word, and named in one line; all that comes and goes is encrypted. Where there are no keys yet, the server
makes its own and those of one client. The other clients' come and go with keys.py, while the server runs.
Bytes: UTF-8 text, one frame each way.
Trouble on command: client.py --stranger, --plain, --server-key=KEY; and this server's own mistake: with
    --no-authenticator                  nobody says who may come in, so nobody comes in
    --no-authenticator --any-domain     everybody does who knows server.key: why the domain must be enforced
"""

import argparse
import contextlib
import functools
import re
import signal
import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))
import zmq

from netmq_example.security.allow_list import AllowList
from netmq_example.security.keys import example

ENDPOINT, SOCKET, LARGEST = "tcp://127.0.0.1:5565", zmq.REP, 65_536


def serve(socket: zmq.Socket[bytes], allowed: AllowList) -> None:
    while True:
        frame = receive_frame(socket)
        name, text = allowed.name_of(frame), frame.bytes.decode(errors="replace")
        print(f"{name or 'nobody knows who'} from {frame.get('Peer-Address')}: {text!r:.80}", flush=True)
        socket.send_string(answer(name, text) if name else "error: your key is not on the list, or not any more")


def keys_for(
    context: zmq.Context[zmq.Socket[bytes]], socket: zmq.Socket[bytes], options: argparse.Namespace
) -> AllowList:
    """Before the socket listens: whoever comes first must be asked about already."""
    try:
        if not options.keys.exists():
            example(options.keys)
            print(f"keys: made {options.keys.absolute()}, with this server's and one client's, alice", flush=True)
        allowed = AllowList(options.keys, functools.partial(print, flush=True))
    except (ValueError, OSError) as error:
        sys.exit(str(error))
    if not options.no_authenticator:
        allowed.answer(context)
    allowed.guard(socket)
    if options.any_domain:
        socket.setsockopt(zmq.ZAP_ENFORCE_DOMAIN, 0)
    return allowed


def answer(name: str, text: str) -> str:
    """Your own answer goes here. What a client may do is yours to decide; who it is, you know."""
    return f"Hello {name}" if text == "Hello" else f"error: expected Hello, got {text[:40]!r}"


def receive_frame(socket: zmq.Socket[bytes]) -> zmq.Frame:
    """The message's last frame. Unlike bytes it knows who sent it."""
    while True:
        with contextlib.suppress(zmq.Again):
            return socket.recv_multipart(copy=False)[-1]


def add_options(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("--keys", type=Path, default="keys", metavar="DIR", help="the server's pair, and allowed/")
    parser.add_argument("--no-authenticator", action="store_true", help="trouble: nobody may come in")
    parser.add_argument("--any-domain", action="store_true", help="trouble: with it, everybody may")


# From here on all servers of this kit are the same, as far as they need it.


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
    add_options(parser)
    options = parser.parse_args()
    # SIGTERM, which kill and process managers send, ends the server as Ctrl-C does; on Windows that is SIGBREAK.
    signal.signal(getattr(signal, "SIGBREAK", signal.SIGTERM), signal.default_int_handler)
    with zmq.Context() as context, context.socket(SOCKET) as socket:
        # A reply that nobody fetches is dropped at the end; waiting for its delivery could take for ever.
        # Who announces more than the largest message is disconnected before it is in memory.
        socket.linger, socket.maxmsgsize, socket.rcvtimeo = 0, LARGEST, 200
        allowed = keys_for(context, socket, options)
        try:
            socket.bind(options.endpoint)
        except zmq.ZMQError as error:
            cure = "try --endpoint tcp://127.0.0.1:0, which takes a free port"
            sys.exit(f"cannot listen on {options.endpoint}: {zmq.strerror(error.errno or 0)}; {cure}")
        print(f"listening on {socket.getsockopt_string(zmq.LAST_ENDPOINT)}", flush=True)
        serve(socket, allowed)


if __name__ == "__main__":
    with contextlib.suppress(KeyboardInterrupt):
        main()
