"""One request of an environment in a scene: read wholly before anything moves, and answered."""

import struct

from netmq_example.messages import MessageError
from netmq_example.scene.agent import Agent, over
from netmq_example.scene.kind import Kind, with_rows
from netmq_example.scene.roster import Roster
from netmq_example.scene.scene import Scene
from netmq_example.scene.steps import Asked, Steps, options_in, reward_of, state_in
from netmq_example.wire import records, trees
from netmq_example.wire.records import Record, Section, bad
from netmq_example.wire.sections import rewards, with_infos
from netmq_example.wire.spaces import write_dict

# Names in an info that are the environment's own, or Gymnasium's.
RESERVED = ("agent", "env", "lost", "final_obs", "final_info")


class Exchange(Steps):
    """MessageError says what is wrong with the request."""

    def __init__(self, scene: Scene, roster: Roster, request: Record, seed: int) -> None:
        super().__init__(scene, roster, request.said, seed, bool(request.bits & records.AUTORESET))
        if not request.sections:
            raise bad("it has no sections")
        for section in request.sections:
            self.asked.append(self.read(section))
        self.acting = [
            (agent, action)
            for one in self.asked
            for row, action in enumerate(one.actions)
            if one.orders[row] in (records.STEP, records.LAST)
            and (agent := one.kind.present[row])
            and one.kind.begun[row]
        ]
        for one in self.asked:
            if records.RESET in one.orders:
                state_in(options_in(self.said), one.kind.state_size)

    def read(self, section: Section) -> Asked:
        kinds = self.roster.kinds
        if section.kind >= len(kinds) or any(one.kind.number == section.kind for one in self.asked):
            raise MessageError(
                "wrong-agents", f"kind {section.kind} is none, or asked for twice: there are {len(kinds)}"
            )
        if section.columns & ~(records.SIZES | records.FORM):
            raise bad(f"columns {section.columns} cannot be in a request by Python's clock")
        kind = kinds[section.kind]
        rows, count = len(section.marks), len(kind.names)
        if rows != count:
            raise MessageError("wrong-agents", f"{rows} rows, but there are {count} agents of {kind.name}")
        for row, order in enumerate(section.marks):
            if (
                order in (records.STEP, records.LAST)
                and kind.present[row]
                and not kind.begun[row]
                and row not in kind.fresh
            ):
                raise MessageError("wrong-agents", f"{kind.names[row]} is over, or has not begun: reset comes first")
        return Asked(kind, section)

    def end(self) -> None:
        """An agent that is over is observed a last time, also if it has left in the same step."""
        for one in self.asked:
            kind = one.kind
            ended: dict[int, Agent] = {}
            for row, order in enumerate(one.orders):
                agent = kind.present[row] if order in (records.STEP, records.LAST) else None
                if agent is None or not kind.begun[row]:
                    continue
                if order == records.LAST:
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
            bytes(records.SEEN | ends(agent) for agent in ended.values()),
            columns=records.ENDED | records.WHO,
            who=struct.pack(f"<{len(ended)}I", *ended),
        )
        with_infos(section, {at: info for at, (_, info) in enumerate(taken) if info})
        return with_rows(section, rows, kind.located)

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
                marks[row] = records.ABSENT
                if agent is None:
                    continue
                # An end is told once.
                if kind.begun[row] and not told and not (self.autoreset and row in one.last):
                    marks[row] |= ends(agent) | (records.SEEN if row in one.last else 0)
            elif row in one.new:
                marks[row] = records.NEW | records.SEEN
            elif order == records.NOTHING:
                continue
            else:
                marks[row] = records.SEEN
            if row in one.last and marks[row] == records.SEEN:
                marks[row] |= ends(agent)
                # From now on it must be reset.
                kind.begun[row] = False
            elif marks[row] & records.SEEN and not marks[row] & records.ABSENT:
                seeing.append(agent)
            telling[row] = agent
        rows = self.seen(kind, seeing)
        # Infos that an agent sets while it observes belong to this answer.
        for row, agent in telling.items():
            numbers[row], info = take(agent)
            if info:
                infos[row] = info
        if one.last and not self.autoreset:
            each = iter(rows)
            rows = [
                one.last[row] if row in one.last else next(each)
                for row, mark in enumerate(marks)
                if mark & records.SEEN
            ]
        section = with_infos(Section(kind.number, rewards(numbers), bytes(marks)), infos)
        return with_rows(section, rows, kind.located)


def ends(agent: Agent) -> int:
    return (records.TERMINATED if agent.terminated else 0) | (records.TRUNCATED if agent.truncated else 0)


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
