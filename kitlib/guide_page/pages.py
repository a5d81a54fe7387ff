"""The pages of the guide as HTML: what can be done with each block, what they link to, what a search finds."""

import json
import re
from collections.abc import Collection, Iterable
from functools import cache
from html import escape
from itertools import takewhile
from pathlib import Path
from typing import Any

from markdown_it import MarkdownIt
from markdown_it.token import Token
from pygments import highlight
from pygments.formatters import HtmlFormatter
from pygments.lexers import TextLexer, find_lexer_class_for_filename, get_lexer_by_name

from kitlib.docs import guide
from kitlib.guide_page import answers, runs
from kitlib.guide_page.diagrams import table
from kitlib.lessons import ROOT, find, lessons

HERE = Path(__file__).parent
ANSWER = re.compile(r"<details><summary>Answer.*?</details>", re.DOTALL)


def fence(_: Any, tokens: list[Token], at: int, __: Any, env: dict[str, Any]) -> str:
    """A block as it stands, with what can be done with it."""
    number, block = next(env["blocks"])
    if block.kind == "diagram":
        return table(block.body)
    lexer = get_lexer_by_name(block.language or "text", stripnl=False)
    shown = f'<pre class="code"><code>{highlight(block.body, lexer, HtmlFormatter(nowrap=True))}</code></pre>'
    if block.kind == "excerpt":
        path, _, name = block.source.partition(" ")
        own = path.endswith("/server.py") and re.search(r"Your own \w+ goes here", block.body)
        more = editor(Path(path).parent.name) if own else ""
        return f'<div data-file="{path}?name={name}">{shown}</div>{more}'
    if not (steps := runs.steps(block)):
        return shown
    # Only ZeroMQ has arrows.
    arrows = len(steps) == 1 and steps[0][0] == "run" and find(steps[0][1]).scheme == "tcp"
    tools = "<button>Run</button>" + '<button value="watch">Run with arrows</button>' * arrows
    for place, (name, value) in enumerate(runs.fields(block)):
        tools += f'<label>{name} <input name="{place}" size="9" value="{escape(value)}"></label>'
    about = f'data-block="{number}" data-steps="{" ".join(words[0] for words in steps)}"'
    return f'<div class="run" {about}>{shown}<form class="tools">{tools}</form></div>'


def editor(key: str) -> str:
    """The place where a reader changes a lesson's server."""
    found = answers.exercises().get(key)
    check = found.check if found else []
    about = f"<p><b>Your turn.</b> {MARKDOWN.renderInline(found.text)}</p>" if found else ""
    tools = '<button value="save">Edit</button>' + '<button value="check">Check</button>' * bool(check)
    value = escape("".join(check[:1]))
    tools += f'<label class="late">options of the client <input name="options" size="28" value="{value}"></label>'
    tools += '<button value="again" class="late">Start again from the kit\'s</button>'
    text = '<small></small><div class="late text"><div></div><textarea spellcheck="false" wrap="off"></textarea></div>'
    shown = f'<p class="tools">{tools}</p><p class="mistake verdict bad"></p>{text}'
    return f'<form class="own" data-lesson="{key}">{about}{shown}</form>'


def html(_: Any, tokens: list[Token], at: int, *__: Any) -> str:
    """As the page has it, but for comments: they name tests."""
    return re.sub(r"<!--.*?-->\n?", "", tokens[at].content, flags=re.DOTALL)


MARKDOWN = MarkdownIt("commonmark", {"html": True}).enable("table")
for kind, rule in {"fence": fence, "html_block": html, "html_inline": html}.items():
    MARKDOWN.add_render_rule(kind, rule)


def tokens_of(path: Path) -> list[Token]:
    """Markdown-it's tokens of a page, with an id for each heading, as GitHub has it, and for each text of an error."""
    tokens = MARKDOWN.parse(path.read_text(encoding="utf-8"))
    for at, token in enumerate(tokens):
        if token.type == "heading_open":
            token.attrSet("id", re.sub(r"[^\w\- ]", "", plain(tokens[at + 1]).lower()).replace(" ", "-"))
        elif token.type == "list_item_open" and path.stem == "troubleshooting":
            token.attrSet("id", f"error-{at}")
        for child in token.children or ():
            child.content = re.sub(r"^\[ \] ", "☐ ", child.content)
    return tokens


def plain(token: Token) -> str:
    """The text of its first line."""
    return "".join(child.content for child in takewhile(lambda each: each.type != "hardbreak", token.children or ()))


@cache
def title(path: Path) -> str:
    return plain(next(token for token in tokens_of(path) if token.type == "inline"))


