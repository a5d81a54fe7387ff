"""The editor shows the clients, and says what is wrong with a build: inspector, traffic, address, prefab, guards."""

import re
import shutil
import time
from pathlib import Path
from xml.etree import ElementTree

import pytest

from kitlib.unity.meta import own_guid
from tests.programs import steady_port
from tests.unity.conftest import NEAREST, PACKAGE, PREFAB

# They share what was built.
pytestmark = pytest.mark.xdist_group("player")


def test_the_inspector_shows_the_state_and_has_buttons(editor, project, serve):
    unity = editor(project)
    _, endpoint = serve("04_background_client")
    unity.do(f"play 4 {endpoint} 2")
    drawn = unity.draw_until("^Info: Connected, round trip [0-9.]+ ms$")
    assert "[Drop the connection]" in drawn and "[Connect]" not in drawn
    # By UI Toolkit, as Unity draws them itself: a drawer that a user has made with it would have no GUI otherwise.
    assert drawn.index("fields of HelloBackground") < drawn.index("Info: Connected")
    unity.play_until("done: 2 replies")
    # The component has all that it wanted; a request more is the editor's.
    unity.do("press Send hello")
    unity.play_until("received world")
    assert "[Drop the connection]" in unity.do("press Drop the connection")
    unity.draw_until("^Warning: disconnected$")
    unity.do("press Connect")
    # A text in the scene shows the same, for a headset.
    unity.draw_until("^hud: HelloBackground: Connected, round trip [0-9.]+ ms$")
    unity.do("stop")
    assert unity.do("draw") == []


def test_the_inspector_shows_why_a_client_gave_up(editor, project):
    unity = editor(project)
    unity.do("play 1 127.0.0.1:5551 3")
    drawn = unity.draw_until("^Error: gave up$")
    assert "Error: bad endpoint '127.0.0.1:5551': write it like tcp://127.0.0.1:PORT" in drawn
    unity.do("stop")


def test_the_buttons_are_for_all_that_are_selected_and_play(editor, project):
    unity = editor(project)
    unity.do("play 1 tcp://127.0.0.1:9 3")
    unity.do("another tcp://127.0.0.1:9")
    assert unity.do("draw").count("[Drop the connection]") == 2
    unity.do("press Drop the connection")
    assert unity.do("draw").count("Warning: disconnected") == 2
    unity.do("press Connect")
    assert unity.do("draw").count("Info: connected") == 2
    # Of a prefab in Assets a button would change the file.
    unity.do("prefab")
    assert unity.do("draw").count("[Drop the connection]") == 1
    unity.do("destroy")
    assert "hud: no client" in unity.draw_until("^hud: no client$")
    unity.do("stop")


def exchanged(drawn):
    """The messages of the window, without time and endpoint."""
    return [line.split(" ", 2)[2] for line in drawn.splitlines() if re.match(r"\d\d:\d\d:\d\d\.\d{3} tcp://", line)]


# The first messages of a lesson's client: a text with its id, a stream, a picture, a header. test_contract.py counts
# those of each lesson.
SEEN = {
    "2": ("02_lazy_pirate", r"> 1-\w+ \| add 1", r"< 1-\w+ \| 1"),
    "3": ("03_publish_subscribe", None, r"< pose/.*"),
    "8": ("08_see_and_steer", r'> {"kind":"frame".* \| \(\d+ bytes\)', r'< {"kind":"action".*'),
    "14": ("14_long_jobs", r'> {"kind":"goal".*', r'< {"kind":"accepted".*'),
}


def test_the_traffic_window_shows_what_the_clients_say(editor, project, serve):
    unity = editor(project)
    unity.do("menu Tools/NetMQ Example/Traffic")
    for number, (key, sent, received) in SEEN.items():
        _, endpoint = serve(key)
        unity.do(f"play {number} {endpoint} 3 60")
        for pattern in filter(None, (sent, received)):
            drawn = unity.draw_until(f" {re.escape(endpoint)} {pattern}$")
            assert [line for line in exchanged(drawn) if re.fullmatch(pattern, line)], key
        unity.do("stop")


