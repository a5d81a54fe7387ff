"""Every page is made as the others are: blocks that say where they come from, sections, links, diagrams, commands."""

import ast
import json
import re
import tomllib

from kitlib.docs import guide
from kitlib.lessons import lessons
from tests.house import page_checks as checks
from tests.programs import ROOT

GUIDE = ROOT / "docs" / "guide"
PAGES = guide.pages()
ALL = sorted({*PAGES, *ROOT.glob("*.md")})
BLOCKS = [block for page in PAGES for block in guide.blocks(page)]


def faults_of(check, each):
    return [fault for one in each for fault in check(one)]


def of_text(check):
    return lambda page: check(page, page.read_text(encoding="utf-8"))


def test_every_block_says_where_it_comes_from():
    assert faults_of(checks.block_faults, BLOCKS) == []


def test_there_is_no_block_that_is_not_checked():
    assert faults_of(of_text(checks.stray_blocks), ALL) == []


def test_a_test_that_a_block_by_hand_names_is_there():
    tests = {path.name for path in ROOT.glob("tests/**/*.py")}
    for path in ROOT.glob("tests/**/*.py"):
        tests.update(re.findall(r"^ *def (test_\w+)", path.read_text(encoding="utf-8"), re.MULTILINE))
    files = {name.removesuffix(".py") for name in tests}
    for block in BLOCKS:
        if block.kind == "by hand":
            for name in re.findall(r"\btest_\w+(?:\.py)?", block.source):
                assert name in tests or name in files, f"{block.where}: {name}"


def test_a_command_means_the_same_to_every_shell():
    assert faults_of(checks.shell_faults, [block for block in BLOCKS if block.kind in ("commands", "by hand")]) == []


def test_a_diagram_is_one_that_mermaid_draws():
    for block in BLOCKS:
        if block.kind == "diagram":
            assert checks.diagram_faults(block.body) == [], block.where


def test_a_page_has_its_sections():
    assert faults_of(of_text(checks.structure_faults), [page for page in PAGES if page.parent == GUIDE]) == []


def test_every_link_and_picture_exists():
    assert faults_of(of_text(checks.link_faults), ALL) == []


def test_every_page_can_be_reached_from_the_readme():
    found, todo = set(), [ROOT / "README.md"]
    while todo:
        page = todo.pop()
        found.add(page)
        for target in checks.targets(page.read_text(encoding="utf-8")):
            path = (page.parent / target.partition("#")[0]).resolve()
            if path.suffix == ".md" and path.exists() and path not in found:
                todo.append(path)
    assert set(PAGES) <= found


def test_every_lesson_has_a_row_in_the_readme():
    readme = (ROOT / "README.md").read_text(encoding="utf-8")
    assert [lesson.key for lesson in lessons() if f"docs/guide/{lesson.key}.md" not in readme] == []


def test_a_page_to_begin_with_says_how_to_start_python_on_windows():
    """There `python3` is most often the Microsoft Store's. Said once, it holds for all pages."""
    for name in ("README.md", "start_here.md", "without_unity.md", "troubleshooting.md"):
        (page,) = [page for page in PAGES if page.name == name]
        assert re.search(r"\bOn\s+Windows\b.{1,20}`py`", page.read_text(encoding="utf-8"), re.DOTALL), name


def test_a_server_for_other_machines_has_what_it_then_asks_for():
    """Without keys it refuses such an endpoint, unless it is told that anyone may come."""
    refused = r"--endpoint\s+tcp://0\.0\.0\.0:\w+\b(?!\s+--(?:open-to-anyone|keys)\b)"
    assert [page.name for page in PAGES if re.search(refused, page.read_text(encoding="utf-8"))] == []


# What stays: the names of the package itself, and those of what not everybody needs.
DOOR = r"netmq_example(\.(body|camera|envs|fleet|jobs|mlagents_envs(\.\w+)*|program|sb3|security|video|web))?"


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
    """What a door has: its `__all__`, from the text, since not everybody has all that it needs."""
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
