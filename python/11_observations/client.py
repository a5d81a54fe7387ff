"""Lesson 11, the client in Python. In C# it is GymManager.cs, or the terminal client, which prints the same lines.

    python python/11_observations/client.py                a car collects coins, until the environment closes it
    python python/11_observations/client.py --agents 3     so many cars, each by itself: agent_0, agent_1, agent_2
    python python/11_observations/client.py --count 3      leave after so many episodes: the environment has lost it

Bytes: records, see netmq_example/wire/records.py and trees.py.
"""

import sys
from pathlib import Path

sys.path[:0] = map(str, Path(__file__).resolve().parents[:2])
from netmq_example.asking import client_options
from netmq_example.extras import importing
from netmq_example.program import run, show, whole

with importing("gymnasium; kit.py run 11 installs it", stopped="stopped"):
    from netmq_example.scene import EnvironmentClient, Scene, SceneSimulator
    from netmq_example.worlds.coin_car import CoinCar


def main() -> None:
    parser = client_options("Simulates a car that collects coins.", "tcp://127.0.0.1:5559", timeout=30, beacon=True)
    parser.add_argument("--count", type=whole, default=0, help="how many episodes to begin; 0: until it is closed")
    parser.add_argument("--agents", type=whole, default=1, help="how many cars; more than one are agent_0, agent_1 …")
    options = parser.parse_args()
    if not 1 <= options.agents <= 1024:
        parser.error(f"--agents takes 1 to 1024, not {options.agents}")
    show(f"asking {options.endpoint}")
    simulator = SceneSimulator(Scene("Coins", [CoinCar() for _ in range(options.agents)], dt=0.1))
    # It connects a DEALER socket, says hello, and answers the environment's requests.
    EnvironmentClient(options.endpoint, timeout=options.timeout).run(simulator, options.count)
    show(f"done: {simulator.episodes} episodes, {simulator.steps} steps")


if __name__ == "__main__":
    run(main, stopped="stopped")
