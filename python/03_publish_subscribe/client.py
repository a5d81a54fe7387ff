"""Lesson 03, the listener in Python: runs TopicListener of topic_listener.py, and prints the lines of the C# twin.

    python python/03_publish_subscribe/client.py                               300 poses, one in 60 is printed
    python python/03_publish_subscribe/client.py --work 0.1 --newest           only the newest: drain what waits
    python python/03_publish_subscribe/client.py --work 0.1 --conflate         the same by libzmq's CONFLATE
    python python/03_publish_subscribe/client.py --topic news --every 1        a topic is a prefix: also newsflash/
    python python/03_publish_subscribe/client.py --topic news/ --every 1       the delimiter at its end cures that

To copy: topic_listener.py.
"""

import argparse
import re
import sys
import time
from pathlib import Path
from socket import getaddrinfo

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))
import zmq

from netmq_example.topic_listener import TopicListener

ENDPOINT = "tcp://127.0.0.1:5553"


def listen(socket: zmq.Socket[bytes], options: argparse.Namespace) -> None:
    # Both hold only for what connects after they are set. CONFLATE is a queue of one frame: of messages that have
    # several it delivers nothing. NetMQ has no such option.
    socket.rcvhwm, socket.conflate = options.hwm, options.conflate
    listener = TopicListener(socket, options.endpoint, options.topic)
    take = listener.newest if options.newest else listener.receive
    for i in range(options.count):
        message = take(options.timeout)
        if options.every and i % options.every == 0:
            print(f"received {printable(message)}", flush=True)
        time.sleep(options.work)
    print(f"done: received {options.count}")


# From here on all clients of this kit are the same, but for their own options.


def printable(text: str) -> str:
    """What a peer sent, fit for one line of a terminal: no control characters, cut to a readable length."""
    return "".join(c if c.isprintable() else "?" for c in text[:200]) + ("…" if len(text) > 200 else "")


def endpoint(text: str) -> str:
    """libzmq itself takes port 99999 and an unknown host without a word, and waits."""
    parts = re.fullmatch(r"tcp://([\w.-]+):(\d{1,5})", text, re.ASCII)
    if not parts or not 0 < int(parts[2]) < 65536:
        raise argparse.ArgumentTypeError(f"bad endpoint '{text}': write it like {ENDPOINT}, port 1 to 65535")
    try:
        getaddrinfo(parts[1], None)
    except (OSError, UnicodeError):
        raise argparse.ArgumentTypeError(f"bad endpoint '{text}': unknown host '{parts[1]}'; check it") from None
    return text


def main() -> None:
    # In a pipe Windows would use another encoding, and a character that it lacks would end the program.
    sys.stdout.reconfigure(encoding="utf-8", errors="replace")  # type: ignore[union-attr]
    parser = argparse.ArgumentParser(description="Listens to a topic.")
    parser.add_argument("--endpoint", type=endpoint, default=ENDPOINT, help="the publisher")
    parser.add_argument("--topic", default="pose/", help="how the messages begin")
    parser.add_argument("--count", type=int, default=300, help="end after so many messages")
    parser.add_argument("--every", type=int, default=60, help="print one in so many; 0: none")
    parser.add_argument("--timeout", type=float, default=5, help="seconds to wait for each message")
    parser.add_argument("--work", type=float, default=0, help="seconds that each message takes: a slow listener")
    parser.add_argument("--hwm", type=int, default=1000, help="high watermark: messages that may wait here")
    parser.add_argument("--newest", action="store_true", help="only the newest message, by draining")
    parser.add_argument("--conflate", action="store_true", help="only the newest message, by libzmq's CONFLATE")
    options = parser.parse_args()
    numbers = (options.count, options.every, options.timeout, options.work, options.hwm)
    if not all(0 <= number < 2**31 for number in numbers):
        parser.error("--count, --every, --timeout, --work and --hwm take numbers from 0 on")
    print(f"listening to '{options.topic}' from {options.endpoint}", flush=True)
    with zmq.Context() as context, context.socket(zmq.SUB) as socket:
        try:
            listen(socket, options)
        except TimeoutError as error:
            sys.exit(f"gave up: {error}")


if __name__ == "__main__":
    try:
        main()
    except KeyboardInterrupt:
        sys.exit("stopped")
