"""The lab's trainer, in Python: steps of simulators that it launches, and of environments in this process.

    python lab/contenders/trainer.py CONSOLE.dll LAB.dll          the terminal clients, and the lab's own program

steps own SECONDS            Gymnasium's own CartPole-v1, in this process
steps own@16 SECONDS         sixteen of them, one after the other, as SyncVectorEnv steps them
steps echo SECONDS           no environment: a DEALER in C# answers with as many bytes as a step and its answer have
steps echo@16 SECONDS        the bytes of sixteen agents in one message
steps csharp SECONDS         lesson 09's simulator in C#; steps python the one in Python
steps csharp@16 SECONDS      lesson 10's, with 16 agents in one message
steps mlagents SECONDS       lesson 09's, by ML-Agents' UnityEnvironment: an action is set, a step done, its results got
steps mlagents@16 SECONDS    lesson 10's, by the same
steps dummy@16 SECONDS       Stable-Baselines3's DummyVecEnv, in this process; steps sb3@16 its UnityVecEnv
steps player SECONDS         lesson 09's, as Unity steps it: in frames
steps player+5 SECONDS       the same, while Python thinks for 5 ms after each step
steps async@2 SECONDS        two of these, side by side; steps sync@4 four, one after the other
steps see64x48 SECONDS       an agent in C# with a picture of 64 x 48 as its observation; steps see64x48@16 sixteen
steps echo64x48 SECONDS      no environment, and as many bytes
steps coins SECONDS          lesson 11's car, with attributes and a picture; steps coins@16 sixteen of them in one scene
close
"""

from __future__ import annotations

import json
import math
import re
import subprocess
import sys
import time
from pathlib import Path
from typing import Any

ROOT = Path(__file__).resolve().parents[2]
sys.path += [str(ROOT / "python"), str(ROOT / "python" / "11_observations")]

import gymnasium  # noqa: E402
import numpy as np  # noqa: E402
import zmq  # noqa: E402
from collector import ACTION, seen_space  # noqa: E402

import netmq_example.envs  # noqa: E402, F401, it registers the environments.
from netmq_example.mlagents_envs.base_env import ActionTuple  # noqa: E402
from netmq_example.mlagents_envs.environment import UnityEnvironment  # noqa: E402
from netmq_example.wire.records import ANSWERS, ASKS, SEEN, STEP, Record, Section  # noqa: E402

CONSOLE, LAB = sys.argv[1:3]
UNITY = "NetMQExample/Unity-v0"


class Echo:
    """ZeroMQ alone, with as many bytes."""

    def __init__(self, count: int, seen: int = 16) -> None:
        self.num_envs = count
        self.context = zmq.Context()
        self.socket = self.context.socket(zmq.ROUTER)
        port = self.socket.bind_to_random_port("tcp://127.0.0.1")
        numbers = bytes(8 * count)
        answer = Record(ANSWERS, 1, [Section(0, numbers, bytes([SEEN]) * count, values=bytes(seen * count))])
        words = ["dotnet", LAB, "respond", f"tcp://127.0.0.1:{port}", str(len(answer.frame()))]
        self.program = subprocess.Popen(words, stdin=subprocess.PIPE)
        self.peer, _ = self.socket.recv_multipart()
        self.request = Record(ASKS, 1, [Section(0, numbers, bytes([STEP]) * count, values=bytes(8 * count))]).frame()
        self.seen = np.zeros((count, 4) if count > 1 else 4)

    def reset(self, seed: int | None = None) -> tuple[Any, Any]:
        return self.seen, {}

    def step(self, action: Any) -> tuple[Any, float, bool, bool, Any]:
        self.socket.send_multipart([self.peer, self.request])
        self.socket.recv_multipart()
        return self.seen, 0.0, False, False, {}

    def close(self) -> None:
        # Its standard input ends, and so does it.
        self.program.communicate()
        self.context.destroy()


