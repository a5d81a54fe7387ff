"""Agents of one kind, which have one name but for a number: their rows, and the bytes of what they do and see.

An action or an observation is as its space says (wire/spaces.py); where Python's side says the space, it is a value,
or locators with a value each (wire/trees.py). It needs gymnasium and numpy.
"""

from typing import Any

import numpy as np

from netmq_example import check
from netmq_example.messages import MessageError
from netmq_example.scene.agent import Agent
from netmq_example.wire import trees
from netmq_example.wire.records import ASKS, FORM, Section
from netmq_example.wire.sections import with_sizes
from netmq_example.wire.space_bytes import Bytes
from netmq_example.wire.spaces import REASONS, Numbers, described


class Kind:
    """`names` are all that there may be; `first` is the number of the first of them among all agents."""

    def __init__(self, number: int, name: str, names: list[str], first: int, model: Agent) -> None:
        self.number = number
        self.name = name
        self.names = names
        self.first = first
        self.model = model
        self.period = check.count("period", model.period)
        self.state_size = check.count("state_size", model.state_size, least=0)
        self.action = None if model.action is None else Bytes(model.action)
        self.observation = None if model.observation is None else Bytes(model.observation)
        self.in_code = type(model).observe is not Agent.observe
        # Then what is seen comes as locators and values.
        self.located = not self.in_code or self.observation is None
        count = len(names)
        # By row: the agent, the last one, whether its episode goes on, whether Python knows that it has left; and rows
        # that have yet to begin.
        self.present: list[Agent | None] = [None] * count
        self.last: list[Agent | None] = [None] * count
        self.begun = [False] * count
        self.told = [False] * count
        self.fresh: set[int] = set()

    def is_free(self, row: int) -> bool:
        """Whether Python knows that the last agent of this row is over, or has left."""
        return not self.begun[row] or self.told[row]

    def described(self) -> dict[str, Any]:
        spaces = [described(one.space) if one else None for one in (self.observation, self.action)]
        return {
            "name": self.name,
            "team": 0,
            "agents": self.names,
            "at_most": len(self.names),
            "period": self.period,
            "observation": spaces[0],
            "action": spaces[1],
            "located": self.located,
            "sensors": [],
            "branches": None,
            "groups": False,
        }

    def like(self, agent: Agent) -> None:
        """ValueError if an agent is of another kind, in spite of its name."""
        model = self.model
        for what in ("period", "state_size", "observation", "action"):
            given, known = getattr(agent, what), getattr(model, what)
            if given is not known and given != known:
                both = f"{agent.name!r} and {self.names[0]!r} have one name, {self.name}, and not the same {what}"
                raise ValueError(f"{both}: give them two names")

    def actions(self, section: Section) -> list[Any]:
        """One for each row that acts. MessageError says what is none."""
        rows = section.rows(ASKS)
        asked = [row for row in rows if row is not None]
        if self.action is None:
            if section.columns & FORM:
                form = trees.SIZE.pack(len(section.form)) + section.form
                asked = [form + bytes(row) for row in asked]
            values = [trees.read(row) for row in asked]
        else:
            values = read_rows(self.action, asked)
        each = iter(values)
        return [None if row is None else next(each) for row in rows]

    def seen(self, agents: list[Agent]) -> list[bytes]:
        if self.observation is None:
            return [trees.write_pairs([("@ = $", agent.observe())]) for agent in agents]
        codec = self.observation.codec
        if not isinstance(codec, Numbers):
            return [write_row(self.observation, agent.observe()) for agent in agents]
        block = np.empty((len(agents), *codec.shape), codec.dtype)
        for at, agent in enumerate(agents):
            value = agent.observe()
            # Of the space as it is, as a rule.
            if type(value) is not np.ndarray or value.dtype != codec.dtype or value.shape != codec.shape:
                value = self.observation.read(write_row(self.observation, value))
            block[at] = value
        try:
            codec.check(block)
        except MessageError:
            for row in block:
                codec.check(row)
        return [row.tobytes() for row in block]


def read_rows(space: Bytes, rows: list[Any]) -> list[Any]:
    codec = space.codec
    if not isinstance(codec, Numbers) or not codec.size or len(rows) < 2 or any(len(row) != codec.size for row in rows):
        return [space.read(row) for row in rows]
    try:
        return list(codec.read_block(np.frombuffer(b"".join(rows), np.uint8).reshape(len(rows), codec.size), 0))
    except MessageError:
        # One of them is wrong, which names itself.
        return [space.read(row) for row in rows]


def write_row(space: Bytes, value: Any) -> bytes:
    """The bytes of an observation, which must be in its space."""
    try:
        row = space.write(value)
        space.read(row)
    except MessageError:
        raise
    except REASONS as error:
        text = " ".join(f"{value!r:.80} is not in {space.space}: {error!s:.80}".split())
        raise MessageError("not-in-space", text) from None
    return row


def with_rows(section: Section, rows: list[bytes], located: bool) -> Section:
    """The same section with these rows. Locators with values have one form as a rule, which then stands there once."""
    if not located or not rows:
        return with_sizes(section, rows)
    end = trees.SIZE.size + trees.SIZE.unpack_from(rows[0])[0]
    size = len(rows[0])
    form = rows[0][:end]
    if any(len(row) != size or row[:end] != form for row in rows):
        return with_sizes(section, rows)
    section.columns |= FORM
    section.form = form[trees.SIZE.size :]
    section.values = b"".join(row[end:] for row in rows)
    return section
