"""Lesson 13: the programs that exchange side channels, also with one that says too much, which is a line and not the
others' business. Their bytes are in test_13_side_channels_bytes.py.
"""

import re
import signal
import subprocess
import time
import uuid

import zmq

from kitlib.docs import guide
from netmq_example.mlagents_envs.carrier import Carrier
from netmq_example.mlagents_envs.side_channel import (
    EngineConfig,
    EngineConfigurationChannel,
    EnvironmentParametersChannel,
    FloatPropertiesChannel,
    RawBytesChannel,
    SideChannelManager,
    StatsSideChannel,
)
from netmq_example.mlagents_envs.unity_channels import EnvironmentParameters
from tests.conftest import PYTHON
from tests.lessons.conftest import bind
from tests.lessons.test_13_side_channels_bytes import (
    LOG,
    RUNTIMES,
    STRANGER,
    TERMINALS,
    each_client,
    each_runtime,
    each_terminal,
    frame,
)
from tests.programs import LIMIT, PATIENT, ROOT, finished, steady_endpoint
from tests.unity.test_unity_play import needs_mono

KEY = "13_side_channels"
PAGE = ROOT / "docs" / "guide" / f"{KEY}.md"


# The programs


LINES = [
    "From Python : Hello",
    "engine: time scale 2.0",
    "engine: target frame rate 60",
    "gravity is now 9.81",
    # From here on the numbers of a seed must never change.
    "1: mass 1.6331, wind 1.7409, light 0.1567",
    "2: mass 1.9916, wind -4.4860, light 0.8501",
    "3: mass 2.4420, wind 1.2800, light 0.8065",
    "4: mass 1.3887, wind 0.5056, light 0.1364",
    "5: mass 1.3885, wind -2.3565, light 0.2082",
    "done: 5 rounds",
]


@each_client
def test_all_clients_print_the_same(kind, serve, start_client):
    server, endpoint = serve(KEY)
    client = start_client(kind, KEY, endpoint, *PATIENT)
    assert client.wait() == 0, client.output
    assert sorted(client.lines) == sorted([f"asking {endpoint}", *LINES])
    server.wait_for("stats: 'mass' 1.3885 average")
    assert "From Unity : 'Error: a fake error in the last round'" in server.lines
    assert [line for line in server.lines if line.startswith("trouble")] == []


# What is said here, in place of so many lines, and what there.
TROUBLES = {
    "unknown": ([], [f"trouble: unknown channel {STRANGER}: kept until it is registered"]),
    "cut": ([], [f"trouble: a message to channel {LOG} of 9 bytes, of which 6 are there"]),
    "throw": ([f"trouble: channel {LOG}: thrown on purpose"], []),
}


@each_terminal
def test_trouble_in_one_conversation_is_not_the_others_business(kind, serve, runs):
    # A server shows one such line a second.
    served = {word: serve(KEY) for word in TROUBLES}
    words = [["--endpoint", endpoint, "--trouble", word, *PATIENT] for word, (_, endpoint) in served.items()]
    for run, (word, (server, endpoint)) in zip(runs(kind, KEY, words), served.items(), strict=True):
        here, there = TROUBLES[word]
        assert run.code == 0
        assert sorted(run.lines) == sorted([f"asking {endpoint}", *here, *LINES[len(here) :]]), word
        for line in there:
            server.wait_for(re.escape(line))
        assert [line for line in server.lines if line.startswith("trouble")] == there


def test_a_server_that_was_started_again_is_told_again(serve, start_client):
    server, endpoint = serve(KEY)
    clients = [start_client(kind, KEY, endpoint, "--count", "100000", *PATIENT) for kind in TERMINALS]
    for client in clients:
        client.wait_for("^20: ")
    server.kill()
    heard = [len(client.lines) for client in clients]
    again, _ = serve(KEY, endpoint=endpoint)
    for client, before in zip(clients, heard, strict=True):
        client.wait_for("^From Python : Hello$", start=before)
        client.wait_for("^[0-9]+: ", start=len(client.lines))
        assert client.lines.count("From Python : Hello") == 2
    assert again.stop() == 0


def test_what_both_sides_slept_is_no_silence(serve, start_client):
    """A laptop's lid was closed; the clients are awake first."""
    server, endpoint = serve(KEY)
    clients = [start_client(kind, KEY, endpoint, "--count", "100000", "--timeout", "4") for kind in TERMINALS]
    for client in clients:
        client.wait_for("^20: ")
    for each in *clients, server:
        each.process.send_signal(signal.SIGSTOP)
    # Longer than any of the clients' timeouts, and this is what is tested.
    time.sleep(9)
    for each in *clients, server:
        each.process.send_signal(signal.SIGCONT)
        time.sleep(0.3)
    for client in clients:
        client.wait_for("^[0-9]+: ", start=len(client.lines))


