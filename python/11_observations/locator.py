"""Lesson 11, locators: where in whose observation a value goes, and which part of the value, as one line of text.

    car@.speed                     into the observation of the agent car, under the key speed, the whole value
    car@.speed = $[0]              the same, but of the value its first item alone
    @@bus@.sun & bus@.lamp(2)      one value to two places: to all agents but bus, and to bus, in an array

    python python/11_observations/locator.py "car@.speed"          prints: 'car'@['speed'] = $
    python python/11_observations/locator.py --scope "car@.body" ".speed"    'car'@['body']['speed'] = $
    python python/11_observations/locator.py "car@.speed["         says at which column what was expected; exit code 2

What is printed is the canonical text: two locators are equal if these are. The guide has the whole language, in
docs/guide/11_locators.md; the C# side is Locator.cs.
"""

import argparse
import sys
from dataclasses import dataclass, field, replace

from mapping import APPEND, LocatorError, Mapping, Path, joined, ordinal
from reader import Reader


@dataclass(frozen=True)
class Locator:
    """Its mappings in the order of their canonical texts, in which they are also written."""

    text: str
    mappings: tuple[Mapping, ...] = field(compare=False)

    @property
    def absolute(self) -> bool:
        """Whether it says whose observation is meant; what is not absolute can not be written anywhere."""
        return all(mapping.absolute for mapping in self.mappings)


def parse(text: str, name: str = "", scope: Locator | None = None) -> Locator:
    """The locator that a text means. `name` is the key where the text has no place at all, such as the name of a field.

    With a scope, what is relative is put there: once for each mapping of the scope.
    """
    reader, mappings = Reader(text), list[Mapping]()
    while True:
        reader.sign("")
        column, (mapping, more) = reader.at + 1, read(reader)
        if name and not mapping.absolute and not mapping.root and not mapping.destination:
            mapping = replace(mapping, destination=(name,))
        if mapping.absolute or scope is None:
            mappings.append(mapping)
        else:
            mappings += [joined(column, mapping, place) for place in scope.mappings]
        if not reader.sign("&"):
            break
    if reader.at < len(text):
        reader.fail(more + "'&' or the end")
    mappings.sort(key=lambda mapping: ordinal(str(mapping)))
    return Locator(" & ".join(map(str, mappings)), tuple(mappings))


def read(reader: Reader) -> tuple[Mapping, str]:
    """The mapping that stands next, and what could have continued it."""
    everyone, agents = reader.sign("@@"), set[str]()
    root = not everyone and reader.sign("@")
    while not root and (agent := reader.name()) is not None:
        agents.add(agent)
        reader.sign("@", "'@' after the name of an agent")
    destination, source = reader.path(appends=True), Path()
    more = after(destination) + "'=', "
    if reader.sign("="):
        reader.sign("$", "'$'")
        source = reader.path(appends=False)
        more = after(source)
    return Mapping(everyone, tuple(sorted(agents, key=ordinal)), root, destination, source), more


def after(path: Path) -> str:
    if path[-1:] == (APPEND,):
        return ""
    return "'(', " if path and isinstance(path[-1], tuple) else "'.', '[', '(', "


def main() -> None:
    # In a pipe Windows would use another encoding, and a character that it lacks would end the program.
    sys.stdout.reconfigure(encoding="utf-8", errors="replace")  # type: ignore[union-attr]
    parser = argparse.ArgumentParser(description="Prints the canonical text of a locator.", add_help=False)
    parser.add_argument("--help", action="help", help="show this")
    parser.add_argument("--scope", help="where a relative locator is put, such as car@.body")
    parser.add_argument("--name", default="", help="the key of a locator without any place")
    parser.add_argument("text", nargs="?", help="the locator, such as .speed")
    options, others = parser.parse_known_args()
    # A text that begins with - is taken for an option that nobody knows.
    texts = others if options.text is None else [options.text, *others]
    if len(texts) != 1:
        parser.error("one locator, in quotes, such as: locator.py '.speed'")
    where = "scope, "
    try:
        scope = None if options.scope is None else parse(options.scope)
        where = ""
        print(parse(texts[0], options.name, scope).text)
    except LocatorError as error:
        print(f"{where}{error}", file=sys.stderr)
        sys.exit(2)


if __name__ == "__main__":
    main()
