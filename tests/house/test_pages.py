"""Every page is made as the others are: blocks that say where they come from, sections, links, diagrams, commands."""

import ast
import json
import os
import re
import tomllib
from html import unescape
from pathlib import Path

from kitlib.docs import guide
from kitlib.lessons import lessons
from tests.programs import ROOT

PAGES = guide.pages()
ALL = sorted({*PAGES, *ROOT.glob("*.md")})
TEXTS = {page: page.read_text(encoding="utf-8") for page in ALL}
BLOCKS = [block for page in PAGES for block in guide.blocks(page)]
LANGUAGES = {".py": "python", ".cs": "csharp"}
SECTIONS = ["Run it", "What you see", "How it works", "Break it on purpose", "In Unity", "Check yourself", "Next"]
# PowerShell 5.1, cmd, bash and zsh all take these as they stand: programs, words, and text in double quotes.
PROGRAMS = ("python3", "python", "dotnet", "git", "cd")
WORD = r"[\w./:=,-]"
PLAIN = rf"(?!\./){WORD}+(?: (?:{WORD}|\"[^\"$`%!\\~]*\")+)*"
# The pages need these of Mermaid, which ends a statement at a semicolon and takes `#name;` for a character.
TEXT = r"(?:[^;#]|#\w+;)+"
STATEMENTS = (
    rf"participant (?P<declared>\w+)(?: as {TEXT})?",
    rf"(?P<from>\w+?)(?:->>|--x)(?P<to>\w+): {TEXT}",
    rf"Note over (?P<over>\w+)(?:,(?P<and>\w+))?: {TEXT}",
    rf"(?:alt|else) {TEXT}",
    "end",
)


def test_every_block_says_where_it_comes_from():
    """A fence that kitlib.docs.guide does not see, because it is indented or written another way, nobody checks."""
    for block in BLOCKS:
        assert block.kind in {"excerpt", "bench", "run", "like", "commands", "diagram", "by hand"}, block.where
        assert block.kind != "by hand" or block.source, f"{block.where}: say why it is by hand"
        assert (block.kind == "diagram") == (block.language == "mermaid"), block.where
        if block.kind == "excerpt":
            assert block.language == LANGUAGES[Path(block.source.split()[0]).suffix], block.where
        assert block.kind not in ("run", "like", "commands") or not block.language, block.where
    for page, text in TEXTS.items():
        assert re.findall(r"^ *(?:```|~~~|<pre).*", guide.BLOCK.sub("", text), re.MULTILINE) == [], page


def test_a_test_that_a_block_by_hand_names_is_there():
    files = list(ROOT.glob("tests/**/*.py"))
    tests = {name for path in files for name in (path.name, path.stem)}
    for path in files:
        tests.update(re.findall(r"^ *def (test_\w+)", path.read_text(encoding="utf-8"), re.MULTILINE))
    for block in BLOCKS:
        if block.kind == "by hand":
            assert {*re.findall(r"\btest_\w+(?:\.py)?", block.source)} <= tests, block.where


def test_a_command_means_the_same_to_every_shell():
    """Or its comment says for which one it is."""
    for block in BLOCKS:
        begins = block.body.startswith((*PROGRAMS, "export ", "set ", "$env:"))
        typed = block.kind == "commands" or (block.kind == "by hand" and not block.language and begins)
        if typed and not re.match(r"for (bash|zsh|cmd|PowerShell)\b.*:", block.source):
            for line in filter(None, block.body.splitlines()):
                assert line.startswith(PROGRAMS) and re.fullmatch(PLAIN, line), f"{block.where}: {line}"


