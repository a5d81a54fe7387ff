"""The programs of the pages, as they stand there: all their C# in one project, played against its servers."""

import os
import re
from pathlib import Path

import pytest

from kitlib.docs import guide
from kitlib.setup import dotnet
from tests.conftest import PYTHON
from tests.lessons.conftest import ask
from tests.programs import ROOT, Mark, finds_processes, finished, steady_endpoint

BLOCKS = [block for page in guide.pages() for block in guide.blocks(page)]
CSHARP = [block for block in BLOCKS if block.language == "csharp" and block.kind != "excerpt"]
# One worker builds it, and it alone.
pytestmark = [pytest.mark.xdist_group("pages"), pytest.mark.timeout(1200)]

FIRST = [
    block.body for block in guide.blocks(ROOT / "docs" / "guide" / "01_request_reply.md") if block.kind == "by hand"
]
NAKED_SERVER, NAKED_CLIENT = FIRST[:2]
(INNKEEPER,) = (block.body for block in BLOCKS if "runs it with the script above" in block.source)
OWN = "tcp://127.0.0.1:5551"
# The component for whoever comes from HelloRequester.cs, and a part of it that goes on after a restart.
HELLO, AGAIN = (block.body for block in CSHARP if "test_the_way_from_the_old_hello" in block.source)
# The surroundings of a fragment: the names that it may use besides its own.
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


