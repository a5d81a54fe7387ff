"""The order of a step, and of a beginning: what simulator.py says of them. In C# it is SceneSteps.cs."""

import copy
import math
import struct
from typing import Any

import numpy as np

from netmq_example.messages import MessageError
from netmq_example.scene.agent import Agent, begin, over
from netmq_example.scene.kind import Kind
from netmq_example.scene.roster import Roster
from netmq_example.scene.scene import Scene
from netmq_example.wire import trees
from netmq_example.wire.records import RESET, Section
from netmq_example.wire.split_mix import MASK, draws

# Of agents that bring others in their on_reset.
MOST_ROUNDS = 100


class Asked:
    def __init__(self, kind: Kind, section: Section) -> None:
        self.kind = kind
        self.orders = section.marks
        self.seeds: tuple[int, ...] = struct.unpack(f"<{len(self.orders)}q", section.numbers)
        self.actions = kind.actions(section)
        # By row: the last observation of those that have ended in this exchange, and those whose episodes begin in it.
        self.last: dict[int, bytes] = {}
        self.again: set[int] = set()
        self.new: set[int] = set()
        self.ended: Section | None = None


class Steps:
    """`said` are the options of a reset; `seed` that of agent 0, as of the last time when all have begun."""

    def __init__(self, scene: Scene, roster: Roster, said: Any, seed: int, autoreset: bool) -> None:
        self.scene = scene
        self.roster = roster
        self.said = said
        self.seed = seed
        self.autoreset = autoreset
        self.asked: list[Asked] = []
        self.acting: list[tuple[Agent, Any]] = []

    def here(self, agent: Agent) -> bool:
        """Whether nobody has removed it meanwhile."""
        return self.roster.is_known() or any(one is agent for one in self.scene.agents)

    def all_over(self) -> bool:
        return all(over(agent) for agent in self.moving())

    def moving(self) -> list[Agent]:
        return [
            agent
            for one in self.asked
            for agent, begun in zip(one.kind.present, one.kind.begun, strict=True)
            if agent and begun and self.here(agent)
        ]

    def step(self, real_time: bool = False) -> int:
        """How many agents have done one. In real time each tick is a step, also of those who do nothing."""
        scene = self.scene
        moving = self.moving()
        acting = [agent for agent, _ in self.acting]
        if real_time:
            acting = [agent for agent in moving if not over(agent)]
            living = set(map(id, acting))
            self.acting = [(agent, action) for agent, action in self.acting if id(agent) in living]
        periods = {id(agent): one.kind.period for one in self.asked for agent in one.kind.present if agent}
        for agent, action in self.acting:
            if self.here(agent):
                # In real time it is given again at the next tick, and an agent may change its own.
                agent.on_action(copy.deepcopy(action) if real_time else action)
        for tick in range(1 if real_time else max(periods[id(agent)] for agent in acting)):
            # Nothing after the end belongs to a step.
            if all(map(over, acting)):
                break
            for agent in moving:
                if tick < periods[id(agent)] and not over(agent) and self.here(agent):
                    agent.on_tick(scene.dt)
            scene.on_tick(scene.dt)
        for agent in acting:
            if self.here(agent):
                agent.on_stepped()
        scene.on_stepped()
        if real_time:
            for agent in acting:
                agent._earned += reward_of(agent)
                agent.reward = 0.0
        return len(acting)

    def begin(self) -> int:
        """New episodes, and how many: of those that are told to, with the bit also of those that have ended, and of
        those that have come meanwhile."""
        for one in self.asked:
            one.again = {row for row, order in enumerate(one.orders) if order == RESET}
            if self.autoreset:
                one.again |= one.last.keys()
        if not any(one.again or one.kind.fresh for one in self.asked):
            return 0
        all_again = self.all_again()
        for one in self.asked:
            # Their last episode is over, and others may come in their place.
            for row in one.again:
                one.kind.begun[row] = False
        by_order = any(RESET in one.orders for one in self.asked)
        if all_again:
            first = self.asked[0]
            self.seed = first.seeds[0] - first.kind.first
            if by_order:
                self.scene.infos.take()
            self.scene.on_reset(draws(first.seeds[0]), options_in(self.said) if by_order else {})
            self.roster.sync()
        for one in self.asked:
            one.kind.fresh |= {row for row in one.again if one.kind.present[row]}
        count = 0
        # An on_reset may bring others, who then have their turn.
        for _ in range(MOST_ROUNDS):
            turn = [(one, row) for one in self.asked for row in sorted(one.kind.fresh) if one.kind.present[row]]
            if not turn:
                break
            agents = [self.begin_one(*each) for each in turn]
            for agent in agents:
                if self.here(agent):
                    agent.on_reset()
                    # Rewards before its first step belong to none.
                    agent.reward = 0.0
            count += len(agents)
            self.roster.sync()
        return count

    def all_again(self) -> bool:
        """Whether nobody who was asked for is left in an episode: then the scene itself begins anew."""
        return any(one.again for one in self.asked) and not any(
            agent and begun and row not in one.again
            for one in self.asked
            for row, (agent, begun) in enumerate(zip(one.kind.present, one.kind.begun, strict=True))
        )

    def begin_one(self, one: Asked, row: int) -> Agent:
        kind = one.kind
        agent = kind.present[row]
        assert agent is not None
        kind.fresh.discard(row)
        kind.begun[row] = True
        rng = draws(one.seeds[row] if row in one.again else (self.seed + kind.first + row) & MASK)
        if one.orders[row] == RESET:
            options = options_in(self.said)
            begin(agent, rng, options, state_in(options, kind.state_size))
        else:
            one.new.add(row)
            begin(agent, rng, {}, [])
        return agent


def options_in(said: Any) -> dict[str, Any]:
    """Those of a reset, fresh for each agent."""
    options = trees.read(said) if said else {}
    if type(options) is not dict:
        raise MessageError("bad-options", f"options are a dict, not {type(options).__name__}")
    return options


def state_in(options: dict[str, Any], size: int) -> list[float]:
    """Taken out of the options: in which an episode begins; nothing, if it begins by chance."""
    given = options.pop("state", []) if size else []
    try:
        items = np.asarray(given)
        if items.dtype.kind not in "biuf":
            raise MessageError("bad-state", "a state is numbers")
        # Counted before they are converted: a message may have millions.
        if items.size not in (0, size):
            raise MessageError("bad-state", f"a state is {size} numbers, not {items.size}")
        state: list[float] = items.astype(np.float64).ravel().tolist()
    except MessageError:
        raise
    except (ValueError, TypeError) as error:
        raise MessageError("bad-state", f"a state is numbers: {error!s:.80}") from None
    return state


def reward_of(agent: Agent) -> float:
    """Any number, also one of numpy's."""
    reward = agent.reward
    if type(reward) is not float:
        try:
            # An array of one number is a number to an old numpy, and none to a new one.
            if np.ndim(reward):
                raise TypeError
            reward = float(reward)
        except (TypeError, ValueError):
            text = f"the reward of {agent.name} is {agent.reward!r:.40}, which is no number"
            raise MessageError("bad-reward", text) from None
    if not math.isfinite(reward):
        raise MessageError("bad-reward", f"the reward of {agent.name} is {reward}")
    return reward
