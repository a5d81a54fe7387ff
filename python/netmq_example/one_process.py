"""For what has a socket or a thread: it belongs to the process that made it, and there is no second one of it.

class Asker(OneProcess):
    def ask(self):
        self.check_process()            RuntimeError after a fork, where libzmq would wait for ever
"""

import os
from typing import Any, NoReturn


class OneProcess:
    process_id: int

    def __new__(cls, *args: Any, **kwargs: Any) -> Any:
        made: Any = super().__new__(cls)
        made.process_id = os.getpid()
        return made

    def check_process(self) -> None:
        if os.getpid() != self.process_id:
            raise RuntimeError("this was made in another process: make a new one in this process, after the fork")

    def __reduce_ex__(self, protocol: Any) -> NoReturn:
        name = type(self).__name__
        raise TypeError(f"a {name} cannot be copied, nor sent to another process: give a function that makes one")
