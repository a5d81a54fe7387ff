"""A real browser, driven by Chrome's DevTools protocol: no package, no port, only two pipes.

    with Chromium() as chromium:
        page = chromium.open("http://127.0.0.1:5566/")
        page.wait_for("document.querySelector('#reply').textContent === 'World'")

The browser is the one that KIT_CHROMIUM names, or a Chromium or Chrome on the path.
"""

import base64
import json
import os
import select
import shutil
import subprocess
import sys
import tempfile
import time
from pathlib import Path

from tests.programs import LIMIT

NAMES = ("chromium-headless-shell", "chromium", "chromium-browser", "google-chrome", "chrome")
MISSING = "no Chromium: install it, or set KIT_CHROMIUM to the program"

# Chromium reads from 3 and writes to 4. A number of ours may be one of these: first both get higher ones.
RENUMBER = """
import fcntl, os, sys
numbers = [fcntl.fcntl(int(number), fcntl.F_DUPFD, 10) for number in sys.argv[1:3]]
for number, wanted in zip(numbers, (3, 4)):
    os.dup2(number, wanted)
os.execv(sys.argv[3], sys.argv[3:])
"""


def find():
    """The browser's program, or None. Pipes have the numbers 3 and 4, which Windows does not know."""
    named = os.environ.get("KIT_CHROMIUM")
    found = named or next((path for name in NAMES if (path := shutil.which(name))), None)
    return shutil.which(found) if found and os.name == "posix" else None


class Chromium:
    """One browser process; each page in it is a tab of its own, without the cookies and the storage of the others."""

    def __init__(self):
        self.profile = tempfile.TemporaryDirectory(ignore_cleanup_errors=True)
        from_us, self.out = os.pipe()
        self.into, to_us = os.pipe()
        words = ["--headless", "--remote-debugging-pipe", f"--user-data-dir={self.profile.name}", "--no-first-run"]
        # In a container /dev/shm is small, and its root has no sandbox.
        words += ["--disable-dev-shm-usage", "--disable-gpu", *(["--no-sandbox"] if os.geteuid() == 0 else [])]
        renumber = [sys.executable, "-c", RENUMBER, str(from_us), str(to_us)]
        command, nothing = [*renumber, find(), *words, "about:blank"], subprocess.DEVNULL
        # Its other files go there as well.
        own = {**os.environ, "XDG_CONFIG_HOME": self.profile.name, "XDG_CACHE_HOME": self.profile.name}
        self.process = subprocess.Popen(
            command, pass_fds=(from_us, to_us), stdin=nothing, stdout=nothing, stderr=nothing, env=own
        )
        os.close(from_us)
        os.close(to_us)
        self.number, self.pages, self.received = 0, {}, b""

    def __enter__(self):
        return self

    def __exit__(self, *_):
        # It ends when its pipe does.
        os.close(self.out)
        try:
            self.process.wait(10)
        except subprocess.TimeoutExpired:
            self.process.kill()
            self.process.wait()
        os.close(self.into)
        self.profile.cleanup()

    def open(self, url, width=1000, height=800, dark=False):
        """A new tab of this size, once the page is loaded."""
        context = self.call("Target.createBrowserContext")["browserContextId"]
        target = self.call("Target.createTarget", url="about:blank", browserContextId=context)["targetId"]
        session = self.call("Target.attachToTarget", targetId=target, flatten=True)["sessionId"]
        page = self.pages[session] = Page(self, session, target, context)
        for domain in ("Page", "Runtime", "Log"):
            page.call(f"{domain}.enable")
        page.resize(width, height)
        scheme = {"name": "prefers-color-scheme", "value": "dark" if dark else "light"}
        page.call("Emulation.setEmulatedMedia", features=[scheme])
        page.go(url)
        return page

    def call(self, method, session=None, limit=LIMIT, **parameters):
        self.number += 1
        message = {"id": self.number, "method": method, "params": parameters}
        data = json.dumps({**message, **({"sessionId": session} if session else {})}).encode() + b"\0"
        while data:
            data = data[os.write(self.out, data) :]
        deadline = time.monotonic() + limit
        while True:
            answer = self.receive(deadline, method)
            if answer.get("id") == self.number:
                assert "error" not in answer, f"{method}: {answer['error']['message']}"
                return answer["result"]

    def receive(self, deadline, why):
        while b"\0" not in self.received:
            ready, _, _ = select.select([self.into], [], [], max(0.0, deadline - time.monotonic()))
            assert ready, f"Chromium was silent: {why}"
            data = os.read(self.into, 1 << 20)
            assert data, f"Chromium has ended: {why}"
            self.received += data
        text, _, self.received = self.received.partition(b"\0")
        message = json.loads(text)
        if page := self.pages.get(message.get("sessionId")):
            page.hear(message)
        return message


