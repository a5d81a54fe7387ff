"""Lesson 10, many agents: one message for many, be they agents of one world or areas of one simulator.

    python python/10_many_agents/server.py                prints: listening on tcp://127.0.0.1:5560
    dotnet run --project csharp-console -- 10             or: python python/10_many_agents/client.py
    python python/10_many_agents/server.py --world CartPole --areas 16          and a client with the same words

Plays ten games of hunters and rabbits with each simulator that comes, and prints a line for each; or 1000 steps of all
areas.
Bytes: messages of lesson 05, see agents.py, areas.py and infos.py. Trouble: stop the simulator in a game, which takes
seconds with --real-time; start it with another number of areas.
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
    from players import balance, play

    import netmq_example.envs  # noqa: F401, it registers the vector environments.
    from netmq_example.envs.parallel_env import ZmqParallelEnv
    from netmq_example.messages import LIMIT, MessageError
except ImportError as error:
    sys.exit(f"{error}: this lesson needs gymnasium and pettingzoo; kit.py run 10 installs them")
except KeyboardInterrupt:
    # gymnasium takes a second.
    sys.exit()

ENDPOINT, SOCKET, LARGEST = "tcp://127.0.0.1:5560", zmq.ROUTER, 4 * LIMIT
PLAYS = {"CartPole": balance, "Pursuit": play}


def environment(socket: zmq.Socket[bytes], options: argparse.Namespace) -> Any:
    """Of several agents, or of several areas; either waits for a simulator."""
    if options.world == "Pursuit":
        return ZmqParallelEnv("Pursuit", socket=socket, real_time=options.real_time)
    return gymnasium.make_vec("NetMQExample/CartPole-v0", options.areas, socket=socket)


def serve(socket: zmq.Socket[bytes], options: argparse.Namespace) -> None:
    """One simulator after the other; what one of them does wrong does not end this program."""
    while True:
        try:
            with contextlib.closing(environment(socket, options)) as env:
                for line in PLAYS[options.world](env):
                    print(line, flush=True)
        except (OSError, MessageError, ValueError, LookupError) as error:
            print(f"trouble: {str(error)!a:.200}", flush=True)
            # One such line a second: many that come with a wrong hello must not fill a disk.
            time.sleep(1)


def add_options(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("--world", choices=["CartPole", "Pursuit"], default="Pursuit", help="what is played")
    parser.add_argument("--areas", type=areas, default=16, help="how many areas of CartPole")
    parser.add_argument("--real-time", action="store_true", help="hunters and rabbits run as fast as one can watch")


def areas(text: str) -> int:
    if not text.isdecimal() or not 0 < int(text) <= 1024:
        raise argparse.ArgumentTypeError(f"--areas takes 1 to 1024, not '{text}'")
    return int(text)


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
