"""The names of the front door, each by its module. `netmq_example` asks here when the first of them is used, so that a
lesson's server loads none of this.
"""

from typing import TYPE_CHECKING

from netmq_example import __version__
from netmq_example.doors import door

if TYPE_CHECKING:
    from netmq_example.background_client import BackgroundClient
    from netmq_example.camera.client import Action, DriverClient
    from netmq_example.errors import Closed, Error, Lost, MessageError, Refused, Timeout
    from netmq_example.jobs.client import JobClient
    from netmq_example.jobs.jobs import Jobs
    from netmq_example.journal import Journal
    from netmq_example.lazy_pirate import LazyPirate
    from netmq_example.many_requester import ManyRequester
    from netmq_example.message_requester import MessageRequester
    from netmq_example.messages import Array, Message, message_reply
    from netmq_example.pose_stream import Pose, PosePublisher, PoseSubscriber
    from netmq_example.program import reply_to
    from netmq_example.publisher import Publisher
    from netmq_example.replies import json_answer
    from netmq_example.server import Server, serve
    from netmq_example.topic_listener import TopicListener

__all__ = [
    "Action",
    "Array",
    "BackgroundClient",
    "Closed",
    "DriverClient",
    "Error",
    "JobClient",
    "Jobs",
    "Journal",
    "LazyPirate",
    "Lost",
    "ManyRequester",
    "Message",
    "MessageError",
    "MessageRequester",
    "Pose",
    "PosePublisher",
    "PoseSubscriber",
    "Publisher",
    "Refused",
    "Server",
    "Timeout",
    "TopicListener",
    "__version__",
    "json_answer",
    "message_reply",
    "reply_to",
    "serve",
]

# Hidden from a type checker, to which any name would exist.
if not TYPE_CHECKING:
    ROOMS = {
        "background_client": "BackgroundClient",
        "camera.client": "Action DriverClient",
        "errors": "Closed Error Lost MessageError Refused Timeout",
        "jobs.client": "JobClient",
        "jobs.jobs": "Jobs",
        "journal": "Journal",
        "lazy_pirate": "LazyPirate",
        "many_requester": "ManyRequester",
        "message_requester": "MessageRequester",
        "messages": "Array Message message_reply",
        "pose_stream": "Pose PosePublisher PoseSubscriber",
        "publisher": "Publisher",
        "program": "reply_to",
        "replies": "json_answer",
        "server": "Server serve",
        "topic_listener": "TopicListener",
    }
    __getattr__, __dir__ = door("netmq_example", ROOMS)