@each_terminal
def test_a_round_that_was_lost_is_told_again(kind, serve, start_client, context):
    """A server takes it, and is gone before it says that it has."""
    with context.socket(zmq.ROUTER) as dying:
        endpoint = bind(dying, steady_endpoint())
        client = start_client(kind, KEY, endpoint, "--count", "2", *PATIENT)
        assert dying.poll(60_000)
        peer, _ = dying.recv_multipart()
        seen = FloatPropertiesChannel()
        seen.set_property("seen", 0)
        dying.send_multipart([peer, bytes(SideChannelManager([seen]).generate_side_channel_messages())])
        while not (dying.poll(60_000) and b"round" in dying.recv_multipart()[1]):
            assert client.process.poll() is None, client.output
    serve(KEY, endpoint=endpoint)
    assert client.wait() == 0, client.output
    assert client.lines[-1] == "done: 2 rounds"


@each_terminal
def test_a_server_of_something_else_is_given_up(kind, start_client, context):
    """One that answers everything, and never what was asked."""
    with context.socket(zmq.ROUTER) as echo:
        endpoint = bind(echo)
        # A busy machine may not echo within a second.
        for limit in (1, 10, 60):
            client = start_client(kind, KEY, endpoint, "--timeout", f"{limit}")
            while client.process.poll() is None:
                if echo.poll(50):
                    echo.send_multipart(echo.recv_multipart())
                    # A client that is busy with echoes alone keeps a core busy.
                    time.sleep(0.05)
            assert client.wait() == 1
            if "no word from" not in client.output:
                break
    assert f"gave up: round 0 was not seen within {2 * limit} s; is that lesson 13's server?" in client.output


def test_the_programs_of_the_page_talk(start, checks, connect, tmp_path):
    """A player that comes again gets all of it again."""
    python, csharp = (block.body for block in guide.blocks(PAGE) if "a file of yours" in block.source)
    assert csharp == (ROOT / "tests" / "lessons" / "checks" / "Weather.cs").read_text(encoding="utf-8")
    (tmp_path / "wind.py").write_text(python, encoding="utf-8")
    endpoint = steady_endpoint()
    start(PYTHON, "wind.py", endpoint, folder=tmp_path, PYTHONPATH=str(ROOT / "python")).wait_for("^listening on")
    for _ in range(2):
        player = start("dotnet", checks, "scene", "Weather", endpoint)
        player.wait_for("^rain in Rome$")
        player.kill()
    # And what is set again and again.
    winds, heard = EnvironmentParameters(), set()
    winds.register_callback("wind", heard.add)
    manager = SideChannelManager([winds])
    simulator = connect(endpoint)
    simulator.send(b"")
    while len(heard) < 3:
        assert simulator.poll(60_000)
        manager.process_side_channel_message(simulator.recv())


def test_python_knows_so_many_simulators_and_no_more(serve, connect):
    server, endpoint = serve(KEY)
    crowd = [connect(endpoint) for _ in range(65)]
    *first, last = crowd
    for one in first:
        one.send(b"")
        assert one.poll(100_000), "each is welcomed"
        assert b"Hello" in one.recv()
    end = time.monotonic() + LIMIT
    while "64 simulators are here" not in server.output:
        assert time.monotonic() < end
        for one in crowd:
            one.send(b"")
        for one in first:
            assert one.poll(100_000)
            assert one.recv() == b"", "it is known, and not welcomed anew"
    # When the others are silent, there is room for another one.
    end = time.monotonic() + 60
    while not last.poll(500) and time.monotonic() < end:
        last.send(b"")
    assert b"Hello" in last.recv(zmq.NOBLOCK)
    assert server.stop() == 0, server.output


@each_runtime
def test_unity_does_what_the_settings_say(runtime, netmq, checks):
    if runtime == "mono":
        needs_mono()
    channel = EngineConfigurationChannel()
    channel.set_configuration(EngineConfig(640, 480, 2, 0.25, 72, 30))
    exchange = SideChannelManager([channel]).generate_side_channel_messages().hex()
    assert finished([RUNTIMES[runtime], checks, "sidechannels", "settings", exchange]).stdout.splitlines() == [
        "engine: screen resolution 640 x 480",
        "engine: quality level 2",
        # As ML-Agents does: no slower than time is.
        "engine: time scale 1.0",
        "engine: target frame rate 72",
        "engine: capture frame rate 30",
        "1 72 30",
    ]


