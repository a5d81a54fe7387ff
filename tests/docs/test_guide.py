"""The README and the guide are true: excerpts, transcripts, commands and programs, each compared or run."""

from __future__ import annotations

import json
import os
import re
import shlex
import subprocess
from pathlib import Path
from xml.etree import ElementTree

import pytest
import zmq

from kitlib.docs import guide, terminal_picture
from kitlib.lessons import find
from kitlib.setup import dotnet
from kitlib.terminal import COLOURS
from lab import report
from tests.conftest import PYTHON
from tests.programs import ROOT, finished, steady_endpoint

GUIDE = ROOT / "docs" / "guide"
PAGES = guide.pages()
BLOCKS = [block for page in PAGES for block in guide.blocks(page)]


def of(*kinds):
    """The blocks of these kinds; those of a page on one worker, because what a run printed is kept in its memory."""
    return pytest.mark.parametrize(
        "block",
        [
            pytest.param(block, id=block.where, marks=pytest.mark.xdist_group(block.page.stem))
            for block in BLOCKS
            if block.kind in kinds
        ],
    )


@of("bench")
def test_a_table_is_what_the_kept_run_has(block):
    assert block.body == report.in_a_page(block.source), "python3 -m lab.report rewrites it"


@of("excerpt")
def test_an_excerpt_is_what_its_file_has(block):
    assert block.body == guide.excerpt(block.source), "python3 -m kitlib.docs.guide rewrites it"


def printed(words, run=guide.printed):
    """However they are quoted: what was run once is not run again."""
    return run(shlex.join(shlex.split(words)))


@pytest.mark.timeout(1200)
@of("run", "like")
def test_a_transcript_is_what_a_run_prints(block, netmq, console):
    """`console` builds first: a run's limit is for what it prints, and not for the build that others wait for too."""
    difference = guide.contradiction(block, printed(block.source))
    if difference:
        # On a busy machine a client tries once more than the page says; a page that is wrong is so again.
        difference = guide.contradiction(block, printed(block.source, guide.printed.__wrapped__))
    assert not difference, f"{difference}\npython3 -m kitlib.docs.guide rewrites it"


@of("commands")
def test_every_command_runs(block, serve, start, client_command, netmq, tmp_path):
    for line in filter(None, block.body.splitlines()):
        words = shlex.split(line.split("  #")[0])
        if words[:2] == ["python3", "kit.py"]:
            run_kit(words[2:], serve, start, tmp_path)
        elif match := re.fullmatch(r"python/(\d\d_\w+)/server\.py", words[1] if len(words) > 1 else ""):
            assert words[0] == "python"
            server, _ = serve(match[1], *words[2:])
            assert server.stop() in (0, -15)
        elif match := re.fullmatch(r"python/(\d\d_\w+)/client\.py", words[1] if len(words) > 1 else ""):
            run_client("python", match[1], words[2:], serve, start, client_command)
        else:
            assert words[:5] == ["dotnet", "run", "--project", "csharp-console", "--"], f"unknown command: {line}"
            run_client("csharp", find(words[5]).key, words[6:], serve, start, client_command)


def run_kit(words, serve, start, folder):
    if words[0] == "server":
        free = ["--endpoint", find(words[1]).anywhere]
        server = start(PYTHON, ROOT / "kit.py", *words, *free, "--folder", folder)
        # Where others are behind it, each line says whose it is.
        server.wait_for(r"^(server +\| )?listening on ")
        server.stop()
        return
    if words[0] == "client":
        # In one folder with its server: lesson 15's has its keys there.
        words = [*words, "--endpoint", serve(find(words[1]).key)[1], "--folder", str(folder)]
    elif words[0] == "run":
        # The same words as in a transcript are not run again; the exit code is looked at there.
        said = printed(shlex.join(words[1:]))
        assert not [line for line in said if "Traceback" in line], "\n".join(said)
        return
    elif words[0] == "test":
        # This very run, or a part of it; only its words are checked.
        words = ["test", "--markers", *words[1:]]
    elif words[0] in ("bench", "doctor"):
        # Tests of their own run them; here only the words are checked.
        words = [*words, "--help"]
    elif words[0] == "unity":
        # It needs a project; test_unity_install.py has some.
        words = [*words, "--help"]
    elif words[0] == "copy":
        words[2] = str(folder / words[2].strip("./"))
    program = start(PYTHON, ROOT / "kit.py", *words)
    assert program.wait(240) in (0, 1), program.output
    assert "Traceback" not in program.output


