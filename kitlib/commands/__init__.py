"""The words after kit.py: a module for each command, and one line with the cure for a wrong word.

A command's module says what it is for in ABOUT and EXAMPLES, adds its options, if it has some, and does it. A word that
it does not know is answered with its CURE; or else, where PASSES_ON is true, it is for the program that is started,
whose own options `program_help` may add to the help.
"""

import argparse
import difflib
import importlib
import io
import platform
import re
import sys
from collections.abc import Callable, Sequence
from pathlib import Path
from types import ModuleType
from typing import NoReturn

from kitlib.lessons import KIT, ROOT, KitError, UsageError, docstring, unwritable
from kitlib.setup.python_setup import project
from kitlib.signals import interruptible
from kitlib.terminal import coloured, nobody_reads, open_streams


def guarded(work: Callable[[], int]) -> int:
    """The exit code of this work, or of what ended it: one line for what a user can mend."""
    open_streams()
    # A legacy console code page must not turn a printed line into a traceback; and in a pipe every system gets UTF-8.
    for stream in (sys.stdout, sys.stderr):
        if isinstance(stream, io.TextIOWrapper):
            stream.reconfigure(encoding=None if stream.isatty() else "utf-8", errors="backslashreplace")
    interruptible()
    try:
        return work()
    except KitError as error:
        return complain(error, error.code)
    except SyntaxError as error:
        # Of a lesson's program, which is read for what it needs.
        return complain(f"{error.filename}, line {error.lineno}: {error.msg}; fix it")
    except KeyboardInterrupt:
        return 130
    except BrokenPipeError:
        nobody_reads()
        return 1
    except OSError as error:
        # A full disk, a folder of somebody else's: whatever it is, the system's own words name it.
        why = "free some space, or try another folder"
        if isinstance(error, FileExistsError | NotADirectoryError):
            why = "it is in the way: name another place"
        elif isinstance(error, PermissionError):
            why = unwritable(Path(str(error.filename or ROOT)))
        return complain(f"{error}; {why}")


def complain(why: object, code: int = 1) -> int:
    print(coloured("kit    |", "error", sys.stderr), why, file=sys.stderr)
    return code


def start(names: Sequence[str], words: list[str]) -> int:
    """Find the command and do it."""
    if not words or words[0] in ("-h", "--help", "help"):
        print(docstring(ROOT / "kit.py").replace("python3 kit.py", KIT))
        # An empty command line is a mistake, and a script must notice that nothing was done.
        return 0 if words else 2
    name = words[0]
    if name in ("--version", "version"):
        print(f"NetMQExample {project()['version']}, Python {sys.version.split()[0]}, {platform.platform()}")
        return 0
    if name not in names:
        there_are = f"there are: {', '.join(names)}"
        raise UsageError(f"there is no command '{name}'; {meant(name.strip('-').lower(), names, 0.6) or there_are}")
    command = importlib.import_module(f"kitlib.commands.{name}")
    code: int = command.do(parse(command, words[1:]))
    return code


class Parser(argparse.ArgumentParser):
    def error(self, message: str) -> NoReturn:
        """Called by argparse: one line, instead of its usage and its own way out."""
        raise UsageError(f"{message}; `{self.prog} --help` shows how")


def parse(command: ModuleType, words: list[str]) -> argparse.Namespace:
    """The options of these words; what is no option of this command is passed on, or named with its cure."""
    name = command.__name__.rpartition(".")[2]
    passes_on = getattr(command, "PASSES_ON", False)
    examples = "examples:\n" + "\n".join(f"  {KIT} {example}" for example in command.EXAMPLES)
    asked = hasattr(command, "program_help") and words[1:] in (["-h"], ["--help"])
    parser = Parser(
        prog=f"{KIT} {name}",
        description=command.ABOUT,
        epilog=f"{examples}\n\n{command.program_help(words[0])}" if asked else examples,
        formatter_class=argparse.RawDescriptionHelpFormatter,
        allow_abbrev=False,
    )
    if hasattr(command, "add_options"):
        command.add_options(parser)
    # The words after `--` are never taken for our own.
    end = words.index("--") if passes_on and "--" in words else len(words)
    options, rest = parser.parse_known_args(words[:end])
    if passes_on:
        options.words = rest + words[end + 1 :]
    elif rest:
        word = rest[0].split("=")[0]
        cure = getattr(command, "CURE", f"`{parser.prog} --help` shows what it takes")
        near = meant(word, re.findall(r"--[\w-]+", parser.format_usage()), 0.75)
        raise UsageError(f"{name} takes no '{word}'; {near or cure}")
    return options


def meant(word: str, known: Sequence[str], cutoff: float) -> str:
    """A guess at what somebody wanted to type, or nothing."""
    near = difflib.get_close_matches(word, known, 1, cutoff)
    return f"did you mean {near[0]}?" if near else ""
