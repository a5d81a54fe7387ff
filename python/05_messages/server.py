"""Lesson 05, messages: agree on the bytes, then numbers, texts and arrays go both ways.

    python python/05_messages/server.py       prints: listening on tcp://127.0.0.1:5555
    python python/05_messages/client.py       or: dotnet run --project csharp-console -- 5

Bytes: a JSON header and one frame for each array, as netmq_example/messages.py says. The kinds of request are
    echo     any arrays                   the same values and arrays
    frame    uint8 [height, width, 3]     `x` and `y` of the brightest pixel, counted from the top left, and the `mean`
                                          of all, to a tenth; with the value `bottom_up` the lowest row comes first
A request that cannot be answered gets a reply of kind `error`, and the server serves on.
Trouble on command: `client.py --wrong-shape`.
"""

import sys
from pathlib import Path

sys.path[:0] = map(str, Path(__file__).resolve().parents[:2])
import zmq

from netmq_example.large import few_answers_wait, receive_frames, send_frames
from netmq_example.messages import LIMIT, Array, Message, MessageError, message_reply
from netmq_example.program import listening, run, server_options


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


def main() -> None:
    parser = server_options(__doc__, "tcp://127.0.0.1:5555")
    parser.add_argument("--quiet", action="store_true", help="no line per reply: it takes longer than the reply")
    options = parser.parse_args()
    # Above LIMIT a sender is told so. Above four times as much libzmq takes no more of it and hangs up.
    with listening(zmq.REP, options, largest=4 * LIMIT, prepare=few_answers_wait) as socket:
        while True:
            # A JSON header, then the arrays. Without a copy: they stay where ZeroMQ has received them.
            header, *arrays = receive_frames(socket)
            _, reply, frames = message_reply(answer, [header, *arrays])
            send_frames(socket, frames)
            if not (options.quiet or reply.kind == "error"):
                print(f"sent {frames[0]!r:.80}", flush=True)


if __name__ == "__main__":
    run(main)
