"""`kit.py guide`, asked as its own pages ask it. In a browser: tests/web/test_guide_in_a_browser.py."""

import json
import re
import shutil
import socket
import threading
import time
from html import unescape
from pathlib import Path

import pytest

from kitlib.docs import guide
from kitlib.guide_page import runs
from tests.conftest import PYTHON
from tests.guide_site import block, opened
from tests.programs import LIMIT, ROOT, Mark, finds_processes, finished

pytest.importorskip("markdown_it")
pytest.importorskip("pygments")
# A guide takes a lesson's own port where that is free.
pytestmark = pytest.mark.xdist_group("guide")
FIRST = "docs/guide/01_request_reply.md"
SERVER = ROOT / "python" / "01_request_reply" / "server.py"


def shown(told, who):
    return [each["text"] for each in told if each.get("who") == who]


def test_every_page_has_each_block_as_it_stands(tmp_path):
    """Nothing of the comments, which name tests; and every picture and file of the kit that it links to is there."""
    seen = set()
    with opened(tmp_path) as site:
        for page in guide.pages():
            name = page.relative_to(ROOT).as_posix()
            status, _, text = site.ask(name)
            main = text.partition("<main>")[2]
            assert status == 200 and "<!--" not in main, name
            code = [unescape(re.sub(r"<[^>]+>", "", each)) for each in re.findall(r"<pre.*?</pre>", main, re.DOTALL)]
            blocks = list(guide.blocks(page))
            assert code == [each.body for each in blocks if each.kind != "diagram"], name
            assert main.count('<svg class="sequence"') == sum(each.kind == "diagram" for each in blocks), name
            for target in re.findall(r'(?:href|src)="(?!\w+:|#)([^"#]+)', main):
                path = (page.parent / target).resolve()
                if path not in seen and path not in guide.pages():
                    assert site.ask(path.relative_to(ROOT).as_posix())[0] == 200, (name, target)
                seen.add(path)
        for name in (".git/config", "keys/server.key_secret", "../../etc/passwd", "kit.py", "answers"):
            assert site.ask(name)[0] == 404, name
        found = json.loads(site.ask("search.json")[2])
        assert ["Run it", f"{FIRST}#run-it", "Lesson 01: request-reply"] in found
        assert any(text.startswith("error: externally-managed") for text, *_ in found)
        marked = re.findall(r'class="hll".*', site.ask("python/01_request_reply/server.py?name=answer")[2])
        assert len(marked) == len(guide.excerpt("python/01_request_reply/server.py answer").splitlines())


def test_strangers_are_refused(tmp_path):
    """By the token, by Host and by Origin; and their frames by the browser, which is told so."""
    wish = block(FIRST, "run 1")
    with opened(tmp_path) as site:
        for headers in ({"Host": f"evil.example:{site.port}"}, {"Origin": "http://evil.example"}, {"Origin": "null"}):
            assert site.ask(FIRST, **headers)[0] == site.ask("run", wish, **headers)[0] == 403, headers
        assert site.ask("run", wish, Origin="")[0] == 403
        for base in ("/", f"/{'x' * (len(site.base) - 2)}/"):
            assert site.ask(FIRST, base=base)[0] == site.ask("run", wish, base=base)[0] == 403
        _, headers, _ = site.ask(FIRST)
        assert "frame-ancestors 'none'" in headers["Content-Security-Policy"] and headers["X-Frame-Options"] == "DENY"
        with socket.socket() as probe:
            # This machine's as well, and not where the guide listens.
            assert probe.connect_ex(("127.0.0.2", site.port)) != 0


def test_nothing_runs_but_what_stands_in_the_pages(tmp_path):
    page = "docs/guide/start_here.md"
    wish = block(page, 'run 2 --server="--drop 2" --options="--count 3"')
    with opened(tmp_path) as site:
        for value in ("2' --journal '/tmp/x", '2" --options "', "2\nrun 1", "$(touch x)", ""):
            status, _, text = site.ask("run", {**wish, "values": {"0": value}})
            assert status == 400 and text.startswith("--drop takes "), (value, text)
        # Git's commands, no page, no block, no page of the guide.
        for other in ({"block": 0}, {"page": "../../etc/passwd"}, {"block": 999}, {"page": "CHANGELOG.md", "block": 0}):
            status, _, text = site.ask("run", {**wish, **other})
            assert status == 400 and "no such command" in text, other
        assert site.ask("shell", {"words": ["ls"]})[0] == 403
        # The program itself refuses this one.
        told = site.told("run", {**wish, "values": {"0": "many"}})
        assert any("--drop" in line and "many" in line for line in shown(told, "server")), told


