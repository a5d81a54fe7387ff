"""Lesson 13: the bytes of side channels in both languages, on .NET and Mono: tests/lessons/checks and Python here
answer the same questions.
"""

import importlib
import json
import math
import random
import re
import struct
import subprocess
import sys
import uuid
from typing import Any

import pytest
import zmq

from netmq_example.mlagents_envs import carrier
from netmq_example.mlagents_envs.exception import UnitySideChannelException
from netmq_example.mlagents_envs.side_channel import (
    EngineConfig,
    EngineConfigurationChannel,
    EnvironmentParametersChannel,
    IncomingMessage,
    OutgoingMessage,
    RawBytesChannel,
    SideChannelManager,
)
from netmq_example.mlagents_envs.side_channel.float_properties_channel import MOST_PROPERTIES, FloatPropertiesChannel
from netmq_example.mlagents_envs.side_channel.raw_side_channel import SideChannel as RawSideChannel
from netmq_example.mlagents_envs.side_channel.side_channel import LARGEST_EXCHANGE_BYTES, MOST_QUEUED_BYTES
from netmq_example.mlagents_envs.unity_channels import (
    EngineSettings,
    EnvironmentParameters,
    StatsRecorder,
    describe,
    uniform,
)
from tests.conftest import CLIENTS
from tests.programs import ROOT
from tests.unity.test_unity_play import needs_mono

KEY = "13_side_channels"
sys.path.insert(0, str(ROOT / "python" / KEY))

from rounds import StringLogChannel  # noqa: E402

GOLDEN = json.loads((ROOT / "tests" / "lessons" / "golden" / f"{KEY}.json").read_text(encoding="utf-8"))
LOG, STRANGER = uuid.UUID("621f0a70-4f87-11ea-a6bf-784f4387d1f7"), uuid.UUID("00112233-4455-6677-8899-aabbccddeeff")
RUNTIMES = {".net": "dotnet", "mono": "mono"}
each_client = pytest.mark.parametrize("kind", CLIENTS)
TERMINALS = [kind for kind in CLIENTS if kind != "unity"]
each_terminal = pytest.mark.parametrize("kind", TERMINALS)
each_runtime = pytest.mark.parametrize("runtime", RUNTIMES)


# The same questions, answered by Python


def bits(value):
    # Python's float has more bits, and makes another NaN of some.
    return "nan" if math.isnan(value) else struct.pack(">f", value).hex()


def digits(data):
    return bytes(data).hex() or "-"


def read(payload, *kinds):
    message = IncomingMessage(payload)
    value = {
        "b": lambda: str(int(message.read_bool())),
        "i": lambda: str(message.read_int32()),
        "f": lambda: bits(message.read_float32()),
        "s": lambda: digits(message.read_string().encode()),
        "l": lambda: ",".join(map(bits, message.read_float32_list())),
        "r": lambda: digits(message.get_raw_bytes()),
    }
    return " ".join(value[kind]() for kind in kinds)


def write(*values):
    message = OutgoingMessage()

    def single(text):
        return struct.unpack(">f", bytes.fromhex(text))[0]

    def data(text):
        return b"" if text == "-" else bytes.fromhex(text)

    writers = {
        "b": lambda text: message.write_bool(text == "1"),
        "i": lambda text: message.write_int32(int(text)),
        "f": lambda text: message.write_float32(single(text)),
        "s": lambda text: message.write_string(data(text).decode()),
        "u": lambda text: message.write_string(data(text).decode(), utf8=True),
        "l": lambda text: message.write_float32_list([single(one) for one in text.split(",") if one]),
        "r": lambda text: message.set_raw_bytes(data(text)),
    }
    for value in values:
        writers[value[0]](value[2:])
    return digits(message.buffer)


def process(exchange):
    lines = []
    raw, late, parameters, properties = (
        RawBytesChannel(uuid.UUID(int=0)),
        RawBytesChannel(STRANGER),
        EnvironmentParameters(),
        FloatPropertiesChannel(),
    )
    # Mono writes no more than 15 digits of a number.
    settings = EngineSettings(
        lambda kind, values: lines.append(describe(kind, values) if values[0] < 1e15 else bits(values[0]))
    )
    log = StringLogChannel(lines.append, False)
    manager = SideChannelManager([log, properties, raw, settings, parameters, StatsRecorder()], lines.append)
    try:
        manager.process_side_channel_message(exchange)
    except UnitySideChannelException as error:
        lines.append(str(error))
    manager.register_side_channel(late)
    lines += [f"late {digits(message)}" for message in late.get_and_clear_received_messages()]
    lines += [f"{key}={bits(value)}" for key, value in properties.properties.items()]
    for key in parameters.parameters:
        drawn = [parameters.get_with_default(key, 0.0) for _ in range(3)]
        lines.append(f"{key}:{','.join(map(bits, drawn))}")
    lines += [digits(message) for message in raw.get_and_clear_received_messages()]
    return digits("\n".join(lines).encode())


