r"""A locator, one line of text: into whose observation a value goes, to which place, and which part of the value.

    car@.speed                     into the observation of the agent car, under the key speed, the whole value
    car@.speed = $[0]              the same, but of the value its first item alone
    @@bus@.sun & bus@.lamp(2)      one value to two places: to all agents but bus, and to bus, in an array

    parse("car@.speed").text                                  'car'@['speed'] = $
    parse(".speed", scope=parse("car@.body")).text            'car'@['body']['speed'] = $
    parse("car@.speed[")                                      LocatorError: column 12: expected a key, a number, …

`text` is the canonical text: two locators are equal if these are. The language, which is gymize's, is
described in docs/guide/11_locators.md. In C# it is Locator.cs. It needs only Python.
"""

from dataclasses import dataclass, field, replace
from typing import Any

from netmq_example.locator.reader import APPEND, Bracketed, LocatorError, Path, Reader, Step, quoted

__all__ = ["APPEND", "Locator", "LocatorError", "Mapping", "Path", "Step", "ordinal", "parse", "quoted", "spelled"]


@dataclass(frozen=True)
class Mapping:
    """One value to one place, as `parse` reads it. With neither `everyone` nor agents, the scope says whose it is."""

    everyone: bool = False
    # The observation is theirs; with `everyone`, it is that of all others.
    agents: tuple[str, ...] = ()
    # From the scope only the agents are taken, and not the path.
    root: bool = False
    destination: Path = ()
    source: Path = ()

    @property
    def absolute(self) -> bool:
        return self.everyone or bool(self.agents)

    def names(self, agent: str) -> bool:
        """Whether the value goes into the observation of this agent."""
        return (agent in self.agents) != self.everyone

    def __str__(self) -> str:
        who = "@@" * self.everyone + "@" * self.root + "".join(f"{quoted(agent)}@" for agent in self.agents)
        return f"{who}{spelled(self.destination)} = ${spelled(self.source)}"


@dataclass(frozen=True)
class Locator:
    """`parse` returns it: its mappings in the order of their canonical texts, in which they are also written."""

    text: str
    mappings: tuple[Mapping, ...] = field(compare=False)


def parse(text: str | None, name: str | None = "", scope: Locator | None = None) -> Locator:
    """The locator that a text means. `name` is the key where the text has no place at all, such as the name of a field.

    With a scope, what is relative is put there: once for each mapping of the scope. None is as an empty text.
    """
    for parameter, value in (("text", text), ("name", name)):
        if not isinstance(value, str | None):
            raise LocatorError(f"{parameter} takes a text, not {value!r:.40}")
    if not isinstance(scope, Locator | None):
        raise LocatorError(f"scope takes a Locator, as parse returns it, not {scope!r:.40}")
    reader = Reader(text or "")
    mappings: list[Mapping] = []
    while True:
        reader.skip_blanks()
        column = reader.at + 1
        mapping, could_follow = read_mapping(reader)
        if name and not mapping.absolute and not mapping.root and not mapping.destination:
            mapping = replace(mapping, destination=(name,))
        if mapping.absolute or scope is None:
            mappings.append(mapping)
        else:
            mappings += [joined(column, mapping, place) for place in scope.mappings]
        if not reader.sign("&"):
            break
    if reader.at < len(reader.text):
        reader.fail(could_follow + "'&' or the end")
    mappings.sort(key=lambda mapping: ordinal(str(mapping)))
    return Locator(" & ".join(map(str, mappings)), tuple(mappings))


def read_mapping(reader: Reader) -> tuple[Mapping, str]:
    """The mapping that stands next, and what could have continued it."""
    everyone = reader.sign("@@")
    root = not everyone and reader.sign("@")
    agents: set[str] = set()
    while not root and (agent := reader.name()) is not None:
        agents.add(agent)
        reader.expect("@", "'@' after the name of an agent")
    destination = reader.path(appends=True)
    source: Path = ()
    could_follow = steps_after(destination) + "'=', "
    if reader.sign("="):
        reader.expect("$", "'$'")
        source = reader.path(appends=False)
        could_follow = steps_after(source)
    return Mapping(everyone, tuple(sorted(agents, key=ordinal)), root, destination, source), could_follow


def steps_after(path: Path) -> str:
    if path[-1:] == (APPEND,):
        return ""
    return "'(', " if path and type(path[-1]) is tuple else "'.', '[', '(', "


def joined(column: int, mapping: Mapping, scope: Mapping) -> Mapping:
    """The mapping, put where the scope says."""
    before = () if mapping.root else scope.destination
    after = mapping.destination
    wrong = ""
    if scope.source:
        wrong = "expected a scope without a source: nothing after '$'"
    elif after and before[-1:] == (APPEND,):
        wrong = "expected nothing after the [] of the scope"
    elif after and before and type(before[-1]) is tuple is not type(after[0]):
        wrong = "expected only (…) after the (…) of the scope"
    if wrong:
        raise LocatorError(f"column {column}: {wrong}")
    root = not scope.absolute and (mapping.root or scope.root)
    return replace(mapping, everyone=scope.everyone, agents=scope.agents, root=root, destination=before + after)


# The canonical text


def spelled(path: Path) -> str:
    """The canonical text of a path: those that mean the same are spelled the same."""
    return "".join(spelled_step(step) for step in path)


def spelled_step(step: Step) -> str:
    match step:
        case str():
            return f"[{quoted(step)}]"
        case Bracketed():
            return f"[{','.join(map(spelled_item, step))}]"
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