def test_a_diagram_is_one_that_mermaid_draws():
    """With no participant made up or forgotten."""
    for block in BLOCKS:
        if block.kind == "diagram":
            first, *lines = [line.strip() for line in block.body.splitlines() if line.strip()]
            assert first == "sequenceDiagram", block.where
            declared, used = set(), set()
            for line in lines:
                found = next((match for form in STATEMENTS if (match := re.fullmatch(form, line))), None)
                assert found, f"{block.where}: {line}"
                for name, value in found.groupdict().items():
                    (declared if name == "declared" else used).add(value)
            assert declared == used - {None}, block.where
            assert lines.count("end") == len([line for line in lines if line.startswith("alt ")]), block.where


def without_blocks(text):
    return re.sub(r"^```.*?^```$", "", text, flags=re.DOTALL | re.MULTILINE)


def test_a_page_has_its_sections():
    """Pure reference has nothing to ask: it is no lesson's, and needs Next alone."""
    keys = {lesson.key for lesson in lessons()}
    for page in PAGES:
        if page.parent == ROOT / "docs" / "guide":
            titles = re.findall(r"^## +(.*?) *$", without_blocks(TEXTS[page]), re.MULTILINE)
            wanted = SECTIONS if "Check yourself" in titles or page.stem in keys else ["Next"]
            assert [title for title in titles if title in wanted] == wanted, page
            assert "\n**You will learn** " in TEXTS[page], page
            assert ".md" in TEXTS[page].partition("\n## Next\n")[2], f"{page}: Next names no page"


def anchors(text):
    """The names of a page's headings, as GitHub makes them."""
    found = set(re.findall(r"<a (?:id|name)=\"([^\"]+)\"", text))
    for title in re.findall(r"^#{1,6} +(.*?) *$", without_blocks(text), re.MULTILINE):
        shown = unescape(re.sub(r"<[^>]+>", "", re.sub(r"!?\[([^\]]*)\]\([^)]*\)", r"\1", title)))
        found.add(re.sub(r"[^\w\- ]", "", shown.lower()).replace(" ", "-"))
    return found


def prose(text):
    """The page without its code, where brackets and hashes mean something else."""
    return re.sub(r"(`+)(?!`).+?\1", "", without_blocks(text))


def targets(text):
    """Where the links and pictures of a page lead to, in markdown and in HTML."""
    found = re.findall(r"\]\(<?([^)\s>]*)>?(?: +\"[^\"]*\")?\)", prose(text))
    found += re.findall(r"^ *\[[^\]]+\]: +(\S+)", prose(text), re.MULTILINE)
    return found + re.findall(r"<(?:a|img|source)\b[^>]*?\b(?:href|src|srcset)=\"([^\"]*)\"", prose(text))


def exactly_there(path):
    """True if it exists in the repository in this very spelling; a Mac or Windows is less exact than GitHub."""
    path = Path(os.path.normpath(path))
    parts = [part for part in (path, *path.parents) if ROOT in part.parents]
    return path == ROOT or (
        parts != [] and all(each.parent.is_dir() and each in each.parent.iterdir() for each in parts)
    )


def test_every_link_and_picture_exists():
    for page, text in TEXTS.items():
        for target in targets(text):
            path, _, anchor = target.partition("#")
            if re.match(r"https?://[^/\s]+\.\w+|mailto:", target):
                continue
            file = page.parent / path if path else page
            assert target and exactly_there(file), f"{page.name}: there is no {target}"
            if anchor and file.suffix == ".md":
                assert anchor in anchors(file.read_text(encoding="utf-8")), f"{page.name}: no such heading: {target}"
        unsaid = re.findall(r"!\[\]\([^)]*\)|<img\b(?![^>]*\balt=\"[^\"]+\")[^>]*>", prose(text))
        assert unsaid == [], f"{page.name}: say in words what is to be seen"


def test_every_page_can_be_reached_from_the_readme():
    found, todo = set(), [ROOT / "README.md"]
    while todo:
        page = todo.pop()
        found.add(page)
        linked = [(page.parent / target.partition("#")[0]).resolve() for target in targets(TEXTS[page])]
        todo += [path for path in linked if path in TEXTS and path not in found]
    assert set(PAGES) <= found


