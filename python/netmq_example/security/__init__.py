"""Keys for both sides, by CURVE: who comes in is on a list, and everything is encrypted."""

from typing import TYPE_CHECKING

from netmq_example.doors import door

if TYPE_CHECKING:
    from netmq_example.security.allow_list import AllowList
    from netmq_example.security.keys import enrol, load, make, revoke, rotate
    from netmq_example.security.requester import ClientKeys, SecureRequester

__all__ = ["AllowList", "ClientKeys", "SecureRequester", "enrol", "load", "make", "revoke", "rotate"]

# Hidden from a type checker, to which any name would exist.
if not TYPE_CHECKING:
    ROOMS = {
        "allow_list": "AllowList",
        "keys": "enrol load make revoke rotate",
        "requester": "ClientKeys SecureRequester",
    }
    __getattr__, __dir__ = door(__name__, ROOMS)
