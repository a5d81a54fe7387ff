"""The front door: what `import netmq_example` gives to a program of one's own."""

import importlib
import subprocess
import sys
from operator import attrgetter

import pytest
import zmq

import netmq_example
from netmq_example import messages
from tests.programs import LIMIT, ROOT, steady_endpoint

ALONE = """
import importlib, sys
for missing in ("numpy", "gymnasium", "pettingzoo", "PIL", "aiohttp", "socketio", "mediapipe", "ray", "torch"):
    sys.modules[missing] = None
before = set(sys.modules)
importlib.import_module(sys.argv[1])
print(*sorted(set(sys.modules) - before))
"""
OTHERS = ["body", "camera", "fleet", "jobs", "scene", "security", "video", "web"]
DOORS = ["netmq_example", *(f"netmq_example.{name}" for name in OTHERS)]


@pytest.mark.parametrize("name", DOORS)
def test_a_door_loads_nothing_and_has_its_names(name):
    words = [sys.executable, "-c", ALONE, name]
    done = subprocess.run(words, cwd=ROOT / "python", capture_output=True, text=True, timeout=LIMIT, check=False)
    assert done.returncode == 0, done.stderr
    loaded = {each for each in done.stdout.split() if "netmq_example" in each or "zmq" in each}
    assert loaded == ({name} if name == "netmq_example" else {"netmq_example", "netmq_example.doors", name})
    door = importlib.import_module(name)
    assert set(door.__all__) <= set(dir(door))
    for each in door.__all__:
        try:
            assert getattr(door, each)
        except ImportError as lacking:
            assert "-m pip install " in str(lacking)
    with pytest.raises(AttributeError, match=rf"^module '{name}' has no attribute 'Nonsense'$"):
        _ = door.Nonsense


SHAPES = {
    "security.SecureRequester": {},
    "camera.DriverClient": {},
    "jobs.JobClient": {},
    "body.BodyListener": {"topic": "pose/0/"},
    "fleet.FleetSocket": {"name": "CartPole", "areas": 1},
    "video.Films": {},
    "mlagents_envs.carrier.ClientCarrier": {"context": zmq.Context.instance()},
}


@pytest.mark.parametrize("name", SHAPES)
def test_what_has_a_socket_shows_its_endpoint_and_is_closed_once(name):
    room, _, kind = name.rpartition(".")
    try:
        made = getattr(importlib.import_module(f"netmq_example.{room}"), kind)
    except ImportError as lacking:
        pytest.skip(str(lacking))
    endpoint = steady_endpoint()
    with made(endpoint=endpoint, **SHAPES[name]) as opened:
        assert repr(opened) == f"{kind}('{endpoint}')"
        opened.close()


def former(name, *words):
    made = getattr(netmq_example, name)(*words)
    made.close()
    return made


@pytest.mark.parametrize("name", ["LazyPirate", "ManyRequester", "DriverClient", "JobClient"])
def test_the_context_came_first_in_version_0_3(name):
    with zmq.Context() as context, pytest.warns(DeprecationWarning, match=rf"^write {name}\(endpoint, …\) with"):
        made = former(name, context, "tcp://127.0.0.1:5999")
    assert (made.endpoint, made.context) == ("tcp://127.0.0.1:5999", context)


def test_what_version_0_3_called_otherwise():
    with pytest.warns(DeprecationWarning):
        client = former("BackgroundClient", steady_endpoint(), 0.2, 1, 8)
    assert (client.capacity, client.pirates[0].timeout, client.pirates[0].tries) == (8, 0.2, 1)
    for old, name in {"read": "Message.read", "read_reply": "Message.read_reply", "reply_to": "message_reply"}.items():
        with pytest.warns(DeprecationWarning, match=rf"^netmq_example\.messages\.{old} is netmq_example\.{name} now"):
            assert getattr(messages, old) is attrgetter(name)(netmq_example)
    with zmq.Context() as context, context.socket(zmq.SUB) as socket, pytest.warns(DeprecationWarning):
        assert former("TopicListener", socket, steady_endpoint(), "pose/").topic == "pose/"
    lines = []
    with zmq.Context() as context, pytest.warns(DeprecationWarning):
        pirate = netmq_example.LazyPirate(context, steady_endpoint(), 0.05, 2, lines.append)
        with pirate, pytest.raises(netmq_example.Timeout):
            pirate.request("x")
    assert lines == ["1: no reply within 0.05 s; try 2 of 2"]
