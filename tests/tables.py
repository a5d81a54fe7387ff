"""The tables of a page of the guide, for tests that run what stands in them."""

from __future__ import annotations

import re
from pathlib import Path


def rows(page: Path, *head: str) -> list[list[str]]:
    """The rows of all tables with these headings, each cell without its backquotes."""
    found = []
    for table in re.findall(r"(?:^\|.*\|\n)+", page.read_text(encoding="utf-8"), re.MULTILINE):
        first, _, *others = ([cell.strip(" ") for cell in line[1:-1].split("|")] for line in table.splitlines())
        if tuple(first) == head:
            found += [[re.sub(r"^`(.*)`$", r"\1", cell).strip() for cell in cells] for cells in others]
    assert found, f"{page.name} has no such table: {head}"
    return found
