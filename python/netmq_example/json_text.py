"""JSON from a peer nests 64 levels deep at most, in Python and in C#.

    value = json.loads(shallow(text))           ValueError says that it nests deeper

Without this limit each version of Python would refuse it at another depth. It needs only Python.
"""

import re

DEEPEST = 64
# A bracket; or a text, in which a bracket is a character like any other.
PARTS = re.compile(r'"(?:[^"\\]++|\\.)*+"?|[][{}]', re.DOTALL)


def shallow(text: str) -> str:
    """The same text; ValueError if it nests more than 64 levels deep."""
    # Most texts have fewer brackets, and cost two counts.
    if text.count("[") + text.count("{") > DEEPEST:
        depth = 0
        for part in PARTS.finditer(text):
            if part[0] in "[{":
                depth += 1
            elif part[0] in "]}":
                depth -= 1
            if depth > DEEPEST:
                raise ValueError(f"it nests more than {DEEPEST} levels deep")
    return text
