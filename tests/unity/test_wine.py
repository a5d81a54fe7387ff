"""The C# clients on Windows' .NET, under Wine: terminal clients, Unity scripts in the player, Play and Stop.

The servers are this system's own Python, reached over loopback. It is no Windows, but it is Windows' .NET with NetMQ's
Windows code: what would fail there in the first minute fails here.
"""

import os
import re
import shutil
import statistics
import subprocess
import sys
from contextlib import suppress
from pathlib import Path

import pytest

from kitlib.programs import quietly
from kitlib.setup import dotnet
from tests.programs import LIMIT, PATIENT, ROOT, Program, free_port, two_ports

WINE = next(filter(None, map(shutil.which, ("wine64", "/usr/lib/wine/wine64", "wine"))), None)
# A request at a time, pictures, areas of a game, keys, and a WebSocket.
KEYS = ["01_request_reply", "08_see_and_steer", "10_many_agents", "15_security", "16_web_gateway"]
# Most Stops take at the most so many milliseconds: far from the usual 60, and from one that waits for something.
STOP_LIMIT = 2000
pytestmark = [
    pytest.mark.long,
    pytest.mark.skipif(sys.platform == "win32", reason="this is Windows itself"),
    pytest.mark.skipif(not WINE, reason="no wine64 here (on Debian: apt install wine64)"),
    pytest.mark.timeout(1200),
    # One build for .NET of Windows, and one Windows.
    pytest.mark.xdist_group("wine"),
]


@pytest.fixture(scope="module")
def programs(netmq, tmp_path_factory):
    """csharp-console.exe and play.exe with Windows' .NET beside them."""
    folder = tmp_path_factory.mktemp("windows")
    # An .exe is made for .NET itself, and not for .NET Standard.
    framework = f"-p:LibraryFramework=net{(dotnet.sdk() or '').split('.')[0]}.0"
    own = ["-p:NuGetAudit=false", f"-p:ArtifactsPath={folder / 'artifacts'}"]
    play = ["-p:UseAppHost=true", "-p:GenerateDependencyFile=true"]
    projects = [("csharp-console", []), ("tests/unity/play", play)]
    for project, more in projects:
        publish = ["dotnet", "publish", ROOT / project, "-o", folder / "bin"]
        windows = ["-r", "win-x64", "--self-contained", framework]
        result = quietly([*publish, *windows, *own, *more], 300, dotnet.ENVIRONMENT)
        if re.search("NU110[123]|NU1301|NU1801", result.output):
            pytest.skip(f"NuGet gave no .NET for Windows: {result.first(' error ')}")
        assert result.ok, result.output
    yield folder / "bin"
    # It is large, and pytest would keep it.
    shutil.rmtree(folder)


@pytest.fixture(scope="module")
def wine(programs, tmp_path_factory):
    """wine("play.exe", …) starts a program in a Windows of this test's own."""
    prefix = tmp_path_factory.mktemp("wine")
    # Wine does not bear how .NET protects the code that it makes: where a picture's buffers bring about a full garbage
    # collection, it ends with an "Internal CLR error" in DynamicResolver's finalizer.
    environment = {"WINEPREFIX": str(prefix), "WINEDEBUG": "-all", "DOTNET_EnableWriteXorExecute": "0"}
    started = []

    def start(program, *words, folder=ROOT):
        command = [str(WINE), programs / program, *words]
        started.append(Program(command, folder=folder, stdin=subprocess.PIPE, **environment))
        return started[-1]

    yield start
    for program in started:
        program.kill()
    # It ends what runs in this WINEPREFIX, and nothing else.
    server = shutil.which("wineserver") or Path(str(WINE)).resolve().parent / "wineserver64"
    subprocess.run([server, "-k"], env={**os.environ, **environment}, timeout=LIMIT, check=False)
    shutil.rmtree(prefix, ignore_errors=True)


@pytest.mark.parametrize("unity", [False, True], ids=["terminal", "unity"])
@pytest.mark.parametrize("key", KEYS)
def test_a_client(key, unity, wine, serve, tmp_path):
    endpoint = serve(key, endpoint=two_ports())[1]
    # The component that has many areas asks, and none of the areas.
    patient = () if unity and key.startswith("10") else PATIENT
    client = wine(
        "csharp-console.exe",
        key,
        *(["--unity"] if unity else []),
        "--endpoint",
        endpoint,
        *patient,
        # The server's, which has made keys there.
        folder=tmp_path,
    )
    assert client.wait(400) == 0, client.output
    assert not [line for line in client.lines if "gave up" in line], client.output


def test_a_client_without_a_server(wine):
    client = wine("csharp-console.exe", "1", "--endpoint", f"tcp://127.0.0.1:{free_port()}", "--timeout", "1")
    assert client.wait(400) == 1, client.output
    assert "no reply" in client.lines[-1]


@pytest.mark.parametrize("server", ["up", "absent"])
@pytest.mark.parametrize("key", [KEYS[0], KEYS[-1]])
def test_play_and_stop(key, server, wine, serve):
    """On the same statics, as with domain reload off."""
    endpoint = serve(key, endpoint=two_ports())[1] if server == "up" else f"tcp://127.0.0.1:{free_port()}"
    unity = wine("play.exe", "keep")
    pipe = unity.process.stdin
    stops = []
    for _ in range(3):
        for button, answer in ((f"play {key} {endpoint} 2", "^playing$"), ("stop", r"^stopped in ([\d.]+) ms")):
            said = len(unity.lines)
            # If it has ended, the next line says of what.
            with suppress(BrokenPipeError):
                pipe.write(f"{button}\n")
                pipe.flush()
            found = unity.wait_for(answer, 60, said)
        stops.append(float(found[1]))
        unity.wait_for("^ready$", 60, said)
    assert statistics.median(stops) < STOP_LIMIT
    pipe.close()
    assert unity.wait() == 0, unity.output
