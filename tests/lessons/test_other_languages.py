"""Lesson 01 in other languages, docs/guide/other_languages: both ways against Python, and what each page promises.

Each program is built into a folder of the test's own from what is installed; where that is not enough the reason says
what to install.
"""

import functools
import os
import re
import shutil
import signal
import subprocess
from pathlib import Path

import pytest
import zmq

from tests.lessons.conftest import ask, bind
from tests.programs import ROOT, steady_endpoint

KEY = "01_request_reply"
FOLDER = ROOT / "docs" / "guide" / "other_languages"
TEN = [*(f"{i}: sent Hello, received World" for i in range(1, 11)), "done: 10 replies"]
# Of each language: the endings of its two files, and what is missing where it cannot run.
LANGUAGES = {
    "C": (".c", "a C compiler and CZMQ: apt install gcc libczmq-dev"),
    "C++": (".cpp", "a C++ compiler and cppzmq: apt install g++ cppzmq-dev"),
    "JavaScript": (".mjs", "Node.js, and in docs/guide/other_languages or NODE_PATH: npm install zeromq@6"),
    "Java": (".java", "a JDK and JeroMQ: apt install default-jdk-headless libjeromq-java, or CLASSPATH=jeromq.jar"),
    "Go": (".go", "Go, libzmq3-dev, and in its module cache: go get github.com/pebbe/zmq4"),
}
# One worker builds a language once.
each_language = pytest.mark.parametrize(
    "language", [pytest.param(name, marks=pytest.mark.xdist_group(f"in {name}")) for name in LANGUAGES]
)


def run(folder, *command, text="", **environment):
    """None where there is no such program."""
    if not shutil.which(command[0]):
        return None
    env = {**os.environ, **environment}
    return subprocess.run(command, cwd=folder, input=text, capture_output=True, text=True, timeout=300, env=env)


def has_header(folder, compiler, kind, name):
    done = run(folder, compiler, "-E", "-x", kind, "-", text=f"#include <{name}>\n")
    return done and done.returncode == 0


def prepare(language, folder):
    """Build both programs in that folder: the words that start the client and the server; or None."""
    if language in ("C", "C++"):
        if not has_header(folder, *(("cc", "c", "czmq.h") if language == "C" else ("c++", "c++", "zmq_addon.hpp"))):
            return None
        for name in ("client", "server"):
            source = (folder / name).with_suffix(LANGUAGES[language][0])
            # As a reader types it.
            words = re.search(r"^//     (c\S+ .*)$", source.read_text(encoding="utf-8"), re.MULTILINE)[1].split()
            done = run(folder, *words, "-Wall", "-Wextra", "-Werror")
            assert done.returncode == 0, done.stderr
        return [folder / "client"], [folder / "server"]
    if language == "JavaScript":
        done = run(FOLDER, "node", "-p", "require.resolve('zeromq')")
        if not done or done.returncode:
            return None
        modules = next(path for path in Path(done.stdout.strip()).parents if path.name == "node_modules")
        (folder / "node_modules").symlink_to(modules, target_is_directory=True)
        return ["node", folder / "client.mjs"], ["node", folder / "server.mjs"]
    if language == "Java":
        jars = os.environ.get("CLASSPATH") or "/usr/share/java/jeromq.jar"
        if not all(Path(jar).exists() for jar in jars.split(os.pathsep)):
            return None
        done = run(folder, "javac", "-cp", jars, "Client.java", "Server.java")
        assert not done or done.returncode == 0, done.stderr
        java = ["java", "-cp", os.pathsep.join([jars, str(folder)])]
        return done and ([*java, "Client"], [*java, "Server"])
    cache = run(folder, "go", "env", "GOMODCACHE")
    if not cache:
        return None
    offline = {"GOPROXY": (Path(cache.stdout.strip()) / "cache" / "download").as_uri(), "GOSUMDB": "off"}
    run(folder, "go", "mod", "init", "hello")
    if run(folder, "go", "get", "github.com/pebbe/zmq4", **offline).returncode:
        return None
    for name in ("client", "server"):
        done = run(folder, "go", "build", "-o", name, f"{name}.go", **offline)
        assert done.returncode == 0, done.stderr
    return [folder / "client"], [folder / "server"]


