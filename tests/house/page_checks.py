"""What must hold for a page of the guide, as functions of its text: each returns the faults that it found."""

from __future__ import annotations

import os
import re
from html import unescape
from pathlib import Path

from kitlib.docs import guide
from kitlib.lessons import lessons
from tests.programs import ROOT

LESSONS = {lesson.key for lesson in lessons()}
KINDS = {"excerpt", "bench", "run", "like", "commands", "diagram", "by hand"}
LANGUAGES = {".py": "python", ".cs": "csharp"}
SECTIONS = (
    "Run it",
    "What you see",
    "How it works",
    "Break it on purpose",
    "In Unity",
    "Check yourself",
    "Next",
)
# What PowerShell 5.1, cmd, bash and zsh all take as it stands: programs, words, and text in double quotes.
PROGRAMS = ("python3", "python", "dotnet", "git", "cd")
WORD = r"[\w./:=,-]"
PLAIN = rf"(?!\./){WORD}+(?: (?:{WORD}|\"[^\"$`%!\\~]*\")+)*"
SHELLS = r"for (bash|zsh|cmd|PowerShell)\b.*:"

# What the pages need of Mermaid, which ends a statement at a semicolon and takes `#name;` for a character.
TEXT = r"(?:[^;#]|#\w+;)+"
STATEMENTS = (
    rf"participant (?P<declared>\w+)(?: as {TEXT})?",
    rf"(?P<from>\w+?)(?:->>|--x)(?P<to>\w+): {TEXT}",
    rf"Note over (?P<over>\w+)(?:,(?P<and>\w+))?: {TEXT}",
    rf"(?P<opens>alt) {TEXT}",
    rf"(?P<goes_on>else) {TEXT}",
    r"(?P<ends>end)",
)


def block_faults(block: guide.Block) -> list[str]:
    """Every block says where it comes from, in the language of that place."""
    if block.kind not in KINDS:
        return [f"{block.where}: put a comment above it that says where it comes from, see kitlib/docs/guide.py"]
    faults = []
    if block.kind == "by hand" and not block.source:
        faults.append(f"{block.where}: say why it is by hand")
    if (block.kind == "diagram") != (block.language == "mermaid"):
        faults.append(f"{block.where}: `<!-- diagram -->` and ```mermaid belong together")
    if block.kind == "excerpt" and block.language != LANGUAGES[Path(block.source.split()[0]).suffix]:
        faults.append(f"{block.where}: an excerpt of this file is not {block.language or 'plain text'}")
    if block.kind in ("run", "like", "commands") and block.language:
        faults.append(f"{block.where}: what is printed or typed has no language")
    return faults


def shell_faults(block: guide.Block) -> list[str]:
    """Lines to type that some shell would read in another way; a block that says for which shell it is, may."""
    lines = block.body.splitlines()
    begins = (*PROGRAMS, "export ", "set ", "$env:")
    typed = block.kind == "commands" or (not block.language and lines and lines[0].startswith(begins))
    if not typed or re.match(SHELLS, block.source):
        return []
    return [
        f"{block.where}: not for every shell: {line}"
        for line in lines
        if line and not (line.startswith(PROGRAMS) and re.fullmatch(PLAIN, line))
    ]


def stray_blocks(page: Path, text: str) -> list[str]:
    """A fence that kitlib.guide does not see, because it is indented or written another way, is checked by nobody."""
    rest = guide.BLOCK.sub("", text)
    return [f"{page.name}: {line.strip()}" for line in rest.splitlines() if re.match(r"\s*(```|~~~|<pre)", line)]


def diagram_faults(body: str) -> list[str]:
    """The statements of a sequence diagram that Mermaid would not draw, or draws with a participant made up."""
    first, *lines = [line.strip() for line in body.splitlines() if line.strip()] or [""]
    faults = [] if first == "sequenceDiagram" else ["its first line is not sequenceDiagram"]
    declared: set[str] = set()
    used: set[str] = set()
    depth = 0
    for line in lines:
        found = next((match for form in STATEMENTS if (match := re.fullmatch(form, line))), None)
        if not found:
            faults.append(f"not a statement: {line}")
            continue
        names = found.groupdict()
        if "declared" in names:
            declared.add(names["declared"])
        used |= {names[key] for key in ("from", "to", "over", "and") if names.get(key)}
        depth += ("opens" in names) - ("ends" in names)
        if depth < 0 or ("goes_on" in names and depth == 0):
            faults.append(f"outside of any block: {line}")
    if depth > 0:
        faults.append("a block has no end")
    faults += [f"not declared: {name}" for name in sorted(used - declared)]
    faults += [f"declared and never used: {name}" for name in sorted(declared - used)]
    return faults


def prose(text: str) -> str:
    """The page without its code, where brackets and hashes mean something else."""
    return re.sub(r"(`+)(?!`).+?\1", "", re.sub(r"^```.*?^```$", "", text, flags=re.DOTALL | re.MULTILINE))


