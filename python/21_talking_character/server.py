"""Application 21, a talking character: words arrive while they are made, and walking away cancels; by lesson 14.

    python python/21_talking_character/server.py          prints: journal talking_character.sqlite3, 0 jobs
                                                                  listening on tcp://127.0.0.1:5571
    python python/21_talking_character/client.py          or: dotnet run --project csharp-console -- 21
    python python/21_talking_character/server.py --ollama http://127.0.0.1:11434 --model llama3.2          a real model

Bytes: those of lesson 14. A prompt is a goal: its kind is talk, its count the most words, its text the prompt. The text
of each feedback is all that was said so far, and that of a result that succeeded is the whole.
Trouble on command: walk away with client.py --leave-after 5; end this server while it talks, and start it again.
"""

import argparse
import contextlib
import functools
import re
import signal
import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))
import zmq
from small_talk import seconds, small_talk

from netmq_example.jobs.jobs import Jobs, exchange
from netmq_example.jobs.journal import Journal
from netmq_example.jobs.work import KINDS, Kind
from netmq_example.talk.ollama import ollama, ollama_talk

ENDPOINT, SOCKET, LARGEST = "tcp://127.0.0.1:5571", zmq.ROUTER, 65_536


def serve(socket: zmq.Socket[bytes], options: argparse.Namespace) -> None:
    """To speak is a job: the words are its feedback, ten times a second at most, which nobody reads faster."""
    speak = functools.partial(small_talk, delay=options.delay, seed=options.seed)
    if options.ollama:
        speak = functools.partial(ollama_talk, url=options.ollama, model=options.model)
    KINDS.clear()
    KINDS["talk"] = Kind(speak, 1000)
    jobs = Jobs(options.journal, options.workers, queue=100, grace=2)
    with contextlib.closing(jobs.workers):
        while True:
            for client, news in exchange(jobs, socket):
                # This never waits: ROUTER drops what is for a client that has gone, or does not read: it asks again.
                socket.send_multipart([client, *news.frames()])


def add_options(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("--journal", type=Journal, default="talking_character.sqlite3", help="made if there is none")
    parser.add_argument("--workers", type=int, choices=range(1, 10), default=2, help="how many talk at the same time")
    parser.add_argument("--seed", type=int, default=0, help="another one says something else")
    parser.add_argument("--delay", type=seconds, default=0.05, help="seconds for each word")
    parser.add_argument("--ollama", type=ollama, metavar="URL", help="a real model, such as at http://127.0.0.1:11434")
    parser.add_argument("--model", default="llama3.2", help="for --ollama")


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
