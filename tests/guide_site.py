"""A guide that `kit.py guide` serves, and a way to ask it as its own page does."""

import contextlib
import http.client
import json
import socket
from urllib.parse import urlsplit

from kitlib.docs import guide
from kitlib.guide_page.runs import FIRST
from tests.conftest import PYTHON
from tests.programs import LIMIT, ROOT, Program


class Site:
    """The address of a guide, and what it answers."""

    def __init__(self, program, folder):
        self.program, self.folder = program, folder
        # It builds the C# client first, where no other test has done so.
        self.url = program.wait_for(r"(http://127\.0\.0\.1:\S+) in a browser; Ctrl-C ends it", limit=600)[1]
        self.port, self.base = urlsplit(self.url).port, urlsplit(self.url).path
        self.origin = f"http://127.0.0.1:{self.port}"

    def ask(self, path, wish=None, base="", **headers):
        """The status, the headers and the text of an answer; a header that is empty is left out."""
        connection = http.client.HTTPConnection("127.0.0.1", self.port, timeout=LIMIT)
        method, body, origin = ("GET", None, "") if wish is None else ("POST", json.dumps(wish), self.origin)
        given = {name: value for name, value in {"Origin": origin, **headers}.items() if value}
        with contextlib.closing(connection):
            connection.request(method, (base or self.base) + path, body, given)
            answer = connection.getresponse()
            return answer.status, answer.headers, answer.read().decode("utf-8", "replace")

    def told(self, path, wish):
        """The lines of each speaker of a run, and its last news, a verdict."""
        status, _, text = self.ask(path, wish)
        assert status == 200, text
        news = [json.loads(line) for line in text.splitlines()]
        said = {"command": [news[0]["command"]]}
        for each in news:
            said.setdefault(each.get("who"), []).append(each.get("text"))
        return said, news[-1]

    @contextlib.contextmanager
    def listening(self, path, wish):
        """The lines of a run as they come, until its tab is closed."""
        body = json.dumps(wish)
        head = f"POST {self.base}{path} HTTP/1.0\r\nHost: 127.0.0.1:{self.port}\r\nOrigin: {self.origin}\r\n"
        with socket.create_connection(("127.0.0.1", self.port), LIMIT) as tab, tab.makefile("rw", newline="") as lines:
            lines.write(f"{head}Content-Length: {len(body)}\r\n\r\n{body}")
            lines.flush()
            yield lines


def block(page, command, step=0, **values):
    """The page's own words to run a command of this block."""
    bodies = [each.body for each in guide.blocks(ROOT / page)]
    wish = {"page": page, "block": bodies.index(f"python3 kit.py {command}\n"), "step": step, "watch": False}
    return {**wish, "values": values}


@contextlib.contextmanager
def opened(tmp_path, *options, **environment):
    """BROWSER names the program that opens a page: here one that does nothing.

    It is never the first guide here, so its programs leave the lessons' own ports to whoever else is on this machine.
    """
    words = [PYTHON, ROOT / "kit.py", "guide", "--folder", tmp_path / "anna", *options]
    first = socket.socket(type=socket.SOCK_DGRAM)
    with contextlib.suppress(OSError):
        first.bind(("127.0.0.1", FIRST))
    program = Program(words, folder=tmp_path, BROWSER=f"'{PYTHON}' -c pass %s", **environment)
    try:
        yield Site(program, tmp_path / "anna")
    finally:
        # Also after a test that failed it is asked, not killed: what it has started ends with it.
        code = program.stop()
        first.close()
    assert code == 0 and "Traceback" not in program.output, program.output
