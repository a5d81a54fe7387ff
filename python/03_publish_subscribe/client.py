"""Lesson 03, the listener in Python. It prints the same lines as the one in C#.

    python python/03_publish_subscribe/client.py                               300 poses, one in 60 is printed
    python python/03_publish_subscribe/client.py --work 0.1 --newest           only the newest: drain what waits
    python python/03_publish_subscribe/client.py --work 0.1 --conflate         the same by libzmq's CONFLATE
    python python/03_publish_subscribe/client.py --topic news --every 1        a topic is a prefix: also newsflash/
    python python/03_publish_subscribe/client.py --topic news/ --every 1       the delimiter at its end cures that

How it subscribes and receives: topic_listener.py.
"""

import sys
import time
from pathlib import Path

sys.path[:0] = map(str, Path(__file__).resolve().parents[:2])
import zmq

from netmq_example.asking import client_options
from netmq_example.program import printable, run, seconds, whole
from netmq_example.topic_listener import TopicListener


def main() -> None:
    parser = client_options("Listens to a topic.", "tcp://127.0.0.1:5553", timeout=5, beacon=True)
    parser.add_argument("--topic", default="pose/", help="how the messages begin")
    parser.add_argument("--count", type=whole, default=300, help="end after so many messages")
    parser.add_argument("--every", type=whole, default=60, help="print one in so many; 0: none")
    parser.add_argument("--work", type=seconds, default=0, help="seconds that each message takes: a slow listener")
    parser.add_argument("--hwm", type=whole, default=1000, help="high watermark: messages that may wait here")
    parser.add_argument("--newest", action="store_true", help="only the newest message, by draining")
    parser.add_argument("--conflate", action="store_true", help="only the newest message, by libzmq's CONFLATE")
    options = parser.parse_args()
    print(f"listening to '{options.topic}' from {options.endpoint}", flush=True)
    with zmq.Context() as context, context.socket(zmq.SUB) as socket:
        # Both hold only for what connects after they are set. CONFLATE is a queue of one frame: of messages that have
        # several it delivers nothing. NetMQ has no such option.
        socket.rcvhwm = options.hwm
        socket.conflate = options.conflate
        listener = TopicListener(options.endpoint, options.topic, socket=socket)
        receive = listener.newest if options.newest else listener.receive
        for i in range(options.count):
            message = receive(options.timeout)
            if options.every and i % options.every == 0:
                print(f"received {printable(message)}", flush=True)
            time.sleep(options.work)
    print(f"done: received {options.count}")


if __name__ == "__main__":
    run(main, stopped="stopped")
