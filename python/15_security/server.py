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

import sys
from functools import partial
from pathlib import Path

sys.path[:0] = map(str, Path(__file__).resolve().parents[:2])
import zmq

from netmq_example.large import receive_frames
from netmq_example.program import Context, Socket, listening, reply_to, run, server_options, show, text_of
from netmq_example.security.allow_list import AllowList, keys_for

REFUSED = b"error: your key is not on the list, or not any more"


def answer(name: str, text: str) -> str:
    """Your own answer goes here. You know the client's name, and decide what it may do."""
    return f"Hello {name}" if text == "Hello" else f"error: expected Hello, got {text[:40]!r}"


def serve(socket: Socket, allowed: AllowList) -> None:
    while True:
        # Only a frame knows who sent it, and its bytes do not.
        frame = receive_frames(socket)[-1]
        name = allowed.name_of(frame)
        text = text_of(frame.bytes)
        show(f"{name or 'nobody knows who'} from {frame.get('Peer-Address')}: {text!r:.80}")
        socket.send(reply_to(partial(answer, name), frame.bytes) if name else REFUSED)


def main() -> None:
    parser = server_options(__doc__, "tcp://127.0.0.1:5565")
    parser.add_argument("--keys", type=Path, metavar="DIR", help="the server's pair, and allowed/; default: keys")
    parser.add_argument("--no-authenticator", action="store_true", help="trouble: nobody may come in")
    parser.add_argument("--any-domain", action="store_true", help="trouble: with it, everybody may")
    options = parser.parse_args()

    def prepare(context: Context, socket: Socket) -> None:
        """Before the socket listens: libzmq must ask about the first client already."""
        # Not before it is sure that it may listen there.
        allowed = options.allowed = keys_for(options.keys or "keys", make=True)
        if not options.no_authenticator:
            allowed.answer(context)
        allowed.guard(socket)
        if options.any_domain:
            socket.setsockopt(zmq.ZAP_ENFORCE_DOMAIN, 0)

    with listening(zmq.REP, options, prepare=prepare) as socket:
        serve(socket, options.allowed)


if __name__ == "__main__":
    run(main)
