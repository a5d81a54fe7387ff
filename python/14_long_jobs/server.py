"""Lesson 14, long jobs: the id outlives the connection. A goal, feedback, a result, and cancel.

    python python/14_long_jobs/server.py          prints: journal long_jobs.sqlite3, 0 jobs
                                                          listening on tcp://127.0.0.1:5564
    python python/14_long_jobs/client.py          or: dotnet run --project csharp-console -- 14

Bytes: messages of lesson 05, whose kind is the verb and whose value `job` is the client's id; DEALER and ROUTER.
    goal {kind, count, text}   cancel   status   forget                                   what a client sends
    accepted {position}   rejected {code, text}   feedback {done, total, text}   canceling   forgotten
    result {status: succeeded, canceled or aborted, done, total, text}                    what it is answered
An array carries the work that is finished so far. `seq` grows with each message about a job. After a request the server
sends news for 5 seconds, and the client asks again in time. After kill -9 the journal has all that a client heard.
Trouble on command: --crash-on N ends the server when a job is at N: start it again yourself. Or end a worker, whose
number is printed; let the queue be full with --queue 1; have a job that ignores cancel: client.py --kind deaf.
"""

import contextlib
import os
import sys
from pathlib import Path

sys.path[:0] = map(str, Path(__file__).resolve().parents[:2])
import zmq
from work import KINDS

from netmq_example.asking import at_least_one
from netmq_example.errors import Error
from netmq_example.jobs.jobs import Jobs
from netmq_example.large import few_answers_wait
from netmq_example.program import listening, run, seconds, server_options, whole


def reached(jobs: Jobs, place: int) -> set[str]:
    return {id for id, job in jobs.live.items() if job.done >= place}


def main() -> None:
    parser = server_options(__doc__, "tcp://127.0.0.1:5564")
    parser.add_argument("--journal", default="long_jobs.sqlite3", help="a file, made if there is none")
    parser.add_argument("--workers", type=at_least_one, default=2, help="how many jobs are done at the same time")
    parser.add_argument("--queue", type=at_least_one, default=100, help="how many may wait; one more is rejected")
    parser.add_argument("--grace", type=seconds, default=2, help="seconds until a job that ignores cancel is killed")
    parser.add_argument("--crash-on", type=whole, default=0, metavar="N", help="end when a job is at N")
    options = parser.parse_args()
    try:
        jobs = Jobs(options.journal, KINDS, options.workers, options.queue, options.grace)
    except (Error, ValueError) as error:
        parser.error(str(error))
    except TypeError as error:
        # One of KINDS cannot be handed to a worker.
        sys.exit(str(error))
    # After a crash, and started in the same way, it goes on.
    before = reached(jobs, options.crash_on)
    with contextlib.closing(jobs), listening(zmq.ROUTER, options, prepare=few_answers_wait) as socket:
        while True:
            jobs.exchange(socket)
            if options.crash_on and reached(jobs, options.crash_on) - before:
                os._exit(1)


if __name__ == "__main__":
    run(main)
