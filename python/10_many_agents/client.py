"""Lesson 10, the client in Python. In C# it is Lesson10, in csharp-console, which prints the same lines.

    python python/10_many_agents/client.py                                hunters and rabbits, until it is closed
    python python/10_many_agents/client.py --world CartPole --areas 16    sixteen poles on sixteen carts
    python python/10_many_agents/client.py --world Car --areas 16         sixteen of lesson 08's cars, each on its road
    python python/10_many_agents/client.py --count 3                      leave after so many games or episodes

Bytes: records, see netmq_example/wire/records.py.
"""

import sys
from pathlib import Path

sys.path[:0] = map(str, Path(__file__).resolve().parents[:2])
from netmq_example.asking import client_options
from netmq_example.extras import importing
from netmq_example.program import run, show, whole

with importing("gymnasium; kit.py run 10 installs it", stopped="stopped"):
    import players

    from netmq_example.scene import EnvironmentClient, Scene, SceneSimulator
    from netmq_example.worlds.cart_pole import CartPole
    from netmq_example.worlds.pursuit import Pursuit
    from netmq_example.worlds.road_car import RoadCar


def scene(world: str, count: int) -> Scene:
    """Agents of one name get numbers: agent_0, agent_1 and so on."""
    if world == "Pursuit":
        return Pursuit()
    kind = RoadCar if world == "Car" else CartPole
    return Scene(world, [kind() for _ in range(count)], dt=0.02)


def main() -> None:
    parser = client_options(
        "Simulates what an environment steps, many at once.", "tcp://127.0.0.1:5559", timeout=30, beacon=True
    )
    parser.add_argument("--world", choices=["CartPole", "Car", "Pursuit"], default="Pursuit", help="what to simulate")
    parser.add_argument("--areas", type=players.areas, default=16, help="how many copies of CartPole or Car")
    parser.add_argument("--count", type=whole, default=0, help="how many episodes to begin; 0: until it is closed")
    options = parser.parse_args()
    show(f"asking {options.endpoint}")
    simulator = SceneSimulator(scene(options.world, options.areas))
    # In a game an episode of each of its agents begins.
    count = options.count * (len(simulator.scene.agents) if options.world == "Pursuit" else 1)
    EnvironmentClient(options.endpoint, timeout=options.timeout).run(simulator, count)
    show(f"done: {simulator.episodes} episodes, {simulator.steps} steps")


if __name__ == "__main__":
    run(main, stopped="stopped")
