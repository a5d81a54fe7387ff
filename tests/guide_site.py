"""A guide that `kit.py guide` serves, and a way to ask it as its own page does."""

import contextlib
import http.client
import json
from urllib.parse import urlsplit

from kitlib.docs import guide
from tests.conftest import PYTHON
from tests.programs import LIMIT, ROOT, Program


class Site:
    """The address of a guide, and what it answers."""

    def __init__(self, program, folder):
        self.program, self.folder = program, folder
        self.url = program.wait_for(r"(http://127\.0\.0\.1:\S+) in a browser; Ctrl-C ends it")[1]
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
        """The lines that a run tells."""
        status, _, text = self.ask(path, wish)
        assert status == 200, text
        return [json.loads(line) for line in text.splitlines()]


def block(page, command, **values):
    """The page's own words to run this command."""
    bodies = [each.body for each in guide.blocks(ROOT / page)]
    return {"page": page, "block": bodies.index(f"python3 kit.py {command}\n"), "values": values, "watch": False}


@contextlib.contextmanager
def opened(tmp_path, **environment):
    """BROWSER names the program that opens a page: here one that does nothing."""
    words = [PYTHON, ROOT / "kit.py", "guide", "--folder", tmp_path / "anna"]
    program = Program(words, folder=tmp_path, BROWSER=f"'{PYTHON}' -c pass %s", **environment)
    try:
        yield Site(program, tmp_path / "anna")
        # Not killed: what it has started ends with it.
        assert program.process.poll() is not None or program.stop() == 0, program.output
        assert "Traceback" not in program.output, program.output
    finally:
        program.kill()
