"""Unity talks to Python over ZeroMQ. These are the names that stay; other modules may change between versions.

    from netmq_example import BackgroundClient, serve

A name is loaded when it is first used. All of them need pyzmq alone; `Array.numpy` and `Array.of` need numpy. Others
are in packages of their own: netmq_example.envs, .sb3, .video, .camera, .security and .program. A copy of a lesson has
fewer names; `kit.py copy netmq_example FOLDER` brings all.
"""

import importlib.util
import sys
from typing import TYPE_CHECKING

if sys.version_info < (3, 11):
    sys.exit(
        "netmq_example needs Python 3.11 or later, this is %d.%d: get one from https://www.python.org,"
        " and then open a new terminal" % sys.version_info[:2]
    )

__version__ = "0.4.0"

if TYPE_CHECKING:
    from netmq_example.front_door import *  # noqa: F403, a type checker has all of them.
    from netmq_example.front_door import __all__ as __all__
else:

    def __getattr__(name):
        if importlib.util.find_spec(f"netmq_example.{name}"):
            # It is a module: `from netmq_example import check` asks here before it imports one.
            raise AttributeError(f"netmq_example.{name} is a module, which must be imported")
        return getattr(importlib.import_module("netmq_example.front_door"), name)

    def __dir__():
        return sorted({*globals(), *__getattr__("__all__")})
