"""Lesson 15, the client in Python: it prints the same lines as the one in C#.

    python python/15_security/client.py                     ten times Hello, each with the reply
    python python/15_security/client.py --stranger          with a key that nobody has enrolled
    python python/15_security/client.py --plain             without keys
    python python/15_security/client.py --server-key=KEY    for a server of another key, which is not this one

How it notices that it is refused, and the bytes: netmq_example/security/requester.py.
"""

import sys
from pathlib import Path

sys.path[:0] = map(str, Path(__file__).resolve().parents[:2])
import zmq

from netmq_example.asking import at_least_one, client_options, wrong_usage
from netmq_example.program import printable, run, whole
from netmq_example.security.requester import ClientKeys, SecureRequester


def main() -> None:
    parser = client_options(
        "Says hello to a server that knows its clients by their keys.", "tcp://127.0.0.1:5565", timeout=1.0, beacon=True
    )
    parser.add_argument("--count", type=whole, default=10, help="how many requests")
    parser.add_argument("--tries", type=at_least_one, default=3, help="how often to send a request before giving up")
    parser.add_argument("--keys", type=Path, default="keys", metavar="DIR", help="server.key and this client's pair")
    # To be given with an equals sign: a key may begin with a dash.
    parser.add_argument("--server-key", default="", metavar="KEY", help="in place of that in server.key")
    parser.add_argument("--stranger", action="store_true", help="a new key, which nobody has enrolled")
    parser.add_argument("--plain", action="store_true", help="no keys at all")
    options = parser.parse_args()
    keys = None
    if not options.plain:
        with wrong_usage(parser):
            keys = ClientKeys(options.keys, options.server_key)
        if options.stranger:
            keys.public, keys.secret = zmq.curve_keypair()
    print(f"asking {options.endpoint}", flush=True)
    with SecureRequester(options.endpoint, keys=keys, timeout=options.timeout, tries=options.tries) as requester:
        for i in range(1, options.count + 1):
            print(f"{i}: sent Hello, received {printable(requester.request('Hello'))}", flush=True)
    print(f"done: {options.count} replies")


if __name__ == "__main__":
    run(main, stopped="stopped")
