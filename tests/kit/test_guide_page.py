"""`kit.py guide`, asked as its own pages ask it. In a browser: tests/web/test_guide_in_a_browser.py."""

import json
import os
import re
import shutil
import socket
import threading
import time
from html import unescape
from pathlib import Path

import pytest

from kitlib.docs import guide
from kitlib.guide_page import answers, runs
from tests.conftest import PYTHON
from tests.guide_site import block, opened
from tests.programs import LIMIT, ROOT, Mark, finds_processes, finished

pytest.importorskip("markdown_it")
pytest.importorskip("pygments")
# A guide takes a lesson's own port where that is free.
pytestmark = pytest.mark.xdist_group("guide")
FIRST = "docs/guide/01_request_reply.md"
SERVER = ROOT / "python" / "01_request_reply" / "server.py"


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
            assert main.count('<table class="sequence"') == sum(each.kind == "diagram" for each in blocks), name
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
        for other in (
            {"block": 0},
            {"page": "../../etc/passwd"},
            {"block": 999},
            {"step": 1},
            {"page": "CHANGELOG.md", "block": 0},
        ):
            status, _, text = site.ask("run", {**wish, **other})
            assert status == 400 and "no such command" in text, other
        assert site.ask("shell", {"words": ["ls"]})[0] == 403
        # The program itself refuses this one.
        said, _ = site.told("run", {**wish, "values": {"0": "many"}})
        assert any("--drop" in line and "many" in line for line in said["server"]), said
        own = {"lesson": "02_lazy_pirate", "check": False}
        for options in ("--folder /tmp", "--endpoint tcp://192.168.1.20:5552", "--count 1\n--folder x"):
            status, _, text = site.ask("own", {**own, "options": options})
            assert status == 400 and len(text.splitlines()) == 1, (options, text)


def test_what_other_machines_would_reach_is_for_a_terminal():
    """And what is no lesson's: of all blocks, these commands alone have a button."""
    found = [words for page in guide.pages() for each in guide.blocks(page) for words in runs.steps(each)]
    assert {words[0] for words in found} == {"run", "server", "client", "test", "doctor"} and len(found) > 90
    assert not [words for words in found if re.search(r"0\.0\.0\.0|192\.|--folder|--open|;", " ".join(words))]


def test_a_run_is_shown_line_by_line_and_compared(tmp_path):
    page, command = "docs/guide/without_unity.md", 'run 1 --client python --options="--count 1"'
    with opened(tmp_path) as site:
        said, last = site.told("run", block(page, command))
        assert said["client"][-1] == "done: 1 replies" and said["server"][0].startswith("listening on ")
        assert last == {"verdict": "printed as on this page", "good": True} and said["command"] == [
            f"python3 kit.py {command}"
        ]
        said, last = site.told("run", block(page, command, **{"0": "2"}))
        assert said["client"][-1] == "done: 2 replies" and last == {"verdict": "ended"}
        assert said["command"] == ['python3 kit.py run 1 --client python --options="--count 2"']


