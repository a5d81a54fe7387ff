r"""Reads the text of a locator sign by sign, and says at which column it is wrong.

    .key  [key]  ["key"]                    a name is ASCII letters, digits and _; any other is quoted, with the
                                            escapes of .NET's regular expressions
    [0]  [-1]  [1:3]  [::2]                 numbers and slices, as Python has them
    []                                      to append; after $ it is the whole
    (0, 1:3, ..., newaxis)                  an index of numpy's; np.newaxis is the same
    [0, 1:3, ..., np.newaxis]               the same; newaxis alone is a key

Blanks between two signs are free. In C# it is LocatorReader.cs. It needs only Python.
"""

import re
from typing import Any, NoReturn

# One step of a path: a key, an index, a slice, an index of numpy's in a tuple, or APPEND.
Step = str | int | slice | tuple[Any, ...] | None
Path = tuple[Step, ...]
# One more of a sequence; nothing follows it.
APPEND = None


class Bracketed(tuple[Any, ...]):
    """An index of numpy's that stands in [ ]: unlike after ( ), whatever step may follow."""

    __slots__ = ()


class LocatorError(ValueError):
    """What is wrong with a locator, in one line that says where."""


# These are .NET's blanks: Python's \s is more.
BLANKS = r"[\t-\r \x85\xa0\u1680\u2000-\u200a\u2028\u2029\u202f\u205f\u3000]*"
BLANK = re.compile(BLANKS)
NAME = re.compile("[A-Za-z_][A-Za-z0-9_]*")
NUMBER = re.compile(rf"[+-]?{BLANKS}[0-9]+")
NEWAXIS = re.compile(rf"(?:np{BLANKS}\.{BLANKS})?newaxis(?![A-Za-z0-9_])")
# What is no key in brackets, although a name begins it.
NO_KEY = re.compile(rf"np{BLANKS}\.|newaxis{BLANKS},")
# As in .NET's regular expressions. Half a character (U+D800 to U+DFFF) is no text, neither as it stands nor escaped.
HEX = "[0-9A-Fa-f]"
ESCAPE = (
    rf"\\[ -/:-@\[-^`{{-~abefnrtv]|\\x{HEX}{{2}}|\\c[@-\[\]^_a-z]|\\[0-7]{{1,3}}|\\u(?![Dd][89A-Fa-f]){HEX}{{4}}"
    rf"|\\u[Dd][89ABab]{HEX}{{2}}\\u[Dd][C-Fc-f]{HEX}{{2}}"
)
INSIDE = {quote: re.compile(rf"(?:[^\\\ud800-\udfff{quote}]|{ESCAPE})*") for quote in "'\""}
ITEM = "a number, a slice, ... or newaxis"


class Reader:
    """Goes through a text from left to right, sign by sign. Blanks between two signs are free."""

    def __init__(self, text: str) -> None:
        self.text = text
        self.at = 0

    def skip_blanks(self) -> None:
        self.take(BLANK)

    def sign(self, sign: str) -> bool:
        self.skip_blanks()
        if not self.text.startswith(sign, self.at):
            return False
        self.at += len(sign)
        return True

    def expect(self, sign: str, expected: str) -> None:
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
                self.expect(quote, rf"{quote} after the name; escapes are such as \\ \' \" \n \uXXXX")
                return unquoted(text)
        return self.take(NAME) or None

    def number(self, never: int | None = None) -> int | None:
        self.skip_blanks()
        text = self.take(NUMBER)
        if not text:
            return None
        digits = text.lstrip("+-").lstrip().lstrip("0") or "0"
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

    def bracket(self) -> Step:
        """The rest of [ … ]; APPEND if nothing is in it."""
        self.skip_blanks()
        key = None if NO_KEY.match(self.text, self.at) else self.name()
        if key is not None:
            self.expect("]", "']'")
            return key
        items = self.items("]", "a key, a number, a slice, ... or ']'")
        if not items:
            return APPEND
        # A number or a slice alone is for lists, too.
        return items[0] if len(items) == 1 and isinstance(items[0], int | slice) else Bracketed(items)

    def items(self, end: str, first: str = ITEM) -> tuple[Any, ...]:
        """An index of numpy's up to its end; a comma may stand before that."""
        items: list[Any] = []
        while not self.sign(end):
            if items:
                self.expect(",", f"',' or '{end}'")
                if self.sign(end):
                    break
            items.append(self.item(ITEM if items else first))
        return tuple(items)

    def item(self, expected: str) -> Any:
        if self.sign("..."):
            return Ellipsis
        if self.take(NEWAXIS):
            return None
        item = self.range()
        return item if item is not None else self.fail(expected)

    def path(self, appends: bool) -> Path:
        """As many steps as there are. Where a value is written, [] appends; else it is the whole of what is there."""
        steps: list[Step] = []
        while True:
            if self.sign("."):
                self.skip_blanks()
                steps.append(self.take(NAME) or self.fail("a name"))
            elif self.sign("["):
                step = self.bracket()
                if step is not APPEND:
                    steps.append(step)
                elif appends:
                    return (*steps, APPEND)
            else:
                break
        while self.sign("("):
            steps.append(self.items(")"))
        return tuple(steps)


# Names

# A canonical text escapes each character that would end a line, write over it, turn its direction or not be seen.
UNSEEN = re.compile(
    r"[\\'\x00-\x1f\x7f-\x9f\xad\u061c\u200b-\u200f\u2028-\u202e\u2060-\u206f\ufeff\ufff9-\ufffb\ud800-\udfff]"
)


def quoted(text: str) -> str:
    return "'" + UNSEEN.sub(lambda m: "\\" + m[0] if m[0] in "\\'" else f"\\u{ord(m[0]):04x}", text) + "'"


def unquoted(text: str) -> str:
    """The name for what stands between two quotation marks, which is known to have no other escapes."""
    text = re.sub(r"\\(?:u(.{4})|x(..)|c(.)|([0-7]{1,3})|(.))", unescaped, text)
    # Two escaped halves are one character.
    return text.encode("utf-16-be", "surrogatepass").decode("utf-16-be")


def unescaped(found: re.Match[str]) -> str:
    unicode, code, control, octal, letter = found.groups()
    if unicode or code:
        return chr(int(unicode or code, 16))
    if control:
        return chr(ord(control.upper()) - 64)
    if octal:
        return chr(int(octal, 8) % 256)
    return dict(zip("abefnrtv", "\a\b\x1b\f\n\r\t\v", strict=True)).get(letter, letter)