def rendered(path: Path) -> str:
    return str(MARKDOWN.renderer.render(tokens_of(path), MARKDOWN.options, {"blocks": enumerate(guide.blocks(path))}))


@cache
def search() -> str:
    """Each title and each text of an error, where it is, and the title of the page, as JSON."""
    found = []
    for path in guide.pages():
        tokens = tokens_of(path)
        for at, token in enumerate(tokens):
            if token.attrGet("id"):
                said = plain(next(each for each in tokens[at:] if each.type == "inline"))
                found.append([said, f"{path.relative_to(ROOT).as_posix()}#{token.attrGet('id')}", title(path)])
    return json.dumps(found)


@cache
def known() -> set[Path]:
    """All files that the guide shows: its pages, what these link to, and what lies in a folder that they link to."""
    found = {*guide.pages(), *ROOT.glob("*.md"), *HERE.glob("page.*")}
    for page in [path for path in found if path.suffix == ".md"]:
        for target in re.findall(r'(?:href|src|srcset|data-file)="([^"#?]+)', rendered(page)):
            for file in {(folder / target).resolve() for folder in (ROOT, page.parent)}:
                if ROOT in file.parents and file.exists():
                    found |= {file, *(file.iterdir() if file.is_dir() else ())}
    return found


def side(base: str, done: Collection[str]) -> str:
    """The lessons by number, each with a word for its path from the title of the map; and the pages around them."""
    on_map = (ROOT / "img" / "lessons.svg").read_text(encoding="utf-8")
    found = re.findall(r"[:;] (?:a |what happens )?(\w+)[^;:]*?, lessons ([\d, ]+)", on_map)
    paths = {number: path for path, numbers in found for number in numbers.split(", ")}
    first = ["start_here", *(lesson.key for lesson in lessons())]
    rest = {page.stem for page in guide.pages()[1:]}.difference(first)

    def links(names: Iterable[str]) -> str:
        shown = ""
        for name in names:
            label = re.sub(r"^\w+ (\d+):", r"\1", title(ROOT / "docs" / "guide" / f"{name}.md"))
            path = paths.get(name.partition("_")[0], "")
            more = f'<small title="the path: see the end of Start here">{path}</small>' + "<b>✓</b>" * (name in done)
            shown += f'<a href="{base}docs/guide/{name}.md">{escape(label)} {more}</a>'
        return shown

    return f"{links(first)}<h2>around the lessons</h2>{links(sorted(rest))}"


def page(path: Path, base: str, name: str, answers: bool) -> tuple[str, str]:
    """The title of a file or folder of the kit, and it as HTML; a file's lines are numbered, `name` is marked."""
    heading = path.relative_to(ROOT).as_posix()
    if path.suffix == ".md":
        body = rendered(path)
        return title(path), body if answers else re.sub(ANSWER, "", body)
    if path.is_dir():
        names = (file.name for file in sorted(path.iterdir()) if file.suffix != ".meta")
        body = "".join(f'<p><a href="{base}{heading}/{name}">{name}</a></p>' for name in names)
    else:
        text = path.read_text(encoding="utf-8")
        find = {".py": guide.python_lines, ".cs": guide.csharp_lines}.get(path.suffix) if name else None
        marked = [line + 1 for line in (find and find(text, name)) or ()]
        lexer = (find_lexer_class_for_filename(path.name) or TextLexer)(stripnl=False)
        body = highlight(text, lexer, HtmlFormatter(linenos="inline", hl_lines=marked, cssclass="code"))
    return heading, f"<h1>{escape(heading)}</h1>{body}"


def class_list(folder: Path, base: str, done: Collection[str]) -> tuple[str, str]:
    """The exercises, each with a tick."""
    rows = "<tr><th>done</th><th>lesson</th><th>exercise</th></tr>"
    for key in answers.exercises():
        tick = f'<input type="checkbox" aria-label="done" data-tick="{key}"{" checked" * (key in done)}>'
        # The texts stand in a page of docs/guide.
        own = re.sub(r'href="(?!\w+:)', f'href="{base}docs/guide/', editor(key))
        link = f'<a href="{base}docs/guide/{key}.md">{key[:2]}</a>'
        rows += f"<tr><td>{tick}</td><td>{link}</td><td>{own}</td></tr>"
    about = f"<h1>Exercises</h1><p>It is kept in {escape(str(folder / answers.TICKS))}.</p>"
    return "Exercises", f"{about}<table>{rows}</table>"


def whole(heading: str, body: str, base: str, done: Collection[str]) -> str:
    made = (HERE / "page.html").read_text(encoding="utf-8")
    return made.format(title=escape(heading), side=side(base, done), body=body, base=base)
