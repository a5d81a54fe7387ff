"""Application 21, words of a real model: Ollama makes them, on this computer or another one.

    ollama pull llama3.2
    python python/21_talking_character/server.py --ollama http://127.0.0.1:11434 --model llama3.2

Bytes: HTTP; POST /api/chat is answered with a line of JSON for each piece of the text, until one says "done".
"""

import json
from argparse import ArgumentTypeError
from collections.abc import Iterator
from contextlib import closing
from http.client import HTTPConnection, HTTPException, HTTPSConnection
from urllib.parse import urlsplit

from netmq_example.jobs.work import Step, WorkError

PERSONA = "You keep an old bridge and talk to a traveller. Answer in a few short sentences of plain text."
# Seconds of silence: a large model is loaded first. Bytes of a line, and characters that are enough for a speech.
SILENCE, LINE, LONGEST = 120, 65_536, 5000


def ollama(text: str) -> str:
    """The type of an option: where Ollama is."""
    try:
        parts = urlsplit(text)
        if parts.scheme in ("http", "https") and parts.hostname and parts.port != 0:
            return text.rstrip("/")
    except ValueError:
        pass
    raise ArgumentTypeError(f"bad address '{text}': write it like http://127.0.0.1:11434")


def ollama_talk(count: int, finished: bytes, prompt: str, *, url: str, model: str) -> Iterator[Step]:
    """When the player walks away this generator is closed, and so the connection: that stops the model."""
    parts, text, done = urlsplit(url), "", 0
    connect = HTTPSConnection if parts.scheme == "https" else HTTPConnection
    try:
        with closing(connect(parts.hostname or "", parts.port, timeout=SILENCE)) as connection:
            for done, piece in enumerate(pieces(connection, f"{parts.path}/api/chat", count, prompt, model), 1):
                text += piece
                yield Step(min(done, count), count, text[:LONGEST])
                if len(text) > LONGEST:
                    break
    except TimeoutError:
        raise WorkError(f"{model} at {url} said nothing for {SILENCE} s: try a smaller model") from None
    except (OSError, HTTPException) as error:
        if done:
            raise WorkError(f"{url} ended in the middle: did Ollama crash?") from None
        why = getattr(error, "strerror", "") or type(error).__name__
        raise WorkError(f"no connection with {url} ({why}): start Ollama: ollama serve") from None
    except (ValueError, KeyError, TypeError, AttributeError, RecursionError):
        raise WorkError(f"what answers at {url} is not Ollama: check --ollama") from None
    yield Step(done, done, text if len(text) <= LONGEST else f"{text[:LONGEST]}…")


def pieces(connection: HTTPConnection, path: str, count: int, prompt: str, model: str) -> Iterator[str]:
    talk = [{"role": "system", "content": PERSONA}, {"role": "user", "content": prompt}]
    request = {"model": model, "messages": talk, "stream": True, "options": {"num_predict": count}}
    connection.request("POST", path, json.dumps(request), {"Content-Type": "application/json"})
    response = connection.getresponse()
    if response.status != 200:
        why = json.loads(response.read(LINE))["error"]
        raise WorkError(f"Ollama says: {why!s:.120}" + f"; try: ollama pull {model}" * (response.status == 404))
    while line := response.readline(LINE):
        news = json.loads(line)
        if "error" in news:
            raise WorkError(f"Ollama says: {news['error']!s:.120}")
        yield news["message"]["content"]
        if news["done"]:
            return
    raise ConnectionResetError
