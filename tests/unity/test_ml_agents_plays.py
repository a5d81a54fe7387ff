"""ML-Agents' shape from one Play to the next: with domain reload, and without it, where every static stays."""

import socket
import subprocess

import pytest

from tests.programs import LIMIT, steady_port
from tests.unity.conftest import needs_mono

pytest.importorskip("numpy", reason="ML-Agents' shape needs numpy: pip install numpy")

from netmq_example.mlagents_envs.environment import UnityEnvironment

PLAY = """
| A init
| A start
| reset
| A begin steps=0 sum=0 episodes=0
| step 0
| step 1
| stop
| A off
| A see 2
| A begin steps=0 sum=0 episodes=1
"""


@pytest.mark.parametrize("runtime, mode", [("dotnet", "keep"), ("mono", "keep"), ("mono", "reload")])
def test_each_play_begins_with_an_academy_of_its_own(runtime, mode, harness):
    """An episode that ends after the last step, in OnDisable, takes nothing from the next Play."""
    if runtime == "mono":
        needs_mono()
    # Nobody listens at the port 1.
    plays = subprocess.run(
        [runtime, harness, mode, "--mlagents-port", "1"],
        input="clock|A|A off 1: end|steps=2\n" * 2,
        capture_output=True,
        text=True,
        timeout=LIMIT,
    )
    assert plays.returncode == 0, plays.stderr
    told = [line for line in plays.stdout.splitlines() if line.startswith("| ")]
    assert told == PLAY.split("\n")[1:-1] * 2
    assert plays.stdout.count("no Python at tcp://127.0.0.1:1: Heuristic decides") == 2


@pytest.mark.parametrize("runtime, mode", [("dotnet", "keep"), ("mono", "reload")])
def test_each_play_finds_a_python_of_its_own(runtime, mode, play):
    port = steady_port()
    plays = play(mode, "--mlagents-port", f"{port}", runtime=runtime, stdin=subprocess.PIPE)
    for _ in range(2):
        before = len(plays.lines)
        plays.process.stdin.write(f"clock|A period=2 numbers=1|--mlagents-port|{port}\n")
        plays.process.stdin.flush()
        env = UnityEnvironment(base_port=port, timeout_wait=LIMIT, seed=3)
        env.reset()
        for _ in range(3):
            decisions, ends = env.get_steps("Ball?team=0")
            assert (list(decisions.agent_id), list(ends.agent_id)) == ([0], [])
            env.step()
        env.close()
        plays.wait_for(r"^\| stop$", start=before)


@pytest.mark.parametrize("says", [b"", b"\0\0\6\4"], ids=["nothing", "as gRPC does"])
def test_a_program_without_zeromq_at_the_port_is_named(says, play):
    """ML-Agents' own trainer, as a rule, which waits there for ML-Agents' own package."""
    with socket.create_server(("127.0.0.1", 0)) as server:
        port = server.getsockname()[1]
        plays = play("keep", "--mlagents-port", f"{port}", stdin=subprocess.PIPE)
        plays.process.stdin.write("clock|A|steps=2\n")
        plays.process.stdin.flush()
        with server.accept()[0] as other:
            other.sendall(says)
            plays.wait_for(rf"tcp://127.0.0.1:{port} speaks no ZeroMQ.*mlagents_learn")
            plays.wait_for(r"^\| stop$")