def test_two_programs_have_a_run_each(tmp_path):
    """As in two terminals, and beside another guide: the server is there until nobody listens to it any more."""
    words = "server 1\npython3 kit.py client 1"
    with opened(tmp_path) as other, opened(tmp_path) as site, other.listening("run", block(FIRST, words)) as theirs:
        next(line for line in theirs if "listening on " in line)
        with site.listening("run", block(FIRST, words)) as lines:
            next(line for line in lines if "listening on " in line)
            said, _ = site.told("run", block(FIRST, words, step=1))
            assert said["client"][-1] == "done: 10 replies" and "sent b'World'" in next(lines)
        said, _ = site.told("run", block(FIRST, words, step=1))
        assert said["client"][-1].startswith("gave up: ")
    # The first guide of a machine leaves both to the lesson's own port, and a later one gives both another.
    for number, more in ((0, []), (7, ["--endpoint", "tcp://127.0.0.1:25558"])):
        for word in ("server", "client"):
            assert runs.arranged([word, "1"], "", None, number) == [word, "1", *more]


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
        assert own["text"] == kit and own["text"].splitlines()[own["at"] - 2].endswith('answer goes here."""')
        check = {"lesson": key, "check": True}
        missing = site.told("own", check)[1]["verdict"]
        assert missing.startswith("not yet: the client has to print received Monde") and "expected Hello" in missing
        for line, mistake in (('if text == "Bonjour"', "expected ':'"), ('if text == "Bonjour":', "")):
            mended = kit.replace(
                "    # The clients of some", f'    {line}\n        return "Monde"\n    # The clients of some'
            )
            own = json.loads(site.ask("edit", {"lesson": key, "text": mended, "was": own["text"]})[2])
            assert mistake in own["error"] and bool(mistake) == bool(own["error"])
            assert not mistake or line in own["text"].splitlines()[own["at"] - 1]
        said, last = site.told("own", check)
        assert last == {"verdict": "done", "good": True} and "1: sent Bonjour, received Monde" in said["client"]
        site.ask("tick", {"lesson": "16_web_gateway", "done": True})
        assert f'data-tick="{key}" checked' in (text := site.ask("class")[2])
        # Both are ticked in the list of lessons as well.
        assert text.count("<b>✓</b>") == 2
        assert SERVER.read_text(encoding="utf-8") == kit
        # A folder with a pupil's name may have the kit's folder in it.
        (tmp_path / "cy").mkdir()
        shutil.copytree(site.folder, tmp_path / "cy" / "answers")
        folders = (site.folder, tmp_path / "bo", tmp_path / "cy")
        # In the folder of a class somebody who has checked nothing has a row as well.
        (tmp_path / "bo").mkdir()
        whole = reported(tmp_path).stdout
        assert whole.count("checked") == 2 and f"{tmp_path / 'bo'} has no exercises.json" in whole
    report = reported(*folders)
    rows = [line.split() for line in report.stdout.splitlines()]
    assert [row for row in rows if not row[0].startswith("kit")][:4] == [
        ["01", "02", "03", "04", "14", "16"],
        [str(site.folder), "checked", "-", "-", "-", "-", "ticked"],
        [str(tmp_path / "bo"), *"------"],
        [str(tmp_path / "cy"), "checked", "-", "-", "-", "-", "ticked"],
    ]
    assert report.returncode == 0 and f"{tmp_path / 'bo'} has no exercises.json" in report.stdout


def reported(*folders):
    return finished([PYTHON, ROOT / "kit.py", "guide", "--report", *folders])


def test_a_file_of_a_pupil_that_the_guide_did_not_write_is_one_line(tmp_path):
    """The table has a row and a line for it, whatever is in it and in the name of its folder."""
    odd = [
        '{"name": "my-app"}',
        "[" * 100_000,
        "not JSON",
        "7",
        "null",
        '["ab"]',
        "\xff",
        "9" * 5000,
        '{"01_request_reply": ["checked"]}',
    ]
    odd += [json.dumps({"01_request_reply": how}) for how in ("\33[2J", 1, None, {"a": "b"}, "checked\n02")]
    # Windows has no such names.
    name = "" if os.name == "nt" else "\33]0;x\7"
    folders = [tmp_path / f"pupil{number}{name}" for number, _ in enumerate(odd)]
    for folder, text in zip(folders, odd, strict=True):
        folder.mkdir()
        (folder / "exercises.json").write_text(text, encoding="latin-1")
    report = reported(*folders)
    _, *lines = report.stdout.splitlines()
    assert report.returncode == 0 and report.stderr == "" and len(lines) == 2 * len(odd)
    for number, (row, why) in enumerate(zip(lines[::2], lines[1::2], strict=True)):
        shown = f"{tmp_path / 'pupil'}{number}{name and '?]0;x?'}"
        assert row.startswith(shown) and row.split()[-6:] == [*"------"]
        assert f"exercises.json of {shown} is not as the guide writes it" in why, why
        assert row.isprintable() and why.isprintable()


def test_what_was_saved_elsewhere_is_not_overwritten(tmp_path):
    """Neither by what is typed in the page nor by a mistake: only by who starts again from the kit's."""
    key = "01_request_reply"
    with opened(tmp_path) as site:
        first = json.loads(site.ask("edit", {"lesson": key})[2])
        path = Path(first["path"])
        path.write_text("# by my editor\n", encoding="utf-8")
        told = json.loads(site.ask("edit", {"lesson": key, "text": "# by the page\n", "was": first["text"]})[2])
        assert told["newer"] and told["text"] == path.read_text(encoding="utf-8") == "# by my editor\n"
        told = json.loads(site.ask("edit", {"lesson": key, "text": "# by the page\n", "was": told["text"]})[2])
        assert not told["newer"] and path.read_text(encoding="utf-8") == "# by the page\n"
        told = json.loads(site.ask("edit", {"lesson": key, "again": True})[2])
        assert told["text"] == path.read_text(encoding="utf-8") == SERVER.read_text(encoding="utf-8")


