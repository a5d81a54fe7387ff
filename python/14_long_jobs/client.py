"""Lesson 14, the client in Python: it prints the same lines as the one in C#.

    python python/14_long_jobs/client.py                          counts to 100, which takes 2 seconds
    python python/14_long_jobs/client.py --kind picture           or: --kind path
    python python/14_long_jobs/client.py --cancel-at 30           --cancel-at 100 may come too late
    python python/14_long_jobs/client.py --leave-at 30            then: --resume ID, here or in C#, or in both

A job that ignores cancel is killed: --kind deaf --count 1000 --cancel-at 1. The bytes are in server.py.
"""

import sys
from pathlib import Path

sys.path[:0] = map(str, Path(__file__).resolve().parents[:2])
from progress import Progress, share, words

from netmq_example.asking import at_least_one, client_options
from netmq_example.errors import Error
from netmq_example.jobs.client import JobClient, job_id
from netmq_example.messages import Message
from netmq_example.program import option, printable, run, whole


def follow(client: JobClient, request: Message, leave_at: int = 0, cancel_at: int = 0) -> Message | None:
    """Show what is new about the job. Its result, or None if this client leaves before."""
    progress = Progress()
    for news in client.watch(request):
        progress.show(printable(f"job {client.job:.8}: {words(news)}"), share(news))
        done = news.values["done"] if news.kind == "feedback" else 0
        if 0 < leave_at <= done:
            progress.show(f"left at {done}; come back with --resume {client.job}")
            return None
        if 0 < cancel_at <= done:
            client.cancel()
    # The last one is the result.
    return news


def main() -> None:
    parser = client_options("Has a long job done, and watches it.", "tcp://127.0.0.1:5564", timeout=1, beacon=True)
    parser.add_argument("--kind", default="count", help="what to do: count, picture, path, deaf, or one of your own")
    parser.add_argument("--text", default="", help="what else your own kind has to know")
    parser.add_argument("--count", type=at_least_one, default=100, help="how far; or the side of the picture, the path")
    parser.add_argument("--resume", type=lambda id: option(job_id, id, str), metavar="ID", help="come back to it")
    parser.add_argument("--cancel-at", type=whole, default=0, metavar="N", help="cancel the job when N is done")
    parser.add_argument("--leave-at", type=whole, default=0, metavar="N", help="leave the job alone when N is done")
    parser.add_argument("--forget", action="store_true", help="have the server forget the job after its end")
    parser.add_argument("--tries", type=at_least_one, default=5, help="how often to connect anew before giving up")
    options = parser.parse_args()
    limits = {"timeout": options.timeout, "tries": options.tries}
    with JobClient(options.endpoint, job=options.resume, **limits) as client:
        print(f"asking {options.endpoint} for job {client.job}", flush=True)
        request = client.ask("status") if options.resume else client.goal(options.kind, options.count, options.text)
        result = follow(client, request, options.leave_at, options.cancel_at)
        if options.forget and result:
            follow(client, client.ask("forget"))
    if result and result.values["status"] == "aborted":
        raise Error("the job was aborted; see above")
    if result:
        finished = bytes(result.arrays[0].data) if result.arrays else b""
        print(f"done: {printable(result.values['status'])}, {len(finished)} bytes, sum {sum(finished)}")


if __name__ == "__main__":
    run(main, stopped="stopped")
