"""Lesson 13 on the steps of an environment: a ball falls, Python sets its gravity, and hears how fast it lands.

    python python/13_side_channels/falling_ball.py        prints: gravity 9.81: 32 steps, landed at 6.28 m/s
                                                                  gravity 1.62: 79 steps, landed at 2.56 m/s

Both sides are in this file and exchange only lesson 09's messages. The environment starts this program once more, as
its simulator. In Unity that half is your scene.
Both need gymnasium.
"""

import argparse
import sys
from pathlib import Path
from typing import Any

sys.path[:0] = map(str, Path(__file__).resolve().parents[:2])
from netmq_example.asking import client_endpoint
from netmq_example.extras import importing
from netmq_example.mlagents_envs.side_channel.environment_parameters_channel import EnvironmentParametersChannel
from netmq_example.mlagents_envs.side_channel.side_channel_manager import SideChannelManager
from netmq_example.mlagents_envs.side_channel.stats_side_channel import StatsSideChannel
from netmq_example.mlagents_envs.unity_channels import EnvironmentParameters, StatsRecorder
from netmq_example.program import run

with importing("gymnasium; pip install gymnasium, or let kit.py run 13 do it", stopped="stopped"):
    import numpy as np
    from gymnasium.spaces import Box, Discrete

    from netmq_example.envs import UnityGymEnv, carry
    from netmq_example.scene import Agent, EnvironmentClient, Scene, SceneSimulator, SideChannelSimulator


def drop(gravity: float) -> None:
    """The training sets gravity, takes its steps, and reads the statistics that came with them."""
    parameters, stats = EnvironmentParametersChannel(), StatsSideChannel()
    env = UnityGymEnv("Ball", launch=[sys.executable, __file__])
    try:
        carry(env, SideChannelManager([parameters, stats]))
        parameters.set_float_parameter("gravity", gravity)
        env.reset(seed=1)
        steps = 0
        landed = False
        while not landed:
            _, _, landed, _, _ = env.step(0)
            steps += 1
        ((speed, _),) = stats.get_and_reset_stats()["landing"]
        print(f"gravity {gravity}: {steps} steps, landed at {speed:.2f} m/s", flush=True)
    finally:
        env.close()


class Ball(Agent):
    """The scene asks for its parameters when it needs them, and records statistics."""

    observation = Box(-100, 100, (1,))
    action = Discrete(1)

    def __init__(self, parameters: EnvironmentParameters, stats: StatsRecorder) -> None:
        super().__init__("ball")
        self.parameters = parameters
        self.stats = stats

    def on_reset(self) -> None:
        self.height = 2.0
        self.speed = 0.0

    def on_tick(self, dt: float) -> None:
        self.speed -= self.parameters.get_with_default("gravity", 9.81) * dt
        self.height += self.speed * dt

    def on_stepped(self) -> None:
        self.terminated = self.height <= 0
        if self.terminated:
            self.stats.add("landing", -self.speed)

    def observe(self) -> Any:
        return np.array([self.height], np.float32)


def simulate(endpoint: str) -> None:
    parameters, stats = EnvironmentParameters(), StatsRecorder()
    scene = Scene("Ball", [Ball(parameters, stats)], dt=0.02)
    manager = SideChannelManager([parameters, stats])
    EnvironmentClient(endpoint, timeout=20).run(SideChannelSimulator(SceneSimulator(scene), manager))


def main() -> None:
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    example = "tcp://127.0.0.1:5559"
    parser.add_argument("--endpoint", type=client_endpoint(example), help="the environment adds this to what it starts")
    options = parser.parse_args()
    if options.endpoint:
        simulate(options.endpoint)
    else:
        drop(9.81)
        drop(1.62)


if __name__ == "__main__":
    run(main, stopped="stopped")