def test_a_server_for_other_machines_has_what_it_then_asks_for():
    """Without keys it refuses such an endpoint, unless it is told that anyone may come."""
    refused = r"--endpoint\s+tcp://0\.0\.0\.0:\w+\b(?!\s+--(?:open-to-anyone|keys)\b)"
    assert [page.name for page in PAGES if re.search(refused, TEXTS[page])] == []


# These stay: the package's own names, and those of rooms that not everybody needs.
ROOMS = "body|camera|envs|fleet|jobs|mlagents_(learn|envs(\\.\\w+)*)|program|sb3|scene|security|video|web"
DOOR = rf"netmq_example(\.({ROOMS}))?"


def imported(code):
    """The names of the package that Python code imports, or names in a text, as "netmq_example.envs:ZmqEnv"."""
    for node in ast.walk(ast.parse(code)):
        if isinstance(node, ast.Import):
            yield from (each.name for each in node.names)
        elif isinstance(node, ast.ImportFrom):
            yield from (f"{node.module}.{each.name}" for each in node.names)
        elif isinstance(node, ast.Constant):
            for module, name, more in re.findall(r"^(netmq_example[.\w]*):(\w+)(/?)", str(node.value)):
                yield module if more else f"{module}.{name}"


def python_on(path):
    """The Python of a page, its blocks and its lines between text, or of a notebook."""
    text = path.read_text(encoding="utf-8")
    if path.suffix == ".ipynb":
        cells = ["".join(cell["source"]) for cell in json.loads(text)["cells"] if cell["cell_type"] == "code"]
        return [re.sub(r"^[%!].*", "", cell, flags=re.MULTILINE) for cell in cells]
    lines = re.findall(r"`((?:from|import) netmq_example[^`]*)`", text)
    return [block.body for block in guide.blocks(path) if block.language == "python"] + [
        line for line in lines if "…" not in line
    ]


def names_at(door):
    """The door's `__all__`, from its text, since not everybody has all the packages that it needs."""
    path = ROOT.joinpath("python", *door.split("."))
    path = path / "front_door" if door == "netmq_example" else path
    file = path.with_suffix(".py") if path.with_suffix(".py").exists() else path / "__init__.py"
    for node in ast.parse(file.read_text(encoding="utf-8")).body if file.exists() else ():
        if isinstance(node, ast.Assign) and ast.unparse(node.targets[0]) == "__all__":
            return set(ast.literal_eval(node.value))
    return set()


def test_pages_and_notebooks_import_from_doors_only():
    def allowed(name):
        door, _, last = name.rpartition(".")
        is_at_one = re.fullmatch(DOOR, door) and last in names_at(door)
        return is_at_one or re.fullmatch(DOOR, name)

    notebooks = [path for folder in ("docs", "python", "lab") for path in ROOT.glob(f"{folder}/**/*.ipynb")]
    found = {
        f"{path.name}: {name}"
        for path in [*ALL, *ROOT.glob("*.ipynb"), *notebooks]
        for code in python_on(path)
        for name in imported(code)
        if name.split(".")[0] == "netmq_example" and not allowed(name)
    }
    assert found == set()


def test_the_notices_name_every_package():
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    wanted = project["dependencies"] + [each for extra in project["optional-dependencies"].values() for each in extra]
    for path in [*ROOT.glob("*.targets"), *ROOT.glob("c*/**/*.csproj")]:
        wanted += re.findall(r'<PackageReference Include="([^"]+)"', path.read_text(encoding="utf-8"))
    notices = (ROOT / "THIRD-PARTY-NOTICES.md").read_text(encoding="utf-8")
    listed = set(re.findall(r"[\w-]+", " ".join(re.findall(r"^\| ([^|]+)", notices, re.MULTILINE)).lower()))
    assert {re.match(r"[\w-]+", each)[0].lower() for each in wanted} - listed == set()
