r"""Lesson 11, locators: where in whose observation a value goes, and which part of the value, as one line of text.

    car@.speed                     into the observation of the agent car, under the key speed, the whole value
    car@.speed = $[0]              the same, but of the value its first item alone
    @@bus@.sun & bus@.lamp(2)      one value to two places: to all agents but bus, and to bus, in an array

    python python/11_observations/locator.py "car@.speed"          prints: 'car'@['speed'] = $
    python python/11_observations/locator.py --scope "car@.body" ".speed"    'car'@['body']['speed'] = $
    python python/11_observations/locator.py "car@.speed["         says at which column what was expected; exit code 2

What is printed is the canonical text: two locators are equal if these are. The guide has the whole language, in
docs/guide/11_locators.md; the C# side is Locator.cs.

Lesson 11, mappings: one value to one place, and the text that says so.

    step       in the canonical text
    "key"      ['key']               of a dict; ' and \ have a backslash before them
    0          [0]                   of a tuple or a list, as Python counts: -1 is the last
    slice      [1:3]
    APPEND     []                    one more of a sequence; nothing follows it
    tuple      (0,1:3,...,np.newaxis)    of an array, as numpy indexes; only others of its kind follow it

Canonical texts are equal if, and only if, what they mean is.

Lesson 11, reading: the text of a locator, sign by sign, and at which column it is wrong.

    .key  [key]  ["key"]                    a name is ASCII letters, digits and _; any other is quoted, where a
                                            backslash stands before \ ' " n r t and uXXXX
    [0]  [-1]  [1:3]  [::2]                 numbers and slices, as Python has them
    []                                      to append
    (0, 1:3, ..., newaxis)                  an index of numpy's; np.newaxis is the same

Blanks between two signs are free.
"""

import argparse
import re
import sys
from dataclasses import dataclass, field, replace
from typing import Any, NoReturn

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


BLANKS = (" ", "\t", "\r", "\n")
NAME = re.compile("[A-Za-z_][A-Za-z0-9_]*")
NUMBER = re.compile(r"[+-]?[ \t\r\n]*[0-9]+")
NEWAXIS = re.compile(r"(?:np[ \t\r\n]*\.[ \t\r\n]*)?newaxis(?![A-Za-z0-9_])")
# Half a character (U+D800 to U+DFFF) is no text, neither as it stands nor as an escape.
ESCAPE = r"\\[\"'\\nrt]|\\u(?![Dd][89A-Fa-f])[0-9A-Fa-f]{4}"
INSIDE = {quote: re.compile(rf"(?:[^\\\ud800-\udfff{quote}]|{ESCAPE})*") for quote in "'\""}


class Reader:
    """Goes through a text from left to right."""

    def __init__(self, text: str) -> None:
        self.text, self.at = text, 0

    def sign(self, sign: str, expected: str = "") -> bool:
        """Goes past this sign, if it stands next, after blanks. With `expected` it must stand there."""
        while self.text.startswith(BLANKS, self.at):
            self.at += 1
        found = self.text.startswith(sign, self.at)
        self.at += len(sign) * found
        return found or (self.fail(expected) if expected else False)

    def fail(self, expected: str) -> NoReturn:
        found = quoted(self.text[self.at]) if self.at < len(self.text) else "the end"
        raise LocatorError(f"column {self.at + 1}: expected {expected}, found {found}")

    def take(self, pattern: re.Pattern[str]) -> str:
        """Goes past what stands right here, if it is of this kind."""
        found = pattern.match(self.text, self.at)
        self.at = found.end() if found else self.at
        return found[0] if found else ""

    def name(self) -> str | None:
        for quote, inside in INSIDE.items():
            if self.sign(quote):
                text = self.take(inside)
                self.sign(quote, rf"{quote} after the name; escapes are \\ \' \" \n \r \t \uXXXX")
                return unquoted(text)
        return self.take(NAME) or None

    def number(self, never: int | None = None) -> int | None:
        self.sign("")
        before, text = self.at, self.take(NUMBER)
        # Ten digits and one more: Python refuses to read thousands of them.
        value = int(text[:1].strip("+0123456789") + (text.strip("+- \t\r\n").lstrip("0")[:11] or "0"))
        if not -(2**31) <= value < 2**31 or (text and value == never):
            self.at = before
            self.fail("a step other than 0" if value == never else "a number from -2147483648 to 2147483647")
        return value if text else None

    def range(self) -> int | slice | None:
        """1, 1:3 or 1:9:2; nothing if there is neither a number nor a colon."""
        start = self.number()
        if not self.sign(":"):
            return start
        stop, step = self.number(), self.number(never=0) if self.sign(":") else None
        # Backwards, a start of 0 is not where numpy would start by itself.
        return slice(None if start == 0 and (step or 1) > 0 else start, stop, None if step == 1 else step)

    def bracket(self, appends: bool) -> Step:
        """The rest of [ … ]."""
        step: Step = self.name()
        if step is None and (step := self.range()) is None:
            self.fail("a key, a number, a slice" + " or ']'" * appends)
        self.sign("]", "']'")
        return step

    def item(self) -> Any:
        if self.sign("..."):
            return Ellipsis
        if self.take(NEWAXIS):
            return None
        item = self.range()
        return item if item is not None else self.fail("a number, a slice, ... or newaxis")

    def items(self) -> tuple[Any, ...]:
        """The rest of ( … )."""
        items: list[Any] = []
        while not self.sign(")"):
            if items:
                self.sign(",", "',' or ')'")
            items.append(self.item())
        return tuple(items)

    def path(self, appends: bool) -> Path:
        """As many steps as there are. Only to a place where a value is written, it can be appended."""
        steps: list[Step] = []
        while (dot := self.sign(".")) or self.sign("["):
            if appends and not dot and self.sign("]"):
                return (*steps, APPEND)
            self.sign("")
            steps.append(self.take(NAME) or self.fail("a name") if dot else self.bracket(appends))
        while self.sign("("):
            steps.append(self.items())
        return tuple(steps)


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
