"""Lesson 16, the gateway's options: what is wrong with an address, a folder of keys or a time is said at once."""

import argparse
import re
import sys
from pathlib import Path
from typing import Any


def address(text: str) -> str:
    """Where browsers come to."""
    port = re.fullmatch(r"http://[\w*-]{1,63}(?:\.[\w-]{1,63})*:(\*|\d{1,5})", text, re.ASCII)
    if not port or int(port[1].replace("*", "0")) > 65535:
        raise argparse.ArgumentTypeError(f"bad endpoint '{text}': write it like http://127.0.0.1:5566, port 0 to 65535")
    return text


def behind(text: str) -> str:
    """A server behind the gateway; libzmq itself takes port 99999 without a word, and waits."""
    port = re.fullmatch(r"tcp://[\w.-]+:(\d{1,5})", text, re.ASCII)
    if not port or not 0 < int(port[1]) < 65536:
        raise argparse.ArgumentTypeError(f"bad endpoint '{text}': write it like tcp://127.0.0.1:5551")
    return text


def keys(folder: str) -> Any:
    """Lesson 15's ClientKeys: a gateway is one client, whoever comes through it."""
    # In its own lesson's folder; at home it lies beside this file.
    sys.path.append(str(Path(__file__).resolve().parents[1] / "15_security"))
    from netmq_example.security.requester import ClientKeys

    try:
        return ClientKeys(Path(folder))
    except (ValueError, OSError) as error:
        raise argparse.ArgumentTypeError(str(error)) from None


def seconds(text: str) -> float:
    if not 0.001 <= float(text) < 86_400:
        raise ValueError
    return float(text)