def python_says(line):
    what, first, *more = line.split(" ")
    try:
        if what == "write":
            return write(first, *more)
        data = b"" if first == "-" else bytes.fromhex(first)
        return read(data, *more) if what == "read" else process(data)
    except UnitySideChannelException as error:
        return f"error {error}".replace("utf8=True", "utf8: true")


@pytest.fixture
def csharp_says(checks):
    def says(runtime, lines):
        if runtime == "mono":
            needs_mono()
        command = [RUNTIMES[runtime], checks, "sidechannels"]
        done = subprocess.run(command, input="\n".join(lines), capture_output=True, text=True, timeout=250)
        assert done.returncode == 0, done.stderr
        return done.stdout.splitlines()

    return says


def said(entry):
    """The expected answer; of `process` the lines."""
    return digits("\n".join(entry["says"]).encode()) if isinstance(entry["says"], list) else entry["says"]


# Bytes


@pytest.mark.parametrize("runtime", ["python", *RUNTIMES])
def test_each_language_agrees_with_the_golden_table(runtime, request):
    asks = [entry["ask"] for entry in GOLDEN]
    python = runtime == "python"
    found = map(python_says, asks) if python else request.getfixturevalue("csharp_says")(runtime, asks)
    for entry, answer in zip(GOLDEN, found, strict=True):
        assert answer == said(entry), entry["name"]


def frame(channel, payload):
    return channel.bytes_le + struct.pack("<i", len(payload)) + payload


IDS = [
    LOG,
    STRANGER,
    uuid.UUID(int=0),
    uuid.UUID("e951342c-4f7e-11ea-b238-784f4387d1f7"),
    uuid.UUID("534c891e-810f-11ea-a9d0-822485860400"),
    uuid.UUID("a1d8f7b7-cec8-50f9-b78b-d3e165a78520"),
    uuid.UUID("60ccf7d0-4f7e-11ea-b238-784f4387d1f7"),
    uuid.UUID(int=1),
]


def a_message(at_random):
    """Something that some channel understands, more or less."""

    def number():
        return struct.pack("<i", at_random.choice([0, 0, 1, 1, 2, 3, 4, 5, -1, 80, 2**31 - 1, -(2**31), 70_000]))

    def single():
        return struct.pack("<f", at_random.choice([0.0, 1.0, 0.5, -2.5, 20.0, 1e30, float("inf"), float("nan"), 9.81]))

    def text():
        words = [b"", b"mass", b"wind", "naïve".encode(), b"\xff\xfe", b"\xed\xa0\x80", b"\xc0\x80", b"\0"]
        data = at_random.choice(words)
        return struct.pack("<i", at_random.choice([len(data)] * 6 + [len(data) + 3, -1, 2**31 - 1])) + data

    def numbers():
        count = at_random.randrange(5)
        wrong = at_random.choice([count] * 6 + [count + 2, -3, 10**6])
        return struct.pack("<i", wrong) + b"".join(single() for _ in range(count))

    parts = [number, single, text, numbers]
    shapes = [[number, number, number], [number, single], [text, number, number, number, single, single]]
    shapes += [[text, number, number, number, numbers], [text, number, single], [text, single, number], [text]]
    return b"".join(part() for part in at_random.choice([*shapes, at_random.choices(parts, k=3)]))


def an_exchange(at_random):
    count = at_random.choice([0, 1, 1, 1, 2, 3])
    data = b"".join(frame(at_random.choice(IDS), a_message(at_random)) for _ in range(count))
    for _ in range(at_random.choice([0, 0, 1, 3])):
        at = at_random.randrange(len(data) + 1)
        added, gone = at_random.randbytes(at_random.choice([0, 1, 1, 4])), at_random.choice([0, 1, 1, 7])
        data = data[:at] + added + data[at + gone :]
    return data


def random_questions(count):
    at_random = random.Random(13)
    for number in range(count):
        if number % 2:
            kinds = " ".join(at_random.choices("bifsl", k=at_random.randrange(1, 6)))
            yield f"read {digits(a_message(at_random)[: at_random.choice([3, 6, 9, 99])])} {kinds}"
        else:
            yield f"process {digits(an_exchange(at_random))}"


