"""Application 21, the client in Python: it prints the same lines as the one in C#.

    python python/21_talking_character/client.py                            a line for each sentence, which grows
    python python/21_talking_character/client.py --prompt "Who are you?"
    python python/21_talking_character/client.py --leave-after 5            walks away when 5 words were said

The bytes are said in server.py.
"""

import argparse
import contextlib
import re
import sys
from pathlib import Path
from socket import getaddrinfo

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))
import zmq

from netmq_example.jobs.client import JobClient, new_id
from netmq_example.messages import MessageError
from netmq_example.talk.speech import Speech

ENDPOINT = "tcp://127.0.0.1:5571"


def listen(client: JobClient, speech: Speech, options: argparse.Namespace) -> str:
    for news in client.watch(client.goal("talk", options.count, options.prompt)):
        speech.hear(news)
        if news.kind == "feedback" and 0 < options.leave_after <= speech.words:
            client.cancel()
    return speech.outcome(news)


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
    parser = argparse.ArgumentParser(description="Talks to a character, and may walk away.")
    parser.add_argument("--endpoint", type=endpoint, default=ENDPOINT, help="the server")
    parser.add_argument("--prompt", default="Who built this bridge?", help="what you say, in at most 1000 characters")
    parser.add_argument("--count", type=int, default=200, help="how many words to listen to at most")
    parser.add_argument("--leave-after", type=int, default=0, metavar="N", help="walk away when N words were said")
    parser.add_argument("--timeout", type=float, default=1.0, help="seconds to wait for a word of the job")
    parser.add_argument("--tries", type=int, default=10, help="how often to connect anew before giving up")
    options = parser.parse_args()
    at_least = min(options.count, options.tries, len(options.prompt)) > 0 <= options.leave_after
    if not (at_least and 0 < options.timeout < 86400 and len(options.prompt) <= 1000):
        numbers = "--count and --tries take a whole number from 1, --leave-after from 0, --timeout seconds above 0"
        parser.error(f"{numbers}, --prompt 1 to 1000 characters")
    speech = Speech()
    job = options.endpoint, new_id(), options.timeout, options.tries, speech.say
    with zmq.Context() as context, contextlib.closing(JobClient(context, *job)) as client:
        print(f"asking {options.endpoint}: {printable(options.prompt)}", flush=True)
        try:
            speech.say(listen(client, speech, options))
        except (TimeoutError, MessageError) as error:
            sys.exit("\n" * bool(speech.shown) + f"gave up: {printable(str(error))}")


if __name__ == "__main__":
    try:
        main()
    except KeyboardInterrupt:
        sys.exit("stopped")