PROJECT = """<Project Sdk="Microsoft.NET.Sdk">
  <PropertyGroup>
    <OutputType>Exe</OutputType>
    <TargetFramework>net$(BundledNETCoreAppTargetFrameworkVersion)</TargetFramework>
    <LangVersion>9.0</LangVersion>
    <Optimize>false</Optimize>
  </PropertyGroup>
  <ItemGroup>{references}</ItemGroup>
</Project>
"""
# The first word says what to play, the second where the server is.
PROGRAM = """
using System; using System.Linq; using System.Reflection;
using NetMQ; using NetMQ.Sockets; using NetMQExample; using UnityEngine; using UnityPlayer;
static class Program
{
    static void Main(string[] args)
    {
        switch (args[0])
        {
            case "naked": Naked(args[1]); break;
            case "hello": Hello(typeof(HelloClient), args[1], "86400", 3, "Sending Hello"); break;
            case "again": Hello(typeof(Again.HelloClient), args[1], "2", 1, "Received Again"); break;
            case "hands": Hands(args[1]); break;
            case "picture": Picture(args[1]); break;
            case "started": Started(args[1], args[2], args[3], false); break;
            case "crashed": Started(args[1], args[2], args[3], true); break;
            default: Script(args[0], args[1]); break;
        }
    }

    static void Naked(string endpoint)
    {
NAKED
    }

    // More replies than a pipe has room for their lines.
    static void Started(string program, string words, string endpoint, bool crash)
    {
        var all = typeof(Program).Assembly.GetTypes().Select(type => type.GetMethod("StartServer"));
        var start = all.Single(found => found != null);
        var (lines, ready) = (0, new System.Threading.ManualResetEventSlim());
        Action<string> heard = line =>
        {
            System.Threading.Interlocked.Increment(ref lines);
            if (line != null && line.StartsWith("listening on ")) ready.Set();
        };
        using var server = (System.Diagnostics.Process)start.Invoke(null, new object[] { program, words, heard });
        ready.Wait();
        if (crash) System.Diagnostics.Process.GetCurrentProcess().Kill();
        using (var requester = new HelloRequester(endpoint))
            for (var i = 0; i < 6000; i++) requester.Request("Hello", TimeSpan.FromSeconds(60));
        server.StandardInput.Close();
        server.WaitForExit();
        Console.WriteLine($"all heard: {lines >= 6000}");
    }

    // What Unity does with scripts: puts them on an object, calls them frame by frame, and disables them at Stop.
    static void Script(string which, string endpoint)
    {
        var player = new Player(typeof(MyClient).Assembly);
        var (answers, least) = (0, which == "Paths" || which == "Innkeeper" ? 3 : 2);
        var wanted = new[] { "where to?", "it says 3.5", "echo 2: 2", "echo 3: 3", "sleep 0.5: slept 0.5",
            "Welcome, Ada!", "Welcome, Bo!", "Good to see you again, Ada!" };
        Application.logMessageReceived += (line, _, _) => answers += wanted.Contains(line) ? 1 : 0;
        player.Begin(() =>
        {
            var script = Add(typeof(MyClient).Assembly.GetType(which), endpoint, added =>
            {
                added.transform.position = new Vector3(3.5f, 0, 0);
                // Asked while it is off: left out.
                (added as Paths)?.Ask(new[] { "echo old" });
            });
            (script as Paths)?.Ask(new[] { "sleep 0.5", "echo 2", "echo 3" });
            if (!(script is Asker asker)) return;
            // While its thread begins.
            asker.transform.position = new Vector3(1.5f, 0, 0);
            asker.Ask();
            asker.transform.position = new Vector3(3.5f, 0, 0);
        });
        player.Run(TimeSpan.FromSeconds(30), () => answers >= least && Time.realtimeSinceStartup > 2.5f);
        player.Stop();
    }

    // An object with this script, whose fields have these values.
    static MonoBehaviour Add(Type type, string endpoint, Action<MonoBehaviour> prepare, params (string, string)[] more)
    {
        var thing = new GameObject("mine");
        thing.SetActive(false);
        var added = (MonoBehaviour)thing.AddComponent(type);
        foreach (var (name, value) in more.Prepend(("endpoint", endpoint))) Inspector.Set(new[] { added }, name, value);
        prepare?.Invoke(added);
        thing.SetActive(true);
        return added;
    }

    static FieldInfo Hidden(Type type, string name)
        => type.GetField(name, BindingFlags.NonPublic | BindingFlags.Instance);

    // All but the last Play are stopped while the server is away, which the old example does not survive; the last when
    // it is done, or has logged this line.
    static void Hello(Type component, string endpoint, string timeout, int plays, string line)
    {
        var player = new Player(component.Assembly);
        for (var play = 1; play <= plays; play++)
        {
            var seen = false;
            var stops = plays == 1 || play < plays;
            Application.LogCallback see = (text, _, _) => seen = stops && text == line;
            Application.logMessageReceived += see;
            player.Begin(() => Add(component, endpoint, null, ("timeout", timeout)));
            player.Run(TimeSpan.FromSeconds(120), () => seen);
            player.Stop();
            Application.logMessageReceived -= see;
            Console.WriteLine($"stopped {play}");
        }
    }

    // The component's picture: its size, and the first number of its lowest and of its highest row.
    static void Picture(string endpoint)
    {
        var player = new Player(typeof(PictureView).Assembly);
        MonoBehaviour view = null;
        player.Begin(() => view = Add(typeof(PictureView), endpoint, null));
        player.Run(TimeSpan.FromSeconds(60), () =>
        {
            var seen = Hidden(typeof(PictureView), "texture").GetValue(view) as Texture2D;
            if (seen == null) return false;
            var pixels = seen.GetRawTextureData<byte>();
            Console.WriteLine($"{seen.width} x {seen.height} {pixels[0]} {pixels[pixels.Length - 3]}");
            return true;
        });
        player.Stop();
    }

    // A hand of two joints, until ten positions were seen; a score from the same port; one whose field was forgotten.
    static void Hands(string endpoint)
    {
        var player = new Player(typeof(HandReceiver).Assembly);
        var (joints, score) = (new Transform[2], new Transform[1]);
        player.Begin(() =>
        {
            new GameObject("forgotten").AddComponent(typeof(HandReceiver));
            Put(joints, endpoint, "hand/", "0.3");
            Put(score, endpoint, "score/", "60");
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
        Add(typeof(HandReceiver), endpoint, hand => Hidden(typeof(HandReceiver), "joints").SetValue(hand, joints),
            ("topic", topic), ("timeout", timeout));
    }
}
"""


@pytest.fixture(scope="session")
def pages(tmp_path_factory, console):
    """The words that start PROGRAM, built with every C# block of the pages, as it stands there."""
    folder = tmp_path_factory.mktemp("pages")
    parts = [block for block in CSHARP if "in the component above" not in block.source and block.body != NAKED_CLIENT]
    files = {f"Block{number}": surrounded(block, number) for number, block in enumerate(parts)}
    files["Program"] = PROGRAM.replace("NAKED", NAKED_CLIENT.replace(f'"{OWN}"', "endpoint"))
    files["Again"] = f"namespace Again {{ {HELLO.partition('        using var client')[0]}{AGAIN}    }}\n}}\n}}\n"
    for name, text in files.items():
        (folder / f"{name}.cs").write_text(text, encoding="utf-8")
    references = "".join(f'<Reference Include="{dll}" />' for dll in Path(console[1]).parent.glob("*.dll"))
    (folder / "pages.csproj").write_text(PROJECT.format(references=references), encoding="utf-8")
    words = ["-p:NuGetAudit=false", "-m:1", "-v:quiet", "-nologo", "-clp:NoSummary;ErrorsOnly"]
    environment = {**os.environ, **dotnet.ENVIRONMENT}
    done = finished(["dotnet", "build", folder, *words], timeout=500, env=environment)
    assert done.returncode == 0, done.stdout + done.stderr
    return ["dotnet", next(folder.rglob("bin/**/pages.dll"))]


