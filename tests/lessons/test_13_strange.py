"""Lesson 13 among strangers: one that says too much, on either side, is a line and not the others' business."""

# ruff: noqa: F401, F811

from __future__ import annotations

import re
import struct
import time
import uuid
from typing import Any

import pytest
import zmq

from netmq_example.mlagents_envs import carrier as one_peer
from netmq_example.mlagents_envs.carrier import Carrier
from netmq_example.mlagents_envs.exception import UnitySideChannelException
from netmq_example.mlagents_envs.side_channel import IncomingMessage, OutgoingMessage
from netmq_example.mlagents_envs.side_channel.engine_configuration_channel import EngineConfigurationChannel
from netmq_example.mlagents_envs.side_channel.environment_parameters_channel import EnvironmentParametersChannel
from netmq_example.mlagents_envs.side_channel.float_properties_channel import MOST_PROPERTIES, FloatPropertiesChannel
from netmq_example.mlagents_envs.side_channel.raw_bytes_channel import RawBytesChannel
from netmq_example.mlagents_envs.side_channel.side_channel import LARGEST_EXCHANGE_BYTES, MOST_QUEUED_BYTES
from netmq_example.mlagents_envs.side_channel.side_channel_manager import SideChannelManager
from netmq_example.mlagents_envs.side_channel.stats_side_channel import StatsSideChannel
from netmq_example.mlagents_envs.unity_channels import EngineSettings, EnvironmentParameters, StatsRecorder, uniform
from netmq_example.trouble import Trouble
from tests.lessons.conftest import bind
from tests.lessons.test_13_side_channels_bytes import (
    LOG,
    STRANGER,
    csharp_says,
    digits,
    each_terminal,
    frame,
    process,
)
from tests.programs import PATIENT, steady_endpoint

KEY = "13_side_channels"

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


def test_the_parts_of_an_exchange_are_the_exchange():
    for exchange in (
        b"",
        frame(LOG, b"x") * 9_999,
        frame(LOG, b"x" * 200_000) * 3,
        frame(LOG, b"x") * 9_999 + frame(LOG, b"Hello")[:-1],
        frame(LOG, b"x") + LOG.bytes_le + struct.pack("<i", -5) * 40_000,
    ):
        parts = list(one_peer.parts(exchange))
        assert b"".join(parts) == exchange
        for part in parts[:-1]:
            SideChannelManager().process_side_channel_message(part)
    assert len(list(one_peer.parts(frame(LOG, b"x") * 9_999))) == 4


@each_terminal
def test_a_flood_of_what_is_wrong_is_no_flood_of_lines(kind, start, client_command, context):
    """Messages that nobody can read, to a channel that is there and to one that is not."""
    wrong = frame(PROPERTIES, b"\xff" * 4) * 500 + frame(uuid.UUID(int=7), b"") * 500
    with context.socket(zmq.ROUTER) as server:
        endpoint = bind(server)
        # How many more there were is said each second. A busy machine may have no word within four seconds.
        for limit in (4, 20, 60):
            client = start(*client_command(kind, KEY, endpoint, "--timeout", f"{limit}"))
            while client.process.poll() is None:
                if server.poll(50):
                    server.send_multipart([server.recv_multipart()[0], wrong])
                    time.sleep(0.2)
            assert client.wait() == 1
            lines = [line for line in client.lines if line.startswith("trouble: ")]
            assert len(lines) < 5 * limit
            if re.search(r"\(and \d{3,} more\)$", "\n".join(lines), re.MULTILINE):
                break
        else:
            raise AssertionError(client.output)


@each_terminal
def test_what_is_no_number_is_printed_in_the_same_way(kind, start, client_command, context):
    """It is queued between two exchanges, and leaves with `send`."""
    with context.socket(zmq.ROUTER) as socket:
        socket.rcvtimeo, endpoint, parameters = 20, bind(socket), []

        def welcome():
            # A client that was not answered soon comes again with a new socket.
            parameters.append(EnvironmentParametersChannel())
            parameters[-1].set_float_parameter("gravity", 1)
            return SideChannelManager([parameters[-1]])

        carrier = Carrier(socket, welcome, print)
        client = start(*client_command(kind, KEY, endpoint, *PATIENT))
        while "gravity is now 1.00" not in client.lines:
            assert client.process.poll() is None, client.output
            carrier.exchange()
        for value in ("inf", "-inf", "nan"):
            parameters[-1].set_float_parameter("gravity", float(value))
            carrier.send()
            client.wait_for(f"gravity is now {value}$")


def test_what_a_peer_may_make_the_other_keep_has_a_limit(csharp_says):
    long = frame(PROPERTIES, struct.pack("<i", 1001) + b"k" * 1001 + struct.pack("<f", 1))
    said = process(long)
    assert b"at most 10000 properties" in bytes.fromhex(said)
    assert csharp_says(".net", [f"process {digits(long)}"]) == [said]
    lines, properties = [], FloatPropertiesChannel()
    manager = SideChannelManager([properties], lines.append)
    for number in [*range(MOST_PROPERTIES + 3), 0]:
        key = f"{number}".encode()
        manager.process_side_channel_message(frame(PROPERTIES, struct.pack("<i", len(key)) + key))
    assert (len(properties.list_properties()), len(lines)) == (MOST_PROPERTIES, 3)


def test_half_a_character_is_not_ascii_in_either_language(csharp_says):
    with pytest.raises(UnitySideChannelException, match="not ASCII"):
        OutgoingMessage().write_string("a\ud800b")
    # In Unity without an exception: it would come out of the game's own Debug.LogError.
    (said,) = csharp_says(".net", ["half -"])
    assert said == f"error channel {LOG}: not sent, text that is not ASCII: write it with utf8: true"


