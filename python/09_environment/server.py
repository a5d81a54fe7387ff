"""Lesson 09, environment: Python decides when time passes in a simulation that C# owns.

    python python/09_environment/server.py                prints: listening on tcp://127.0.0.1:5559
    dotnet run --project csharp-console -- 9              or: python python/09_environment/client.py
    python python/09_environment/server.py --world Car    and a client with --world Car

Plays ten episodes with each simulator that comes, and prints a line for each.
Bytes: messages of lesson 05. Trouble: stop the simulator in an episode; start a second one meanwhile.
"""

import argparse
import contextlib
import re
import signal
import sys
import time
from pathlib import Path
from typing import Any

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))
import zmq

try:
    import gymnasium
    from policies import by_hand

    import netmq_example.envs  # noqa: F401, it registers the environments.
    from netmq_example.messages import LIMIT, MessageError
except KeyboardInterrupt:
    # gymnasium takes a second.
    sys.exit()

ENDPOINT, SOCKET, LARGEST = "tcp://127.0.0.1:5559", zmq.ROUTER, 4 * LIMIT
EPISODES = 10


def play(env: gymnasium.Env[Any, Any], policy: Any, number: int) -> str:
    """One episode, as Gymnasium plays it everywhere."""
    seen, info = env.reset(seed=number)
    steps, total, over = 0, 0.0, False
    while not over:
        seen, reward, terminated, truncated, info = env.step(policy(seen))
        steps, total, over = steps + 1, total + float(reward), terminated or truncated
    return f"episode {number}: {steps} steps, return {total:.1f}" + (f", {info['lost']}" if "lost" in info else "")


def serve(socket: zmq.Socket[bytes], options: argparse.Namespace) -> None:
    """One simulator after the other; what one of them does wrong does not end this program."""
    while True:
        try:
            with gymnasium.make(f"NetMQExample/{options.world}-v0", socket=socket) as env:
                policy = by_hand(env, options.world)
                for number in range(1, EPISODES + 1):
                    print(play(env, policy, number), flush=True)
        except (OSError, MessageError, ValueError, AssertionError) as error:
            print(f"trouble: {str(error)!a:.200}", flush=True)
            # One such line a second: many that come with a wrong hello must not fill a disk.
            time.sleep(1)


def add_options(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("--world", choices=["Car", "CartPole"], default="CartPole", help="which environment")


# From here on all servers of this kit are the same, as far as they need it.


def endpoint(text: str) -> str:
    """libzmq itself would listen on port 99999 - 65536, and for everybody, without a word."""
    port = re.fullmatch(r"tcp://[\w.*-]+:(\*|\d{1,5})", text, re.ASCII)
    if not port or int(port[1].replace("*", "0")) > 65535:
        raise argparse.ArgumentTypeError(f"bad endpoint '{text}': write it like {ENDPOINT}, port 0 to 65535")
    # Options are read one after the other, and this one may come first.
    told = any(word.startswith(("--keys", "--open-to-anyone")) for word in sys.argv)
    if not told and not re.match(r"tcp://(localhost|127\.[\d.]+):", text):
        raise argparse.ArgumentTypeError(f"'{text}' lets anyone in: lesson 15 has keys, --open-to-anyone has none")
    return text


def main() -> None:
    # In a pipe Windows would use another encoding, and a character that it lacks would end the program.
    sys.stdout.reconfigure(encoding="utf-8", errors="replace")  # type: ignore[union-attr]
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    parser.add_argument("--endpoint", type=endpoint, default=ENDPOINT, help="port 0 takes a free one")
    parser.add_argument("--open-to-anyone", action="store_true", help="also from other machines, without keys")
    add_options(parser)
    options = parser.parse_args()
    # SIGTERM, which kill and process managers send, ends the server as Ctrl-C does; on Windows that is SIGBREAK.
    signal.signal(getattr(signal, "SIGBREAK", signal.SIGTERM), signal.default_int_handler)
    with zmq.Context() as context, context.socket(SOCKET) as socket:
        # A reply that nobody fetches is dropped at the end; waiting for its delivery could take for ever.
        # Who announces more than the largest message is disconnected before it is in memory.
        socket.linger, socket.maxmsgsize, socket.rcvtimeo = 0, LARGEST, 200
        try:
            socket.bind(options.endpoint)
        except zmq.ZMQError as error:
            cure = "try --endpoint tcp://127.0.0.1:0, which takes a free port"
            sys.exit(f"cannot listen on {options.endpoint}: {zmq.strerror(error.errno or 0)}; {cure}")
        print(f"listening on {socket.getsockopt_string(zmq.LAST_ENDPOINT)}", flush=True)
        serve(socket, options)


if __name__ == "__main__":
    with contextlib.suppress(KeyboardInterrupt):
        main()
