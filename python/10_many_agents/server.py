"""Lesson 10, many agents: one message for many, be they copies of one agent or all of a game.

    python python/10_many_agents/server.py                prints: listening on tcp://127.0.0.1:5559
    dotnet run --project csharp-console -- 10             or: python python/10_many_agents/client.py
    python python/10_many_agents/server.py --world CartPole --areas 16          and a client with the same words
    python python/10_many_agents/server.py --world Car --areas 16               whose actions are numbers to steer by

Plays ten games of hunters and rabbits with each simulator that comes, and prints a line for each; or 1000 steps of all
areas.
Bytes: records, see netmq_example/wire/records.py. Trouble: stop the simulator in a game, which takes seconds with
--real-time; start it with another number of areas.
"""

import sys
from contextlib import closing
from pathlib import Path
from typing import Any

sys.path[:0] = map(str, Path(__file__).resolve().parents[:2])
import zmq

from netmq_example.extras import importing
from netmq_example.program import listening, run, server_options, show
from netmq_example.trouble import Trouble

with importing("gymnasium and pettingzoo; kit.py run 10 installs them"):
    import gymnasium
    from players import Crowd, Game, areas

    import netmq_example.envs.vector_env  # noqa: F401, it registers the environments.
    from netmq_example.envs import UnityParallelEnv
    from netmq_example.messages import LIMIT, MessageError

GAMES = 10


def play(env: Any, player: Game | Crowd) -> None:
    """One step is one message: it has the actions of all, and its reply what they see then."""
    seen, infos = env.reset(seed=player.seed)
    while player.plays(env):
        seen, _, terminated, truncated, infos = env.step(player.actions(env, seen))
        player.count(terminated, truncated, infos)
    print(player, flush=True)


def main() -> None:
    parser = server_options(__doc__, "tcp://127.0.0.1:5559")
    parser.add_argument("--world", choices=["CartPole", "Car", "Pursuit"], default="Pursuit", help="what is played")
    parser.add_argument("--areas", type=areas, default=16, help="how many areas of CartPole or Car")
    parser.add_argument("--real-time", action="store_true", help="hunters and rabbits run as fast as one can watch")
    options = parser.parse_args()
    with listening(zmq.ROUTER, options, largest=4 * LIMIT) as socket:
        trouble = Trouble(show)
        while True:
            try:
                if options.world == "Pursuit":
                    with closing(UnityParallelEnv("Pursuit", socket=socket, real_time=options.real_time)) as env:
                        for number in range(1, GAMES + 1):
                            play(env, Game(number))
                else:
                    id = f"NetMQExample/{options.world}-v0"
                    with closing(gymnasium.make_vec(id, options.areas, socket=socket)) as envs:
                        play(envs, Crowd(options.world))
            except (OSError, MessageError, ValueError, LookupError) as error:
                trouble(str(error))


if __name__ == "__main__":
    run(main)
