"""Lesson 10, the client in Python: the C# version is Lesson10, and it prints the same lines.

    python python/10_many_agents/client.py                                hunters and rabbits, until it is closed
    python python/10_many_agents/client.py --world CartPole --areas 16    sixteen poles on sixteen carts
    python python/10_many_agents/client.py --count 3                      leave after so many games

Bytes: messages of lesson 05, see agents.py, areas.py and infos.py.
"""

import argparse
import re
import sys
from pathlib import Path
from socket import getaddrinfo

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))

try:
    from netmq_example.simulation.agents import AgentSimulator
    from netmq_example.simulation.areas import AreaSimulator
    from netmq_example.simulation.simulator import EnvironmentClient
    from netmq_example.worlds.cart_pole import CartPole
    from netmq_example.worlds.pursuit import Pursuit
except ImportError as error:
    sys.exit(f"{error}: this lesson needs gymnasium; kit.py run 10 installs it")
except KeyboardInterrupt:
    # gymnasium takes a second.
    sys.exit("stopped")

ENDPOINT = "tcp://127.0.0.1:5560"


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
    parser = argparse.ArgumentParser(description="Simulates what an environment steps, many at once.")
    parser.add_argument("--endpoint", type=endpoint, default=ENDPOINT, help="the environment")
    parser.add_argument("--world", choices=["CartPole", "Pursuit"], default="Pursuit", help="what to simulate")
    parser.add_argument("--areas", type=int, default=16, help="how many areas of CartPole")
    parser.add_argument("--count", type=int, default=0, help="how many episodes; 0: until it is closed")
    parser.add_argument("--timeout", type=float, default=30, help="seconds to wait for an environment")
    options = parser.parse_args()
    if options.count < 0 or not 0 < options.timeout < 86400 or not 0 < options.areas <= 1024:
        parser.error("--count takes whole numbers from 0, --areas 1 to 1024, --timeout seconds, more than 0")
    print(f"asking {options.endpoint}", flush=True)
    areas = [CartPole() for _ in range(options.areas)]
    simulator = AgentSimulator(Pursuit()) if options.world == "Pursuit" else AreaSimulator(areas)
    client = EnvironmentClient(options.endpoint, options.timeout, lambda line: print(printable(line), flush=True))
    try:
        client.run(simulator, options.count)
    except TimeoutError as error:
        sys.exit(f"gave up: {printable(str(error))}")
    print(f"done: {simulator.episodes} episodes, {simulator.steps} steps")


if __name__ == "__main__":
    try:
        main()
    except KeyboardInterrupt:
        sys.exit("stopped")
