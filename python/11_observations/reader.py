r"""Lesson 11, reading: the text of a locator, sign by sign, and at which column it is wrong.

    .key  [key]  ["key"]                    a name is ASCII letters, digits and _; any other is quoted, where a
                                            backslash stands before \ ' " n r t and uXXXX
    [0]  [-1]  [1:3]  [::2]                 numbers and slices, as Python has them
    []                                      to append
    (0, 1:3, ..., newaxis)                  an index of numpy's; np.newaxis is the same

Blanks between two signs are free.
"""

import re
from typing import Any, NoReturn

from mapping import APPEND, LocatorError, Path, Step, quoted, unquoted

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
