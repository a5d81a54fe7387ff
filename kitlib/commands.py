"""The words after kit.py: what each command explains of itself, and one line with the cure for a wrong word."""

from __future__ import annotations

import argparse
import difflib
import re
import shlex
from collections.abc import Callable, Sequence
from typing import NoReturn

from .lessons import KitError, UsageError, find

KIT = "python3 kit.py"


class Command(argparse.ArgumentParser):
    """One command: `do` is what it does with its options, `cure` is said to who gives it a word too many."""

    def __init__(
        self, name: str, do: Callable[[argparse.Namespace], int], about: str, examples: Sequence[str], cure: str = ""
    ) -> None:
        super().__init__(
            prog=f"{KIT} {name}",
            description=about,
            epilog="examples:\n" + "\n".join(f"  {example}" for example in examples),
            formatter_class=argparse.RawDescriptionHelpFormatter,
        )
        self.name = name
        self.do = do
        self.cure = cure

    def parse(self, words: list[str]) -> argparse.Namespace:
        """The options of these words; what is no option of this command is named with its cure."""
        options, rest = self.parse_known_args(words)
        if rest:
            raise UsageError(self.answer(rest[0].split("=")[0]))
        return options

    def answer(self, word: str) -> str:
        """What to say to a word that this command does not know."""
        known = re.findall(r"--[\w-]+", self.format_usage())
        cure = self.cure or f"`{self.prog} --help` shows what it takes"
        near = difflib.get_close_matches(word, known, 1, 0.75)
        return f"{self.name} takes no '{word}'; " + (f"did you mean {near[0]}?" if near else cure)

    def error(self, message: str) -> NoReturn:
        """Called by argparse: one line, instead of its usage and its own way out."""
        raise UsageError(f"{message}; `{self.prog} --help` shows how")


class PassingOn(Command):
    """A command whose words are for another program, all but --help."""

    def parse(self, words: list[str]) -> argparse.Namespace:
        """All words as they are, in `words`; those after `--` are never taken for our own."""
        own = words[: words.index("--")] if "--" in words else words
        if {"-h", "--help"} & set(own):
            self.print_help()
            raise SystemExit(0)
        return argparse.Namespace(words=[*own, *words[len(own) + 1 :]])


def start(commands: Sequence[Command], about: str, words: list[str]) -> int:
    """Do what the words say; returns the exit code."""
    if not words or words[0] in ("-h", "--help", "help"):
        print(about.strip())
        # Who typed nothing wanted something, and a script must notice that nothing was done.
        return 0 if words else 2
    command = next((command for command in commands if command.name == words[0]), None)
    if command is None:
        raise UsageError(f"there is no command '{words[0]}'; {meant(words[0], [each.name for each in commands])}")
    return command.do(command.parse(words[1:]))


def meant(word: str, names: list[str]) -> str:
    """A guess at what somebody wanted to type, or all that there is."""
    near = difflib.get_close_matches(word.strip("-").lower(), names, 1)
    if near:
        return f"did you mean {near[0]}?"
    try:
        return f"did you mean `{KIT} run {find(word).number}`?"
    except KitError:
        return f"there are: {', '.join(names)}"


def split(text: str, option: str) -> list[str]:
    """The words of an option that holds options for a program."""
    try:
        return shlex.split(text)
    except ValueError:
        raise UsageError(f'{option} {text}: a quotation mark in it is not closed; write {option}="…"') from None
