"""The gateway for browsers, and clients of it. It needs aiohttp, and for Socket.IO python-socketio."""

from typing import TYPE_CHECKING

# A module of this package is called door.
from netmq_example.doors import door as _door

if TYPE_CHECKING:
    from netmq_example.web.browser_socket import Listener, Requester, for_browsers
    from netmq_example.web.door import Door
    from netmq_example.web.requester import WebSocketRequester
    from netmq_example.web.socketio_requester import SocketIORequester

__all__ = ["Door", "Listener", "Requester", "SocketIORequester", "WebSocketRequester", "for_browsers"]

# Hidden from a type checker, to which any name would exist.
if not TYPE_CHECKING:
    ROOMS = {
        "browser_socket": "Listener Requester for_browsers",
        "door": "Door",
        "requester": "WebSocketRequester",
        "socketio_requester": "SocketIORequester",
    }
    __getattr__, __dir__ = _door(__name__, ROOMS)
