"""Lesson 11, the collector: what Python declares of the car that collects coins, and how it drives it by hand.

The keys are those that the car's class has marked: CoinCar.cs, or netmq_example/worlds/coin_car.py. In a project of
yours, your spaces and an agent that learns take its place.
"""

import string
from typing import Any

import gymnasium
import numpy as np
from gymnasium.spaces import Box, Dict, Discrete, Sequence, Text

PLACE = Box(0, 10, (2,), np.float32)
ACTION = Dict(push=Box(-1, 1, (2,), np.float32), boost=Discrete(2))


def seen_space(wrong: bool) -> "Dict[Any]":
    """With a mistake if it is wanted: the field is larger than 1 m."""
    return Dict(
        place=Box(0, 1, (2,), np.float32) if wrong else PLACE,
        coins=Sequence(PLACE),
        left=Discrete(4),
        says=Text(min_length=0, max_length=40, charset=string.printable),
        last=ACTION,
        camera=Box(0, 255, (48, 64, 3), np.uint8),
    )


def policy(seen: Any) -> Any:
    """By hand: straight to the nearest coin, and fast while it is far. Without coins it stays."""
    ways = [coin - seen["place"] for coin in seen["coins"]]
    way = min(ways, key=lambda way: float(way @ way), default=np.zeros(2, np.float32))
    return {"push": np.clip(2 * way, -1, 1), "boost": int(way @ way > 4)}


def play(env: gymnasium.Env[Any, Any], number: int) -> str:
    """One episode, as Gymnasium plays it everywhere."""
    seen, info = env.reset(seed=number)
    steps = 0
    total = 0.0
    infos: list[str] = []
    over = False
    while not over:
        seen, reward, terminated, truncated, info = env.step(policy(seen))
        steps += 1
        total += float(reward)
        infos += [f"{each!a:.60}".strip("'") for each in info["agent"]]
        over = terminated or truncated
    if "lost" in info:
        infos.append(info["lost"])
    return f"episode {number}: {steps} steps, return {total:.2f}: {', '.join(infos):.200}"
