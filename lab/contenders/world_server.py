"""World to whatever comes, for the performance lab: one server for the clients of lessons 01, 02 and 04.

Bytes: theirs. Of more than one frame all but the last, such as an id, come back before it.
"""

from __future__ import annotations

import zmq


def main() -> None:
    with zmq.Context() as context, context.socket(zmq.REP) as socket:
        socket.linger = 0
        socket.bind("tcp://127.0.0.1:*")
        print(f"listening on {socket.getsockopt_string(zmq.LAST_ENDPOINT)}", flush=True)
        while True:
            *before, _ = socket.recv_multipart()
            socket.send_multipart([*before, b"World"])


if __name__ == "__main__":
    main()
