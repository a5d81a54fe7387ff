"""Lesson 17, the client in Python: a simulator. In C# it is FleetMember.cs, which prints the same lines.

    python python/17_many_machines/client.py                          a pole on a cart, until the hub sends it home
    python python/17_many_machines/client.py --endpoint beacon://hub:5567        the hub with --beacon hub
    python python/17_many_machines/client.py --keys keys              with lesson 15's keys
    python python/17_many_machines/client.py --crash-after 200        trouble: it ends in the middle of an episode
    python python/17_many_machines/client.py --delay 8                trouble: so many seconds for each step

Bytes: those of lesson 09, see netmq_example/scene/simulator.py.
"""

import os
import sys
import time
from pathlib import Path

sys.path[:0] = map(str, Path(__file__).resolve().parents[:2])
from netmq_example.asking import client_options
from netmq_example.extras import importing
from netmq_example.program import run, seconds, show, whole
from netmq_example.security.requester import client_keys

with importing("gymnasium; kit.py run 17 installs it", stopped="stopped"):
    from netmq_example.fleet.simulator import FleetSimulator
    from netmq_example.scene import EnvironmentClient, Scene, SceneSimulator
    from netmq_example.wire.records import STEP, Record
    from netmq_example.worlds.cart_pole import DT, CartPole


class Mortal(FleetSimulator):
    """Trouble on command: it ends instead of one more step than `crash_after`, and takes `delay` seconds for each."""

    crash_after = 0
    delay = 0.0

    def do(self, request: Record) -> Record:
        if request.has(STEP):
            if 0 < self.crash_after <= self.steps:
                show(f"crash after {self.steps} steps, as told")
                os._exit(1)
            time.sleep(self.delay)
        return super().do(request)


def main() -> None:
    parser = client_options(
        "Simulates what trainers step by way of the hub.", "tcp://127.0.0.1:5567", timeout=30, beacon=True
    )
    parser.add_argument("--keys", type=client_keys, metavar="DIR", help="server.key and this simulator's pair")
    parser.add_argument("--build", default="1", help="what the hub must expect")
    parser.add_argument("--count", type=whole, default=0, help="how many episodes to begin; 0: until it is sent home")
    parser.add_argument("--crash-after", type=whole, default=0, metavar="N", help="end without a word after N steps")
    parser.add_argument("--delay", type=seconds, default=0, help="seconds that each step takes")
    options = parser.parse_args()
    show(f"asking {options.endpoint}")
    simulator = Mortal(SceneSimulator(Scene("CartPole", [CartPole()], DT)), build=options.build)
    simulator.crash_after, simulator.delay = options.crash_after, options.delay
    prepare = options.keys.apply if options.keys else None
    client = EnvironmentClient(options.endpoint, timeout=options.timeout, prepare=prepare)
    client.run(simulator, options.count)
    show(f"done: {simulator.episodes} episodes, {simulator.steps} steps")


if __name__ == "__main__":
    run(main, stopped="stopped")
