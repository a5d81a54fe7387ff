"""Lesson 04 with JSON: objects of one's own both ways, and what does not fit named on both sides."""

from __future__ import annotations

import json

from tests.lessons.conftest import ask

KEY = "04_background_client"
TOLD = """
def answer(text):
    import json
    reply = json.loads(text)["reply"]
    return json.dumps({"say": text}) if reply == "the state" else reply
"""


def test_classes_of_ones_own_in_csharp(serve_own, start, checks):
    program = start("dotnet", checks, "background", f"Ask={serve_own(KEY, TOLD)[1]}")
    assert program.wait() == 0, program.output
    assert program.lines == ["Ask: ok"]


JSON = """
from netmq_example.replies import json_answer

seen = []


@json_answer
def answer(state: dict) -> dict:
    seen.append(state["guest"])
    if state.get("mistake"):
        return {}["mine"]
    if "result" in state:
        return {"nan": {"x": float("nan")}, "set": {"x": {1}}, "list": [], "key": {(1, 2): 1}}[state["result"]]
    return {"seen": seen, "x": state["place"]["x"]}
"""
ASKED = {
    '{"guest": "Ada", "place": {"x": 1}}': '{"seen": ["Ada"], "x": 1}',
    '{"guset": "Ada", "place": {"x": 1}}': "error: the request has no 'guest'; it has 'guset', 'place'",
    '{"guest": "Bo", "place": {}}': "error: the request has no 'x'; it has nothing",
    "{}": "error: the request has no 'guest'; it has nothing",
    "[1]": "error: the request '[1]' is no JSON object: send a class with fields",
    "null": "error: the request 'null' is no JSON object: send a class with fields",
    '{"guest": NaN}': "error: the request '{\"guest\": NaN}' is no JSON: NaN is not JSON",
    "hello\n": "error: the request 'hello?' is no JSON: Expecting value: line 1 column 1 (char 0)",
    "[" * 60_000: f"error: the request '{'[' * 80}…' is no JSON: it nests more than 64 levels deep",
    '{"guest": "Cy", "result": "list"}': "error: answer returned []: return a dict",
    '{"guest": "Cy", "result": "nan"}': "error: answer returned what JSON cannot have: Out of range float values",
    '{"guest": "Cy", "result": "set"}': "error: answer returned what JSON cannot have: Object of type set is not JSON",
    '{"guest": "Cy", "result": "key"}': "error: answer returned what JSON cannot have: keys must be str",
    '{"guest": "Cy", "mistake": true}': "error: KeyError('mine')",
}


def test_a_dict_in_and_a_dict_out_in_python(serve_own, context):
    server, endpoint = serve_own(KEY, JSON)
    for id, (request, wanted) in enumerate(ASKED.items()):
        # Asked twice, as by a retry.
        for _ in range(2):
            reply = ask(context, endpoint, b"%d" % id, request.encode())[1].decode()
            assert reply.startswith(wanted), reply
            if reply[0] == "{":
                assert json.loads(reply) == json.loads(wanted)
    server.wait_for(r"KeyError: 'mine'")
    # In one line, and how many there were meanwhile; only a mistake that is the answer's own has a traceback.
    assert "trouble: the request has no 'guest'; it has 'guset', 'place'" in server.lines
    # Asked twice.
    assert server.output.count("Traceback") == 1