def run_client(kind, key, options, serve, start, client_command):
    _, endpoint = serve(key)
    if options[:1] == ["--unity"]:
        # The endpoint is the test's own.
        kind, pairs = "unity", zip(options[1::2], options[2::2], strict=True)
        options = [word for name, value in pairs if name != "--endpoint" for word in (name, value)]
    program = start(*client_command(kind, key, endpoint, *options))
    assert program.wait(120) in (0, 1), program.output
    assert "Traceback" not in program.output


def compiled(project, netmq):
    """Every C# file that a project compiles, as MSBuild lists them."""
    command = ["dotnet", "msbuild", project, *netmq.properties, "-getItem:Compile"]
    done = subprocess.run(command, capture_output=True, env={**os.environ, **dotnet.ENVIRONMENT}, timeout=500)
    return {Path(item["FullPath"]) for item in json.loads(done.stdout)["Items"]["Compile"]}


def test_every_csharp_excerpt_is_of_a_file_that_is_compiled(netmq):
    sources = {
        ROOT / block.source.split()[0] for block in BLOCKS if block.language == "csharp" and block.kind == "excerpt"
    }
    assert sources
    # The lessons' own first: most of the time nobody else needs to be asked.
    projects = [project for tree in ("csharp-*", "lab", "tests") for project in ROOT.glob(f"{tree}/**/*.csproj")]
    for project in sorted(projects, key=lambda path: path.stem not in ("NetMQExample", "csharp-console")):
        if sources:
            sources -= compiled(project, netmq)
    assert not sources


# What stands round a fragment: the names that it may use besides its own.
SURROUNDINGS = """
using System; using System.Collections.Generic; using System.Linq; using System.Threading; using System.Threading.Tasks;
using NetMQ; using NetMQ.Sockets; using NetMQExample; using UnityEngine;
{usings}
class Fragment{number} : MonoBehaviour
{{
    RequestSocket socket = null; BackgroundClient client = null; string[] args = null;
{body}
}}
"""
DECLARATION = r"(?:\[\w|public |private |protected |internal |static |readonly |async |void |IEnumerator )"


def surrounded(block, number):
    """A file that the fragment can be compiled in: a member of a MonoBehaviour, or statements of a method.

    A class of its own is a file already, and compiles as a reader copies it.
    """
    if re.search(r"^public .*\bclass \w+", block.body, re.MULTILINE):
        return f'#line {block.line + 2} "{block.page.name}"\n{block.body}'
    usings = re.findall(r"^using [\w.= ]+;$", block.body, re.MULTILINE)
    body = re.sub(r"^using [\w.= ]+;$", "", block.body, flags=re.MULTILINE)
    body = f'#line {block.line + 2} "{block.page.name}"\n{body}\n#line default'
    if not re.search(rf"^{DECLARATION}", body, re.MULTILINE):
        body = f"async Task Statements() {{\n{body}\nawait Task.CompletedTask; }}"
    fresh = [using for using in usings if using not in SURROUNDINGS]
    return SURROUNDINGS.format(usings="\n".join(fresh), number=number, body=body)


def build(folder, console, properties=""):
    """Build the C# files of a folder against the lessons' assembly."""
    references = "".join(f'<Reference Include="{dll}" />' for dll in Path(console[1]).parent.glob("*.dll"))
    (folder / "fragments.csproj").write_text(
        f"""<Project Sdk="Microsoft.NET.Sdk">
  <PropertyGroup>
    <TargetFramework>net$(BundledNETCoreAppTargetFrameworkVersion)</TargetFramework>
    <LangVersion>9.0</LangVersion>
    <Optimize>false</Optimize>
    {properties}
  </PropertyGroup>
  <ItemGroup>{references}</ItemGroup>
</Project>
""",
        encoding="utf-8",
    )
    command = [
        "dotnet",
        "build",
        folder,
        "-p:NuGetAudit=false",
        "-m:1",
        "-v:quiet",
        "-nologo",
        "-clp:NoSummary;ErrorsOnly",
    ]
    return subprocess.run(
        command, capture_output=True, text=True, env={**os.environ, **dotnet.ENVIRONMENT}, timeout=500
    )