def anchors(text: str) -> set[str]:
    """The names of a page's headings, as GitHub makes them."""
    found: set[str] = set()
    plain = re.sub(r"^```.*?^```$", "", text, flags=re.DOTALL | re.MULTILINE)
    for title in re.findall(r"^#{1,6} +(.*?) *$", plain, re.MULTILINE):
        shown = unescape(re.sub(r"<[^>]+>", "", re.sub(r"!?\[([^\]]*)\]\([^)]*\)", r"\1", title)))
        name = once = re.sub(r"[^\w\- ]", "", shown.lower()).replace(" ", "-")
        number = 0
        while name in found:
            number += 1
            name = f"{once}-{number}"
        found.add(name)
    return found | set(re.findall(r"<a (?:id|name)=\"([^\"]+)\"", text))


def targets(text: str) -> list[str]:
    """Where the links and pictures of a page lead to, in markdown and in HTML."""
    text = prose(text)
    found = re.findall(r"\]\(<?([^)\s>]*)>?(?: +\"[^\"]*\")?\)", text)
    found += re.findall(r"^ *\[[^\]]+\]: +(\S+)", text, re.MULTILINE)
    found += re.findall(r"<(?:a|img)\b[^>]*?\b(?:href|src)=\"([^\"]*)\"", text)
    for srcset in re.findall(r"<(?:source|img)\b[^>]*?\bsrcset=\"([^\"]*)\"", text):
        found += [one.split()[0] for one in srcset.split(",")]
    return found


def exactly_there(path: Path) -> bool:
    """True if it exists in the repository in this very spelling; a Mac or Windows is less exact than GitHub."""
    path = Path(os.path.normpath(path))
    if path != ROOT and ROOT not in path.parents:
        return False
    while path != ROOT:
        if not path.parent.is_dir() or path.name not in os.listdir(path.parent):
            return False
        path = path.parent
    return True


def link_faults(page: Path, text: str) -> list[str]:
    """Links that lead nowhere, and pictures without a word for who cannot see them."""
    faults = []
    for target in targets(text):
        if re.match(r"https?://[^/\s]+\.\w+", target) or target.startswith("mailto:"):
            continue
        path, _, anchor = target.partition("#")
        file = page.parent / path if path else page
        if not target or not exactly_there(file):
            faults.append(f"{page.name}: there is no {target}")
        elif anchor and file.suffix == ".md":
            there = text if not path else file.read_text(encoding="utf-8")
            if anchor not in anchors(there):
                faults.append(f"{page.name}: there is no such heading: {target}")
    for image in re.findall(r"!\[\]\([^)]*\)|<img\b(?![^>]*\balt=\"[^\"]+\")[^>]*>", prose(text)):
        faults.append(f"{page.name}: say in words what is to be seen in {image}")
    return faults


def sections(text: str) -> list[tuple[str, str]]:
    """The `##` headings of a page, each with what stands under it."""
    # A comment in a program is no heading.
    plain = re.sub(r"^```.*?^```$", "code", text, flags=re.DOTALL | re.MULTILINE)
    parts = re.split(r"^## +(.*?) *$", plain, flags=re.MULTILINE)
    return list(zip(parts[1::2], parts[2::2], strict=True))


def structure_faults(page: Path, text: str) -> list[str]:
    """A page of the guide has these sections in this order, none of them empty, and leads on to another page.

    Pure reference has nothing to ask: it is no lesson's, and needs Next alone.
    """
    faults = []
    opening = text.partition("\n## ")[0]
    if not opening.startswith("# "):
        faults.append(f"{page.name}: it begins with no title")
    if "\n**You will learn** " not in opening:
        faults.append(f"{page.name}: `**You will learn** …` belongs before the first section")
    found = sections(text)
    asks = "Check yourself" in dict(found) or page.stem in LESSONS
    wanted = list(SECTIONS) if asks else ["Next"]
    if [title for title, _ in found if title in wanted] != wanted:
        faults.append(f"{page.name}: the sections must be, once each and in this order: {', '.join(wanted)}")
    faults += [f"{page.name}: nothing under {title}" for title, body in found if not body.strip()]
    under = dict(found)
    if not [target for target in targets(under.get("Next", "")) if target.partition("#")[0].endswith(".md")]:
        faults.append(f"{page.name}: Next names no page")
    if asks:
        asked = under.get("Check yourself", "")
        # The blank lines are what makes GitHub read the answer as markdown.
        folded = r"\n   <details><summary>Answer</summary>\n\n   [^<]+\n\n   </details>(?:\n|$)"
        questions = re.findall(rf"^(\d+)\. \*[^*]+\?\*{folded}", asked, re.MULTILINE)
        if len(questions) < 2 or questions != re.findall(r"^(\d+)\. ", asked, re.MULTILINE):
            faults.append(f"{page.name}: Check yourself needs questions like `1. *Why?*`, each with its answer folded")
    return faults
