"""ZeroMQ and nothing else, for the performance lab: a ROUTER that echoes.

Bytes: one frame each way: the same bytes, or, if the first is 3, the first 200.
"""

from __future__ import annotations

import sys

import zmq


def main() -> None:
    with zmq.Context() as context, context.socket(zmq.ROUTER) as router:
        router.linger = 0
        router.bind(sys.argv[1] if len(sys.argv) > 1 else "tcp://127.0.0.1:*")
        print(f"listening on {router.getsockopt_string(zmq.LAST_ENDPOINT)}", flush=True)
        while True:
            client, message = router.recv_multipart(copy=False)
            if message.buffer[0] == 3:
                router.send_multipart([client, message.bytes[:200]])
            else:
                router.send_multipart([client, message], copy=False)


if __name__ == "__main__":
    main()
