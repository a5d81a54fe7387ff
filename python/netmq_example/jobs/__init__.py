"""Long jobs that outlive a connection: a client, and what a server of one's own is made of."""

from typing import TYPE_CHECKING

from netmq_example.doors import door

if TYPE_CHECKING:
    from netmq_example.jobs.client import JobClient
    from netmq_example.jobs.jobs import Jobs
    from netmq_example.jobs.journal import Journal
    from netmq_example.work import Kind, Step, WorkError

__all__ = ["JobClient", "Jobs", "Journal", "Kind", "Step", "WorkError"]

# Hidden from a type checker, to which any name would exist.
if not TYPE_CHECKING:
    ROOMS = {"client": "JobClient", "jobs": "Jobs", "journal": "Journal", "workers": "Kind Step WorkError"}
    __getattr__, __dir__ = door(__name__, ROOMS)
