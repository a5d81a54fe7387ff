"""The words after kit.py: what each command explains of itself, and one line with the cure for a wrong word."""

from __future__ import annotations

import argparse
import difflib
import platform
import re
import shlex
import sys
import tomllib
from collections.abc import Callable, Sequence
from typing import NoReturn

from kitlib import lessons
from kitlib.lessons import KIT, ROOT, KitError, UsageError, find


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
            allow_abbrev=False,
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


class Half(Command):
    """A command for one program of a lesson, which gets the words that are not our own."""

    def parse(self, words: list[str]) -> argparse.Namespace:
        options, options_of_the_program = self.parse_known_args(words)
        options.words = options_of_the_program
        return options


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
        print(about.strip().replace("python3 kit.py", KIT))
        # Who typed nothing wanted something, and a script must notice that nothing was done.
        return 0 if words else 2
    if words[0] in ("--version", "version"):
        print(version())
        return 0
    command = next((command for command in commands if command.name == words[0]), None)
    if command is None:
        raise UsageError(f"there is no command '{words[0]}'; {meant(words[0], [each.name for each in commands])}")
    return command.do(command.parse(words[1:]))


def version() -> str:
    """What a report of a bug wants to know first."""
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    return f"NetMQExample {project['version']}, Python {sys.version.split()[0]}, {platform.platform()}"


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
    lexer = shlex.shlex(text, posix=True, punctuation_chars=False)
    lexer.whitespace_split, lexer.commenters = True, ""
    if lessons.WINDOWS:
        # A backslash there is part of a path.
        lexer.escape = ""
    try:
        return list(lexer)
    except ValueError:
        raise UsageError(f'{option} {text}: a quotation mark in it is not closed; write {option}="…"') from None
