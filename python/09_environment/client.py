"""Lesson 09, the client in Python. In C# it is CartPoleAgent.cs, which prints the same lines.

    python python/09_environment/client.py                a pole on a cart, until the environment closes it
    python python/09_environment/client.py --world Car    lesson 08's car on its road
    python python/09_environment/client.py --count 3      leave after so many episodes: the environment has lost it

Bytes: records, see netmq_example/wire/records.py and spaces.py.
"""

import sys
from pathlib import Path

sys.path[:0] = map(str, Path(__file__).resolve().parents[:2])
from netmq_example.asking import client_options
from netmq_example.extras import importing
from netmq_example.program import run, show, whole

with importing("gymnasium; pip install gymnasium, or let kit.py run 9 do it", stopped="stopped"):
    from netmq_example.scene import EnvironmentClient, Scene, SceneSimulator
    from netmq_example.worlds.cart_pole import CartPole
    from netmq_example.worlds.road_car import RoadCar

# An agent has on_reset, on_action, on_tick, on_stepped and observe: yours can stand here.
WORLDS = {"CartPole": CartPole, "Car": RoadCar}


def main() -> None:
    parser = client_options("Simulates what an environment steps.", "tcp://127.0.0.1:5559", timeout=30, beacon=True)
    parser.add_argument("--world", choices=sorted(WORLDS), default="CartPole", help="what to simulate")
    parser.add_argument("--count", type=whole, default=0, help="how many episodes to begin; 0: until it is closed")
    options = parser.parse_args()
    show(f"asking {options.endpoint}")
    simulator = SceneSimulator(Scene(options.world, [WORLDS[options.world]()], dt=0.02))
    EnvironmentClient(options.endpoint, timeout=options.timeout).run(simulator, options.count)
    show(f"done: {simulator.episodes} episodes, {simulator.steps} steps")


if __name__ == "__main__":
    run(main, stopped="stopped")