@each_runtime
def test_both_languages_say_the_same_of_random_payloads(runtime, csharp_says):
    """Unity's handlers never end the exchange, whatever is in it; and Python's are the same."""
    count = 3_000
    questions = list(random_questions(count))
    python = [python_says(line) for line in questions]
    csharp = csharp_says(runtime, questions)
    wrong = [(line, *both) for line, *both in zip(questions, python, csharp, strict=True) if both[0] != both[1]]
    assert wrong[:3] == []
    # Of each kind so many that the comparison means something.
    errors = sum(answer.startswith("error") for answer in python[1::2])
    assert count / 10 < errors < count / 2 - count / 10
    assert sum(b"late" in bytes.fromhex(answer.replace("-", "")) for answer in python[::2]) > count / 50


# A project of ML-Agents has these names; whole programs of theirs are in test_13_from_ml_agents.py
MOVED = """
import uuid
from typing import Any
from mlagents_envs.exception import UnityCommunicationException, UnityException, UnitySideChannelException
from mlagents_envs.side_channel import SideChannel, OutgoingMessage, IncomingMessage
from mlagents_envs.side_channel.engine_configuration_channel import EngineConfigurationChannel
from mlagents_envs.side_channel.environment_parameters_channel import EnvironmentParametersChannel
from mlagents_envs.side_channel.side_channel_manager import SideChannelManager
from mlagents_envs.side_channel.stats_side_channel import EnvironmentStats, StatsAggregationMethod, StatsSideChannel

class OneWay(SideChannel):
    def on_message_received(self, msg: IncomingMessage) -> None:
        raise UnityCommunicationException("it only sends")

channel = OneWay(channel_id=uuid.uuid4())
channel.queue_message_to_send(OutgoingMessage())
assert channel.message_queue == [b""] and channel.channel_id.version == 4
channel.message_queue = []
assert SideChannelManager([channel]).generate_side_channel_messages() == b""
assert SideChannelManager(None).generate_side_channel_messages() == b""
assert EngineConfigurationChannel.ConfigurationType.TIME_SCALE == 2
assert EnvironmentParametersChannel.EnvironmentDataTypes.SAMPLER == 1
assert EnvironmentParametersChannel.SamplerTypes.MULTIRANGEUNIFORM == 2
assert issubclass(UnitySideChannelException, UnityException)
stats: EnvironmentStats = StatsSideChannel().get_and_reset_stats()
assert stats == {} and StatsAggregationMethod.MOST_RECENT.value == 1

from mlagents_envs.side_channel.float_properties_channel import FloatPropertiesChannel
from mlagents_envs.side_channel.incoming_message import IncomingMessage
from mlagents_envs.side_channel.outgoing_message import OutgoingMessage

out = OutgoingMessage()
out.write_bool(True)
msg = IncomingMessage(bytes(out.buffer), offset=0)
assert (msg.read_bool(default_value=False), msg.read_string("over")) == (True, "over")
channel = FloatPropertiesChannel()
channel.set_property("speed", 2.0)
assert channel.get_property("speed") == 2.0 and channel.get_property("other") is None
assert channel.list_properties() == ["speed"] and channel.get_property_dict_copy() == {"speed": 2.0}
"""


def test_a_channel_moves_over_by_one_word_of_its_imports():
    exec(MOVED.replace("mlagents_envs", "netmq_example.mlagents_envs"), {"__name__": "moved"})


@pytest.mark.parametrize(
    ("place", "name"),
    [
        ("environment", "UnityEnvironment"),
        ("base_env", "ActionTuple"),
        ("exception", "UnitySideChannelException"),
        ("side_channel", "SideChannelManager"),
        ("side_channel.raw_side_channel", "SideChannel"),
    ],
)
def test_the_place_of_version_0_3_has_the_same_class(place, name, monkeypatch):
    for loaded in [each for each in sys.modules if each.startswith(f"netmq_example.{place.split('.')[0]}")]:
        monkeypatch.delitem(sys.modules, loaded)
    with pytest.warns(DeprecationWarning, match=rf"netmq_example\.{place.split('.')[0]} is "):
        former = importlib.import_module(f"netmq_example.{place}")
    assert getattr(former, name) is getattr(importlib.import_module(f"netmq_example.mlagents_envs.{place}"), name)


# Where the two halves of ML-Agents do not agree, and what else Python alone decides


def test_what_is_queued_stays_as_it_was_and_goes_by_the_order_of_registration():
    one, two, message = RawBytesChannel(LOG), RawBytesChannel(STRANGER), OutgoingMessage()
    manager = SideChannelManager([two, one])
    message.write_string("a")
    one.queue_message_to_send(message)
    message.write_string("b")
    two.send_raw_data(b"c")
    one.queue_message_to_send(message)
    exchange = frame(STRANGER, b"c") + frame(LOG, b"\1\0\0\0a") + frame(LOG, b"\1\0\0\0a\1\0\0\0b")
    assert bytes(manager.generate_side_channel_messages()) == exchange
    assert manager.generate_side_channel_messages() == b"", "what was sent is not sent again"


