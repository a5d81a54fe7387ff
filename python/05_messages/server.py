"""Lesson 05, messages: agree on the bytes, then numbers, texts and arrays go both ways.

    python python/05_messages/server.py       prints: listening on tcp://127.0.0.1:5555
    python python/05_messages/client.py       or: dotnet run --project csharp-console -- 5

Bytes: a JSON header and one frame for each array, as messages.py beside this file says. The kinds of request are
    echo     any arrays                   the same values and arrays
    frame    uint8 [height, width, 3]     `x` and `y` of the brightest pixel, counted from the top left, and the `mean`
                                          of all, to a tenth; with the value `bottom_up` the lowest row comes first
A request that cannot be answered gets a reply of kind `error`, and the server serves on.
Trouble on command: `client.py --wrong-shape`.
"""

import argparse
import contextlib
import re
import signal
import sys
import traceback
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))
import zmq

from netmq_example.messages import LIMIT, Array, Message, MessageError, read

# Above the limit of messages.py a sender is told so. Above this one libzmq takes no more of it and hangs up.
ENDPOINT, SOCKET, LARGEST = "tcp://127.0.0.1:5555", zmq.REP, 4 * LIMIT


def answer(request: Message) -> Message:
    """Your own answer goes here; MessageError says why there is none."""
    match request.kind, request.arrays:
        case "echo", arrays:
            return Message("ok", request.id, request.values, arrays)
        case "frame", [Array("uint8", (height, width, 3)) as array] if height and width:
            # Unity begins with the lowest row. To turn the rows over copies nothing: it is another view of the bytes.
            picture = array.numpy()[::-1] if request.values.get("bottom_up") is True else array.numpy()
            y, x = divmod(int(picture.sum(axis=2, dtype="uint16").argmax()), width)
            return Message("ok", request.id, {"x": x, "y": y, "mean": round(float(picture.mean()), 1)})
        case "frame", _:
            raise MessageError("bad-shape", "a frame has one array, uint8 [height, width, 3]")
    raise MessageError("unknown-kind", f"kind {request.kind!a:.40} is neither echo nor frame")


def serve(socket: zmq.Socket[bytes], options: argparse.Namespace) -> None:
    while True:
        # It waits in slices: on Windows Ctrl-C does not interrupt a longer wait.
        with contextlib.suppress(zmq.Again):
            # Without a copy: the arrays stay where ZeroMQ has received them.
            reply = reply_to(socket.recv_multipart(copy=False))
            socket.send_multipart(reply, copy=False)
            if not (options.quiet or reply[0].startswith(b'{"kind":"error"')):
                print(f"sent {reply[0]!r:.80}", flush=True)


def reply_to(frames: list[zmq.Frame]) -> list[bytes]:
    """What is wrong is told to whoever asked, and the server serves on."""
    request = Message("")
    try:
        request = read(frames)
        # What cannot be written is found out here, before a part of it is on its way.
        return answer(request).frames()
    except Exception as error:
        if not isinstance(error, MessageError):
            # A mistake in `answer`: its place is for whoever writes it.
            traceback.print_exc()
            error = MessageError("error-in-answer", repr(error))
        return Message("error", error.id or request.id, {"code": error.code, "text": error.text}).frames()


def add_options(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("--quiet", action="store_true", help="no line per reply: it takes longer than the reply")


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