@pytest.fixture
def naked_server(start, tmp_path):
    """Where the first page's Python listens."""
    endpoint = steady_endpoint()
    (tmp_path / "naked.py").write_text(NAKED_SERVER.replace(OWN, endpoint), encoding="utf-8")
    start(PYTHON, tmp_path / "naked.py")
    return endpoint


def test_the_naked_programs_meet_each_other_and_the_lessons_own(pages, naked_server, serve, start, client_command):
    assert OWN in NAKED_SERVER and OWN in NAKED_CLIENT
    for endpoint in naked_server, serve("01_request_reply")[1]:
        client = start(*pages, "naked", endpoint)
        assert client.wait() == 0, client.output
        assert client.lines == ["World"]
    for kind in "python", "csharp":
        words = ["--count", "1", "--text", "Hi", "--timeout", "60"]
        wrong = start(*client_command(kind, "01_request_reply", naked_server, *words))
        assert wrong.wait() == 0
        assert "1: sent Hi, received error: expected Hello" in wrong.lines


@finds_processes
def test_a_server_that_a_game_starts(pages):
    endpoint = steady_endpoint()
    words = f'"{ROOT / "python" / "01_request_reply" / "server.py"}" --endpoint {endpoint}'
    mark = Mark()
    assert finished([*pages, "crashed", PYTHON, words, endpoint], env={**os.environ, **mark.environment}).returncode
    # And its server is gone, whose port the next start wants.
    assert mark.gone()
    assert finished([*pages, "started", PYTHON, words, endpoint]).stdout == "all heard: True\n"


def test_a_script_of_yours_plays(pages, serve, serve_own):
    """The components that lessons 04, 05 and 06 give a Unity developer to begin with, each against its server."""

    def play(which, lesson="", endpoint=""):
        done = finished([*pages, which, endpoint or serve(lesson)[1]])
        return (done.stdout + done.stderr).splitlines()

    said = play("Asker", "05_messages")
    assert said == ["it says 1.5", *["it says 3.5"] * (len(said) - 1)] and len(said) >= 3, said
    said = play("Paths", "06_many_in_flight")
    heard = sorted(line for line in said if "no reply within" not in line)
    assert heard == ["echo 2: 2", "echo 3: 3", "sleep 0.5: slept 0.5"], said
    said = play("MyClient", "04_background_client")
    # One at once, one after a second, one after two, and on a busy machine more, a second apart; and no error at Stop,
    # but of what was asked just then.
    heard = [line for line in said if line != "the client was disposed"]
    assert heard == ["where to?"] * len(heard), said
    assert 2 <= len(heard) <= 31
    heard = play("Innkeeper", endpoint=serve_own("04_background_client", INNKEEPER)[1])
    assert heard == ["Welcome, Ada!", "Welcome, Bo!", "Good to see you again, Ada!"]


def test_a_game_of_yours_serves(console, start, run, tmp_path):
    """The script that lesson 04 gives: each answer moves the scene once, in Update."""
    (mine,) = (block.body for block in CSHARP if "test_a_game_of_yours_serves" in block.source)
    (tmp_path / "Jumper.cs").write_text(mine, encoding="utf-8")
    endpoint = steady_endpoint()
    player = start(PYTHON, ROOT / "kit.py", "play", tmp_path / "Jumper.cs", "--endpoint", endpoint, "--seconds", "300")
    words = ["--endpoint", endpoint, "--text", "jump", "--count", "2", "--timeout", "60"]
    for kind, heights in ("python", (1, 2)), ("csharp", (3, 4)):
        done = run(kind, "02_lazy_pirate", *words)
        for number, height in enumerate(heights, 1):
            assert f"{number}: sent jump, received at {height} m" in done.lines, (done, player.output)
    player.stop()


def test_a_listener_of_yours_goes_on(console, start, serve, tmp_path):
    """The script that lesson 03 gives, through an outage that is longer than its timeout."""
    (mine,) = (block.body for block in CSHARP if "test_a_listener_of_yours_goes_on" in block.source)
    (tmp_path / "NewsReader.cs").write_text(mine, encoding="utf-8")
    server, endpoint = serve("03_publish_subscribe")
    words = ["--endpoint", endpoint, "--timeout", "0.5", "--seconds", "300"]
    player = start(PYTHON, ROOT / "kit.py", "play", tmp_path / "NewsReader.cs", *words)
    player.wait_for("^NewsReader reads news/ the cube has made ")
    server.kill()
    player.wait_for("^trouble: nothing from ", start=len(player.lines))
    serve("03_publish_subscribe", endpoint=endpoint)
    player.wait_for("^NewsReader reads news/ ", start=len(player.lines))
    player.stop()


