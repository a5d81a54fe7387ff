"""Draws the pictures of the guide in the browser: .venv/bin/python -m tests.web.guide_pictures"""

import tempfile
from pathlib import Path

from PIL import Image

from tests.guide_site import opened
from tests.programs import ROOT
from tests.web.chromium import Chromium

# By the name of the picture: the page, and the words in the block whose button is pressed.
PICTURES = {"guide_start": ("start_here", "kit.py run 1"), "guide_break": ("02_lazy_pirate", "--drop 3")}


def main() -> None:
    print("waiting for the guide, which builds the C# client first …", flush=True)
    with tempfile.TemporaryDirectory() as folder, Chromium() as chromium, opened(Path(folder)) as site:
        for name, (page, words) in PICTURES.items():
            print(f"{name}: running {words} of {page} …", flush=True)
            tab = chromium.open(f"{site.url}docs/guide/{page}.md", 1240, 860)
            block = f"[...document.querySelectorAll('.run')].find(each => each.innerText.includes({words!r}))"
            tab.evaluate(f"{block}.id = 'shown'")
            tab.click("#shown form button")
            verdict = tab.wait_for("document.querySelector('#shown .verdict:is(.good, .bad)')?.innerText")
            assert verdict.startswith("printed as on this page"), verdict
            tab.evaluate("window.scrollTo(0, document.querySelector('#shown').offsetTop - 160)")
            path = ROOT / "img" / f"{name}.png"
            tab.picture(path)
            with Image.open(path) as drawn:
                # As many colours as a page with smooth letters needs.
                drawn.convert("RGB").quantize(64).save(path, optimize=True)
            print(f"{name}: {path.stat().st_size} bytes", flush=True)
            tab.close()


if __name__ == "__main__":
    main()
