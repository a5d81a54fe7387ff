"""Lesson 09, environment: Python decides when time passes in a simulation that C# owns.

    python python/09_environment/server.py                prints: listening on tcp://127.0.0.1:5559
    dotnet run --project csharp-console -- 9              or: python python/09_environment/client.py
    python python/09_environment/server.py --world Car    and a client with --world Car

Plays ten episodes with each simulator that comes, and prints a line for each.
Bytes: records, see netmq_example/wire/records.py and spaces.py.
Trouble: stop the simulator in an episode; start a second one meanwhile.
"""

import sys
from pathlib import Path
from typing import Any

sys.path[:0] = map(str, Path(__file__).resolve().parents[:2])
import zmq

from netmq_example.extras import importing
from netmq_example.program import Socket, listening, run, server_options, show
from netmq_example.trouble import Trouble

with importing("gymnasium; pip install gymnasium, or let kit.py run 9 do it"):
    import gymnasium
    from policies import by_hand

    import netmq_example.envs.gym_env  # noqa: F401, it registers the environments.
    from netmq_example.messages import LIMIT, MessageError

EPISODES = 10


def play(env: gymnasium.Env[Any, Any], policy: Any, number: int) -> str:
    """One episode, as Gymnasium plays it everywhere. Each reset and each step is a request, and its reply."""
    seen, info = env.reset(seed=number)
    steps = 0
    total = 0.0
    over = False
    while not over:
        seen, reward, terminated, truncated, info = env.step(policy(seen))
        steps += 1
        total += float(reward)
        over = terminated or truncated
    lost = f", {info['lost']}" if "lost" in info else ""
    return f"episode {number}: {steps} steps, return {total:.1f}{lost}"


def serve(socket: Socket, world: str) -> None:
    """One simulator after the other; what one of them does wrong does not end this program."""
    trouble = Trouble(show)
    while True:
        try:
            with gymnasium.make(f"NetMQExample/{world}-v0", socket=socket) as env:
                policy = by_hand(env, world)
                for number in range(1, EPISODES + 1):
                    print(play(env, policy, number), flush=True)
        except (OSError, MessageError, ValueError, AssertionError) as error:
            trouble(str(error))


def main() -> None:
    parser = server_options(__doc__, "tcp://127.0.0.1:5559")
    parser.add_argument("--world", choices=["Car", "CartPole"], default="CartPole", help="which environment")
    options = parser.parse_args()
    with listening(zmq.ROUTER, options, largest=4 * LIMIT) as socket:
        serve(socket, options.world)


if __name__ == "__main__":
    run(main)
