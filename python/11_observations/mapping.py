"""Lesson 11, mappings: one value to one place, and the text that says so.

    step       in the canonical text
    "key"      ['key']               of a dict; ' and \\ have a backslash before them
    0          [0]                   of a tuple or a list, as Python counts: -1 is the last
    slice      [1:3]
    APPEND     []                    one more of a sequence; nothing follows it
    tuple      (0,1:3,...,np.newaxis)    of an array, as numpy indexes; only others of its kind follow it

Canonical texts are equal if, and only if, what they mean is.
"""

import re
from dataclasses import dataclass, replace
from typing import Any

APPEND = None
Step = str | int | slice | tuple[Any, ...] | None
Path = tuple[Step, ...]

# What would end a line, write over it, turn its direction or not be seen: in a canonical text it is escaped.
UNSEEN = re.compile(
    r"[\\'\x00-\x1f\x7f-\x9f\xad\u061c\u200b-\u200f\u2028-\u202e\u2060-\u206f\ufeff\ufff9-\ufffb\ud800-\udfff]"
)


class LocatorError(ValueError):
    """What is wrong with a locator, in one line that says where."""


@dataclass(frozen=True)
class Mapping:
    """One value to one place. With neither `everyone` nor agents, it is the scope that says whose observation."""

    everyone: bool = False
    # Whose observation; with `everyone`, whose not.
    agents: tuple[str, ...] = ()
    # From the scope only the agents are taken, and not the path.
    root: bool = False
    destination: Path = ()
    source: Path = ()

    @property
    def absolute(self) -> bool:
        return self.everyone or bool(self.agents)

    def names(self, agent: str) -> bool:
        return (agent in self.agents) != self.everyone

    def __str__(self) -> str:
        who = "@@" * self.everyone + "@" * self.root + "".join(f"{quoted(agent)}@" for agent in self.agents)
        return f"{who}{spelled(self.destination)} = ${spelled(self.source)}"


def joined(column: int, mapping: Mapping, scope: Mapping) -> Mapping:
    """The mapping, put where the scope says."""
    before, after = () if mapping.root else scope.destination, mapping.destination
    last, first = before[-1:], after[:1]
    wrong = ""
    if not scope.absolute:
        wrong = "expected agents, such as car@, because the scope names none"
    elif scope.source:
        wrong = "expected a scope without a source: nothing after '$'"
    elif first and last == (APPEND,):
        wrong = "expected nothing after the [] of the scope"
    elif first and any(isinstance(step, tuple) for step in last) and not isinstance(first[0], tuple):
        wrong = "expected only (…) after the (…) of the scope"
    if wrong:
        raise LocatorError(f"column {column}: {wrong}")
    return replace(mapping, everyone=scope.everyone, agents=scope.agents, root=False, destination=before + after)


def quoted(text: str) -> str:
    """A name as it stands in a canonical text."""
    return "'" + UNSEEN.sub(lambda m: "\\" + m[0] if m[0] in "\\'" else f"\\u{ord(m[0]):04x}", text) + "'"


def unquoted(text: str) -> str:
    """The name for what stands between two quotation marks, which is known to have no other escapes."""
    names = {"n": "\n", "r": "\r", "t": "\t"}
    return re.sub(r"\\(?:u(.{4})|(.))", lambda m: chr(int(m[1], 16)) if m[1] else names.get(m[2], m[2]), text)


def spelled(path: Path) -> str:
    """The canonical text: paths that mean the same are spelled the same."""
    return "".join(spelled_step(step) for step in path)


def spelled_step(step: Step) -> str:
    match step:
        case str():
            return f"[{quoted(step)}]"
        case tuple():
            return f"({','.join(map(spelled_item, step))})"
    return "[]" if step is APPEND else f"[{spelled_item(step)}]"


def spelled_item(item: Any) -> str:
    if isinstance(item, slice):
        start, stop = ("" if end is None else end for end in (item.start, item.stop))
        return f"{start}:{stop}" + (f":{item.step}" if item.step else "")
    return {None: "np.newaxis", ...: "..."}.get(item, str(item))


def ordinal(text: str) -> bytes:
    """Sorts as C# does by StringComparer.Ordinal: the same on every machine, whatever its language."""
    return text.encode("utf-16-be", "surrogatepass")
