"""Lesson 17, a trainer."""

import sys
from pathlib import Path

sys.path += [
    str(Path(__file__).resolve().parents[1] / name) for name in ("05_messages", "09_environment", "10_many_agents")
]
import gymnasium
import vector  # noqa: F401
from fleet import FleetSocket
from players import balance

with FleetSocket(sys.argv[1], "CartPole", int(sys.argv[2])) as socket:
    envs = gymnasium.make_vec("NetMQExample/CartPole-v0", int(sys.argv[2]), socket=socket)
    import time
    t=time.time()
    for line in balance(envs):
        print(line)
    print(time.time()-t)
    envs.close()
