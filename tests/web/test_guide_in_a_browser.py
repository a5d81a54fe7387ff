"""The guide in a real browser: a lesson without a terminal, and a page of a stranger's."""

import functools
import http.server
import json
import re
import threading

import pytest

from tests.guide_site import block, opened
from tests.programs import ROOT, Mark, finds_processes

pytest.importorskip("markdown_it")
pytest.importorskip("pygments")
# A guide takes a lesson's own port where that is free.
pytestmark = pytest.mark.xdist_group("guide")
FIRST = "docs/guide/01_request_reply.md"


def test_a_lesson_without_a_terminal(tmp_path, open_page):
    """A page, a run that is broken on purpose, arrows, an answer of one's own, large type; and all of it from here."""
    with opened(tmp_path) as site:
        page = open_page(f"{site.url}docs/guide/02_lazy_pirate.md")
        drop = "[...document.querySelectorAll('.run')].find(each => each.innerText.includes('--drop 3'))"
        page.evaluate(f"{drop}.id = 'drop'")
        page.evaluate("document.querySelector('#drop input').value = '2'")
        page.click("#drop form button")
        page.wait_for("document.querySelector('#drop .columns')?.innerText.includes('done: 4 replies')")
        assert re.search(r"request 2, b'2-\w+': '2', dropped", page.text("#drop .columns"))
        assert '--server="--drop 2"' in page.text("#drop .output code")
        page.wait_for("document.querySelector('#drop .verdict').textContent === 'ended'")
        page.evaluate("document.querySelector('#drop input').value = '3'")
        page.click("#drop [value=watch]")
        verdict = "document.querySelector('#drop .verdict').innerText"
        page.wait_for(f"{verdict}.startsWith('printed as on this page') && frames.length === 1")
        # The arrows are below the button, and seen.
        middle = (
            "document.elementFromPoint(innerWidth / 2, document.querySelector('iframe').getBoundingClientRect().y + 50)"
        )
        assert page.evaluate(f"{middle}.tagName") == "IFRAME"
        page.click("#drop .output button")
        # The verdict on the run stays there when the picture is closed.
        page.wait_for("document.querySelector('#drop .output button').innerText === 'Start' && frames.length === 0")
        assert page.evaluate(verdict).startswith("printed as on this page")
        # Two programs, each with its own Stop and Start.
        crash = "[...document.querySelectorAll('.run')].find(each => each.innerText.includes('--crash-on 3'))"
        page.evaluate(f"{crash}.id = 'crash'")
        page.click("#crash form button")
        page.wait_for("document.querySelector('#crash section')?.innerText.includes(', crash')")
        page.wait_for("document.querySelector('#crash section button').innerText === 'Start'")
        page.click("#crash section button")
        page.wait_for("document.querySelector('#crash section + section').innerText.includes('done: 4 replies')")
        assert "from the journal" in page.text("#crash section")
        write = (
            "(() => {{ const text = document.querySelector('textarea'); text.value = text.value.replace({}, {}); }})()"
        )
        page.click(".own [value=save]")
        page.wait_for("document.querySelector('textarea').value.includes('def answer')")
        page.evaluate(write.format("'    if not (asked'", """'    return "7"\\n    if not (asked'"""))
        page.evaluate("document.querySelector('.own input').value = '--count 1000000 --tries 20'")
        page.click(".own [value=save]")
        page.wait_for("document.querySelector('.own .output')?.innerText.includes('sent add 1, received 7')")
        page.evaluate(write.format("'return \"7\"'", "'return str(-5 * next(numbers))'"))
        page.evaluate(write.format("'def answer'", "'numbers = itertools.count(1)\\n\\n\\ndef answer'"))
        # The client goes on.
        page.click(".own [value=save]")
        page.wait_for("document.querySelector('.own .output').innerText.includes('sent add 1, received -5')")
        page.click("[value=check]")
        page.wait_for("document.querySelector('.own .verdict.good')?.innerText === 'done'")
        path = site.folder / "02_lazy_pirate" / "server.py"
        path.write_text("# by my editor\n", encoding="utf-8")
        page.evaluate("window.confirm = () => false")
        page.click(".own [value=save]")
        page.wait_for("document.querySelector('.mistake').innerText.startsWith('not saved: ')")
        page.evaluate("window.confirm = () => true")
        page.click(".own [value=save]")
        page.wait_for("document.querySelector('textarea').value === '# by my editor\\n'")
        page.click(".own [value=again]")
        page.wait_for("document.querySelector('textarea').value.includes('def answer')")
        assert path.read_bytes() == (ROOT / "python" / "02_lazy_pirate" / "server.py").read_bytes()
        # A program that prints without end: the page stays quick, and keeps the last lines.
        before = page.memory()
        endless = "import itertools\\nfor number in itertools.count():\\n    print(number)\\n"
        page.evaluate(f"document.querySelector('textarea').value = '{endless}'")
        page.click(".own [value=save]")
        lines = "document.querySelector('.own .output pre')?.textContent.split('\\n')"
        page.wait_for(f"{lines}?.at(-1) > 20000")
        assert page.evaluate(f"{lines}.length") == 500 and page.memory() - before < 10_000_000
        page.click(".own .output button")
        page.wait_for("document.querySelector('.own .output .verdict').textContent === 'stopped'")
        page.click("main a[href*='LazyPirateRequester.cs']")
        page.wait_for("document.querySelector('dialog').innerText.includes('class LazyPirateRequester')")
        page.press("Escape")
        page.resize(390, 800)
        before = page.evaluate("parseFloat(getComputedStyle(document.body).fontSize)")
        page.press("b")
        assert page.evaluate("parseFloat(getComputedStyle(document.body).fontSize)") == 2 * before
        assert page.evaluate("document.documentElement.scrollWidth <= innerWidth")
        page.press("/")
        page.type("Address already in use")
        page.wait_for("document.querySelector('#found').innerText.includes('AddressAlreadyInUseException')")
        from_here = "performance.getEntriesByType('resource').every(each => each.name.startsWith('http://127.0.0.1:'))"
        assert page.evaluate(from_here)
        assert page.errors == []
        # A content security policy that is broken is said in the console; so is what comes from elsewhere.
        assert page.said == []
        page.go(f"{site.url}class")
        assert page.evaluate("document.querySelector('[data-tick=\\'02_lazy_pirate\\']').checked")


@finds_processes
def test_a_page_of_a_stranger_starts_nothing(tmp_path, open_page):
    """Even if it knows the whole address."""
    mark = Mark()
    (tmp_path / "index.html").write_text("<title>elsewhere</title><body></body>", encoding="utf-8")
    files = functools.partial(http.server.SimpleHTTPRequestHandler, directory=tmp_path)
    with (
        opened(tmp_path, **mark.environment) as site,
        http.server.ThreadingHTTPServer(("127.0.0.1", 0), files) as other,
    ):
        threading.Thread(target=other.serve_forever, daemon=True).start()
        alone, wish = mark.processes(), json.dumps(json.dumps(block(FIRST, "run 1")))
        page = open_page(f"http://127.0.0.1:{other.server_port}/")
        for mode in ("cors", "no-cors"):
            page.evaluate(f"fetch('{site.url}run', {{method: 'POST', mode: '{mode}', body: {wish}}}).catch(() => 0)")
        frame = f"Object.assign(document.createElement('iframe'), {{src: '{site.url}{FIRST}', onload: done}})"
        page.evaluate(f"new Promise(done => document.body.append({frame}))")
        assert mark.processes() == alone
        assert any("frame-ancestors" in line or "X-Frame-Options" in line for line in page.said), page.said
        other.shutdown()