def compile_fragments(folder, blocks, console):
    """Compile C# blocks that are no excerpts; returns the errors."""
    for number, block in enumerate(blocks):
        (folder / f"Fragment{number}.cs").write_text(surrounded(block, number), encoding="utf-8")
    done = build(folder, console)
    return "" if done.returncode == 0 else done.stdout + done.stderr


def test_every_other_csharp_block_compiles(tmp_path, console):
    """Three that do not are beside them: of each error the compiler says in which block it is."""
    blocks = [block for block in BLOCKS if block.language == "csharp" and block.kind != "excerpt"]
    # Not what another test compiles where it belongs.
    blocks = [block for block in blocks if "in the component above" not in block.source]
    wrong = [
        guide.Block(GUIDE / "x.md", 7, "by hand", "why", "csharp", body)
        for body in (
            "void Update()\n{\n    socket.SendFrame(missing);\n}\n",
            "using System;\n\nvar x = args.Lenth;\n",
            "\npublic class Mine { void Say() => Debug.Log(1); }\n",
        )
    ]
    errors = compile_fragments(tmp_path, [*blocks, *wrong], console)
    assert [line for line in errors.splitlines() if "error" in line and not re.search(r"x\.md\((10|11),", line)] == []
    assert re.search(r"x\.md\(11,.*'missing'", errors)
    assert re.search(r"x\.md\(11,.*'Lenth'", errors)
    assert re.search(r"x\.md\(10,.*'Debug'", errors), "a file without its usings"


# What Unity does with scripts: puts them on an object, calls them frame by frame, and disables them at Stop.
PLAY = """
using System; using System.Linq; using NetMQExample; using UnityEngine; using UnityPlayer;
var player = new Player(typeof(MyClient).Assembly);
DrivenBehaviour car = null;
var (answers, least) = (0, args[0] == "paths" ? 3 : 2);
var wanted = new[] { "where to?", "it says 3.5", "echo 2: 2", "echo 3: 3", "sleep 0.5: slept 0.5" };
Application.logMessageReceived += (line, _, _) => answers += wanted.Contains(line) ? 1 : 0;
player.Begin(() =>
{
    var thing = new GameObject("mine");
    thing.SetActive(false);
    var types = args[0] == "client" ? new[] { typeof(MyClient) }
        : args[0] == "asker" ? new[] { typeof(Asker) }
        : args[0] == "paths" ? new[] { typeof(Paths) }
        : new[] { args[0] == "eye" ? typeof(MyEye) : typeof(MyCar), typeof(CameraSender), typeof(RoadScene) };
    Inspector.Set(types.Select(type => (MonoBehaviour)thing.AddComponent(type)).ToArray(), "endpoint", args[1]);
    car = thing.GetComponent<DrivenBehaviour>();
    thing.transform.position = new Vector3(3.5f, 0, 0);
    // Beside the middle of the road.
    if (car is MyEye) thing.transform.SetPositionAndRotation(new Vector3(52, 0, 12), Quaternion.Euler(0, 80, 0));
    // Asked while it is off: left out.
    thing.GetComponent<Paths>()?.Ask(new[] { "echo old" });
    thing.SetActive(true);
    if (thing.GetComponent<Paths>() is Paths paths) paths.Ask(new[] { "sleep 0.5", "echo 2", "echo 3" });
    if (!(thing.GetComponent<Asker>() is Asker asker)) return;
    // While its thread begins.
    thing.transform.position = new Vector3(1.5f, 0, 0);
    asker.Ask();
    thing.transform.position = new Vector3(3.5f, 0, 0);
});
player.Run(TimeSpan.FromSeconds(car == null ? 30 : 40),
    () => car == null ? answers >= least && Time.realtimeSinceStartup > 2.5f : car.Speed > 3 || Turned());
if (car is MyCar) Console.WriteLine($"drives: {car.Speed > 3}");
if (car is MyEye) Console.WriteLine($"looks around: {Turned()}");
player.Stop();
bool Turned() => car is MyEye && Math.Abs(car.transform.rotation.y - Quaternion.Euler(0, 80, 0).y) > 0.01f;
"""


