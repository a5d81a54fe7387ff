r"""A locator, one line of text: into whose observation a value goes, to which place, and which part of the value.

    car@.speed                     into the observation of the agent car, under the key speed, the whole value
    car@.speed = $[0]              the same, but of the value its first item alone
    @@bus@.sun & bus@.lamp(2)      one value to two places: to all agents but bus, and to bus, in an array

    parse("car@.speed").text                                  'car'@['speed'] = $
    parse(".speed", scope=parse("car@.body")).text            'car'@['body']['speed'] = $
    parse("car@.speed[")                                      LocatorError: column 12: expected a key, a number, …

`text` is the canonical text: two locators mean the same if, and only if, these are equal. The language, which is
gymize's, is described in docs/guide/11_locators.md. In C# it is Locator.cs and LocatorReader.cs. It needs only Python.
"""

import re
from dataclasses import dataclass, field, replace
from typing import Any, NoReturn

# One step of a path: a key, an index, a slice, an index of numpy's in a tuple, or APPEND.
Step = str | int | slice | tuple[Any, ...] | None
Path = tuple[Step, ...]
# One more of a sequence; nothing follows it.
APPEND = None


class LocatorError(ValueError):
    """What is wrong with a locator, in one line that says where."""


@dataclass(frozen=True)
class Mapping:
    """One value to one place, as `parse` reads it. With neither `everyone` nor agents, the scope says whose it is."""

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
        """Whether the value goes into the observation of this agent."""
        return (agent in self.agents) != self.everyone

    def __str__(self) -> str:
        who = "@@" * self.everyone + "@" * self.root + "".join(f"{quoted(agent)}@" for agent in self.agents)
        return f"{who}{spelled(self.destination)} = ${spelled(self.source)}"


@dataclass(frozen=True)
class Locator:
    """What `parse` returns: its mappings in the order of their canonical texts, in which they are also written."""

    text: str
    mappings: tuple[Mapping, ...] = field(compare=False)


def parse(text: str, name: str = "", scope: Locator | None = None) -> Locator:
    """The locator that a text means. `name` is the key where the text has no place at all, such as the name of a field.

    With a scope, what is relative is put there: once for each mapping of the scope.
    """
    for parameter, value in (("text", text), ("name", name)):
        if not isinstance(value, str):
            raise LocatorError(f"{parameter} takes a text, not {value!r:.40}")
    if not isinstance(scope, Locator | None):
        raise LocatorError(f"scope takes a Locator, as parse returns it, not {scope!r:.40}")
    reader = Reader(text)
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
    if reader.at < len(text):
        reader.fail(could_follow + "'&' or the end")
    mappings.sort(key=lambda mapping: ordinal(str(mapping)))
    return Locator(" & ".join(map(str, mappings)), tuple(mappings))


def read_mapping(reader: "Reader") -> tuple[Mapping, str]:
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
    return "'(', " if path and isinstance(path[-1], tuple) else "'.', '[', '(', "


def joined(column: int, mapping: Mapping, scope: Mapping) -> Mapping:
    """The mapping, put where the scope says."""
    before = () if mapping.root else scope.destination
    after = mapping.destination
    wrong = ""
    if not scope.absolute:
        wrong = "expected agents, such as car@, because the scope names none"
    elif scope.source:
        wrong = "expected a scope without a source: nothing after '$'"
    elif after and before[-1:] == (APPEND,):
        wrong = "expected nothing after the [] of the scope"
    elif after and before and isinstance(before[-1], tuple) and not isinstance(after[0], tuple):
        wrong = "expected only (…) after the (…) of the scope"
    if wrong:
        raise LocatorError(f"column {column}: {wrong}")
    return replace(mapping, everyone=scope.everyone, agents=scope.agents, root=False, destination=before + after)


# Reading

BLANKS = (" ", "\t", "\r", "\n")
NAME = re.compile("[A-Za-z_][A-Za-z0-9_]*")
NUMBER = re.compile(r"[+-]?[ \t\r\n]*[0-9]+")
NEWAXIS = re.compile(r"(?:np[ \t\r\n]*\.[ \t\r\n]*)?newaxis(?![A-Za-z0-9_])")
# Half a character (U+D800 to U+DFFF) is no text, neither as it stands nor as an escape.
ESCAPE = r"\\[\"'\\nrt]|\\u(?![Dd][89A-Fa-f])[0-9A-Fa-f]{4}"
INSIDE = {quote: re.compile(rf"(?:[^\\\ud800-\udfff{quote}]|{ESCAPE})*") for quote in "'\""}


