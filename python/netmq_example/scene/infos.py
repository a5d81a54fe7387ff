"""Infos: what an agent or a scene says to Python between two answers. In C# it is InfoList.cs."""

from typing import Any

from netmq_example.messages import Message, MessageError
from netmq_example.wire import trees

# Bytes of infos that wait for an answer.
MOST_WAITING = 12_000


class Infos:
    """What waits for the next answer: no more than so many bytes, and those that are left out are counted."""

    def __init__(self) -> None:
        self.waiting: list[Any] = []
        self.size = 0
        self.dropped = 0

    def send(self, info: Any) -> None:
        """MessageError says what is no info: texts, numbers, true, false, lists, dicts and arrays."""
        data = trees.write(info)
        if self.size + len(data) > MOST_WAITING:
            self.dropped += 1
            return
        self.size += len(data)
        # As it is now, whatever becomes of it.
        self.waiting.append(trees.read(data))

    def take(self) -> list[Any]:
        taken = self.waiting
        if self.dropped:
            taken.append({"dropped": self.dropped})
        self.__init__()  # type: ignore[misc]
        return taken


def info_of(request: Message) -> tuple[str, Any]:
    """An info: the agent that it is for, or "" for the scene, and its value."""
    pair = trees.read(request.arrays[0].data) if len(request.arrays) == 1 else None
    if type(pair) is not list or len(pair) != 2 or not isinstance(pair[0], str):
        raise MessageError("bad-info", f"{pair!a:.40} is no name with an info")
    return pair[0], pair[1]
