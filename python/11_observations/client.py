"""Lesson 11, the client in Python. In C# it is GymManager.cs, or the terminal client, which prints the same lines.

    python python/11_observations/client.py                a car collects coins, until the environment closes it
    python python/11_observations/client.py --count 3      leave after so many episodes: the environment has lost it

Bytes: records, see netmq_example/records.py and simulation/scene.py.
"""

import sys
from pathlib import Path

sys.path[:0] = map(str, Path(__file__).resolve().parents[:2])
from netmq_example.program import client_options, importing, run, show, whole

with importing("gymnasium; kit.py run 11 installs it", stopped="stopped"):
    from netmq_example.simulation.scene import SceneSimulator
    from netmq_example.simulation.simulator import EnvironmentClient
    from netmq_example.worlds.coin_car import CoinCar


def main() -> None:
    parser = client_options("Simulates a car that collects coins.", "tcp://127.0.0.1:5561", timeout=30)
    parser.add_argument("--count", type=whole, default=0, help="how many episodes; 0: until it is closed")
    options = parser.parse_args()
    show(f"asking {options.endpoint}")
    simulator = SceneSimulator("Coins", 0.1, [CoinCar("agent")])
    # It connects a DEALER socket, says hello, and answers the environment's requests.
    EnvironmentClient(options.endpoint, options.timeout, show).run(simulator, options.count)
    show(f"done: {simulator.episodes} episodes, {simulator.steps} steps")


if __name__ == "__main__":
    run(main, stopped="stopped")
