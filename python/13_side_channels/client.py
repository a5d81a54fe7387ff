"""Lesson 13, the client in Python: a simulation with side channels, the C# version is SideChannelRounds.cs.

    python python/13_side_channels/client.py                       draws parameters, and records statistics
    python python/13_side_channels/client.py --trouble unknown     sends to a channel that the server has not
    python python/13_side_channels/client.py --trouble cut         sends a message without its end
    python python/13_side_channels/client.py --trouble throw       has a handler that throws

Bytes: as in server.py. To copy: client_carrier.py.
"""

import argparse
import re
import sys
from pathlib import Path
from socket import getaddrinfo

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))
import zmq
from rounds import TROUBLES, Rounds

from netmq_example.side_channel.carrier import ClientCarrier
from netmq_example.side_channel.side_channel import LARGEST_EXCHANGE

ENDPOINT = "tcp://127.0.0.1:5563"


def talk(carrier: ClientCarrier, rounds: Rounds) -> None:
    """Whoever has something to say sends it at once, and waits for no step of the other."""
    data = b""
    while not rounds.done:
        received = carrier.exchange(data, wait=0.01)
        data = rounds.exchange(received)


# From here on all clients of this kit are the same, but for their own options.


def printable(text: str) -> str:
    """What a peer sent, fit for one line of a terminal: no control characters, cut to a readable length."""
    return "".join(c if c.isprintable() else "?" for c in text[:200]) + ("…" if len(text) > 200 else "")


def endpoint(text: str) -> str:
    """libzmq itself takes port 99999 and an unknown host without a word, and waits."""
    parts = re.fullmatch(r"tcp://([\w.-]+):(\d{1,5})", text, re.ASCII)
    if not parts or not 0 < int(parts[2]) < 65536:
        raise argparse.ArgumentTypeError(f"bad endpoint '{text}': write it like {ENDPOINT}, port 1 to 65535")
    try:
        getaddrinfo(parts[1], None)
    except (OSError, UnicodeError):
        raise argparse.ArgumentTypeError(f"bad endpoint '{text}': unknown host '{parts[1]}'; check it") from None
    return text


def main() -> None:
    # In a pipe Windows would use another encoding, and a character that it lacks would end the program.
    sys.stdout.reconfigure(encoding="utf-8", errors="replace")  # type: ignore[union-attr]
    parser = argparse.ArgumentParser(description="A simulation with side channels.")
    parser.add_argument("--endpoint", type=endpoint, default=ENDPOINT, help="the server")
    parser.add_argument("--count", type=int, default=5, help="how many rounds")
    parser.add_argument("--timeout", type=float, default=5, help="seconds that the server may be silent")
    parser.add_argument("--trouble", choices=TROUBLES, default="none", help="what goes wrong, and only once")
    options = parser.parse_args()
    if options.count < 0 or not 0 < options.timeout < 86400:
        parser.error("--count takes a whole number from 0, --timeout seconds, more than 0")
    print(f"asking {options.endpoint}", flush=True)
    limit = 2 * options.timeout
    rounds = Rounds(options.count, options.trouble, limit, lambda line: print(printable(line), flush=True))
    with zmq.Context() as context:
        carrier = ClientCarrier(context, options.endpoint, options.timeout, LARGEST_EXCHANGE)
        try:
            talk(carrier, rounds)
        except TimeoutError as error:
            sys.exit(f"gave up: {error}")
        finally:
            carrier.socket.close()
    print(f"done: {options.count} rounds")


if __name__ == "__main__":
    try:
        main()
    except KeyboardInterrupt:
        sys.exit("stopped")