@pytest.fixture(scope="session")
def programs(tmp_path_factory):
    """programs("Go"): the words that start the client and the server, built once."""

    @functools.cache
    def build(language):
        ending, needs = LANGUAGES[language]
        folder = tmp_path_factory.mktemp("other_language")
        for source in FOLDER.glob(f"*{ending}"):
            shutil.copy(source, folder)
        return prepare(language, folder) or pytest.skip(f"{language} needs {needs}")

    return build


@pytest.fixture
def serve_in(programs, start):
    """serve_in("Go"): (server, endpoint), on a free port."""

    def serve_in(language):
        server = start(*programs(language)[1], "tcp://127.0.0.1:0")
        return server, server.wait_for(r"^listening on (tcp://127\.0\.0\.1:[1-9]\d*)$")[1]

    return serve_in


@each_language
def test_their_client_and_our_server(language, programs, start, serve):
    _, endpoint = serve(KEY)
    client = start(*programs(language)[0], endpoint)
    assert client.wait() == 0, client.output
    assert client.lines == [f"asking {endpoint}", *TEN]


@each_language
def test_our_client_and_their_server(language, serve_in, context, start_client):
    server, endpoint = serve_in(language)
    # C and C++ show no more than ASCII.
    shown = "Gr????e" if language in ("C", "C++") else "Grüße"
    assert ask(context, endpoint, "Grüße".encode()) == [f"error: expected Hello, got '{shown}'".encode()]
    # Controls, another direction of writing, no character at all, much of it, and several frames.
    for odd in ([b"\x1b[2J\r\n\xe2\x80\xae\xff"], [b""], [b"\n" * 60_000], [b"Bonjour", b"Hello", b""]):
        (reply,) = ask(context, endpoint, *odd)
        assert reply.startswith(b"error: expected Hello, got '")
        assert reply.decode().isprintable()
        assert len(reply) < 200
    client = start_client("python", KEY, endpoint)
    assert client.wait() == 0, client.output
    assert client.lines == [f"asking {endpoint}", *TEN]
    # The signal ends it; a Java machine says so as a shell does, and Go in its own way.
    assert server.stop(signal.SIGINT, limit=30) in (-signal.SIGINT, 128 + signal.SIGINT, 2)
    assert server.lines == [f"listening on {endpoint}"]
    with context.socket(zmq.REP) as rep:
        rep.bind(endpoint)


@each_language
def test_a_client_shows_any_reply_in_one_line_and_gives_up(language, programs, start, context):
    with context.socket(zmq.REP) as rep:
        endpoint = bind(rep)
        client = start(*programs(language)[0], endpoint)
        for reply in ([b"\x1b[2J one\r\n2: \xe2\x80\xae\xff"], [b"World", b"and more"], [b"x" * 60_000]):
            assert rep.recv_multipart() == [b"Hello"]
            rep.send_multipart(reply)
        # Its fourth request finds nobody.
        assert client.wait() == 1, client.output
    assert client.lines[2:] == [
        "2: sent Hello, received World",
        f"3: sent Hello, received {'x' * 200}",
        f"gave up: no reply from {endpoint} within 2.5 s; is the server running?",
    ]
    assert client.lines[1].startswith("1: sent Hello, received ")
    assert client.lines[1].isprintable()


@each_language
def test_no_server_a_bad_endpoint_and_a_taken_port_are_one_line(language, programs, start, serve):
    command, server_command = programs(language)
    nobody, taken = steady_endpoint(), serve(KEY)[1]
    alone, confused = start(*command, nobody), start(*command, "nowhere")
    second = start(*server_command, taken)
    assert confused.wait() == 2, confused.output
    assert len(confused.lines) == 1
    assert confused.lines[0].startswith("bad endpoint 'nowhere': ")
    assert confused.lines[0].endswith("write it like tcp://127.0.0.1:5551")
    assert second.wait() == 1, second.output
    assert len(second.lines) == 1
    assert second.lines[0].startswith(f"cannot listen on {taken}: ")
    assert second.lines[0].endswith("; try tcp://127.0.0.1:0, which takes a free port")
    assert alone.wait() == 1, alone.output
    give_up = f"gave up: no reply from {nobody} within 2.5 s; is the server running?"
    assert alone.lines == [f"asking {nobody}", give_up]
