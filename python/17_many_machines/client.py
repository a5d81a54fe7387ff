"""Lesson 17, the client in Python: a simulator, the C# version is FleetMember, and it prints the same lines.

    python python/17_many_machines/client.py                          a pole on a cart, until the hub sends it home
    python python/17_many_machines/client.py --find 5567              asks the hub that is heard on this UDP port
    python python/17_many_machines/client.py --keys keys              with lesson 15's keys
    python python/17_many_machines/client.py --crash-after 200        trouble: it ends in the middle of an episode
    python python/17_many_machines/client.py --delay 8                trouble: so many seconds for each step

Bytes: those of lesson 09, see environment_client.py there.
"""

import argparse
import functools
import re
import sys
from pathlib import Path
from socket import getaddrinfo

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))

try:
    from netmq_example.fleet.simulator import FleetSimulator, way_to_hub
    from netmq_example.simulation.simulator import EnvironmentClient
    from netmq_example.worlds.cart_pole import CartPole
except ImportError as error:
    sys.exit(f"{error}: this lesson needs gymnasium; kit.py run 17 installs it")
except KeyboardInterrupt:
    # gymnasium takes a second.
    sys.exit("stopped")

ENDPOINT = "tcp://127.0.0.1:5567"


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
    parser = argparse.ArgumentParser(description="Simulates what trainers step by way of the hub.")
    parser.add_argument("--endpoint", type=endpoint, default=ENDPOINT, help="the hub")
    parser.add_argument("--find", type=int, default=0, metavar="PORT", help="the hub that is heard on this UDP port")
    parser.add_argument("--keys", default="", metavar="DIR", help="server.key and this simulator's pair")
    parser.add_argument("--build", default="1", help="what the hub must expect")
    parser.add_argument("--count", type=int, default=0, help="how many episodes; 0: until it is sent home")
    parser.add_argument("--timeout", type=float, default=30, help="seconds to wait for the hub")
    parser.add_argument("--crash-after", type=int, default=0, metavar="N", help="end without a word after N steps")
    parser.add_argument("--delay", type=float, default=0, help="seconds that each step takes")
    options = parser.parse_args()
    if min(options.count, options.crash_after) < 0 or not 0 <= options.find < 65536:
        parser.error("--count and --crash-after take whole numbers from 0, --find a port")
    if not 0 < options.timeout < 86400 or not 0 <= options.delay < 86400:
        parser.error("--timeout takes seconds, more than 0, --delay from 0")
    try:
        place, keys = way_to_hub(options)
        print(f"asking {place}", flush=True)
        simulator = FleetSimulator(CartPole(), options.build, options.crash_after, options.delay)
        said = functools.partial(print, flush=True)
        client = EnvironmentClient(place, options.timeout, lambda line: said(printable(line)), keys)
        client.run(simulator, options.count)
    except ValueError as error:
        parser.error(str(error))
    except TimeoutError as error:
        sys.exit(f"gave up: {printable(str(error))}")
    print(f"done: {simulator.episodes} episodes, {simulator.steps} steps")


if __name__ == "__main__":
    try:
        main()
    except KeyboardInterrupt:
        sys.exit("stopped")
