"""Draws the pictures of the guide in the browser: .venv/bin/python -m tests.web.guide_pictures"""

import tempfile
from pathlib import Path

from tests.guide_site import opened
from tests.programs import ROOT
from tests.web.chromium import Chromium

# By the name of the picture: the page, the words in the block whose button is pressed, and the size.
PICTURES = {
    "guide_start": ("start_here", "kit.py run 1", 860),
    "guide_break": ("02_lazy_pirate", "--drop 3", 860),
}


def main() -> None:
    with tempfile.TemporaryDirectory() as folder, Chromium() as chromium, opened(Path(folder)) as site:
        for name, (page, words, height) in PICTURES.items():
            tab = chromium.open(f"{site.url}docs/guide/{page}.md", 1240, height)
            block = f"[...document.querySelectorAll('.run')].find(each => each.innerText.includes({words!r}))"
            tab.evaluate(f"{block}.id = 'shown'")
            tab.click("#shown form button")
            # The first run builds the C# client.
            tab.wait_for("document.querySelector('#shown .verdict')?.innerText.startsWith('as on the page')", limit=600)
            tab.evaluate("window.scrollTo(0, document.querySelector('#shown').offsetTop - 160)")
            tab.picture(ROOT / "img" / f"{name}.png")
            tab.close()


if __name__ == "__main__":
    main()