class Reader:
    """Goes through a text from left to right, sign by sign. Blanks between two signs are free."""

    def __init__(self, text: str) -> None:
        self.text = text
        self.at = 0

    def skip_blanks(self) -> None:
        while self.text.startswith(BLANKS, self.at):
            self.at += 1

    def sign(self, sign: str) -> bool:
        """Goes past this sign, if it stands next, after blanks."""
        self.skip_blanks()
        if not self.text.startswith(sign, self.at):
            return False
        self.at += len(sign)
        return True

    def expect(self, sign: str, expected: str) -> None:
        """Goes past this sign, which must stand next."""
        if not self.sign(sign):
            self.fail(expected)

    def fail(self, expected: str) -> NoReturn:
        found = quoted(self.text[self.at]) if self.at < len(self.text) else "the end"
        raise LocatorError(f"column {self.at + 1}: expected {expected}, found {found}")

    def take(self, pattern: re.Pattern[str]) -> str:
        """Goes past what stands right here, if it is of this kind."""
        found = pattern.match(self.text, self.at)
        self.at = found.end() if found else self.at
        return found[0] if found else ""

    def name(self) -> str | None:
        """A bare name, or one between quotation marks, which may be empty; None if there is none."""
        for quote, inside in INSIDE.items():
            if self.sign(quote):
                text = self.take(inside)
                self.expect(quote, rf"{quote} after the name; escapes are \\ \' \" \n \r \t \uXXXX")
                return unquoted(text)
        return self.take(NAME) or None

    def number(self, never: int | None = None) -> int | None:
        self.skip_blanks()
        text = self.take(NUMBER)
        if not text:
            return None
        digits = text.lstrip("+- \t\r\n").lstrip("0") or "0"
        # One digit more than the largest has is enough to see that it is too large: Python refuses to read thousands.
        value = int(digits[:11]) * (-1 if text.startswith("-") else 1)
        if not -(2**31) <= value < 2**31 or value == never:
            self.at -= len(text)
            self.fail("a step other than 0" if value == never else "a number from -2147483648 to 2147483647")
        return value

    def range(self) -> int | slice | None:
        """1, 1:3 or 1:9:2; None if there is neither a number nor a colon."""
        start = self.number()
        if not self.sign(":"):
            return start
        stop = self.number()
        step = self.number(never=0) if self.sign(":") else None
        # Backwards, a start of 0 is not where numpy would start by itself.
        forwards = step is None or step > 0
        return slice(None if start == 0 and forwards else start, stop, None if step == 1 else step)

    def bracket(self, appends: bool) -> Step:
        """The rest of [ … ]."""
        step: Step = self.name()
        if step is None:
            step = self.range()
        if step is None:
            self.fail("a key, a number, a slice or ']'" if appends else "a key, a number, a slice")
        self.expect("]", "']'")
        return step

    def item(self) -> Any:
        """One item of an index of numpy's."""
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
                self.expect(",", "',' or ')'")
            items.append(self.item())
        return tuple(items)

    def path(self, appends: bool) -> Path:
        """As many steps as there are. Only to a place where a value is written, it can be appended."""
        steps: list[Step] = []
        while True:
            if self.sign("."):
                self.skip_blanks()
                steps.append(self.take(NAME) or self.fail("a name"))
            elif self.sign("["):
                if appends and self.sign("]"):
                    return (*steps, APPEND)
                steps.append(self.bracket(appends))
            else:
                break
        while self.sign("("):
            steps.append(self.items())
        return tuple(steps)


# The canonical text

# What would end a line, write over it, turn its direction or not be seen: in a canonical text it is escaped.
UNSEEN = re.compile(
    r"[\\'\x00-\x1f\x7f-\x9f\xad\u061c\u200b-\u200f\u2028-\u202e\u2060-\u206f\ufeff\ufff9-\ufffb\ud800-\udfff]"
)


def quoted(text: str) -> str:
    """A name as it stands in a canonical text."""
    return "'" + UNSEEN.sub(lambda m: "\\" + m[0] if m[0] in "\\'" else f"\\u{ord(m[0]):04x}", text) + "'"


def unquoted(text: str) -> str:
    """The name for what stands between two quotation marks, which is known to have no other escapes."""
    names = {"n": "\n", "r": "\r", "t": "\t"}
    return re.sub(r"\\(?:u(.{4})|(.))", lambda m: chr(int(m[1], 16)) if m[1] else names.get(m[2], m[2]), text)


def spelled(path: Path) -> str:
    """The canonical text of a path: those that mean the same are spelled the same."""
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
