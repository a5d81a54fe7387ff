"""Lesson 02, the client in Python: it prints the same lines as the one in C#.

    python python/02_lazy_pirate/client.py                     ten times `add 1`, each with the balance it is answered
    python python/02_lazy_pirate/client.py --text balance      only asks

lazy_pirate.py has the retries and the bytes.
"""

import sys
from pathlib import Path

sys.path[:0] = map(str, Path(__file__).resolve().parents[:2])
from netmq_example.asking import at_least_one, client_options
from netmq_example.lazy_pirate import LazyPirate
from netmq_example.program import printable, run, whole


def main() -> None:
    about = "Adds to the server's account, and asks again until it is answered."
    parser = client_options(about, "tcp://127.0.0.1:5552", timeout=0.5, beacon=True)
    parser.add_argument("--count", type=whole, default=10, help="how many requests")
    parser.add_argument("--text", default="add 1", help="what to ask: 'add 1' or 'balance'")
    parser.add_argument("--tries", type=at_least_one, default=5, help="how often to send a request before giving up")
    options = parser.parse_args()
    print(f"asking {options.endpoint}", flush=True)
    with LazyPirate(options.endpoint, timeout=options.timeout, tries=options.tries) as pirate:
        for i in range(1, options.count + 1):
            reply = pirate.request(options.text)
            print(f"{i}: sent {options.text}, received {printable(reply)}", flush=True)
    print(f"done: {options.count} replies")


if __name__ == "__main__":
    run(main, stopped="stopped")