def make(name: str) -> Any:
    """An environment, or as many at once as its name says."""
    where, _, count = name.partition("@")
    options: dict[str, Any]
    pole = "NetMQExample/CartPole-v0"
    # The 3 of sb3 is no size.
    size = [int(length) for length in re.findall(r"\d+", where)] if where.startswith(("echo", "see")) else []
    if where.startswith("echo"):
        return Echo(int(count or 1), 3 * math.prod(size) if size else 16)
    if size:
        options = {"env_name": "Seeing", "launch": ["dotnet", LAB, "see", *map(str, size), count or "1"]}
        return gymnasium.make_vec(UNITY, int(count), **options) if count else gymnasium.make(UNITY, **options)
    if where == "own":
        return gymnasium.make_vec("CartPole-v1", int(count), "sync") if count else gymnasium.make("CartPole-v1")
    if where in ("dummy", "sb3"):
        return LearnersEnv(where, int(count))
    if where == "mlagents":
        return MLAgentsEnv(int(count or 1))
    if where == "coins":
        options = {"env_name": "Coins", "observation_space": seen_space(False), "action_space": ACTION}
        options["launch"] = ["dotnet", CONSOLE, "11", *(["--agents", count] if count else [])]
        return gymnasium.make_vec(UNITY, int(count), **options) if count else gymnasium.make(UNITY, **options)
    player = ["dotnet", CONSOLE, "9", "--unity"]
    if where in ("async", "sync"):
        return gymnasium.make_vec(pole, int(count), where, launch=player)
    if where == "csharp" and count:
        return gymnasium.make_vec(pole, int(count), launch=many(count))
    python = [sys.executable, str(ROOT / "python" / "09_environment" / "client.py")]
    return gymnasium.make(pole, launch={"python": python, "csharp": player[:-1]}.get(where, player))


def many(count: Any) -> list[str]:
    return ["dotnet", CONSOLE, "10", "--world", "CartPole", "--areas", str(count)]


class LearnersEnv:
    """A VecEnv of Stable-Baselines3, with the words of Gymnasium."""

    def __init__(self, where: str, count: int) -> None:
        self.num_envs = count
        self.envs: Any
        if where == "sb3":
            from netmq_example.sb3 import UnityVecEnv

            self.envs = UnityVecEnv("NetMQExample/CartPole-v0", count, launch=many(count))
        else:
            from stable_baselines3.common.vec_env import DummyVecEnv

            self.envs = DummyVecEnv([lambda: gymnasium.make("CartPole-v1")] * count)

    def reset(self, seed: int | None = None) -> tuple[Any, Any]:
        self.envs.seed(seed)
        return self.envs.reset(), {}

    def step(self, actions: Any) -> tuple[Any, Any, Any, Any, Any]:
        seen, rewards, over, infos = self.envs.step(actions)
        return seen, rewards, over, over, infos

    def close(self) -> None:
        self.envs.close()


class MLAgentsEnv:
    """ML-Agents' environment, with the words of Gymnasium."""

    def __init__(self, count: int) -> None:
        self.num_envs = count
        program, *words = many(count) if count > 1 else ["dotnet", CONSOLE, "9"]
        self.env = UnityEnvironment(program, additional_args=words)
        self.name = ""

    def reset(self, seed: int | None = None) -> tuple[Any, Any]:
        self.env.reset()
        (self.name,) = self.env.behavior_specs
        return self.env.get_steps(self.name)[0].obs[0], {}

    def step(self, actions: Any) -> tuple[Any, Any, bool, bool, Any]:
        self.env.set_actions(self.name, ActionTuple(discrete=actions.reshape(-1, 1)))
        self.env.step()
        decisions, _ = self.env.get_steps(self.name)
        # An agent that ends begins anew within the step.
        return decisions.obs[0], decisions.reward, False, False, {}

    def close(self) -> None:
        self.env.close()


def policy(env: Any, seen: Any) -> Any:
    """The pole is held by a rule, so that it stays up; the car stays where it is, so that its episode does not end."""
    if isinstance(seen, dict):
        return NOTHING[len(seen["left"]) if np.ndim(seen["left"]) else 0]
    if seen.ndim > 2:
        return np.zeros(seen.shape[:-3], np.int64)[()]
    pushed = np.asarray(seen).T
    return (pushed[2] + pushed[3] > 0).astype(np.int64)


def nothing(count: int) -> Any:
    shape = (count,) if count else ()
    return {"push": np.zeros((*shape, 2), np.float32), "boost": np.zeros(shape, np.int64)[()]}


NOTHING = {count: nothing(count) for count in (0, 16)}


def measure(env: Any, seconds: float, thinking: float) -> dict[str, object]:
    """Steps of every agent, seconds, and each wait in microseconds."""
    areas, waits = getattr(env, "num_envs", 1), list[float]()
    seen, _ = env.reset(seed=1)
    start = now = time.perf_counter()
    while not waits or now < start + seconds:
        action = policy(env, seen)
        if thinking:
            time.sleep(thinking)
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
            name, _, thinking = words[1].partition("+")
            if name not in made:
                made[name] = make(name)
            answer = measure(made[name], float(words[2]), float(thinking or 0) / 1000)
        print(json.dumps(answer), flush=True)


if __name__ == "__main__":
    main()