def test_what_nobody_takes_has_a_limit_and_is_counted(csharp_says):
    lines, channel = [], RawBytesChannel(STRANGER)
    manager = SideChannelManager([channel], lines.append)
    for number in range(100_500):
        channel.send_raw_data(number.to_bytes(3, "big"))
    sent = manager.generate_side_channel_messages()
    assert lines == [
        f"channel {STRANGER}: nobody takes its messages, the oldest are dropped",
        f"channel {STRANGER}: 50001 messages were dropped",
    ]
    assert (len(sent) // 23, sent[20:23]) == (50_499, (50_001).to_bytes(3, "big"))
    assert csharp_says(".net", ["keep 100500"]) == [f"{'|'.join(lines)} 50499 {digits(sent[20:23])}"]
    for _ in range(6):
        channel.send_raw_data(bytes(LARGEST_EXCHANGE_BYTES // 2 + 1))
        channel.send_raw_data(bytes(LARGEST_EXCHANGE_BYTES // 2 + 1))
    assert channel.queued_bytes <= MOST_QUEUED_BYTES
    assert len(lines) == 3, "said once"


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


def engine(**settings):
    return EngineConfigurationChannel().set_configuration_parameters(**settings)


PARAMETERS = EnvironmentParametersChannel()
CONTEXT = zmq.Context.instance()
NAN = float("nan")
# The parameter that the error has to name, a call, and what it is given. The spaces only make two names of one.
WRONG: dict[str, list[Any]] = {
    "channel_id": [RawBytesChannel, 0, None, "", STRANGER.bytes],
    "buffer": [IncomingMessage, 5, -1, None, NAN, "text"],
    "offset": [lambda value: IncomingMessage(b"", value), -1, None, NAN, "", 0.5],
    "b": [OutgoingMessage().write_bool, None, NAN, -1, "", []],
    "i": [OutgoingMessage().write_int32, None, NAN, 2**31, "", 0.5],
    "f": [OutgoingMessage().write_float32, None, 1e300, "", [1.0]],
    "float_list": [OutgoingMessage().write_float32_list, None, 0, [None], "x", [1e300]],
    "s": [OutgoingMessage().write_string, None, 0, NAN, b"x"],
    "buffer ": [OutgoingMessage().set_raw_bytes, 5, None, "text"],
    "msg": [RawBytesChannel(STRANGER).queue_message_to_send, None, 0, "", b"x"],
    "data": [RawBytesChannel(STRANGER).queue_bytes, None, 5, "text"],
    "data ": [SideChannelManager().process_side_channel_message, None, 5, "text"],
    "count": [RawBytesChannel(STRANGER).take, -1, None, NAN, ""],
    "side_channels": [SideChannelManager, 0, "", PARAMETERS],
    "channel": [SideChannelManager().register_side_channel, 0, None, ""],
    "report": [lambda value: SideChannelManager([], value), 0, None, ""],
    "key": [FloatPropertiesChannel().get_property, 0, None, NAN],
    "key ": [lambda value: FloatPropertiesChannel().set_property(value, 1), 0, None, NAN, ""],
    "value": [lambda value: FloatPropertiesChannel().set_property("a", value), None, "", "1"],
    "width": [lambda value: engine(width=value, height=80), NAN, "", 0.5],
    "time_scale": [lambda value: engine(time_scale=value), "", [1], NAN, 1e6],
    "config": [EngineConfigurationChannel().set_configuration, None, 0, (80, 80, 1, 20.0, -1, 60)],
    "key  ": [lambda value: PARAMETERS.set_float_parameter(value, 1), 0, None, NAN, ""],
    "max_value": [lambda value: PARAMETERS.set_uniform_sampler_parameters("a", 1, value, 1), None, ""],
    "st_dev": [lambda value: PARAMETERS.set_gaussian_sampler_parameters("a", 1, value, 1), None, ""],
    "seed": [lambda value: PARAMETERS.set_gaussian_sampler_parameters("a", 1, 1, value), None, "", NAN, 2**31],
    "intervals": [
        lambda value: PARAMETERS.set_multirangeuniform_sampler_parameters("a", value, 1),
        *(None, 0, [1.0], [(1.0,)], [(0.0, None)]),
    ],
    "seed ": [lambda value: uniform(0, 1, value), None, "", NAN, 0.5],
    "apply": [EngineSettings, None, 0, ""],
    "action": [lambda value: EnvironmentParameters().register_callback("a", value), None, 0],
    "value ": [lambda value: StatsRecorder().add("a", value), None, ""],
    "StatsAggregationMethod": [lambda value: StatsRecorder().add("a", 1, value), None, "", -1, 4],
    "socket": [lambda value: one_peer.Carrier(value, SideChannelManager, print), None, 0, ""],
    "manager": [one_peer.Peer, None, 0, ""],
    "endpoint": [lambda value: one_peer.ClientCarrier(CONTEXT, value), None, 0, "", "tcp://x:99999"],
    "timeout": [lambda value: one_peer.ClientCarrier(CONTEXT, "tcp://x:1", value), None, 0, -1, NAN, ""],
    "context": [lambda value: one_peer.ClientCarrier(value, "tcp://x:1"), None, 0, ""],
}


@pytest.mark.parametrize("name", WRONG)
def test_what_a_method_cannot_use_is_named(name):
    call, *values = WRONG[name]
    for value in values:
        with pytest.raises((ValueError, TypeError), match=rf"\b{name.strip()}\b") as caught:
            call(value)
        assert "\n" not in str(caught.value)
