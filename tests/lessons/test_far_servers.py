"""A far server is reached: over a line with a round trip of 600 ms, of which a new connection takes four or more.

tests/bad_peers.py has the line. Those clients are here whose tries make a new socket each.
"""

import pytest

from tests.bad_peers import SlowLine

ROUND_TRIP = 0.6
# What the client is told, and the line by which it has been answered.
CASES = {
    "08_see_and_steer": (["--every", "1"], "^frame [0-9]+: age"),
    "09_environment": ([], "^simulating .* for "),
    "10_many_agents": ([], "^simulating .* for "),
    "11_observations": ([], "^simulating .* for "),
    "12_video": (["--count", "0"], " can film "),
    "13_side_channels": (["--timeout", "20"], "^[0-9]+: mass "),
    "14_long_jobs": ([], "^job .*: (accepted|[0-9]+ of )"),
    "17_many_machines": ([], "^simulating .* for "),
    "21_talking_character": ([], "^she: "),
}


@pytest.mark.parametrize("kind", ["python", "csharp"])
@pytest.mark.parametrize("key", CASES)
def test_a_far_server_is_reached(key, kind, serve, start, client_command):
    words, answered = CASES[key]
    with SlowLine(serve(key)[1], ROUND_TRIP) as line:
        start(*client_command(kind, key, line.endpoint, *words)).wait_for(answered)
