"""Lesson 17, with Ray: Ray places, restarts and counts processes; ZeroMQ steps the simulators in them.

    python python/17_many_machines/ray_train.py                    two actors, each with a simulator in Python
    python python/17_many_machines/ray_train.py --crash-on 10      the process that plays episode 10 ends there
    python python/17_many_machines/ray_train.py --launch dotnet run --project csharp-console -- 9
    python python/17_many_machines/ray_train.py --address auto     in the Ray cluster that this machine is part of

Prints what lesson 09's train.py prints, number for number: a seed belongs to its episode and not to who plays it, so
it makes no difference how many actors there are, and which of them die. Below that: by how many processes.
It needs gymnasium and ray.
"""

import argparse
import logging
import os
import signal
import sys
from pathlib import Path
from typing import Any

sys.path[:0] = map(str, Path(__file__).resolve().parents[:2])
from netmq_example.asking import at_least_one
from netmq_example.extras import importing
from netmq_example.program import run, whole

# Otherwise Ray tells its makers how it is used.
os.environ.setdefault("RAY_USAGE_STATS_ENABLED", "0")
with importing("gymnasium and ray; pip install gymnasium ray", stopped="stopped"):
    import gymnasium
    import ray

    import netmq_example.envs  # noqa: F401, WORLD is of it.
    from netmq_example.worlds.cross_entropy import STEPS, Episode, play, train

LESSONS = Path(__file__).resolve().parents[1]
WORLD = "netmq_example.envs:NetMQExample/CartPole-v0"
GENERATIONS = 50
# How often a process that ended is started again, and its episode played again.
MOST_RESTARTS = 10
# For all episodes that are under way.
WAIT_SECONDS = 300


@ray.remote(max_restarts=MOST_RESTARTS, max_task_retries=MOST_RESTARTS)
class Player:
    """A process of its own, where Ray has a place for it. Whole episodes pass through Ray; their steps do not."""

    def __init__(self, launch: list[str], crash_on: int) -> None:
        self.launch = launch
        self.crash_on = crash_on
        self.env: gymnasium.Env[Any, Any] | None = None

    def play(self, number: int, episode: Episode) -> tuple[int, int]:
        """How many steps the pole stays up, and which process knows it."""
        if number == self.crash_on and not ray.get_runtime_context().was_current_actor_reconstructed:
            os._exit(1)
        # Not before it is needed: what goes wrong is then the answer of a call, and not the end of an actor.
        if not self.env:
            self.env = gymnasium.make(WORLD, max_episode_steps=STEPS, launch=self.launch)
        try:
            return play(self.env, *episode), os.getpid()
        except ConnectionError:
            # The simulator is lost. Its process goes as well: so there is one way back for both.
            self.close()
            os._exit(1)

    def close(self) -> None:
        if self.env:
            self.env.close()


def play_all(players: list[Any], episodes: list[Episode], played_by: list[int]) -> list[int]:
    """All at once, dealt to the players in turn; what they return comes in the order of the episodes."""
    numbers = range(len(played_by), len(played_by) + len(episodes))
    asked = [players[n % len(players)].play.remote(n + 1, each) for n, each in zip(numbers, episodes, strict=True)]
    _, missing = ray.wait(asked, num_returns=len(asked), timeout=WAIT_SECONDS)
    if missing:
        raise TimeoutError(
            f"{len(missing)} episodes are not over after {WAIT_SECONDS} s: is there a place for each actor?"
        )
    returns = ray.get(asked)
    played_by += [process for _, process in returns]
    return [steps for steps, _ in returns]


def last_line(error: Exception) -> str:
    """Of what Ray says, which also has where it happened."""
    return (str(error).strip() or repr(error)).splitlines()[-1]


def main() -> None:
    parser = argparse.ArgumentParser(description="Learns to balance a pole, in processes that Ray places.")
    parser.add_argument("--actors", type=at_least_one, default=2, help="how many, 1 or more")
    parser.add_argument("--address", default="local", help="auto: this machine's Ray cluster; local: one for this run")
    parser.add_argument("--crash-on", type=whole, default=0, metavar="EPISODE", help="there the actor's process ends")
    parser.add_argument("--seed", type=whole, default=0, help="the same seed gives the same numbers")
    parser.add_argument("--launch", nargs=argparse.REMAINDER, metavar="WORD", help="a simulator and its words; last")
    options = parser.parse_args()
    launch = options.launch or [sys.executable, str(LESSONS / "09_environment" / "client.py")]
    # A place for each on this machine, whatever its cores: simulators wait more than they compute.
    here = {"num_cpus": options.actors, "include_dashboard": False} if options.address == "local" else {}
    # Ray's processes find the package there.
    path = {"env_vars": {"PYTHONPATH": str(LESSONS)}}
    players: list[Any] = []
    played_by: list[int] = []
    try:
        try:
            ray.init(options.address, log_to_driver=False, logging_level=logging.ERROR, runtime_env=path, **here)
        except Exception as error:
            # Where it cannot start, Ray raises whatever it met, such as a bare Exception.
            sys.exit(f"gave up: {last_line(error)}")
        # SIGTERM, on Windows SIGBREAK, ends the simulators as well, as Ctrl-C does.
        signal.signal(getattr(signal, "SIGBREAK", signal.SIGTERM), signal.default_int_handler)
        for _ in range(options.actors):
            players.append(Player.remote(launch, options.crash_on))  # type: ignore[attr-defined]
        train(lambda episodes: play_all(players, episodes, played_by), options.seed, GENERATIONS)
        print(f"done: {len(played_by)} episodes by {len(set(played_by))} processes of {len(players)} actors")
    except (OSError, ValueError, ray.exceptions.RayError) as error:
        sys.exit(f"gave up: {last_line(error)}")
    finally:
        if players:
            ray.wait([player.close.remote() for player in players], num_returns=len(players), timeout=15)
        ray.shutdown()


if __name__ == "__main__":
    run(main, stopped="stopped")