def test_the_traffic_window_filters_pauses_and_copies(editor, project, serve):
    unity = editor(project)
    unity.do("menu Tools/NetMQ Example/Traffic")
    _, endpoint = serve("01_request_reply")
    unity.do(f"play 1 {endpoint} 1200")
    unity.play_until("done: 1200 replies")
    unity.do("stop")
    unity.do("press Copy")
    copied = exchanged("\n".join(unity.do("clipboard")))
    assert len(copied) == 1000 and copied == ["> Hello", "< World"] * 500, "the last thousand"
    unity.do("type Only lines with=world")
    unity.do("draw")
    assert set(exchanged("\n".join(unity.do("draw")))) == {"< World"}
    assert "[Pause]" in unity.do("press Pause")
    assert "[Go on]" in unity.do("draw")
    unity.do("type Only lines with=5 bytes")
    unity.do(f"play 1 {endpoint} 3")
    unity.play_until("done: 3 replies")
    unity.do("stop")
    unity.do("type Only lines with=")
    unity.do("press Copy")
    assert exchanged("\n".join(unity.do("clipboard"))) == copied, "nothing is kept in a pause"


def test_a_program_that_is_not_the_editor_holds_no_call(editor, project):
    """Not even what it would be given is made. The lessons' own calls, compiled for the editor, are seen."""
    assert editor(project).do("counted") == ["seen 0, made 0", "seen 1"]


def test_one_asset_says_where_the_servers_are(editor, project, serve):
    unity = editor(project)
    assert "created Assets/Resources/NetMQServerAddress.asset" in unity.do("menu Tools/NetMQ Example/Server address")
    assert not any("created" in line for line in unity.do("menu Tools/NetMQ Example/Server address"))
    port = steady_port()
    unity.do("host localhost")
    unity.do(f"play 1 tcp://127.0.0.1:{port} 3")
    unity.play_until(f"asking tcp://localhost:{port}")
    unity.do("stop")
    unity.do("host beacon://lab")
    unity.do(f"play 1 tcp://127.0.0.1:{port} 3")
    unity.play_until(f"asking beacon://lab:{port}")
    unity.do("stop")
    # Another machine's name was written on purpose.
    unity.do("play 1 tcp://127.0.0.2:9 3")
    unity.play_until("asking tcp://127.0.0.2:9")
    unity.do("stop")


@pytest.mark.parametrize(
    ("words", "said"),
    [
        # The last one, as in Python; or that of one class.
        ("--endpoint tcp://127.0.0.1:8 -x --endpoint=tcp://127.0.0.1:9", "^asking tcp://127.0.0.1:9$"),
        ("--HelloClient.endpoint tcp://127.0.0.1:9 --endpoint tcp://127.0.0.1:8", "^asking tcp://127.0.0.1:9$"),
        ("--endpoint", "^Error: bad endpoint '': write it like "),
    ],
)
def test_a_build_takes_the_endpoint_from_its_command_line(words, said, editor, project):
    unity = editor(project, words=words.split())
    unity.do("play 1 tcp://127.0.0.1:5551 3")
    unity.draw_until(said)
    unity.do("stop")


PLIST = (
    '<?xml version="1.0" encoding="UTF-8"?>\n<plist version="1.0">\n<dict>\n\t<key>A</key>\n\t<dict>\n\t</dict>\n'
    "</dict>\n</plist>\n"
)


def test_a_device_is_warned_of_what_cannot_work_there(editor, project, tmp_path):
    unity = editor(project)
    plist = tmp_path / "Info.plist"
    plist.write_text(PLIST, encoding="utf-8")
    loopback = "HelloClient in scene Main asks 127.0.0.1, which on a device is the device itself"
    permission = "Android may refuse NetMQ the network: set Project Settings, Player, Other Settings, Internet Access"
    said = "\n".join(unity.do(f"build Android {tmp_path}"))
    assert said.count(loopback) == 1 and said.count(permission) == 1
    said = "\n".join(unity.do(f"build StandaloneLinux64 {tmp_path}"))
    assert loopback not in said and permission not in said
    # The linker finds its file even if the package is not in Assets.
    assert f"link: {project / 'Assets' / 'NetMQExample' / 'link.xml'}" in said
    for _ in range(2):
        said = "\n".join(unity.do(f"build iOS {tmp_path}"))
        assert loopback in said and permission not in said
    (outer,) = ElementTree.parse(plist).getroot()
    assert [part.text for part in outer if part.tag == "key"] == ["NSLocalNetworkUsageDescription", "A"], "once"
    unity.do("menu Tools/NetMQ Example/Server address")
    unity.do("host 192.168.1.20")
    assert loopback not in "\n".join(unity.do(f"build Android {tmp_path}"))
    # The build goes on without the file.
    (project / "Assets" / "NetMQExample" / "link.xml.meta").unlink()
    assert "link: " in unity.do(f"build Android {tmp_path}")


