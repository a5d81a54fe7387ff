"""What the lessons' tests share: a context for peers that are not the kit's, and one request of such a peer; the C#
side of lesson 05's messages without a client around it; and environments, with the simulators that they launch.
"""

from __future__ import annotations

import pytest
import zmq

from kitlib.setup import dotnet
from tests.programs import ROOT


@pytest.fixture
def context():
    with zmq.Context() as context:
        yield context


@pytest.fixture(scope="session")
def messages_program(netmq):
    """The command of tests/lessons/checks/MessageChecks.cs."""
    return ["dotnet", str(dotnet.build(netmq, ROOT / "tests" / "lessons" / "checks")), "messages"]


def ask(context, endpoint, *frames, kind=zmq.REQ):
    """One request of a client that is not the kit's; the reply's frames."""
    with context.socket(kind) as asker:
        asker.linger = 0
        asker.connect(endpoint)
        asker.send_multipart(frames)
        assert asker.poll(100_000), f"no reply to {frames!r:.80}"
        return asker.recv_multipart()


@pytest.fixture
def launch(client_command):
    """launch("csharp", "--count", "3"): the words for an environment that starts its simulator by itself."""

    def words(kind, *options, key="09_environment"):
        command = client_command(kind, key, "nowhere", *options)
        at = command.index("--endpoint")
        return command[:at] + command[at + 2 :]

    return words


@pytest.fixture
def make():
    """gymnasium.make, and what it made is closed at the end of the test."""
    gymnasium = pytest.importorskip("gymnasium", reason="lesson 09 needs gymnasium: pip install gymnasium")
    import netmq_example.envs  # noqa: F401

    made = []

    def make_env(id="NetMQExample/CartPole-v0", **where):
        made.append(gymnasium.make(id, **where))
        return made[-1]

    yield make_env
    for env in made:
        env.close()
