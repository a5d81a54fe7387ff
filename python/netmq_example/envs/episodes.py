"""The episodes of many agents: the seed of each, and how long it may be.

episodes = Episodes(16, limit=500)
episodes.plant(3, everybody)                    agent i begins with the seed 3 + i, and draws those that follow
episodes.orders(again, gone)                    what each agent is told in the next step
"""

from typing import Any

import numpy as np
from gymnasium.utils import seeding

from netmq_example.envs.remote import is_seed
from netmq_example.messages import EXACT
from netmq_example.wire.records import LAST, RESET, STEP


class Episodes:
    """`limit` is how many steps an episode has at most, or 0."""

    def __init__(self, count: int, limit: int) -> None:
        self.count = count
        self.limit = limit
        # Generators, each with the seed that it was made of; and the seed of each agent's next episode, which is drawn
        # ahead, since an episode may begin before anybody asks for it.
        self.randoms = [seeding.np_random() for _ in range(count)]
        self.next = np.zeros(count, np.int64)
        self.draw(range(count))
        # Steps of each episode, and how many are left until the first one's time is up.
        self.steps = np.zeros(count, int)
        self.left = 0

    def plant(self, seed: Any, mask: Any) -> None:
        """A seed for each agent, None where its generator draws one."""
        if seed is None:
            return
        if is_seed(seed):
            seed = [int(seed) + agent for agent in range(self.count)]
        each = list(seed) if np.iterable(seed) and not isinstance(seed, str) else [seed]
        if len(each) != self.count or not all(one is None or is_seed(one) for one in each):
            raise ValueError(
                f"{len(each)} seeds are not one for each of {self.count} agents, below 2**53: {each!r:.80}"
            )
        for agent in np.flatnonzero(mask):
            if each[agent] is not None:
                self.randoms[agent] = seeding.np_random(int(each[agent]))
                self.next[agent] = each[agent]

    def draw(self, agents: Any) -> None:
        for agent in agents:
            self.next[agent] = self.randoms[agent][0].integers(EXACT)

    def begun(self, agents: Any) -> None:
        self.draw(agents)
        self.steps[agents] = 0
        self.count_again()

    def count_again(self) -> None:
        self.left = self.limit - int(self.steps.max()) if self.limit else 0

    def orders(self, again: Any, gone: Any) -> tuple[bytes | None, Any]:
        """The order to each agent, and who steps; None stands for: all of them step."""
        if again is None and gone is None and not (self.limit and self.left <= 1):
            return None, None
        orders = np.full(self.count, STEP, np.uint8)
        if self.limit:
            orders[self.steps + 1 >= self.limit] = LAST
        begins = [mask for mask in (again, gone) if mask is not None]
        if not begins:
            return orders.tobytes(), None
        begin = np.logical_or.reduce(begins)
        orders[begin] = RESET
        return orders.tobytes(), ~begin

    def stepped(self, steps: Any) -> None:
        """A step is done, by all of them or by these; the others have begun again in it, or are away."""
        self.steps += 1
        self.left -= 1
        if steps is not None:
            self.steps[~steps] = 0
            self.count_again()

    def up(self) -> Any:
        """The agents whose time is up; None where there can be none."""
        return self.steps >= self.limit if self.limit and self.left <= 0 else None