def test_what_other_machines_would_reach_is_for_a_terminal():
    """And what is no lesson's: of all blocks, these commands alone have a button."""
    found = [words for page in guide.pages() for each in guide.blocks(page) for words in runs.steps(each)]
    assert {words[0] for words in found} == {"run", "server", "client", "test", "doctor"} and len(found) > 90
    assert not [words for words in found if re.search(r"0\.0\.0\.0|192\.|--folder|--open|;", " ".join(words))]


def test_a_run_is_shown_line_by_line_and_compared(tmp_path):
    page, command = "docs/guide/without_unity.md", 'run 1 --client python --options="--count 1"'
    with opened(tmp_path) as site:
        told = site.told("run", block(page, command))
        assert shown(told, "client")[-1] == "done: 1 replies" and shown(told, "server")[0].startswith("listening on ")
        assert told[-1] == {"verdict": "as on the page"}
        told = site.told("run", block(page, command, **{"0": "2"}))
        assert shown(told, "client")[-1] == "done: 2 replies" and told[-1] == {"verdict": ""}
        # Two commands, of which the second one needs the first.
        told = site.told("run", block(FIRST, "server 1\npython3 kit.py client 1"))
        assert shown(told, "client")[-1] == "done: 10 replies" and "sent b'World'" in shown(told, "server")


def test_a_difference_is_the_first_line_that_differs(tmp_path):
    page = tmp_path / "page.md"
    page.write_text("<!-- run: 1 -->\n```\nserver | a\nclient | 1\n...\nclient | done: 3\n```\n", encoding="utf-8")
    (shown,) = guide.blocks(page)
    for lines, difference in (
        (["client | 1", "client | 2", "server | a", "client | done: 3"], ""),
        (["client | 1", "server | b", "client | done: 3"], "server: the page has a"),
        (["client | 1", "server | a", "client | gave up"], "client: the page has done: 3"),
        (["client | 1", "server | a", "client | done: 3", "client | b"], "client: the page does not have b"),
    ):
        assert guide.first_difference(shown, lines) == difference
        assert bool(guide.contradiction(shown, lines)) == bool(difference)


def test_an_exercise_is_edited_checked_and_reported(tmp_path):
    kit, key = SERVER.read_text(encoding="utf-8"), "01_request_reply"
    with opened(tmp_path) as site:
        own = json.loads(site.ask("edit", {"lesson": key})[2])
        assert own["text"] == kit and own["text"][own["at"] :].startswith("def answer")
        missing = site.told("try", {"lesson": key, "check": True})[-1]["verdict"]
        assert missing.startswith("not yet: wanted received Monde; came: ") and "expected Hello" in missing
        for line, mistake in (('if text == "Bonjour"', "expected ':'"), ('if text == "Bonjour":', "")):
            mended = kit.replace(
                "    # The clients of some", f'    {line}\n        return "Monde"\n    # The clients of some'
            )
            error = json.loads(site.ask("edit", {"lesson": key, "text": mended})[2])["error"]
            assert mistake in error and bool(mistake) == bool(error)
        assert site.told("try", {"lesson": key, "check": True})[-1] == {"verdict": "done", "passed": True}
        site.ask("tick", {"lesson": "16_web_gateway", "done": True})
        assert f'data-tick="{key}" checked' in site.ask("class")[2]
        assert SERVER.read_text(encoding="utf-8") == kit
        # A folder with a pupil's name may have the kit's folder in it.
        (tmp_path / "cy").mkdir()
        shutil.copytree(site.folder, tmp_path / "cy" / "answers")
        folders = (site.folder, tmp_path / "bo", tmp_path / "cy")
        report = finished([PYTHON, ROOT / "kit.py", "guide", "--report", *folders], cwd=tmp_path)
    rows = [line.split() for line in report.stdout.splitlines()]
    assert [row for row in rows if not row[0].startswith("kit")][:4] == [
        ["01", "02", "03", "04", "14", "16"],
        [str(site.folder), "checked", "-", "-", "-", "-", "ticked"],
        [str(tmp_path / "bo"), *"------"],
        [str(tmp_path / "cy"), "checked", "-", "-", "-", "-", "ticked"],
    ]
    assert report.returncode == 0 and f"{tmp_path / 'bo'} has no exercises.json" in report.stdout


