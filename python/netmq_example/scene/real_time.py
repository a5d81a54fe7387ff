"""Real time: a scene goes on while Python thinks, for whoever asks for it. In C# it is RealTimeClock.cs.

Each exchange first makes up for the ticks that the clock has seen since the last one, with the actions from then; the
tick that is due now has the new ones. Each tick is a step, rewards are summed, and who ends has no more ticks until the
next exchange. It is Python that keeps the pace: it sends no more than one step for each tick.
"""

from collections.abc import Callable
from typing import Any

from netmq_example.scene.agent import Agent
from netmq_example.scene.steps import Steps
from netmq_example.wire.records import LAST, RESET, STEP

# More than that is not made up for when Python, or the whole computer, has slept.
MOST_SECONDS = 10.0


class RealTime:
    def __init__(self, dt: float, clock: Callable[[], float]) -> None:
        self.dt = dt
        self.clock = clock
        self.on = False
        # When the next tick is due.
        self.next = 0.0
        self.acting: list[tuple[Agent, Any]] = []

    def switched(self, on: bool) -> bool:
        """Whether time passes by the clock; it begins when it is asked for."""
        if on and not self.on:
            self.restart()
        self.on = on
        return on

    def restart(self) -> None:
        self.next = self.clock() + self.dt
        self.acting = []

    def step(self, exchange: Steps) -> int:
        """How many steps agents have done."""
        steps = 0
        if exchange.acting:
            until = self.clock() - self.dt
            self.next = max(self.next, until - MOST_SECONDS)
            new, exchange.acting = exchange.acting, self.acting
            while until >= self.next and not exchange.all_over():
                self.next += self.dt
                steps += exchange.step(real_time=True)
            exchange.acting = new
            self.next += self.dt
            if not exchange.all_over():
                steps += exchange.step(real_time=True)
        self.acting = exchange.acting
        orders = {order for one in exchange.asked for order in one.orders}
        if RESET in orders and not orders & {STEP, LAST}:
            self.restart()
        return steps