def test_pupils_may_have_pages_without_answers(tmp_path):
    page = "docs/guide/02_lazy_pirate.md"
    with opened(tmp_path, "--no-answers") as site:
        text = site.ask(page)[2]
        assert "<summary>Answer" not in text and "Check yourself" in text and 'id="next"' in text
        assert "Answers that work" not in site.ask("docs/guide/classroom.md")[2]
    with opened(tmp_path) as site:
        assert "<summary>Answer" in site.ask(page)[2]


def test_the_port_is_for_this_guide_alone(tmp_path, monkeypatch):
    """On Windows two servers that reuse an address share it. To ask for this machine's name takes seconds on macOS."""
    from kitlib.guide_page import server

    monkeypatch.setattr(socket, "getfqdn", None)
    with server.Guide(tmp_path, None, True) as made:
        assert not made.socket.getsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR)


# Answers of the classroom page, and one for lesson 04: what takes the place of what.
ANSWERS = {
    "02_lazy_pirate": (
        "    if not (asked",
        '    if text == "take 5":\n        db.execute("UPDATE account SET balance = balance - 5")\n'
        '        return str(db.execute("SELECT balance FROM account").fetchone()[0])\n    if not (asked',
    ),
    "03_publish_subscribe": (
        "            # Your own topic goes here.",
        '            socket.send_string(time.strftime("time/ %H:%M:%S"))',
    ),
    "04_background_client": (
        '    if text == "hello"',
        '    if text == "Bonjour":\n        return "Salut"\n    if text == "hello"',
    ),
}


@pytest.mark.parametrize("key", ANSWERS)
def test_a_check_passes_with_an_answer_that_works_and_without_does_not(tmp_path, key):
    with opened(tmp_path) as site:
        text, check = json.loads(site.ask("edit", {"lesson": key})[2])["text"], {"lesson": key, "check": True}
        assert site.told("own", check)[1]["verdict"].startswith("not yet: the client has to print ")
        site.ask("edit", {"lesson": key, "text": text.replace(*ANSWERS[key]), "was": text})
        assert site.told("own", check)[1] == {"verdict": "done", "good": True}


def test_a_verdict_shows_why_nothing_came_and_what_time_it_wants(tmp_path):
    gone, time = "client | gave up: nothing from tcp://127.0.0.1:5553 within 5 s", "client | received time/ 12:30:00"
    crash = "AttributeError: module 'time' has no attribute 'now'"
    for lines, why in (
        ([f"server | {crash}", gone], crash),
        ([gone], "within 5 s"),
        ([*[time] * 5, "client | done: received 5"], "with the time of each"),
    ):
        told = str(answers.exercises()["03_publish_subscribe"].verdict(tmp_path, lines)["verdict"])
        assert told.startswith("not yet: ") and why in told and "loop" not in told


def test_what_is_no_text_and_no_request_is_one_line(tmp_path):
    """And of ticks at once each is kept. The guide's own output has no traceback."""
    key = "01_request_reply"
    with opened(tmp_path) as site:
        own = Path(json.loads(site.ask("edit", {"lesson": key})[2])["path"])
        own.write_bytes("# Grüße\n".encode("latin-1"))
        for path, wish, cure in (
            ("edit", {"lesson": key}, "save it as UTF-8"),
            ("edit", {"lesson": key, "text": "", "was": "x"}, "save it as UTF-8"),
            ("run", {"page": FIRST, "block": "x", "step": 0}, "load it anew"),
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
        # Its server would stay, and is silent: no line that cannot be written tells that the tab is closed.
        with site.listening("run", block(FIRST, "server 1\npython3 kit.py client 1")) as lines:
            next(line for line in lines if "listening on " in line)
            assert mark.processes().keys() > alone
            if how == "server":
                site.program.stop()
        deadline = time.monotonic() + LIMIT
        while how == "tab" and mark.processes().keys() > alone:
            assert time.monotonic() < deadline, mark.processes()
            time.sleep(0.02)
    assert mark.gone()
