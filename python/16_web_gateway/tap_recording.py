"""Lesson 16, a recording: the tap's page with the messages inside, one file that opens without a server.

What a peer sent is in it as letters and digits only (gzip, base64), so nothing of it can become a part of the page.
"""

import argparse
import base64
import gzip
import json
import sys
from pathlib import Path

from arrows import WHOLE, Arrows

HTML = Path(__file__).with_name("tap.html")
BEGIN, END = '<script type="text/plain" id="recording">', "</script>"


def recording(arrows: Arrows, title: str) -> str:
    kept = [each.as_json(WHOLE) for each in arrows.after(0, arrows.number)]
    data = json.dumps({"title": title, "totals": arrows.totals, "arrows": kept}).encode()
    packed = base64.b64encode(gzip.compress(data, mtime=0)).decode()
    return HTML.read_text(encoding="utf-8").replace(BEGIN + END, BEGIN + packed + END)


def file(text: str) -> Path:
    """For argparse: what cannot be written is told now, and not when all has been seen."""
    try:
        Path(text).touch()
    except (OSError, ValueError) as error:
        raise argparse.ArgumentTypeError(f"cannot write {text!r}: {error}; choose another file") from None
    return Path(text)


def write(path: Path, arrows: Arrows, title: str) -> None:
    try:
        path.write_text(recording(arrows, title), encoding="utf-8", newline="\n")
    except OSError as error:
        sys.exit(f"cannot write {path}: {error.strerror}; no recording")