def test_an_id_is_registered_once_also_by_the_same_channel():
    log = RawBytesChannel(LOG)
    with pytest.raises(UnitySideChannelException, match=f"channel {LOG} is registered already"):
        SideChannelManager([log, log])


def test_a_handlers_mistake_is_not_the_others_business(monkeypatch):
    class Wrong(RawSideChannel):
        def on_message_received(self, data):
            raise KeyError("a mistake")

    lines, right = [], RawBytesChannel(uuid.UUID(int=2))
    manager = SideChannelManager([Wrong(uuid.UUID(int=1)), right], lines.append)
    manager.process_side_channel_message(frame(uuid.UUID(int=1), b"") + frame(uuid.UUID(int=2), b"x"))
    assert right.get_and_clear_received_messages() == [b"x"]
    (line,) = lines
    said = r"channel 00000000-0000-0000-0000-000000000001: its handler raised KeyError\('a mistake'\) "
    monkeypatch.setattr(Wrong, "process_message", lambda self: None)
    manager.process_side_channel_message(frame(uuid.UUID(int=1), b""))
    assert lines[-1].endswith("(called wrongly)")
    assert re.fullmatch(said + r"\(raw_side_channel\.py:\d+, test_13_side_channels_bytes\.py:\d+\)", line), line


def test_what_is_kept_for_unknown_channels_has_a_limit():
    lines, late = [], RawBytesChannel(STRANGER)
    manager = SideChannelManager([], lines.append)
    for number in range(150):
        manager.process_side_channel_message(frame(STRANGER, bytes([number])))
    assert ["kept until" in line for line in lines] == [True, False] and "dropped" in lines[1]
    manager.register_side_channel(late)
    assert late.get_and_clear_received_messages() == [bytes([number]) for number in range(100)]


def test_settings_are_as_many_messages_as_there_are():
    engine, heard = EngineConfigurationChannel(), []
    with pytest.raises(UnitySideChannelException, match="width and height"):
        engine.set_configuration_parameters(width=80)
    engine.set_configuration(EngineConfig.default_config())
    manager = SideChannelManager([EngineSettings(lambda kind, values: heard.append(describe(kind, values)))])
    manager.process_side_channel_message(SideChannelManager([engine]).generate_side_channel_messages())
    assert heard == [
        "engine: screen resolution 80 x 80",
        "engine: quality level 1",
        "engine: time scale 20.0",
        "engine: target frame rate -1",
        "engine: capture frame rate 60",
    ]


# A peer can make the other one do only so much.


def test_the_parts_of_an_exchange_are_the_exchange():
    for exchange in (
        b"",
        frame(LOG, b"x") * 9_999,
        frame(LOG, b"x" * 200_000) * 3,
        frame(LOG, b"x") * 9_999 + frame(LOG, b"Hello")[:-1],
        frame(LOG, b"x") + LOG.bytes_le + struct.pack("<i", -5) * 40_000,
    ):
        parts = list(carrier.parts(exchange))
        assert b"".join(parts) == exchange
        for part in parts[:-1]:
            SideChannelManager().process_side_channel_message(part)
    assert len(list(carrier.parts(frame(LOG, b"x") * 9_999))) == 4


def test_what_a_peer_may_make_the_other_keep_has_a_limit(csharp_says):
    long = frame(FloatPropertiesChannel().channel_id, struct.pack("<i", 1001) + b"k" * 1001 + struct.pack("<f", 1))
    said = process(long)
    assert b"at most 10000 properties" in bytes.fromhex(said)
    assert csharp_says(".net", [f"process {digits(long)}"]) == [said]
    lines, properties = [], FloatPropertiesChannel()
    manager = SideChannelManager([properties], lines.append)
    for number in [*range(MOST_PROPERTIES + 3), 0]:
        key = f"{number}".encode()
        manager.process_side_channel_message(
            frame(FloatPropertiesChannel().channel_id, struct.pack("<i", len(key)) + key)
        )
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
    "socket": [lambda value: carrier.Carrier(value, SideChannelManager, print), None, 0, ""],
    "endpoint": [lambda value: carrier.ClientCarrier(CONTEXT, value), None, 0, "", "tcp://x:99999"],
    "timeout": [lambda value: carrier.ClientCarrier(CONTEXT, "tcp://x:1", value), None, 0, -1, NAN, ""],
    "context": [lambda value: carrier.ClientCarrier(value, "tcp://x:1"), None, 0, ""],
}


@pytest.mark.parametrize("name", WRONG)
def test_what_a_method_cannot_use_is_named(name):
    call, *values = WRONG[name]
    for value in values:
        with pytest.raises((ValueError, TypeError), match=rf"\b{name.strip()}\b") as caught:
            call(value)
        assert "\n" not in str(caught.value)
