"""For what has a socket or a thread: it belongs to the process that made it, and there is no second one of it.

class Asker(OneProcess):
    @one_at_a_time                      RuntimeError beside another one, on this thread or another
    def ask(self):
        self.check_process()            RuntimeError after a fork, where libzmq would wait for ever
"""

import functools
import inspect
import os
import threading
from collections.abc import Callable
from typing import Any, NoReturn, Protocol, Self, TypeVar, cast

Method = TypeVar("Method", bound=Callable[..., Any])


class Keys(Protocol):
    """ClientKeys of netmq_example.security: they prove to a server who asks."""

    def apply(self, socket: Any) -> None: ...


class OneProcess:
    """With `close()` it is a context manager, too; and what has an `endpoint`, or a `path`, shows it."""

    process_id: int
    at_work: threading.Lock

    def __new__(cls, *args: Any, **kwargs: Any) -> Self:
        made = super().__new__(cls)
        made.process_id = os.getpid()
        made.at_work = threading.Lock()
        return made

    def check_process(self) -> None:
        if os.getpid() != self.process_id:
            raise RuntimeError("this was made in another process: make a new one in this process, after the fork")

    def close(self) -> None:
        """Give back what it has. Twice is once."""

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *error: object) -> None:
        self.close()

    def __repr__(self) -> str:
        return f"{type(self).__name__}({getattr(self, 'endpoint', getattr(self, 'path', ''))!r})"

    def __reduce_ex__(self, protocol: Any) -> NoReturn:
        name = type(self).__name__
        raise TypeError(f"a {name} cannot be copied, nor sent to another process: give a function that makes one")


def one_at_a_time(method: Method) -> Method:
    """For a method that asks and waits, or yields what comes: two of them at once would read each other's replies."""

    def begin(self: OneProcess) -> None:
        self.check_process()
        if not self.at_work.acquire(blocking=False):
            name = type(self).__name__
            raise RuntimeError(f"this {name} has not ended what it does: wait for that, or make a second {name}")

    @functools.wraps(method)
    def call(self: OneProcess, *args: Any, **words: Any) -> Any:
        begin(self)
        try:
            return method(self, *args, **words)
        finally:
            self.at_work.release()

    @functools.wraps(method)
    def iterate(self: OneProcess, *args: Any, **words: Any) -> Any:
        begin(self)
        try:
            yield from method(self, *args, **words)
        finally:
            self.at_work.release()

    return cast(Method, iterate if inspect.isgeneratorfunction(method) else call)
