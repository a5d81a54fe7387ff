"""Lesson 11, a locator's canonical text: what Python and C# take it for.

    python python/11_observations/locator.py "car@.speed"                     prints: 'car'@['speed'] = $
    python python/11_observations/locator.py ".speed" --scope "car@.body"     prints: 'car'@['body']['speed'] = $
    python python/11_observations/locator.py "car@.speed["                    says at which column what was expected

docs/guide/11_locators.md has the whole language, netmq_example/locator reads it.
"""

import argparse
import io
import sys
from pathlib import Path

sys.path[:0] = map(str, Path(__file__).resolve().parents[:2])
from netmq_example.locator import LocatorError, parse


def main() -> None:
    parser = argparse.ArgumentParser(description="Prints the canonical text of a locator.", add_help=False)
    parser.add_argument("--help", action="help", help="show this")
    parser.add_argument("--scope", help="where a relative locator is put, such as car@.body")
    parser.add_argument("--name", default="", help="the key of a locator without any place")
    parser.add_argument("text", nargs="?", help="the locator, such as .speed")
    options, others = parser.parse_known_args()
    # A text that begins with - is taken for an option that nobody knows.
    texts = others if options.text is None else [options.text, *others]
    if len(texts) != 1:
        parser.error("one locator, in quotes, such as: locator.py '.speed'")
    where = "scope, "
    try:
        scope = None if options.scope is None else parse(options.scope)
        where = ""
        print(parse(texts[0], options.name, scope).text)
    except LocatorError as error:
        print(f"{where}{error}", file=sys.stderr)
        sys.exit(2)


if __name__ == "__main__":
    # As program.py has it, which needs pyzmq: in a pipe Windows would use another encoding.
    if isinstance(sys.stdout, io.TextIOWrapper):
        sys.stdout.reconfigure(encoding="utf-8")
    main()
