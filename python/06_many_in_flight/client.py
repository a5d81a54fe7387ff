"""Lesson 06, the client in Python: many requests under way, printed as their replies arrive.

    python python/06_many_in_flight/client.py                   a slow request does not hold up the others
    python python/06_many_in_flight/client.py --window 1        one after the other, as in lesson 01

many_requester.py has the bytes, and the way by which a reply finds its request.
"""

import itertools
import sys
from pathlib import Path

sys.path[:0] = map(str, Path(__file__).resolve().parents[:2])
from netmq_example.asking import at_least_one, client_options
from netmq_example.errors import Error
from netmq_example.many_requester import ManyRequester
from netmq_example.program import printable, run, whole

TEXT = "sleep 0.8|echo one|sleep 0.5|echo two|sleep 0.2|echo three"


def main() -> None:
    parser = client_options("Asks without waiting for each answer.", "tcp://127.0.0.1:5556", timeout=2.5)
    parser.add_argument("--count", type=whole, default=6, help="how many requests")
    parser.add_argument("--text", default=TEXT, help="requests to repeat, with | between")
    parser.add_argument("--window", type=at_least_one, default=4, help="how many requests may be under way")
    parser.add_argument("--tries", type=at_least_one, default=3, help="how often to send a request before giving up")
    options = parser.parse_args()
    print(f"asking {options.endpoint}, {options.window} in flight", flush=True)
    texts = options.text.split("|")
    requests = itertools.islice(itertools.cycle(texts), options.count)
    failures = 0
    limits = {"window": options.window, "timeout": options.timeout, "tries": options.tries}
    with ManyRequester(options.endpoint, **limits) as requester:
        for number, reply, error in requester.request_many(requests):
            outcome = f"received {printable(reply)}"
            # A reply that begins with `error:` is one, too: that error is Refused.
            if error and not reply:
                failures += 1
                outcome = f"gave up: {error}"
            print(f"{number}: sent {printable(texts[(number - 1) % len(texts)])}, {outcome}", flush=True)
    print(f"done: {options.count - failures} replies", flush=True)
    if failures:
        raise Error(f"{failures} of {options.count} requests to {options.endpoint} have no reply; see above")


if __name__ == "__main__":
    run(main, stopped="stopped")