class Page:
    """A tab. `said` is what the page wrote to the console, `errors` what nobody caught."""

    def __init__(self, chromium, session, target, context):
        self.chromium, self.session, self.target, self.context = chromium, session, target, context
        self.said, self.errors = [], []

    def hear(self, message):
        about = message.get("params", {})
        if message.get("method") == "Runtime.exceptionThrown":
            details = about["exceptionDetails"]
            self.errors.append(details.get("exception", {}).get("description") or details["text"])
        elif message.get("method") == "Runtime.consoleAPICalled":
            self.said.append(" ".join(str(each.get("value", each.get("description"))) for each in about["args"]))
        elif message.get("method") == "Log.entryAdded":
            self.said.append(f"{about['entry']['text']} {about['entry'].get('url', '')}")

    def call(self, method, **parameters):
        return self.chromium.call(method, self.session, **parameters)

    def go(self, url):
        failed = self.call("Page.navigate", url=url).get("errorText")
        assert not failed, f"{url}: {failed}"
        self.wait_for("document.readyState === 'complete'")

    def evaluate(self, expression):
        done = self.call("Runtime.evaluate", expression=expression, awaitPromise=True, returnByValue=True)
        assert "exceptionDetails" not in done, f"{expression}: {done['exceptionDetails']}"
        return done["result"].get("value")

    def wait_for(self, expression, limit=LIMIT):
        deadline = time.monotonic() + limit
        while not (value := self.evaluate(expression)):
            if time.monotonic() > deadline:
                shown = self.evaluate("document.body.innerText")
                raise AssertionError(f"never true: {expression}; the page shows:\n{shown}\n{self.said} {self.errors}")
            # It only decides how often it is asked.
            time.sleep(0.02)
        return value

    def text(self, selector):
        """The text of an element as a reader sees it."""
        return self.evaluate(f"document.querySelector({json.dumps(selector)}).innerText")

    def click(self, selector):
        """As a mouse does: on the middle of the element, which must be there and seen."""
        middle = f"""(() => {{ const element = document.querySelector({json.dumps(selector)});
            element.scrollIntoView({{block: 'center'}}); const at = element.getBoundingClientRect();
            return [at.x + at.width / 2, at.y + at.height / 2]; }})()"""
        x, y = self.evaluate(middle)
        for kind in ("mousePressed", "mouseReleased"):
            self.call("Input.dispatchMouseEvent", type=kind, x=x, y=y, button="left", clickCount=1)

    def type(self, text):
        """Text for what has the focus."""
        self.call("Input.insertText", text=text)

    def press(self, key):
        """One key: Enter, Tab, Escape, ArrowDown, a letter."""
        code = {"Enter": 13, "Tab": 9, "Escape": 27, "ArrowDown": 40, "ArrowUp": 38, " ": 32}.get(key, ord(key[0]))
        characters = {"text": "\r" if key == "Enter" else key} if key == "Enter" or len(key) == 1 else {}
        for kind in ("keyDown", "keyUp"):
            self.call("Input.dispatchKeyEvent", type=kind, key=key, windowsVirtualKeyCode=code, **characters)

    def resize(self, width, height):
        """The size of the page itself, as on a screen of that size."""
        size = {"width": width, "height": height, "deviceScaleFactor": 1, "mobile": False}
        self.call("Emulation.setDeviceMetricsOverride", **size)

    def memory(self):
        """Bytes of the page's JavaScript, after its garbage was collected."""
        self.call("HeapProfiler.collectGarbage")
        return self.call("Runtime.getHeapUsage")["usedSize"]

    def picture(self, path):
        """The page as it looks, in a PNG file."""
        Path(path).write_bytes(base64.b64decode(self.call("Page.captureScreenshot", format="png")["data"]))

    def close(self):
        self.chromium.call("Target.disposeBrowserContext", browserContextId=self.context)
        self.chromium.pages.pop(self.session, None)