def test_a_mac_asks_for_the_local_network(editor, project, tmp_path):
    """And is not warned of 127.0.0.1: that is the same Mac. A program that was signed before is signed again, once."""
    # Where there is no codesign, its line is said.
    codesign = tmp_path / "bin" / "codesign"
    codesign.parent.mkdir()
    log = Path(f"{codesign}.log")
    unity = editor(project, str(shutil.which(NEAREST)), PATH=str(codesign.parent))
    # A project for Xcode is signed there.
    for output, inside, signed in (("xcode", "My Game", False), ("Game.app", "Contents", True)):
        plist = tmp_path / output / inside / "Info.plist"
        plist.parent.mkdir(parents=True)
        plist.write_text(PLIST, encoding="utf-8")
        codesign.unlink(missing_ok=True)
        build = f"build StandaloneOSX {tmp_path / output}"
        said = unity.do(build) + unity.do(build)
        words = f'--force --deep --sign - "{tmp_path / output}"'
        assert said.count(f"on a Mac, before {output} runs: codesign {words}") == signed
        codesign.write_text(f'#!/bin/sh\necho "$@" >> {codesign}.log\n', encoding="utf-8")
        codesign.chmod(0o755)
        plist.write_text(PLIST, encoding="utf-8")
        said += unity.do(build) + unity.do(build)
        assert (log.read_text().splitlines() if log.exists() else []) == [words.replace('"', "")] * signed
        assert not any("127.0.0.1" in line for line in said)
        assert plist.read_text(encoding="utf-8").count("<key>NSLocalNetworkUsageDescription</key>") == 1


def test_android_17_asks_for_the_local_network(editor, project, tmp_path):
    unity = editor(project)
    ask = (
        "from Android 17 on the user decides whether a game may talk to the local network: declare android.permission."
    )
    for level, asked in {"36": False, "37": True, "0": False}.items():
        assert (ask in "\n".join(unity.do(f"build Android {tmp_path} {level}"))) == asked
    manifest = project / "Assets" / "Plugins" / "Android" / "AndroidManifest.xml"
    manifest.parent.mkdir(parents=True)
    manifest.write_text('<uses-permission android:name="android.permission.ACCESS_LOCAL_NETWORK" />', encoding="utf-8")
    assert ask not in "\n".join(unity.do(f"build Android {tmp_path} 37"))


def test_the_menu_adds_the_prefab(editor, project):
    """By its GUID, wherever the package lies; and what the prefab refers to is there."""
    unity = editor(project)
    assert "undo: Add NetMQ client" in unity.do("menu GameObject/NetMQ Example/Background client")
    text = PREFAB.read_text(encoding="utf-8")
    scripts = [own_guid(PACKAGE / name) for name in ("04_background_client/HelloBackground.cs", "Shared/ClientHud.cs")]
    assert re.findall(r"m_Script: \{fileID: 11500000, guid: (\w+), type: 3\}", text) == scripts
    names = re.findall(r"^--- !u!\d+ &(\d+)$", text, re.MULTILINE)
    assert len(names) == len(set(names)) and set(re.findall(r"\{fileID: (\d+)\}", text)) <= {"0", *names}
    client = re.search(r"&(\d+)\nMonoBehaviour:(?:\n  .*)+?" + scripts[0], text)
    assert client and f"  client: {{fileID: {client[1]}}}\n" in text


def test_clients_that_a_script_forgot_are_counted_once_after_stop(editor, project):
    unity = editor(project)
    # A connection that ends a moment after Stop is not worth a line.
    unity.do("play 1 tcp://127.0.0.1:9 3")
    unity.do("forget 1")
    unity.do("stop")
    unity.do("settle")
    unity.do("remember")
    assert unity.do("draw") == []
    # A window of the editor's may have clients of its own.
    unity.do("forget 1")
    unity.do("play 1 tcp://127.0.0.1:9 3")
    unity.do("forget 2")
    began = time.monotonic()
    unity.do("stop")
    unity.do("settle")
    drawn = unity.draw_until("still open")
    assert "NetMQ connections that are still open: 2; call Dispose in OnDisable of the script that made them" in drawn
    assert time.monotonic() - began >= 2, "what is still ending has its time"
    assert unity.do("draw") == []
    assert unity.program.output.count("still open") == 1
    unity.do("remember")
