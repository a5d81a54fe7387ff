"""Lesson 15's allow-list in front of an echo, for the performance lab. Bytes: one frame each way."""

from __future__ import annotations

import sys
from pathlib import Path

import zmq

sys.path.append(str(Path(__file__).resolve().parents[2] / "python"))
from netmq_example.security import keys
from netmq_example.security.allow_list import AllowList

# The client has its keys from there.
FOLDER = Path(__file__).resolve().parents[2] / ".build" / "lab_keys"


def main() -> None:
    if not FOLDER.exists():
        keys.example(FOLDER)
    allowed = AllowList(FOLDER)
    with zmq.Context() as context, context.socket(zmq.ROUTER) as router:
        router.linger, router.rcvhwm = 0, 16
        allowed.answer(context)
        allowed.guard(router)
        router.bind("tcp://127.0.0.1:*")
        print(f"listening on {router.getsockopt_string(zmq.LAST_ENDPOINT)}", flush=True)
        while True:
            client, message = router.recv_multipart(copy=False)
            if allowed.name_of(message):
                router.send_multipart([client, message], copy=False)


if __name__ == "__main__":
    main()