def test_pictures_are_raw_bytes_in_their_order(checks, context):
    """128 x 128 in colour, from C# to Python, each answered with an empty message."""
    count, seen, channels = 30, 0, []
    with context.socket(zmq.ROUTER) as socket:
        socket.rcvtimeo, endpoint = 20, bind(socket)

        def welcome():
            channels.append(RawBytesChannel(STRANGER))
            return SideChannelManager([channels[-1]])

        carrier = Carrier(socket, welcome, print)
        with subprocess.Popen(["dotnet", checks, "sidechannels", "pictures", endpoint, str(count)]) as sender:
            try:
                end = time.monotonic() + LIMIT
                while sender.poll() is None:
                    assert time.monotonic() < end, f"only {seen} pictures"
                    carrier.exchange()
                    for channel in channels:
                        for picture in channel.get_and_clear_received_messages():
                            assert picture == bytes([seen]) * 49_152
                            seen += 1
                            channel.send_raw_data(b"")
                    carrier.send()
            finally:
                sender.kill()
    assert (seen, sender.returncode) == (count, 0)


# One that says too much, or nothing


PROPERTIES = FloatPropertiesChannel().channel_id


def test_one_that_says_too_much_does_not_keep_the_others_waiting(serve, connect):
    _, endpoint = serve(KEY)
    talker, other = connect(endpoint), connect(endpoint)
    talker.send(b"")
    assert talker.poll(60_000)
    talker.recv()
    # Each is answered with the property `seen`, 32 bytes.
    talker.send(frame(PROPERTIES, b"") * 100_000)
    other.send(b"")
    assert other.poll(60_000)
    assert b"Hello" in other.recv()
    answered = 0
    while talker.poll(0):
        answered += talker.recv().count(b"seen")
    assert answered < 100_000, "the other was answered in between"
    while answered < 100_000:
        assert talker.poll(60_000), answered
        answered += talker.recv().count(b"seen")
    assert answered == 100_000, "and nothing was lost"


def test_a_flood_of_what_is_wrong_is_no_flood_of_lines(start_client, context):
    """Messages that nobody can read, to a channel that is there and to one that is not."""
    wrong = frame(PROPERTIES, b"\xff" * 4) * 500 + frame(uuid.UUID(int=7), b"") * 500
    with context.socket(zmq.ROUTER) as server:
        endpoint = bind(server)
        # How many more there were is said each second. A busy machine may have no word within four seconds.
        for limit in (4, 20, 60):
            clients = [start_client(kind, KEY, endpoint, "--timeout", f"{limit}") for kind in TERMINALS]
            while any(client.process.poll() is None for client in clients):
                if server.poll(50):
                    server.send_multipart([server.recv_multipart()[0], wrong])
                    time.sleep(0.1)
            assert [client.wait() for client in clients] == [1, 1]
            said = [[line for line in client.lines if line.startswith("trouble: ")] for client in clients]
            assert max(map(len, said)) < 5 * limit
            if all(re.search(r"\(and \d{3,} more\)$", "\n".join(lines), re.MULTILINE) for lines in said):
                break
        else:
            raise AssertionError(said)


@each_terminal
def test_what_is_no_number_is_printed_in_the_same_way(kind, start_client, context):
    """It is queued between two exchanges, and leaves with `send`."""
    with context.socket(zmq.ROUTER) as socket:
        socket.rcvtimeo, endpoint, parameters = 20, bind(socket), []

        def welcome():
            # A client that was not answered soon comes again with a new socket.
            parameters.append(EnvironmentParametersChannel())
            parameters[-1].set_float_parameter("gravity", 1)
            return SideChannelManager([parameters[-1]])

        carrier = Carrier(socket, welcome, print)
        client = start_client(kind, KEY, endpoint, *PATIENT)
        while "gravity is now 1.00" not in client.lines:
            assert client.process.poll() is None, client.output
            carrier.exchange()
        for value in ("inf", "-inf", "nan"):
            parameters[-1].set_float_parameter("gravity", float(value))
            carrier.send()
            client.wait_for(f"gravity is now {value}$")


def test_a_python_that_is_silent_for_longer_is_waited_for(start, checks, context):
    """Before it is there for the first time, and in the middle; each time that is one line."""
    endpoint = steady_endpoint()
    player = start("dotnet", checks, "scene", "OwnChannels", endpoint, "1")
    silence = f"^no word from {endpoint} within 1 s; is the server running. It is tried again and again$"
    player.wait_for(silence)
    parameters, stats = [], StatsSideChannel()

    def welcome() -> SideChannelManager:
        # Each has its own: the first that is heard here may be a socket that the player has replaced meanwhile.
        parameters.append(EnvironmentParametersChannel())
        parameters[-1].set_float_parameter("wind", 1)
        return SideChannelManager([parameters[-1], stats])

    with context.socket(zmq.ROUTER) as socket:
        socket.rcvtimeo = 20
        socket.bind(endpoint)
        carrier = Carrier(socket, welcome, print)
        for wind in (1, 2):
            if parameters:
                parameters[-1].set_float_parameter("wind", wind)
            while f"wind {wind}" not in player.lines:
                assert player.process.poll() is None, player.output
                carrier.exchange()
            # A step of training.
            seen = len(player.lines)
            player.wait_for(silence, start=seen)
        assert stats.get_and_reset_stats()["frames"][0][0] <= 3, "what was recorded before is not lost"
    player.kill()
