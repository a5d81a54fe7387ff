"""Infos of many agents: each as it was sent, and Gymnasium's dict of arrays, of which nothing is made unasked.

    infos = Infos(16, section, {"env": […]})
    infos[3]                            what was said of agent 3, read when it is asked for
    infos.gathered(add)                 {"place": an array, "_place": who has one}; of nothing nothing

Where all have one form, an array is a column of the bytes that came, in the dtype that was sent. Where dtypes, types
or shapes differ it is an array of objects, each as it was sent.
"""

import functools
import math
from typing import Any

import numpy as np

from netmq_example.envs.remote import MASK, OWN, info_in
from netmq_example.json_text import parsed
from netmq_example.wire import trees
from netmq_example.wire.records import Section

NUMBERS = {"int64": np.dtype("<i8"), "float64": np.dtype("<f8"), "bool": np.dtype(bool)}


class Infos:
    """A list, of which item i is the dict of agent i; `everyone` is said of all of them."""

    def __init__(self, count: int, section: Section | None = None, everyone: dict[str, Any] | None = None) -> None:
        self.count = count
        self.section = section if section is not None and len(section.table) else None
        self.everyone = everyone or {}
        # The environment's own words, by row: it is the last to speak.
        self.added: dict[int, dict[str, Any]] = {}

    def __len__(self) -> int:
        return self.count

    def __getitem__(self, agent: int) -> dict[str, Any]:
        agent = range(self.count)[agent]
        return {**self.everyone, **self.each.get(agent, {}), **self.added.get(agent, {})}

    def listed(self) -> list[dict[str, Any]]:
        """A dict for each agent, its user's own."""
        if self.section is None and not self.everyone and not self.added:
            return [{} for _ in range(self.count)]
        return [self[agent] for agent in range(self.count)]

    def add(self, agent: int, info: dict[str, Any]) -> None:
        self.added[agent] = {**self.added.get(agent, {}), **info}

    @functools.cached_property
    def each(self) -> dict[int, dict[str, Any]]:
        """Of those of whom something was said."""
        section = self.section
        if section is None:
            return {}
        who = section.whose()
        return {int(who[row]): info_in(data) for row, data in section.each_info()}

    def gathered(self) -> dict[str, Any]:
        if self.section is None and not self.everyone and not self.added:
            return {}
        columns = None if self.everyone or self.added else self.columns()
        return self.mixed() if columns is None else columns

    def columns(self) -> dict[str, Any] | None:
        """Arrays made at once of the bytes; None where the infos have not all the same form."""
        section: Any = self.section
        table = np.frombuffer(section.table, np.uint32).reshape(-1, 2)
        size = int(table[0, 1])
        head = 4 + trees.SIZE.unpack_from(section.infos)[0]
        form = bytes(section.infos[4:head])
        dtype = dtype_of(form) if len(form) <= trees.LONGEST_KEPT else None
        if dtype is None or dtype.itemsize != size or (table[:, 1] != size).any():
            return None
        block = np.frombuffer(section.infos, np.uint8).reshape(-1, size)
        if (block[:, :head] != block[0, :head]).any():
            return None
        whole = block.reshape(-1).view(dtype)
        rows = np.asarray(section.whose())[table[:, 0]]
        mask = np.zeros(self.count, bool)
        mask[rows] = True
        found: dict[str, Any] = {}
        for key in (dtype.names or ())[1:]:
            column = whole[key]
            if column.dtype.kind == "f" and not np.isfinite(column).all():
                return None
            found[key] = np.zeros((self.count, *column.shape[1:]), column.dtype)
            found[key][rows] = column
            found[f"_{key}"] = mask.copy()
        if MASK in found:
            found[MASK] = found[MASK].astype(np.int8)
        return found

    def mixed(self) -> dict[str, Any]:
        each = [self[agent] for agent in range(self.count)]
        found: dict[str, Any] = {}
        keys = dict.fromkeys(key for one in each for key in one)
        for key in keys:
            # It has no place beside the mask of that name.
            if key[:1] == "_" and key[1:] in keys:
                continue
            mask = np.array([key in one for one in each])
            values = [one[key] for one in each if key in one]
            found[key] = self.array_of(values, mask)
            found[f"_{key}"] = mask
        return found

    def array_of(self, values: list[Any], mask: Any) -> Any:
        forms = {(type(value), getattr(value, "dtype", None), getattr(value, "shape", None)) for value in values}
        if len(forms) == 1 and isinstance(values[0], bool | int | float | np.ndarray | np.generic):
            first = np.asarray(values[0])
            array = np.zeros((self.count, *first.shape), first.dtype)
            array[mask] = values
            return array
        each = dict(zip(np.flatnonzero(mask).tolist(), values, strict=True))
        if len(forms) == 1 and isinstance(values[0], dict):
            part = Infos(self.count)
            part.added = each
            return part.mixed()
        objects = np.full(self.count, None, object)
        for agent, value in each.items():
            objects[agent] = value
        return objects


@functools.lru_cache(200)
def dtype_of(form: bytes) -> Any:
    """The bytes of a dict of numbers and arrays, with the form before it; None for any other."""
    try:
        return dtype_in(parsed(form), len(form))
    except trees.REASONS:
        # Not one that is read at once; or none at all, which is said where it is read.
        return None


def dtype_in(told: Any, length: int) -> Any:
    parts = told.get("dict") if isinstance(told, dict) and len(told) == 1 else None
    if not isinstance(parts, dict) or not parts or not OWN.isdisjoint(parts):
        return None
    fields: list[Any] = [("", np.uint8, length + 4)]
    for key, part in parts.items():
        if not key or f"_{key}" in parts or not isinstance(part, str) or part in ("null", "text", "bytes"):
            return None
        if part in NUMBERS:
            fields.append((key, NUMBERS[part]))
            continue
        name, shape, _ = trees.array_form(part)
        if not math.prod(shape):
            return None
        fields.append((key, np.dtype(name).newbyteorder("<"), shape))
    return np.dtype(fields)