def test_a_script_of_yours_plays(tmp_path, console, serve):
    """The components that lessons 04, 05, 06 and 08 give a Unity developer to begin with, each against its server."""
    for block in (each for each in BLOCKS if each.language == "csharp" and "a_script_of_yours_plays" in each.source):
        name = re.search(r"class (\w+)", block.body)[1]
        (tmp_path / f"{name}.cs").write_text(block.body, encoding="utf-8")
    (tmp_path / "Program.cs").write_text(PLAY, encoding="utf-8")
    done = build(tmp_path, console, "<OutputType>Exe</OutputType>")
    assert done.returncode == 0, done.stdout + done.stderr

    def play(which, lesson):
        command = ["dotnet", next(tmp_path.rglob("bin/**/fragments.dll")), which, serve(lesson)[1]]
        done = finished(command)
        return (done.stdout + done.stderr).splitlines()

    assert play("car", "08_see_and_steer")[-1] == "drives: True"
    assert play("eye", "08_see_and_steer")[-1] == "looks around: True"
    said = play("asker", "05_messages")
    assert said == ["it says 1.5", *["it says 3.5"] * (len(said) - 1)] and len(said) >= 3, said
    said = play("paths", "06_many_in_flight")
    heard = sorted(line for line in said if "no reply within" not in line)
    assert heard == ["echo 2: 2", "echo 3: 3", "sleep 0.5: slept 0.5"], said
    said = play("client", "04_background_client")
    # One at once, one after a second, one after two, and on a busy machine more, a second apart; and no error at Stop,
    # but of what was asked just then.
    heard = [line for line in said if line != "the client was disposed"]
    assert heard == ["where to?"] * len(heard), said
    assert 2 <= len(heard) <= 31


# A hand of two joints, until ten positions were seen; a score from the same port; one whose field was forgotten.
HANDS = """
using System;
using System.Reflection;
using UnityEngine;
class Hands
{
    static void Main(string[] args)
    {
        var player = new UnityPlayer.Player(typeof(HandReceiver).Assembly);
        var (joints, score) = (new Transform[2], new Transform[1]);
        player.Begin(() =>
        {
            new GameObject("forgotten").AddComponent(typeof(HandReceiver));
            Put(joints, args[0], "hand/", "0.3");
            Put(score, args[0], "score/", "60");
        });
        var (seen, last) = (0, 0f);
        player.Run(TimeSpan.FromSeconds(120), () =>
        {
            if (joints[1].localPosition.z != last) seen++;
            last = joints[1].localPosition.z;
            return seen >= 10 && score[0].localPosition.x != 0;
        });
        Console.WriteLine($"{joints[0].localPosition} {joints[1].localPosition.x} {score[0].localPosition}");
        player.Stop();
    }

    static void Put(Transform[] joints, string endpoint, string topic, string timeout)
    {
        for (var i = 0; i < joints.Length; i++) joints[i] = new GameObject("joint").transform;
        var thing = new GameObject(topic);
        thing.SetActive(false);
        var script = (MonoBehaviour)thing.AddComponent(typeof(HandReceiver));
        foreach (var (name, value) in new[] { ("endpoint", endpoint), ("topic", topic), ("timeout", timeout) })
            UnityPlayer.Inspector.Set(new[] { script }, name, value);
        var field = typeof(HandReceiver).GetField("joints", BindingFlags.NonPublic | BindingFlags.Instance);
        field.SetValue(script, joints);
        thing.SetActive(true);
    }
}
"""


def test_two_hands_of_cvzone():
    """Also the one that is not seen is sent."""
    (block,) = [each for each in BLOCKS if "test_two_hands_of_cvzone" in each.source]
    sent, hands = [], [{"type": "Right", "lmList": [[10, 20, -3], [11, 21, -4]]}]
    names = {"hands": hands, "height": 480, "number": 7, "send": lambda *words: sent.append(words)}
    exec(compile(block.body, block.where, "exec"), names)
    assert sent == [([], 7, "hand/left/"), ([10, 460, -3, 11, 459, -4], 7, "hand/right/")]


