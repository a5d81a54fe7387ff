"""The timers of mlagents_envs.timers, with its names: where a program's time goes, as a tree, and gauges beside it.

    @timed
    def learn(): ...

    with hierarchical_timer("play"):
        learn()
    get_timer_tree()        {"name": "root", …, "children": {"play": {…, "children": {"learn": {…}}}}}

Each thread has a tree of its own. ML-Agents' trainers write the main thread's into timers.json.
"""

import contextlib
import functools
import math
import sys
import threading
import time
from collections import defaultdict
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from typing import Any, ParamSpec, TypeVar

P = ParamSpec("P")
T = TypeVar("T")


@dataclass
class TimerNode:
    """One block of code. Those of worker processes are sent to the trainer, which merges them."""

    children: dict[str, "TimerNode"] = field(default_factory=dict)
    total: float = 0.0
    count: int = 0
    is_parallel: bool = False

    def merge(self, other: "TimerNode", root_name: str, is_parallel: bool = True) -> None:
        node = self.children.setdefault(root_name, TimerNode())
        node.total += other.total
        node.count += other.count
        node.is_parallel |= is_parallel
        for name, child in other.children.items():
            node.merge(child, name, is_parallel)

    def tree(self) -> dict[str, Any]:
        # Blocks in parallel take longer together than the one around them.
        own = max(0.0, self.total - sum(child.total for child in self.children.values()))
        parallel = {"is_parallel": True} if self.is_parallel else {}
        below = {"children": {name: child.tree() for name, child in self.children.items()}} if self.children else {}
        return {"total": self.total, "count": self.count, **parallel, "self": own, **below}


class TimerStack:
    """Of one thread: its tree, the blocks that are open, and its gauges."""

    def __init__(self) -> None:
        self.root = TimerNode()
        self.open = [self.root]
        self.start = time.perf_counter()
        self.gauges: dict[str, dict[str, float]] = {}
        command = " ".join(sys.argv)
        self.metadata = {"timer_format_version": "0.1.0", "start_time_seconds": str(int(time.time()))}
        self.metadata |= {"python_version": sys.version, "command_line_arguments": command}


STACKS: dict[int | None, TimerStack] = defaultdict(TimerStack)


def get_timer_stack_for_thread(t: threading.Thread) -> TimerStack | None:
    return STACKS.get(t.ident)


@contextlib.contextmanager
def hierarchical_timer(name: str) -> Iterator[TimerNode]:
    """Adds the time of a block of code, also of one that raises."""
    blocks = STACKS[threading.get_ident()].open
    node = blocks[-1].children.setdefault(name, TimerNode())
    blocks.append(node)
    start = time.perf_counter()
    try:
        yield node
    finally:
        node.total += time.perf_counter() - start
        node.count += 1
        blocks.pop()


def timed(func: Callable[P, T]) -> Callable[P, T]:

    @functools.wraps(func)
    def call(*args: P.args, **words: P.kwargs) -> T:
        with hierarchical_timer(func.__qualname__):
            return func(*args, **words)

    return call


def set_gauge(name: str, value: float) -> None:
    """The newest of some values, which is shown with the lowest and the highest."""
    if not math.isnan(value):
        merge_gauges({name: {"value": value, "min": value, "max": value, "count": 1}})


def merge_gauges(gauges: dict[str, dict[str, float]]) -> None:
    own = STACKS[threading.get_ident()].gauges
    for name, new in gauges.items():
        old = own.get(name, {**new, "count": 0})
        low, high = min(old["min"], new["min"]), max(old["max"], new["max"])
        own[name] = {"value": new["value"], "min": low, "max": high, "count": old["count"] + new["count"]}


def add_metadata(key: str, value: str) -> None:
    STACKS[threading.get_ident()].metadata[key] = value


def get_timer_root() -> TimerNode:
    stack = STACKS[threading.get_ident()]
    stack.root.total = time.perf_counter() - stack.start
    stack.root.count = 1
    return stack.root


def get_timer_tree() -> dict[str, Any]:
    stack = STACKS[threading.get_ident()]
    metadata = {**stack.metadata, "end_time_seconds": str(int(time.time()))}
    gauges = {"gauges": stack.gauges} if stack.gauges else {}
    return {"name": "root", **gauges, "metadata": metadata, **get_timer_root().tree()}


def reset_timers() -> None:
    STACKS[threading.get_ident()] = TimerStack()
