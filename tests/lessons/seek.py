"""Drives lesson 10's robots by a rule, from their pictures alone, and films all sixteen: img/10_sixteen.gif."""

import sys

sys.path.append("python")
import gymnasium
import numpy as np

import netmq_example.envs  # noqa: F401, it registers the environments.
from netmq_example.video.film_writer import open_film


def policy(pictures):
    """Turn to the right until there is red, and drive where it is in the middle."""
    red = (pictures[..., 0] > 150) & (pictures[..., 1] < 100)
    columns = red.sum(axis=1)
    middle = (columns * np.arange(64)).sum(axis=1) / np.maximum(1, columns.sum(axis=1))
    ahead = 1 + np.sign(np.round((middle - 31.5) / 8)).astype(int)
    return np.where(columns.any(axis=1), ahead, 2)


if __name__ == "__main__":
    launch = [sys.executable, "kit.py", "play", "Seeker.cs", "SeekerCopies.cs", "--add", "GymManager"]
    launch += ["--envName", "Seeker", "--dt", "0.1"]
    words = {"env_name": "Seeker", "max_episode_steps": 200, "launch": launch, "wait": 300}
    envs = gymnasium.make_vec("NetMQExample/Unity-v0", 16, **words)
    film = open_film("sixteen.gif")
    try:
        for seed in range(8):
            alike, _ = envs.reset(seed=[seed] * 16)
            assert (alike == alike[0]).all(), "a robot sees its neighbours"
        seen, _ = envs.reset(seed=1)
        found = 0
        for step in range(120):
            # Four rows of four pictures.
            wall = seen.reshape(4, 4, 48, 64, 3).swapaxes(1, 2).reshape(192, 256, 3)
            film.add(wall, step * 0.1)
            seen, rewards, terminated, truncated, infos = envs.step(policy(seen))
            found += int(terminated.sum())
        film.close(12)
        print(f"{found} balls were found")
    finally:
        envs.close()
