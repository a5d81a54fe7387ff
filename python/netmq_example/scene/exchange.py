"""One request of an environment in a scene: what is asked of whom, and what happens. simulator.py has the order."""

import math
import struct
from typing import Any

import numpy as np

from netmq_example.messages import Message, MessageError
from netmq_example.scene.agent import Agent, begin, over
from netmq_example.scene.kind import Kind, with_rows
from netmq_example.scene.roster import Roster
from netmq_example.scene.scene import Scene
from netmq_example.wire import trees
from netmq_example.wire.records import (
    ABSENT,
    AUTORESET,
    ENDED,
    FORM,
    LAST,
    NEW,
    NOTHING,
    RESET,
    SEEN,
    SIZES,
    STEP,
    TERMINATED,
    TRUNCATED,
    WHO,
    Record,
    Section,
    bad,
    rewards,
    with_infos,
)
from netmq_example.wire.spaces import write_dict
from netmq_example.wire.split_mix import MASK, draws

# Names in an info that are the environment's own, or Gymnasium's.
RESERVED = ("agent", "env", "lost", "final_obs", "final_info")
# Of agents that bring others in their on_reset.
MOST_ROUNDS = 100


class Asked:
    """What is asked of one kind."""

    def __init__(self, kind: Kind, section: Section) -> None:
        self.kind = kind
        self.orders = section.marks
        self.seeds: tuple[int, ...] = struct.unpack(f"<{len(self.orders)}q", section.numbers)
        self.actions = kind.actions(section)
        # What those that have ended in this exchange have seen last, by row; and whose episodes begin in it.
        self.last: dict[int, bytes] = {}
        self.again: set[int] = set()
        self.new: set[int] = set()
        self.ended: Section | None = None