def test_a_picture_of_pythons_is_seen(pages, serve_own):
    """The page's `answer`, in a copy of the lesson's server, and its component: upright, with red above."""
    (mine,) = (block.body for block in BLOCKS if "runs it with the component below" in block.source)
    endpoint = serve_own("05_messages", mine)[1]
    assert finished([*pages, "picture", endpoint]).stdout.splitlines() == ["320 x 240 0 255"]


def test_two_hands_of_cvzone():
    """Also the one that is not seen is sent."""
    (block,) = [each for each in BLOCKS if "test_two_hands_of_cvzone" in each.source]
    sent, hands = [], [{"type": "Right", "lmList": [[10, 20, -3], [11, 21, -4]]}]
    names = {"hands": hands, "height": 480, "number": 7, "send": lambda *words: sent.append(words)}
    exec(compile(block.body, block.where, "exec"), names)
    assert sent == [([], 7, "hand/left/"), ([10, 460, -3, 11, 459, -4], 7, "hand/right/")]


def test_the_way_from_udp(tmp_path, pages, start):
    """The publisher and the component that the page for whoever comes from UDPReceive.cs gives, against each other: the
    publisher comes late, and sends odd messages: alone, then among others."""
    publisher, _ = (block.body for block in BLOCKS if "test_the_way_from_udp" in block.source)
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
    unity = start(*pages, "hands", endpoint)
    for _ in range(2):
        begin = len(unity.lines)
        why = "is the server running, with topic 'hand/', or a message over 64 KB[?]"
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


def test_unity_tells_one_who_publishes(tmp_path, start, context):
    """The page's lines, asked in the bytes of lesson 02: what is asked again, by its id, is not done again."""
    (hear,) = (block.body for block in BLOCKS if "test_unity_tells_one_who_publishes" in block.source)
    endpoint = steady_endpoint()
    program = hear.replace("tcp://127.0.0.1:5053", endpoint) + "\nwhile True:\n    hear()\n    time.sleep(0.03)\n"
    (tmp_path / "publisher.py").write_text(f"import time\n\nimport zmq\n\n{program}", encoding="utf-8")
    python = start(PYTHON, tmp_path / "publisher.py")
    for id in (b"1", b"2", b"1", b"3"):
        assert ask(context, endpoint, id, b"left hand", id) == [id, b"heard"]
    python.wait_for("^Unity says left hand 3$")
    assert python.lines == [f"Unity says left hand {number}" for number in (1, 2, 3)]


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


def test_the_way_from_the_old_hello(tmp_path, pages, start):
    """The component that the page for whoever comes from HelloRequester.cs gives, against a server as theirs is."""
    (tmp_path / "server.py").write_text(OLD_SERVER, encoding="utf-8")
    endpoint = steady_endpoint()
    unity = start(*pages, "hello", endpoint)
    unity.wait_for("^stopped 2$")
    server = start(PYTHON, tmp_path / "server.py", endpoint)
    assert unity.wait() == 0, unity.output
    # A client of the first two Plays that lived on would ask as well.
    assert server.lines == ["Received request: b'Hello'"] * 10
    away = ["Sending Hello", "stopped 1", "Sending Hello", "stopped 2"]
    assert unity.lines == [*away, *["Sending Hello", "Received World"] * 10, "stopped 3"]


def test_the_way_from_the_old_hello_goes_on_after_a_restart(tmp_path, pages, start):
    """The same component, with the page's loop in it."""
    for name, text in (("1.py", OLD_SERVER), ("2.py", OLD_SERVER.replace("World", "Again"))):
        (tmp_path / name).write_text(text, encoding="utf-8")
    endpoint = steady_endpoint()
    unity = start(*pages, "again", endpoint)
    server = start(PYTHON, tmp_path / "1.py", endpoint)
    unity.wait_for("^Received World$")
    server.kill()
    unity.wait_for("^no reply ", start=unity.lines.index("Received World"))
    start(PYTHON, tmp_path / "2.py", endpoint)
    assert unity.wait() == 0, unity.output
    assert unity.lines[-2:] == ["Received Again", "stopped 1"]
