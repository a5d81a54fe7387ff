"""Long jobs that outlive a connection: a client, and what a server of one's own is made of."""

from typing import TYPE_CHECKING

from netmq_example.doors import door

if TYPE_CHECKING:
    from netmq_example.jobs.client import JobClient
    from netmq_example.jobs.jobs import Jobs
    from netmq_example.jobs.journal import Journal
    from netmq_example.jobs.work import Kind, Step, WorkError

__all__ = ["JobClient", "Jobs", "Journal", "Kind", "Step", "WorkError"]

# Hidden from a type checker, to which any name would exist.
if not TYPE_CHECKING:
    ROOMS = {
        "JobClient": "netmq_example.jobs.client",
        "Jobs": "netmq_example.jobs.jobs",
        "Journal": "netmq_example.jobs.journal",
        "Kind": "netmq_example.jobs.work",
        "Step": "netmq_example.jobs.work",
        "WorkError": "netmq_example.jobs.work",
    }
    __getattr__, __dir__ = door(__name__, ROOMS)
