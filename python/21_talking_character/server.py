"""Application 21, a talking character: words arrive while they are made, and walking away cancels; by lesson 14.

    python python/21_talking_character/server.py          prints: journal talking_character.sqlite3, 0 jobs
                                                                  listening on tcp://127.0.0.1:5571
    python python/21_talking_character/client.py          or: dotnet run --project csharp-console -- 21
    python python/21_talking_character/server.py --ollama http://127.0.0.1:11434 --model llama3.2          a real model

Bytes: those of lesson 14. A prompt is a goal: its kind is talk, its count the most words, its text the prompt. The text
of each feedback is all that was said so far, and that of a result that succeeded is the whole.
Trouble on command: walk away with client.py --leave-after 5; end this server while it talks, and start it again.
"""

import contextlib
import functools
import sys
from pathlib import Path

sys.path[:0] = map(str, Path(__file__).resolve().parents[:2])
import zmq
from small_talk import small_talk

from netmq_example import arguments
from netmq_example.asking import wrong_usage
from netmq_example.jobs.jobs import Jobs
from netmq_example.large import few_answers_wait
from netmq_example.program import listening, option, run, seconds, server_options
from netmq_example.talk.ollama import address, ollama_talk
from netmq_example.work import Kind


def main() -> None:
    parser = server_options(__doc__, "tcp://127.0.0.1:5571")
    parser.add_argument("--journal", default="talking_character.sqlite3", help="made if there is none")
    parser.add_argument("--workers", type=int, choices=range(1, 10), default=2, help="how many talk at the same time")
    parser.add_argument("--seed", type=int, default=0, help="another one says something else")
    parser.add_argument("--delay", type=seconds, default=0.05, help="seconds for each word")
    parser.add_argument("--ollama", type=lambda text: option(address, text, str), metavar="URL", help="a real model")
    parser.add_argument(
        "--model", type=lambda text: option(arguments.text, text, str), default="llama3.2", help="its name"
    )
    options = parser.parse_args()
    talk = functools.partial(small_talk, delay=options.delay, seed=options.seed)
    if options.ollama:
        talk = functools.partial(ollama_talk, url=options.ollama, model=options.model)
    with wrong_usage(parser):
        # To speak is a job: the words are its feedback, ten times a second at most, which is faster than one reads.
        jobs = Jobs(options.journal, {"talk": Kind(talk, most=1000)}, options.workers)
    with contextlib.closing(jobs), listening(zmq.ROUTER, options, prepare=few_answers_wait) as socket:
        while True:
            jobs.exchange(socket)


if __name__ == "__main__":
    run(main)
