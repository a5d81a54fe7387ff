"""Lesson 03, the listener in Python: runs PoseSubscriber of pose_subscriber.py, and prints the lines of the C# twin.

    python python/03_publish_subscribe/client.py                         follow 300 poses, and know of each one missed
    python python/03_publish_subscribe/client.py --newest --work 0.1     only the newest pose: drain what waits
    python python/03_publish_subscribe/client.py --conflate --work 0.1   the same by libzmq's CONFLATE
    python python/03_publish_subscribe/client.py --listen news           a topic is a prefix: newsflash/ comes as well
    python python/03_publish_subscribe/client.py --listen news/          the delimiter at its end cures that

Bytes: as in server.py. To take home: pose_subscriber.py.
"""

from __future__ import annotations

import argparse
import re
import sys
import time
from socket import getaddrinfo

import zmq
from pose_subscriber import PoseSubscriber, printable, reconnect, take, waits


def follow(subscriber: PoseSubscriber, options: argparse.Namespace) -> None:
    wait_for = subscriber.newest if options.newest or options.conflate else subscriber.receive
    end = time.monotonic() + options.seconds
    while subscriber.received < options.count and time.monotonic() < end:
        if wait_for(options.patience) and options.every and subscriber.received % options.every == 0:
            print(subscriber.pose, flush=True)
        if subscriber.pose and subscriber.pose.number >= options.until > 0:
            break
        time.sleep(options.work)
    print(subscriber.summary())


def listen(stream: zmq.Socket[bytes], options: argparse.Namespace) -> None:
    """Print what comes. What was sent before the publisher knew of this listener is lost, and nobody says so."""
    print(f"listening to '{options.listen}' from {options.endpoint}", flush=True)
    stream.subscribe(options.listen)
    stream.connect(options.endpoint)
    for number in range(options.count):
        for limit in waits(options.patience):
            if frames := take(stream, limit):
                break
            if not number:
                reconnect(stream, options.endpoint)
        else:
            waited = f"within {options.patience:g} s"
            raise TimeoutError(f"nothing from {options.endpoint} {waited}; is the server running, or the line slow?")
        print(f"received {printable(frames[0].decode(errors='replace'))}", flush=True)
    print(f"done: received {options.count}")


def endpoint(text: str) -> str:
    """What --endpoint takes. libzmq itself takes port 99999 and an unknown host without a word, and waits."""
    parts = re.fullmatch(r"tcp://([^\s:]+):(\d{1,5})", text)
    if not parts or not 0 < int(parts[2]) < 65536:
        raise argparse.ArgumentTypeError(f"bad endpoint '{text}': write it like tcp://127.0.0.1:5553, port 1 to 65535")
    try:
        getaddrinfo(parts[1], None)
    except (OSError, UnicodeError):
        unknown = f"bad endpoint '{text}': unknown host '{parts[1]}'; check its spelling"
        raise argparse.ArgumentTypeError(unknown) from None
    return text


def main() -> None:
    # In a pipe Windows would use another encoding, which has no sign for much of what a peer may send.
    sys.stdout.reconfigure(encoding="utf-8", errors="replace")  # type: ignore[union-attr]
    parser = argparse.ArgumentParser(description="Follows a pose, and knows of each one it missed.")
    parser.add_argument("--endpoint", type=endpoint, default="tcp://127.0.0.1:5553", help="the publisher")
    parser.add_argument("--snapshots", type=endpoint, help="where it gives them; if left out, the port 100 higher")
    parser.add_argument("--count", type=int, default=300, help="end after so many messages")
    parser.add_argument("--until", type=int, default=0, help="or at the pose of this number; 0: at none")
    parser.add_argument("--seconds", type=float, default=60.0, help="or after this time")
    parser.add_argument("--patience", type=float, default=5.0, help="seconds to wait for the publisher")
    parser.add_argument("--every", type=int, default=60, help="print one pose in so many; 0: none")
    parser.add_argument("--hwm", type=int, default=1000, help="messages that may wait here; 0: no limit")
    parser.add_argument("--work", type=float, default=0.0, help="seconds that each pose takes: a slow subscriber")
    parser.add_argument("--newest", action="store_true", help="only the newest pose, by draining")
    parser.add_argument("--conflate", action="store_true", help="only the newest pose, by libzmq's CONFLATE")
    parser.add_argument("--listen", metavar="PREFIX", help="print all messages that begin so, without snapshots")
    options = parser.parse_args()
    if not all(0 <= value < 2**31 for value in vars(options).values() if isinstance(value, int | float)):
        parser.error("--count, --until, --seconds, --patience, --every, --hwm and --work take numbers from 0 on")
    if not options.snapshots:
        host, port = options.endpoint.rsplit(":", 1)
        parser.parse_args(["--snapshots", f"{host}:{int(port) + 100}"], options)
    with zmq.Context() as context, context.socket(zmq.SUB) as stream:
        # Both hold for what is connected after they are set. CONFLATE is a queue of one frame: it delivers nothing of
        # messages that have several. NetMQ has no such option.
        stream.rcvhwm, stream.conflate, stream.linger = options.hwm, options.conflate, 0
        # What is longer is none of this lesson's.
        stream.maxmsgsize = 65536
        if options.listen is not None:
            listen(stream, options)
        else:
            print(f"following {options.endpoint}, snapshots from {options.snapshots}", flush=True)
            follow(PoseSubscriber(stream, options.endpoint, options.snapshots), options)


if __name__ == "__main__":
    try:
        main()
    except TimeoutError as error:
        sys.exit(f"gave up: {error}")
    except KeyboardInterrupt:
        sys.exit("stopped")