def test_the_way_from_udp(tmp_path, console, start):
    """The publisher and the component that the page for whoever comes from UDPReceive.cs gives, against each other: the
    publisher comes late, and sends odd messages: alone, then among others."""
    publisher, component = (block.body for block in BLOCKS if "test_the_way_from_udp" in block.source)
    endpoint = steady_endpoint()
    loop = """
import pathlib, time
i = 0
while True:
    i += 1
    heard = len([*pathlib.Path().glob("heard *")])
    publisher.send_string(("hand/ hello", f"hand/ {i} nobody", f"hand/ {i}" + 6 * " nan", f"hand/ {i}")[heard])
    time.sleep(0.03)
    if heard:
        send([0.5, 1, 2, -1.25, 0, 3 + i * (heard == 3)], i)
    if heard == 3:
        send([7, 8, 9], i, "score/")
    time.sleep(0.03)
"""
    program = publisher.replace("tcp://127.0.0.1:5052", endpoint) + loop
    (tmp_path / "publisher.py").write_text(program, encoding="utf-8")
    (tmp_path / "HandReceiver.cs").write_text(component, encoding="utf-8")
    (tmp_path / "Hands.cs").write_text(HANDS, encoding="utf-8")
    done = build(tmp_path, console, "<OutputType>Exe</OutputType>")
    assert done.returncode == 0, done.stdout + done.stderr
    unity = start("dotnet", next(tmp_path.rglob("bin/**/fragments.dll")), endpoint)
    for _ in range(2):
        begin = len(unity.lines)
        why = "is the server running, with topic 'hand/'[?]"
        unity.wait_for(f"^trouble: nothing from {endpoint} within 0.3 s; {why}$", start=begin)
    start(PYTHON, tmp_path / "publisher.py", folder=tmp_path)
    wanted = "wanted hand/ NUMBER and 3 numbers for each of 2 Joints, with blanks between and decimal points, not"
    for number, odd in enumerate(
        ("'hand/ hello' with 0", r"'hand/ \d+ nobody' with 1", r"'hand/ \d+( nan){6}' with 6")
    ):
        unity.wait_for(f"^trouble: {wanted} {odd} numbers$")
        (tmp_path / f"heard {number}").touch()
    assert unity.wait() == 0, unity.output
    assert unity.lines[-1] == "(0.50, -1.00, 2.00) -1.25 (7.00, -8.00, 9.00)", unity.output
    others = [line for line in unity.lines[:-1] if not line.startswith("trouble: ")]
    assert others == ["HandReceiver: drag the points of your hand into its field Joints, and leave none empty"]


def test_unity_tells_one_who_publishes(tmp_path, start):
    """The page's lines, asked in the bytes of lesson 02: what is asked again, by its id, is not done again."""
    (hear,) = (block.body for block in BLOCKS if "test_unity_tells_one_who_publishes" in block.source)
    endpoint = steady_endpoint()
    program = hear.replace("tcp://127.0.0.1:5053", endpoint) + "\nwhile True:\n    hear()\n    time.sleep(0.03)\n"
    (tmp_path / "publisher.py").write_text(f"import time\n\nimport zmq\n\n{program}", encoding="utf-8")
    python = start(PYTHON, tmp_path / "publisher.py")
    with zmq.Context() as context, context.socket(zmq.REQ) as unity:
        unity.linger, unity.rcvtimeo = 0, 100_000
        unity.connect(endpoint)
        for id in (b"1", b"2", b"1", b"3"):
            unity.send_multipart([id, b"left hand", id])
            assert unity.recv_multipart() == [id, b"heard"]
    python.wait_for("^Unity says left hand 3$")
    assert python.lines == [f"Unity says left hand {number}" for number in (1, 2, 3)]


# Twice Stop while the server is away, which the old one does not survive; then until it is done.
HELLO = """
using System;
using UnityEngine;
var player = new UnityPlayer.Player(typeof(HelloClient).Assembly);
for (var play = 1; play <= 3; play++)
{
    var waits = false;
    Application.LogCallback see = (text, _, _) => waits = play < 3 && text == "Sending Hello";
    Application.logMessageReceived += see;
    player.Begin(() =>
    {
        var thing = new GameObject("hello");
        thing.SetActive(false);
        var script = (MonoBehaviour)thing.AddComponent(typeof(HelloClient));
        UnityPlayer.Inspector.Set(new[] { script }, "endpoint", args[0]);
        UnityPlayer.Inspector.Set(new[] { script }, "timeout", "86400");
        thing.SetActive(true);
    });
    player.Run(TimeSpan.FromSeconds(60), () => waits);
    player.Stop();
    Application.logMessageReceived -= see;
    Console.WriteLine($"stopped {play}");
}
"""
OLD_SERVER = """
import sys
import time

import zmq

socket = zmq.Context().socket(zmq.REP)
socket.bind(sys.argv[1])
while True:
    print(f"Received request: {socket.recv()}", flush=True)
    time.sleep(0.01)
    socket.send(b"World")
"""


