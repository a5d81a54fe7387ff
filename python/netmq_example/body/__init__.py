"""Persons and hands in front of a webcam: a listener to their poses, recordings, and MediaPipe, which finds them."""

from typing import TYPE_CHECKING

from netmq_example.doors import door

if TYPE_CHECKING:
    from netmq_example.body.camera import watch
    from netmq_example.body.listener import BodyListener, BodyPose
    from netmq_example.body.people import SourceError, play, read, write

__all__ = ["BodyListener", "BodyPose", "SourceError", "play", "read", "watch", "write"]

# Hidden from a type checker, to which any name would exist.
if not TYPE_CHECKING:
    ROOMS = {"camera": "watch", "listener": "BodyListener BodyPose", "people": "SourceError play read write"}
    __getattr__, __dir__ = door(__name__, ROOMS)
