"""The pages of the guide as HTML: what they link to, and what a search finds in them."""

import json
import re
from functools import cache
from html import escape
from itertools import takewhile
from pathlib import Path
from string import Template
from typing import Any
from urllib.parse import unquote

from markdown_it import MarkdownIt
from markdown_it.token import Token
from pygments import highlight
from pygments.formatters import HtmlFormatter
from pygments.lexers import get_lexer_by_name, get_lexer_for_filename
from pygments.util import ClassNotFound

from kitlib.docs import guide
from kitlib.guide_page import answers, diagrams, runs
from kitlib.lessons import ROOT, lessons

HERE = Path(__file__).parent
GUIDE = ROOT / "docs" / "guide"
MAP = ROOT / "img" / "lessons.svg"
# Each item of its lists begins with the text of an error.
ERRORS = GUIDE / "troubleshooting.md"


def fence(_: Any, tokens: list[Token], at: int, __: Any, env: dict[str, Any]) -> str:
    """A block as it stands, with what can be done with it."""
    number, block = next(env["blocks"])
    if block.kind == "diagram":
        return diagrams.svg(block.body)
    code = coloured(block.body, block.language) if block.language else escape(block.body)
    shown = f'<pre class="code"><code>{code}</code></pre>\n'
    if block.kind == "excerpt":
        path, _, name = block.source.partition(" ")
        own = re.search(r"Your own \w+ goes here", block.body) and path.endswith("/server.py")
        shown = f'<div data-file="{escape(path)}?name={escape(name)}">{shown}</div>'
        return shown + (answers.editor(Path(path).parent.name) if own else "")
    if not runs.steps(block):
        return shown
    fields = "".join(
        f"<label>{escape(name)} <input data-field='{place}' data-name='{escape(name)}' value='{escape(value)}'></label>"
        for place, (name, value) in enumerate(runs.fields(block))
    )
    watch = '<button data-do="watch">Run with arrows</button>' if runs.watchable(block) else ""
    tools = f'<p class="tools"><button data-do="run">Run</button>{watch}{fields}</p>'
    return f'<div class="run" data-block="{number}">{shown}{tools}</div>'


def text(_: Any, tokens: list[Token], at: int, *__: Any) -> str:
    """A task is a box to tick."""
    content = tokens[at].content
    task = at == 0 and content.startswith("[ ] ")
    return '<input type="checkbox"> ' * task + escape(content[4 * task :])


def html(_: Any, tokens: list[Token], at: int, *__: Any) -> str:
    """As the page has it, but for comments: they name tests."""
    return re.sub(r"<!--.*?-->\n?", "", tokens[at].content, flags=re.DOTALL)


MARKDOWN = MarkdownIt("commonmark", {"html": True}).enable("table")
for kind, rule in {"fence": fence, "text": text, "html_block": html, "html_inline": html}.items():
    MARKDOWN.add_render_rule(kind, rule)


def tokens_of(path: Path) -> list[Token]:
    """What the page consists of, with an id for each heading, as GitHub has it, and for each text of an error."""
    tokens = MARKDOWN.parse(path.read_text(encoding="utf-8"))
    for at, token in enumerate(tokens):
        if token.type == "heading_open":
            token.attrSet("id", re.sub(r"[^\w\- ]", "", plain(tokens[at + 1]).lower()).replace(" ", "-"))
        elif token.type == "list_item_open" and path == ERRORS:
            token.attrSet("id", f"error-{at}")
        for child in token.children or ():
            if str(child.attrGet("href")).startswith("http"):
                child.attrs |= {"target": "_blank", "rel": "noreferrer"}
    return tokens


def plain(token: Token) -> str:
    """The text of its first line."""
    first = takewhile(lambda child: child.type != "hardbreak", token.children or ())
    return "".join(child.content for child in first)


def rendered(path: Path) -> str:
    return str(MARKDOWN.renderer.render(tokens_of(path), MARKDOWN.options, {"blocks": enumerate(guide.blocks(path))}))


def title(path: Path) -> str:
    return plain(next(token for token in tokens_of(path) if token.type == "inline"))