def test_the_way_from_the_old_hello(tmp_path, console, start):
    """The component that the page for whoever comes from HelloRequester.cs gives, against a server as theirs is."""
    block, _ = [each for each in BLOCKS if "test_the_way_from_the_old_hello" in each.source]
    for name, text in (("HelloClient.cs", block.body), ("Program.cs", HELLO), ("server.py", OLD_SERVER)):
        (tmp_path / name).write_text(text, encoding="utf-8")
    done = build(tmp_path, console, "<OutputType>Exe</OutputType>")
    assert done.returncode == 0, done.stdout + done.stderr
    endpoint = steady_endpoint()
    unity = start("dotnet", next(tmp_path.rglob("bin/**/fragments.dll")), endpoint)
    unity.wait_for("^stopped 2$")
    server = start(PYTHON, tmp_path / "server.py", endpoint)
    assert unity.wait() == 0, unity.output
    # A client of the first two Plays that lived on would ask as well.
    assert server.lines == ["Received request: b'Hello'"] * 10
    away = ["Sending Hello", "stopped 1", "Sending Hello", "stopped 2"]
    assert unity.lines == [*away, *["Sending Hello", "Received World"] * 10, "stopped 3"]


def test_the_way_from_the_old_hello_goes_on_after_a_restart(tmp_path, console, start):
    """The same component, with the page's loop in it."""
    component, loop = [each.body for each in BLOCKS if "test_the_way_from_the_old_hello" in each.source]
    component = component.partition("        using var client")[0] + loop + "    }\n}\n"
    program = HELLO.replace("play <= 3", "play <= 1").replace("86400", "2").replace("(60)", "(120)")
    program = program.replace('play < 3 && text == "Sending Hello"', 'text == "Received Again"')
    again = OLD_SERVER.replace("World", "Again")
    for name, text in (("HelloClient.cs", component), ("Program.cs", program), ("1.py", OLD_SERVER), ("2.py", again)):
        (tmp_path / name).write_text(text, encoding="utf-8")
    done = build(tmp_path, console, "<OutputType>Exe</OutputType>")
    assert done.returncode == 0, done.stdout + done.stderr
    endpoint = steady_endpoint()
    unity = start("dotnet", next(tmp_path.rglob("bin/**/fragments.dll")), endpoint)
    server = start(PYTHON, tmp_path / "1.py", endpoint)
    unity.wait_for("^Received World$")
    server.kill()
    unity.wait_for("^no reply ", start=unity.lines.index("Received World"))
    start(PYTHON, tmp_path / "2.py", endpoint)
    assert unity.wait() == 0, unity.output
    assert unity.lines[-2:] == ["Received Again", "stopped 1"]


@pytest.mark.parametrize(
    "block",
    [block for block in BLOCKS if block.language not in ("", "csharp", "mermaid") and block.kind != "excerpt"],
    ids=lambda block: block.where,
)
def test_every_block_of_another_language_can_be_read(block):
    if block.language == "python":
        compile(block.body, block.where, "exec")
    elif block.language == "json":
        json.loads(block.body)
    else:
        assert block.language == "xml"
        ElementTree.fromstring(block.body)


def test_the_picture_of_a_terminal_is_what_a_run_prints(netmq):
    svg = terminal_picture.PICTURE.read_text(encoding="utf-8")
    command, *lines = terminal_picture.lines_of(svg)
    assert command == f"$ python3 kit.py run {terminal_picture.RUN}"
    assert pictured(lines) == "", "python3 -m kitlib.docs.terminal_picture draws it"
    # In colour, as `show` prints it.
    assert svg == terminal_picture.draw(command[2:], [re.sub(r"^\w+ +\|", in_colour, line) for line in lines])


def pictured(lines):
    shown = guide.Block(terminal_picture.PICTURE, 1, "like", "", "", "".join(f"{line}\n" for line in lines))
    return guide.contradiction(shown, printed(terminal_picture.RUN))


def in_colour(prefix):
    return f"\033[{COLOURS[prefix[0].split()[0]]}m{prefix[0]}\033[0m"
