"""An error that ends a program says in its one line what went wrong and what to do, so no page has to explain it."""

import ast
import re

from tests.programs import ROOT

# Those that end a program. A MessageError is a reply with a code, and a ValueError a mistake in the caller's code.
PYTHON = {
    *("Error", "Timeout", "Lost", "Closed", "ListenError", "SourceError", "WorkError", "OSError"),
    *("KitError", "UsageError", "NoNetMQ", "argparse.ArgumentTypeError", "sys.exit"),
}
CSHARP = "TimeoutException|UsageException|GaveUpException|InvalidOperationException"
# "…; do this", "…: do this", a question that leads to the cause, a hole called cure, or the rule that was broken.
CURE = r"; |: (?!\{)|\?|\{(with_)?cure|\{pip_install| takes | must |, not \{"
# These hand on a text of another place that has its own cure, or another program's words.
HANDED_ON = r"(gave up|no poses|failed|Ollama says): \{.*|scope, \{.*|\{[^}]*\}: \{.*"
# After these a program goes on by itself, or it has closed the thing itself.
GOES_ON = {"the client was disposed", "the environment is gone, or silent", "Python is gone", "no connection"}
GOES_ON |= {"the client was closed", "the listener was stopped", "the game is gone", "there is no game, or it is gone"}


def without_code(text):
    """The hole of an f-string holds code: of it only the name is kept."""
    return re.sub(r"\{(\w*)[^{}]*\}", r"{\1}", text)


def text_of(node):
    """The text that an expression is made of, with its holes; empty if it is none."""
    if isinstance(node, ast.Constant) and isinstance(node.value, str):
        return node.value
    if isinstance(node, ast.JoinedStr):
        return without_code(ast.unparse(node)[2:-1])
    return text_of(node.left) + text_of(node.right) if isinstance(node, ast.BinOp) else ""


def python_texts(path):
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if isinstance(node, ast.Call) and ast.unparse(node.func) in PYTHON and node.args:
            yield text_of(node.args[0])


def csharp_texts(path):
    for thrown in re.findall(rf"throw new (?:{CSHARP})\((.*?)\);\n", path.read_text(encoding="utf-8"), re.DOTALL):
        yield without_code("".join(re.findall(r'"((?:[^"\\]|\\.)*)"', thrown)))


def test_an_error_names_its_cause_and_a_thing_to_do():
    texts = {}
    for tree in ("kit.py", "kitlib/**/*.py", "lab/**/*.py", "python/**/*.py"):
        texts |= {text: path for path in ROOT.glob(tree) for text in python_texts(path)}
    for tree in ("unity/**/*.cs", "csharp-console/*.cs"):
        texts |= {text: path for path in ROOT.glob(tree) for text in csharp_texts(path)}
    assert len(texts) > 150
    assert [
        f"{path.relative_to(ROOT).as_posix()}: {text}"
        for text, path in texts.items()
        if text and not re.search(CURE, text) and not re.fullmatch(HANDED_ON, text) and text not in GOES_ON
    ] == []
