"""Lesson 11, observations: what an agent sees is said where it is declared.

    python python/11_observations/server.py               prints: listening on tcp://127.0.0.1:5559
    dotnet run --project csharp-console -- 11             or: python python/11_observations/client.py

A car collects coins; what it sees, its class has marked field by field. Plays ten episodes with each simulator that
comes, by hand, and prints a line for each. Bytes: records, see netmq_example/wire/records.py and trees.py.
Trouble on command: `--wrong-space` declares a space that what is seen does not fit.
"""

import sys
from pathlib import Path
from typing import Any

sys.path[:0] = map(str, Path(__file__).resolve().parents[:2])
import zmq

from netmq_example.extras import importing
from netmq_example.program import listening, run, server_options, show
from netmq_example.trouble import Trouble

with importing("gymnasium; kit.py run 11 installs it"):
    import gymnasium
    from collector import ACTION, play, seen_space

    # The first registers the environments; the second reads what agents with attributes see.
    import netmq_example.envs.gym_env
    import netmq_example.envs.sights  # noqa: F401
    from netmq_example.messages import LIMIT, MessageError

EPISODES = 10


def main() -> None:
    parser = server_options(__doc__, "tcp://127.0.0.1:5559")
    parser.add_argument("--wrong-space", action="store_true", help="declare that places lie between 0 and 1")
    options = parser.parse_args()
    spaces: dict[str, Any] = {"observation_space": seen_space(options.wrong_space), "action_space": ACTION}
    with listening(zmq.ROUTER, options, largest=4 * LIMIT) as socket:
        # One simulator after the other; what one of them does wrong does not end this program.
        trouble = Trouble(show)
        while True:
            try:
                with gymnasium.make("NetMQExample/Unity-v0", env_name="Coins", socket=socket, **spaces) as env:
                    for number in range(1, EPISODES + 1):
                        print(play(env, number), flush=True)
            except (OSError, MessageError, ValueError, LookupError) as error:
                trouble(str(error))


if __name__ == "__main__":
    run(main)
