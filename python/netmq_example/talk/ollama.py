"""Words of a real model: Ollama makes them, on this computer or another one. A kind of work for netmq_example.jobs.

    talk = functools.partial(ollama_talk, url="http://127.0.0.1:11434", model="llama3.2")
    for step in talk(200, b"", "Who are you?"):                 at most 200 words or parts of words
        print(step.text)                                        all of it so far

Bytes: HTTP; POST /api/chat is answered with a line of JSON for each piece of the text, until one says "done"
(github.com/ollama/ollama, docs/api.md). WorkError says what is wrong, and what to do.
"""

import json
from collections.abc import Iterator
from contextlib import closing
from http.client import HTTPConnection, HTTPException, HTTPSConnection
from typing import Any
from urllib.parse import urlsplit

from netmq_example import arguments
from netmq_example.json_text import shallow
from netmq_example.work import Step, WorkError

PERSONA = "You keep an old bridge and talk to a traveller. Answer in a few short sentences of plain text."
# A large model is loaded first.
SILENCE_SECONDS = 120
LARGEST_LINE_BYTES = 65_536
MOST_CHARACTERS = 5000
MOST_THOUGHTS = 500_000


def address(_: str, value: Any) -> str:
    """Where Ollama is: a rule as those of check.py."""
    try:
        parts = urlsplit(value)
        if parts.scheme in ("http", "https") and parts.hostname and parts.port != 0:
            return str(value).rstrip("/")
    except (ValueError, AttributeError, TypeError):
        pass
    raise ValueError(f"bad address '{value!s:.80}': write it like http://127.0.0.1:11434")


def ollama_talk(count: int, finished: bytes, prompt: str, *, url: str, model: str) -> Iterator[Step]:
    """When the player walks away this generator is closed, and so the connection: that stops the model."""
    parts = urlsplit(address("url", url))
    arguments.text("model", model)
    connect = HTTPSConnection if parts.scheme == "https" else HTTPConnection
    text = said = ""
    done = 0
    # The fields that came in place of words.
    beside: set[str] = set()
    try:
        with closing(connect(parts.hostname or "", parts.port, timeout=SILENCE_SECONDS)) as connection:
            for done, piece in enumerate(pieces(connection, f"{parts.path}/api/chat", count, prompt, model), 1):
                text += piece["content"] or ""
                beside |= {name for name in ("thinking", "tool_calls") if piece.get(name)}
                said = spoken(text)
                yield Step(min(done, count), count, said[:MOST_CHARACTERS])
                if len(said) > MOST_CHARACTERS or len(text) > MOST_THOUGHTS:
                    break
    except TimeoutError:
        raise WorkError(f"{model} at {url} said nothing for {SILENCE_SECONDS} s: try a smaller model") from None
    except (OSError, HTTPException) as error:
        if done:
            raise WorkError(f"{url} ended in the middle: did Ollama crash?") from None
        why = getattr(error, "strerror", "") or type(error).__name__
        raise WorkError(f"no connection with {url} ({why}): start Ollama: ollama serve") from None
    except (ValueError, KeyError, TypeError, AttributeError):
        raise WorkError(f"what answers at {url} is not Ollama: check --ollama") from None
    if not said.strip():
        if text.strip():
            beside.add("thinking")
        why = f", after {' and '.join(sorted(beside))}" if beside else ""
        raise WorkError(f"{model} ended without a word{why}: take another model, one that does not think")
    yield Step(done, done, said if len(said) <= MOST_CHARACTERS else f"{said[:MOST_CHARACTERS]}…")


def spoken(text: str) -> str:
    """Without what some models put first, what they think, in <think>…</think>; also while that is not whole yet."""
    text = text.lstrip()
    if text.startswith("<think>"):
        return text.partition("</think>")[2].lstrip()
    return "" if "<think>".startswith(text) else text


def pieces(connection: HTTPConnection, path: str, count: int, prompt: str, model: str) -> Iterator[dict[str, Any]]:
    """The model's messages, as they come, each with a part of a word or more as its `content`."""
    talk = [{"role": "system", "content": PERSONA}, {"role": "user", "content": prompt}]
    # Thinking would use up the words that the model may say.
    request = {"model": model, "messages": talk, "stream": True, "think": False, "options": {"num_predict": count}}
    connection.request("POST", path, json.dumps(request), {"Content-Type": "application/json"})
    response = connection.getresponse()
    if response.status != 200:
        why = json.loads(shallow(response.read(LARGEST_LINE_BYTES).decode()))["error"]
        cure = f"; try: ollama pull {model}" if response.status == 404 else ""
        raise WorkError(f"Ollama says: {why!s:.120}{cure}")
    while line := response.readline(LARGEST_LINE_BYTES):
        news = json.loads(shallow(line.decode()))
        if "error" in news:
            raise WorkError(f"Ollama says: {news['error']!s:.120}")
        yield news["message"]
        if news["done"]:
            return
    raise ConnectionResetError
