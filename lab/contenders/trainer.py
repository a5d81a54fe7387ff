"""The lab's trainer, in Python: steps of CartPole, in this process and in simulators that it launches.

    python lab/contenders/trainer.py PROGRAM.dll          the terminal clients, as .NET runs them

steps own SECONDS            Gymnasium's own CartPole-v1, in this process
steps own@16 SECONDS         sixteen of them, one after the other, as SyncVectorEnv steps them
steps csharp SECONDS         lesson 09's simulator in C#; steps python the one in Python
steps csharp@16 SECONDS      lesson 10's, with 16 areas in one message
close
"""

from __future__ import annotations

import json
import sys
import time
from pathlib import Path
from typing import Any

ROOT = Path(__file__).resolve().parents[2]
sys.path.append(str(ROOT / "python"))

import gymnasium  # noqa: E402
import numpy as np  # noqa: E402

import netmq_example.envs  # noqa: E402, F401, it registers the environments.


def make(name: str) -> Any:
    """An environment, or as many at once as its name says."""
    where, _, count = name.partition("@")
    if where == "own":
        if count:
            return gymnasium.make_vec("CartPole-v1", int(count), vectorization_mode="sync")
        return gymnasium.make("CartPole-v1")
    if count:
        words = ["dotnet", sys.argv[1], "10", "--world", "CartPole", "--areas", count]
        return gymnasium.make_vec("NetMQExample/CartPole-v0", int(count), launch=words)
    python = [sys.executable, str(ROOT / "python" / "09_environment" / "client.py")]
    words = python if where == "python" else ["dotnet", sys.argv[1], "9"]
    return gymnasium.make("NetMQExample/CartPole-v0", launch=words)


def measure(env: Any, seconds: float) -> dict[str, object]:
    """Steps of every agent, seconds, and each wait in microseconds; the pole is held by a rule, so that it stays up."""
    areas, waits = getattr(env, "num_envs", 1), list[float]()
    seen, _ = env.reset(seed=1)
    start = now = time.perf_counter()
    while not waits or now < start + seconds:
        pushed = np.asarray(seen).T
        action = (pushed[2] + pushed[3] > 0).astype(np.int64)
        before = time.perf_counter()
        seen, _, terminated, truncated, _ = env.step(action)
        now = time.perf_counter()
        waits.append(round((now - before) * 1e6, 1))
        if areas == 1 and (terminated or truncated):
            seen, _ = env.reset()
    return {"messages": areas * len(waits), "seconds": now - start, "waits": waits}


def main() -> None:
    made: dict[str, Any] = {}
    for line in sys.stdin:
        words, answer = line.split(), dict[str, object]()
        if words[0] == "close":
            while made:
                made.popitem()[1].close()
        else:
            if words[1] not in made:
                made[words[1]] = make(words[1])
            answer = measure(made[words[1]], float(words[2]))
        print(json.dumps(answer), flush=True)


if __name__ == "__main__":
    main()