class Exchange:
    """Reads a request wholly, before anything moves: MessageError says what is wrong with it."""

    def __init__(self, scene: Scene, roster: Roster, request: Record, seed: int) -> None:
        self.scene = scene
        self.roster = roster
        self.request = request
        self.seed = seed
        self.autoreset = bool(request.bits & AUTORESET)
        self.asked: list[Asked] = []
        if not request.sections:
            raise bad("it has no sections")
        for section in request.sections:
            self.asked.append(self.read(section))
        self.acting = [
            (agent, action)
            for one in self.asked
            for row, action in enumerate(one.actions)
            if one.orders[row] in (STEP, LAST) and (agent := one.kind.present[row]) and one.kind.begun[row]
        ]
        self.options()
        self.states = {one.kind.number: self.state_of(one.kind) for one in self.asked if RESET in one.orders}

    def read(self, section: Section) -> Asked:
        kinds = self.roster.kinds
        if section.kind >= len(kinds) or any(one.kind.number == section.kind for one in self.asked):
            raise MessageError(
                "wrong-agents", f"kind {section.kind} is none, or asked for twice: there are {len(kinds)}"
            )
        if section.columns & ~(SIZES | FORM):
            raise bad(f"columns {section.columns} cannot be in a request by Python's clock")
        kind = kinds[section.kind]
        rows, count = len(section.marks), len(kind.names)
        if rows != count:
            raise MessageError("wrong-agents", f"{rows} rows, but there are {count} agents of {kind.name}")
        for row, order in enumerate(section.marks):
            if order in (STEP, LAST) and kind.present[row] and not kind.begun[row] and row not in kind.fresh:
                raise MessageError("wrong-agents", f"{kind.names[row]} is over, or has not begun: reset comes first")
        return Asked(kind, section)

    def options(self) -> dict[str, Any]:
        """Those of a reset, fresh for each agent."""
        options = trees.read(self.request.said) if self.request.said else {}
        if type(options) is not dict:
            raise MessageError("bad-options", f"options are a dict, not {type(options).__name__}")
        return options

    def state_of(self, kind: Kind) -> list[float]:
        """In which an episode begins; nothing, if it begins by chance."""
        given = self.options().get("state", [])
        size = kind.state_size
        if not size:
            return []
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

    # The order of a step

    def here(self, agent: Agent) -> bool:
        """Whether nobody has removed it meanwhile."""
        agents = self.scene.agents
        return len(agents) == len(self.roster.now) or any(one is agent for one in agents)

    def all_over(self) -> bool:
        return all(over(agent) for agent in self.moving())

    def moving(self) -> list[Agent]:
        """Those in an episode."""
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
                agent.on_action(action)
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

    def end(self) -> None:
        """Whoever is over is observed a last time, also who has left in the same step. Then it is seen who is there."""
        for one in self.asked:
            kind = one.kind
            ended: dict[int, Agent] = {}
            for row, order in enumerate(one.orders):
                agent = kind.present[row] if order in (STEP, LAST) else None
                if agent is None or not kind.begun[row]:
                    continue
                if order == LAST:
                    agent.truncated = True
                if over(agent):
                    ended[row] = agent
            if ended:
                rows = self.seen(kind, list(ended.values()))
                one.last = dict(zip(ended, rows, strict=True))
                if self.autoreset:
                    one.ended = self.ended(kind, ended, rows)
        self.roster.sync()

    def ended(self, kind: Kind, ended: dict[int, Agent], rows: list[bytes]) -> Section:
        taken = [take(agent) for agent in ended.values()]
        section = Section(
            kind.number,
            rewards([reward for reward, _ in taken]),
            bytes(SEEN | ends(agent) for agent in ended.values()),
            columns=ENDED | WHO,
            who=struct.pack(f"<{len(ended)}I", *ended),
        )
        with_infos(section, {at: info for at, (_, info) in enumerate(taken) if info})
        return with_rows(section, rows, kind.located)

    def begin(self) -> int:
        """New episodes, and how many: of those that are told to, with the bit also of those that have ended, and of
        those that have come meanwhile."""
        for one in self.asked:
            one.again = {row for row, order in enumerate(one.orders) if order == RESET}
            if self.autoreset:
                one.again |= one.last.keys()
        if not any(one.again or one.kind.fresh for one in self.asked):
            return 0
        by_order = any(RESET in one.orders for one in self.asked)
        if self.all_again():
            first = self.asked[0]
            self.seed = first.seeds[0] - first.kind.first
            if by_order:
                self.scene.infos.take()
            self.scene.on_reset(draws(first.seeds[0]), self.options() if by_order else {})
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
                    # What it earns before its first step belongs to none.
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
        if row not in one.again:
            one.new.add(row)
            begin(agent, draws((self.seed + kind.first + row) & MASK), {}, [])
        elif one.orders[row] == RESET:
            options = self.options()
            if kind.state_size:
                options.pop("state", None)
            begin(agent, draws(one.seeds[row]), options, list(self.states[kind.number]))
        else:
            one.new.add(row)
            begin(agent, draws(one.seeds[row]), {}, [])
        return agent

    # The answer

    def seen(self, kind: Kind, agents: list[Agent]) -> list[bytes]:
        if kind.in_code:
            return kind.seen(agents)
        return [trees.write_pairs(self.roster.pairs(agent)) for agent in agents]

    def sections(self) -> list[Section]:
        now = [self.section(one) for one in self.asked]
        return now + [one.ended for one in self.asked if one.ended]

    def section(self, one: Asked) -> Section:
        kind = one.kind
        count = len(one.orders)
        marks = bytearray(count)
        numbers = [0.0] * count
        infos: dict[int, bytes] = {}
        seeing: list[Agent] = []
        telling: dict[int, Agent] = {}
        for row, order in enumerate(one.orders):
            agent = kind.present[row]
            if agent is None:
                agent = kind.last[row]
                told, kind.told[row] = kind.told[row], True
                marks[row] = ABSENT
                if agent is None:
                    continue
                # An end is told once.
                if kind.begun[row] and not told and not (self.autoreset and row in one.last):
                    marks[row] |= ends(agent) | (SEEN if row in one.last else 0)
            elif row in one.new:
                marks[row] = NEW | SEEN
            elif order == NOTHING:
                continue
            else:
                marks[row] = SEEN
            if row in one.last and marks[row] == SEEN:
                marks[row] |= ends(agent)
                # From now on it must be reset.
                kind.begun[row] = False
            elif marks[row] & SEEN and not marks[row] & ABSENT:
                seeing.append(agent)
            telling[row] = agent
        rows = self.seen(kind, seeing)
        # What an agent says while it observes belongs to this answer.
        for row, agent in telling.items():
            numbers[row], info = take(agent)
            if info:
                infos[row] = info
        if one.last and not self.autoreset:
            each = iter(rows)
            rows = [one.last[row] if row in one.last else next(each) for row, mark in enumerate(marks) if mark & SEEN]
        section = with_infos(Section(kind.number, rewards(numbers), bytes(marks)), infos)
        return with_rows(section, rows, kind.located)


def ends(agent: Agent) -> int:
    return (TERMINATED if agent.terminated else 0) | (TRUNCATED if agent.truncated else 0)


def take(agent: Agent) -> tuple[float, bytes]:
    """Its reward and its info, each of which Python gets once."""
    reward = reward_of(agent) + agent._earned
    agent.reward = agent._earned = 0.0
    if not agent.info and not agent._infos.size and not agent._infos.dropped:
        return reward, b""
    info = agent.info
    if type(info) is not dict:
        raise MessageError("bad-info", f"an info is a dict, not {info!a:.40}")
    wrong = [
        name for name in info if name in RESERVED or (isinstance(name, str) and name[:1] == "_" and name[1:] in info)
    ]
    if wrong:
        raise MessageError("bad-info", f"these names are the environment's own: {wrong[0]!a:.40}; {agent.name} has it")
    agent.info = {}
    if sent := agent._infos.take():
        info = {**info, "agent": sent}
    return reward, write_dict(info, "info")


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


def info_of(request: Message) -> tuple[str, Any]:
    """An info: the agent that it is for, or "" for the scene, and its value."""
    pair = trees.read(request.arrays[0].data) if len(request.arrays) == 1 else None
    if type(pair) is not list or len(pair) != 2 or not isinstance(pair[0], str):
        raise MessageError("bad-info", f"{pair!a:.40} is no name with an info")
    return pair[0], pair[1]
