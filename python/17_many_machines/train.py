"""Lesson 17, a trainer: lesson 10's vector environment, as it is, whose agents are in scenes on any machine.

    python python/17_many_machines/train.py --areas 2                begins when two simulators are at the hub
    python python/17_many_machines/train.py --areas 2 --each         prints the return of each episode, by its seed

It pushes each cart to where its pole falls. Each episode has a seed, and so its return is the same wherever it was
simulated, and however often it was begun anew. Your learning code replaces `play`.
"""

import argparse
import sys
from pathlib import Path
from typing import Any

sys.path[:0] = map(str, Path(__file__).resolve().parents[:2])
from netmq_example.asking import client_endpoint, positive_seconds
from netmq_example.extras import importing
from netmq_example.program import run
from netmq_example.security.requester import ClientKeys

with importing("gymnasium; kit.py run 17 installs it", stopped="stopped"):
    import gymnasium
    import numpy as np

    import netmq_example.envs  # noqa: F401, it registers the environments.
    from netmq_example.fleet.trainer import FleetSocket
    from netmq_example.messages import MessageError


def policy(seen: Any) -> Any:
    """Not the best one: its episodes end."""
    return (seen[:, 2] > 0).astype(np.int64)


def play(envs: Any, episodes: int) -> list[float]:
    """The return of each episode, by its seed: 0, 1, 2, and so on. Episodes lost with a hub begin anew."""
    areas = envs.num_envs
    nothing = np.zeros(areas, bool)
    seeds = list(range(areas))
    following = areas
    returns = dict.fromkeys(seeds, 0.0)
    seen, _ = envs.reset(seed=seeds)
    while min(seeds) < episodes:
        seen, rewards, terminated, truncated, infos = envs.step(policy(seen))
        over = terminated | truncated
        lost = infos.get("_lost", nothing)
        for area in range(areas):
            returns[seeds[area]] += rewards[area]
            if over[area] and not lost[area]:
                seeds[area] = following
                following += 1
        if over.any():
            begun, infos = envs.reset(seed=seeds, options={"reset_mask": over})
            # If the hub is lost just now, episodes that were not over are lost too.
            lost = lost | infos.get("_lost", nothing)
            seen = np.where((over | lost)[:, None], begun, seen)
            returns |= {seed: 0.0 for area, seed in enumerate(seeds) if over[area] or lost[area]}
    return [returns[seed] for seed in range(episodes)]


def main() -> None:
    parser = argparse.ArgumentParser(description="Plays episodes by way of the hub.")
    hub = "tcp://127.0.0.1:5567"
    parser.add_argument("--endpoint", type=client_endpoint(hub), default=hub, help="the hub")
    parser.add_argument("--areas", type=int, choices=range(1, 1025), default=2, metavar="N", help="how many at a time")
    parser.add_argument("--episodes", type=int, choices=range(1, 10**6), default=20, metavar="N", help="how many")
    parser.add_argument("--each", action="store_true", help="print each episode's return")
    parser.add_argument("--keys", default="", metavar="DIR", help="server.key and this trainer's pair")
    parser.add_argument(
        "--timeout", type=positive_seconds, default=60, help="seconds to wait for simulators, and for each step"
    )
    options = parser.parse_args()
    try:
        keys = ClientKeys(options.keys).apply if options.keys else None
        where: dict[str, Any] = {"wait": options.timeout, "timeout": options.timeout, "autoreset_mode": "Disabled"}
        with FleetSocket(options.endpoint, "CartPole", options.areas, prepare=keys) as fleet:
            envs = gymnasium.make_vec("NetMQExample/CartPole-v0", options.areas, fleet=fleet, **where)
            returns = play(envs, options.episodes)
            envs.close()
    except (OSError, MessageError, ValueError) as error:
        sys.exit(f"gave up: {error}")
    if options.each:
        for seed, steps in enumerate(returns):
            print(f"seed {seed}: return {steps:.0f}")
    print(f"done: {len(returns)} episodes, sum {sum(returns):.0f}", flush=True)


if __name__ == "__main__":
    run(main, stopped="stopped")
