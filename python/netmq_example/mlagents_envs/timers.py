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
from collections.abc import Callable, Iterator
from dataclasses import asdict, dataclass, field
from typing import Any, ParamSpec, TypeVar

__all__ = [
    "GaugeNode",
    "TimerNode",
    "TimerStack",
    "add_metadata",
    "get_timer_root",
    "get_timer_stack_for_thread",
    "get_timer_tree",
    "hierarchical_timer",
    "merge_gauges",
    "reset_timers",
    "set_gauge",
    "timed",
]

P = ParamSpec("P")
T = TypeVar("T")

TIMER_FORMAT_VERSION = "0.1.0"


@dataclass
class TimerNode:
    """One block of code. Those of worker processes are sent to the trainer, which merges them."""

    children: dict[str, "TimerNode"] = field(default_factory=dict)
    total: float = 0.0
    count: int = 0
    is_parallel: bool = False

    def get_child(self, name: str) -> "TimerNode":
        if name not in self.children:
            self.children[name] = TimerNode()
        return self.children[name]

    def add_time(self, elapsed: float) -> None:
        self.total += elapsed
        self.count += 1

    def merge(self, other: "TimerNode", root_name: str | None = None, is_parallel: bool = True) -> None:
        """Adds another tree, below `root_name` if that is given."""
        node = self.get_child(root_name) if root_name else self
        node.total += other.total
        node.count += other.count
        node.is_parallel |= is_parallel
        for name, child in other.children.items():
            node.get_child(name).merge(child, is_parallel=is_parallel)

    def tree(self) -> dict[str, Any]:
        children = {name: child.tree() for name, child in self.children.items()}
        own = self.total - sum(child["total"] for child in children.values())
        found: dict[str, Any] = {"total": self.total, "count": self.count}
        if self.is_parallel:
            found["is_parallel"] = True
        # Blocks in parallel take longer together than the one around them.
        found["self"] = max(0.0, own)
        if children:
            found["children"] = children
        return found


@dataclass
class GaugeNode:
    """The newest of some values, with the lowest and the highest."""

    value: float
    min: float = math.inf
    max: float = -math.inf
    count: int = 0

    def update(self, new_value: float) -> None:
        self.value = new_value
        self.min = min(self.min, new_value)
        self.max = max(self.max, new_value)
        self.count += 1

    def merge(self, other: "GaugeNode") -> None:
        self.value = other.value
        self.min = min(self.min, other.min)
        self.max = max(self.max, other.max)
        self.count += other.count


class TimerStack:
    """The blocks that are open on one thread; the functions below use it."""

    def __init__(self) -> None:
        self.reset()

    def reset(self) -> None:
        self.root = TimerNode()
        self.stack = [self.root]
        self.start_time = time.perf_counter()
        self.gauges: dict[str, GaugeNode] = {}
        self.metadata = {
            "timer_format_version": TIMER_FORMAT_VERSION,
            "start_time_seconds": str(int(time.time())),
            "python_version": sys.version,
            "command_line_arguments": " ".join(sys.argv),
        }

    def push(self, name: str) -> TimerNode:
        self.stack.append(self.stack[-1].get_child(name))
        return self.stack[-1]

    def pop(self) -> None:
        self.stack.pop()

    def get_root(self) -> TimerNode:
        self.root.total = time.perf_counter() - self.start_time
        self.root.count = 1
        return self.root

    def get_timing_tree(self, node: TimerNode | None = None) -> dict[str, Any]:
        if node is not None:
            return node.tree()
        self.metadata["end_time_seconds"] = str(int(time.time()))
        gauges = {name: asdict(gauge) for name, gauge in self.gauges.items()}
        beside: dict[str, Any] = {"gauges": gauges} if gauges else {}
        return {"name": "root", **beside, "metadata": self.metadata, **self.get_root().tree()}

    def set_gauge(self, name: str, value: float) -> None:
        if not math.isnan(value):
            self.gauges.setdefault(name, GaugeNode(value)).update(value)

    def add_metadata(self, key: str, value: str) -> None:
        self.metadata[key] = value


STACKS: dict[int | None, TimerStack] = {}


def _get_thread_timer() -> TimerStack:
    thread = threading.get_ident()
    if thread not in STACKS:
        STACKS[thread] = TimerStack()
    return STACKS[thread]


def get_timer_stack_for_thread(t: threading.Thread) -> TimerStack | None:
    return STACKS.get(t.ident)


@contextlib.contextmanager
def hierarchical_timer(name: str, timer_stack: TimerStack | None = None) -> Iterator[TimerNode]:
    """Adds the time of a block of code, also of one that raises."""
    stack = timer_stack or _get_thread_timer()
    node = stack.push(name)
    start = time.perf_counter()
    try:
        yield node
    finally:
        node.add_time(time.perf_counter() - start)
        stack.pop()


def timed(func: Callable[P, T]) -> Callable[P, T]:
    """Adds the time of each call of this function, by its name."""

    @functools.wraps(func)
    def call(*args: P.args, **words: P.kwargs) -> T:
        with hierarchical_timer(func.__qualname__):
            return func(*args, **words)

    return call


def set_gauge(name: str, value: float, timer_stack: TimerStack | None = None) -> None:
    (timer_stack or _get_thread_timer()).set_gauge(name, value)


def merge_gauges(gauges: dict[str, GaugeNode], timer_stack: TimerStack | None = None) -> None:
    own = (timer_stack or _get_thread_timer()).gauges
    for name, gauge in gauges.items():
        own.setdefault(name, GaugeNode(gauge.value)).merge(gauge)


def add_metadata(key: str, value: str, timer_stack: TimerStack | None = None) -> None:
    (timer_stack or _get_thread_timer()).add_metadata(key, value)


def get_timer_tree(timer_stack: TimerStack | None = None) -> dict[str, Any]:
    return (timer_stack or _get_thread_timer()).get_timing_tree()


def get_timer_root(timer_stack: TimerStack | None = None) -> TimerNode:
    return (timer_stack or _get_thread_timer()).get_root()


def reset_timers(timer_stack: TimerStack | None = None) -> None:
    (timer_stack or _get_thread_timer()).reset()