@cache
def search() -> str:
    """What can be found, as JSON: each title or text of an error, where it is, and the title of the page."""
    found = []
    for path in guide.pages():
        tokens = tokens_of(path)
        for at, token in enumerate(tokens):
            if token.attrGet("id"):
                text = plain(next(each for each in tokens[at:] if each.type == "inline"))
                found.append([text, f"{path.relative_to(ROOT).as_posix()}#{token.attrGet('id')}", title(path)])
    return json.dumps(found)


@cache
def known() -> set[Path]:
    """All files that the guide shows: its pages, what these link to, and what lies in a folder that they link to."""
    found = {*guide.pages(), *ROOT.glob("*.md")}
    for page in list(found):
        for target in re.findall(r'(?:href|src|srcset|data-file)="([^"#?]+)', rendered(page)):
            file = ((ROOT if target.startswith("python/") else page.parent) / unquote(target)).resolve()
            if ROOT in file.parents and file.exists():
                found |= {file, *(file.iterdir() if file.is_dir() else ())}
    return found


def label(page: str) -> str:
    return re.sub(r"^(?:Lesson|Application) (\d+):", r"\1", title(GUIDE / f"{page}.md"))


@cache
def side() -> dict[str, list[str]]:
    """The pages by group: the paths as on the map, whose title names them, and then those around the lessons."""
    keys = {f"{lesson.number:02}": lesson.key for lesson in lessons()}
    on_map = re.findall(r"[:;] ([^;:]+?), lessons ([\d, ]+)", MAP.read_text(encoding="utf-8"))
    groups = {"first": ["start_here", keys["01"]]}
    groups |= {path: [keys[number] for number in numbers.split(", ")] for path, numbers in on_map}
    listed = {name for names in groups.values() for name in names}
    return groups | {"around the lessons": [page.stem for page in guide.pages()[1:] if page.stem not in listed]}


def coloured(text: str, language: str) -> str:
    return str(highlight(text, get_lexer_by_name(language, stripnl=False), HtmlFormatter(nowrap=True)))


def source(path: Path, name: str) -> str:
    """A file with numbered lines, of which those of the function that the page shows are marked."""
    text = path.read_text(encoding="utf-8")
    try:
        lexer = get_lexer_for_filename(path.name, stripnl=False)
    except ClassNotFound:
        lexer = get_lexer_by_name("text", stripnl=False)
    find = {".py": guide.python_lines, ".cs": guide.csharp_lines}.get(path.suffix)
    marked = [line + 1 for line in (find(text, name) if find and name else None) or ()]
    return str(highlight(text, lexer, HtmlFormatter(linenos="inline", hl_lines=marked, cssclass="code")))


def page(path: Path, base: str, name: str = "") -> str:
    """The whole page of a file or folder of the kit."""
    if path.suffix == ".md":
        return whole(title(path), rendered(path), base)
    heading = path.relative_to(ROOT).as_posix()
    files = [file.name for file in sorted(path.iterdir()) if file.is_file()] if path.is_dir() else []
    listed = "".join(f'<li><a href="{base}{heading}/{file}">{file}</a></li>' for file in files)
    body = f"<ul>{listed}</ul>" if path.is_dir() else source(path, name)
    return whole(heading, f"<h1>{escape(heading)}</h1>{body}", base)


def whole(heading: str, body: str, base: str) -> str:
    listed = ""
    for group, names in side().items():
        items = "".join(f'<li><a href="{base}docs/guide/{name}.md">{escape(label(name))}</a></li>' for name in names)
        listed += f"<h2>{escape(group)}</h2><ul>{items}</ul>"
    made = Template((HERE / "page.html").read_text(encoding="utf-8"))
    return made.substitute(title=escape(heading), side=listed, body=body, base=base)


@cache
def style() -> str:
    """That of the page, and the colours of code for light and for dark."""
    light, dark = (HtmlFormatter(style=name).get_style_defs(".code") for name in ("default", "monokai"))
    own = (HERE / "page.css").read_text(encoding="utf-8")
    return f"{light}\n@media (prefers-color-scheme: dark) {{ {dark} }}\n{own}"
