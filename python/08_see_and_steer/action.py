"""Lesson 08, an action: what to do, and about which picture.

Bytes: a reply of kind `action`, with the values `frame`, `throttle`, `brake` and `steer`. The C# side is
DriverClient.cs.
"""

import sys
from dataclasses import dataclass
from pathlib import Path

# In its own lesson's folder; at home it lies beside this file.
sys.path.append(str(Path(__file__).resolve().parents[1] / "05_messages"))
from messages import Message, MessageError


@dataclass
class Action:
    """What to do, about which picture, and how long it took to be told. What is out of range is put back into it."""

    frame: int
    throttle: float
    brake: float
    steer: float
    milliseconds: float = 0.0

    def __post_init__(self) -> None:
        self.throttle, self.brake = min(1.0, max(0.0, self.throttle)), min(1.0, max(0.0, self.brake))
        self.steer = min(1.0, max(-1.0, self.steer))


def read_action(reply: Message, frame: int) -> Action:
    """The action in a reply; MessageError says why it is none for this picture."""
    for name in ("frame", "throttle", "brake", "steer"):
        if reply.kind != "action" or type(reply.values.get(name)) not in (int, float):
            raise MessageError("no-action", f"the reply is no action, or without a number '{name}'")
    values = reply.values
    if values["frame"] != frame:
        raise MessageError("wrong-frame", f"an action for picture {values['frame']}, but {frame} was asked about")
    return Action(frame, values["throttle"], values["brake"], values["steer"])