# Answers of the classroom page, and one for lesson 04: what takes the place of what.
ANSWERS = {
    "02_lazy_pirate": (
        "    if not (asked",
        '    if text == "take 5":\n        db.execute("UPDATE account SET balance = balance - 5")\n'
        '        return str(db.execute("SELECT balance FROM account").fetchone()[0])\n    if not (asked',
    ),
    "04_background_client": (
        '    if text == "hello"',
        '    if text == "Bonjour":\n        return "Monde"\n    if text == "hello"',
    ),
}


@pytest.mark.parametrize("key", ANSWERS)
def test_a_check_passes_with_an_answer_that_works_and_without_does_not(tmp_path, key):
    with opened(tmp_path) as site:
        text = json.loads(site.ask("edit", {"lesson": key})[2])["text"]
        assert site.told("try", {"lesson": key, "check": True})[-1]["verdict"].startswith("not yet: ")
        site.ask("edit", {"lesson": key, "text": text.replace(*ANSWERS[key])})
        assert site.told("try", {"lesson": key, "check": True})[-1]["passed"]


def test_a_program_that_prints_in_a_loop_is_shown_in_part(tmp_path):
    """Its first lines, and how many are left out; and what the client says beside it."""
    kit, key = SERVER.read_text(encoding="utf-8"), "01_request_reply"
    loud = kit.replace(
        "    # The clients of some", "    for number in range(100_000):\n        print(number)\n    # The"
    )
    with opened(tmp_path) as site:
        site.ask("edit", {"lesson": key, "text": loud})
        told = site.told("try", {"lesson": key, "check": True})
    lines = shown(told, "server")
    assert "0" in lines and any(re.fullmatch(r"\.\.\. \d+ lines left out", line) for line in lines)
    assert len(lines) < 50_000 and told[-1]["verdict"].startswith("not yet: wanted received Monde")


def test_what_is_no_text_and_no_request_is_one_line(tmp_path):
    """And of ticks at once each is kept. The guide's own output has no traceback."""
    key = "01_request_reply"
    with opened(tmp_path) as site:
        own = Path(json.loads(site.ask("edit", {"lesson": key})[2])["path"])
        own.write_bytes("# Grüße\n".encode("latin-1"))
        for path, wish, cure in (
            ("edit", {"lesson": key}, "save it as UTF-8"),
            ("edit", {"lesson": key, "text": "\ud800"}, "save it as UTF-8"),
            ("run", {"page": FIRST, "block": "x"}, "load it anew"),
            ("run", [], "load it anew"),
        ):
            status, _, text = site.ask(path, wish)
            assert status == 400 and cure in text and len(text.splitlines()) == 1, text
        assert site.ask("edit", {"lesson": key}, **{"Content-Length": "abc"})[0] == 403
        keys = re.findall(r'data-tick="(\w+)"', site.ask("class")[2])
        each = [threading.Thread(target=site.ask, args=("tick", {"lesson": one, "done": True})) for one in keys]
        for one in each:
            one.start()
        for one in each:
            one.join()
        assert json.loads((site.folder / "exercises.json").read_text()).keys() == set(keys)


@finds_processes
@pytest.mark.parametrize("how", ["tab", "server"])
def test_a_closed_tab_and_the_end_of_the_server_end_the_programs(tmp_path, how):
    mark = Mark()
    with opened(tmp_path, **mark.environment) as site:
        alone = mark.processes().keys()
        wish = json.dumps({"lesson": "01_request_reply", "check": False})
        head = f"POST {site.base}try HTTP/1.0\r\nHost: 127.0.0.1:{site.port}\r\nOrigin: {site.origin}\r\n"
        with socket.create_connection(("127.0.0.1", site.port), LIMIT) as tab, tab.makefile("rw", newline="") as lines:
            lines.write(f"{head}Content-Length: {len(wish)}\r\n\r\n{wish}")
            lines.flush()
            # Then all are silent: no line that cannot be written tells that the tab is closed.
            next(line for line in lines if "done: 10 replies" in line)
            assert mark.processes().keys() > alone
            if how == "server":
                site.program.stop()
        deadline = time.monotonic() + LIMIT
        while how == "tab" and mark.processes().keys() > alone:
            assert time.monotonic() < deadline, mark.processes()
            time.sleep(0.02)
    assert mark.gone()
