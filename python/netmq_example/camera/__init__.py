"""Pictures of a running game for a driver, and recordings of what it did. Recordings need numpy, JPEG files Pillow."""

from typing import TYPE_CHECKING

from netmq_example.doors import door

if TYPE_CHECKING:
    from netmq_example.camera.client import Action, DriverClient
    from netmq_example.camera.pictures import decode, encode
    from netmq_example.camera.recording import Recorder, Row, recorded

__all__ = ["Action", "DriverClient", "Recorder", "Row", "decode", "encode", "recorded"]

# Hidden from a type checker, to which any name would exist.
if not TYPE_CHECKING:
    ROOMS = {"client": "Action DriverClient", "pictures": "decode encode", "recording": "Recorder Row recorded"}
    __getattr__, __dir__ = door(__name__, ROOMS)
