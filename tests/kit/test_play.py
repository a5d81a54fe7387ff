"""kit.py play: a reader's own scripts, as one writes them."""

import re

import pytest

from kitlib.docs import guide
from kitlib.unity import player
from tests.conftest import PYTHON
from tests.programs import ROOT

# In no namespace, with warnings, and nothing said of what it does.
MINE = """using UnityEngine;

public class MyOwn : MonoBehaviour
{
    [SerializeField] private string endpoint = "tcp://127.0.0.1:5554";
    [SerializeField] private Vector3 scale = new Vector3(1, 1, 1);
    private int unused = 3;
    private Greeting greeting;

    // Where it keeps files: beside itself, and not in the kit.
    void Awake() { Debug.Log(Application.persistentDataPath); Debug.Log(scale); }
    void OnEnable() { greeting = new Greeting(endpoint); }
    void Update() { int alsoUnused; Debug.Log(greeting.Ask()); Application.Quit(); }
    void OnDisable() { greeting.Dispose(); }
}
"""
ITS_CLASS = """class Greeting : System.IDisposable
{
    readonly NetMQExample.HelloRequester requester;
    public Greeting(string endpoint) { requester = new NetMQExample.HelloRequester(endpoint); }
    public string Ask() { return requester.Request("Hello", System.TimeSpan.FromSeconds(5)); }
    public void Dispose() { requester.Dispose(); }
}
"""


# The first run asks for NetMQ and builds, and says so.
SET_UP = ("kit    | asking NuGet", "kit    | building")


@pytest.fixture
def play(console, netmq, start):
    def play(*words, folder=ROOT):
        program = start(PYTHON, ROOT / "kit.py", "play", *words, folder=folder)
        return program.wait(300), [line for line in program.lines if not line.startswith(SET_UP)]

    return play


def test_scripts_of_ones_own_are_played(play, serve, tmp_path):
    folder = tmp_path / "my; own scripts"
    folder.mkdir()
    (folder / "MyOwn.cs").write_text(MINE, encoding="utf-8")
    (folder / "Greeting.cs").write_text(ITS_CLASS, encoding="utf-8")
    # This one lies beside them, and nobody asks for it.
    (folder / "Other.cs").write_text("no C#", encoding="utf-8")
    endpoint = serve("01_request_reply")[1]
    ours = play("MyOwn.cs", "Greeting.cs", "--endpoint", endpoint, folder=folder)
    assert ours == (0, [str(folder), "(1.00, 1.00, 1.00)", "World"])
    (folder / "Greeting.cs").write_text(ITS_CLASS.replace('"Hello"', '"Bye"'), encoding="utf-8")
    both = (folder / "MyOwn.cs", folder / "Greeting.cs")
    code, lines = play(*both, "--endpoint", endpoint, "--scale=1,-0.5,0")
    assert code == 0
    assert lines[1] == "(1.00, -0.50, 0.00)"
    assert lines[2].startswith("error: expected Hello")
    assert play(*both, "--scale", "1,2") == (2, ["--scale: '1,2' is no Vector3"])


DEAF = """using System.Threading;
using NetMQExample;

public class Deaf : NetworkBehaviour
{
    protected override void Talk(CancellationToken stop)
    {
        Log("nobody reads this");
        stop.WaitHandle.WaitOne();
    }

    protected override void Update() { }
}
"""


def test_an_update_that_takes_nothing_from_the_network_thread_is_named(play, tmp_path):
    (tmp_path / "Deaf.cs").write_text(DEAF, encoding="utf-8")
    cause = "Deaf: write its Update as protected override, with base.Update(); in it, or nothing that Talk logs or"
    code, lines = play("Deaf.cs", "--seconds", "3", folder=tmp_path)
    assert code == 1 and [line.startswith(cause) for line in lines] == [True], lines


def test_a_changed_copy_of_the_kits_is_what_the_others_use(play, serve, tmp_path):
    """Also those that are unchanged copies; alone they are the kit's own."""
    source = ROOT / "unity/Assets/NetMQExample/01_request_reply"
    text = (source / "HelloRequester.cs").read_text(encoding="utf-8")
    (tmp_path / "HelloClient.cs").write_bytes((source / "HelloClient.cs").read_bytes())
    (tmp_path / "HelloRequester.cs").write_text(
        text.replace("Send(text, timeout, stop);", 'Send("Bye", timeout, stop);'), encoding="utf-8"
    )
    words = [tmp_path / "HelloClient.cs", tmp_path / "HelloRequester.cs", "--count", "1"]
    code, lines = play(*words, "--endpoint", serve("01_request_reply")[1])
    assert code == 0
    assert "received error: expected Hello, got 'Bye'" in lines[-2]
    whose = "by the scripts named here; name each other file of the kit that needs it, too"
    assert lines[0] == f"kit    | HelloRequester.cs: named like the kit's, and used in its place {whose}"


ASKER = """using UnityEngine;

public sealed class Asker : MonoBehaviour
{
    private GameObject second;
    private int frames;

    private void Start()
    {
        // The first scene, loaded again.
        (second = new GameObject("second")).AddComponent<Game>();
        Game.Client.Request("hello", reply => Debug.Log($"heard {reply}"), Debug.LogError);
    }

    private void Update()
    {
        if (++frames == 3) Debug.Log($"one game: {second == null}");
    }
}
"""


def test_a_client_for_several_scenes(play, serve, tmp_path):
    """The script of the page, with one that asks."""
    page = ROOT / "docs" / "guide" / "unity_project.md"
    (block,) = [block for block in guide.blocks(page) if "test_a_client_for_several_scenes" in block.source]
    (tmp_path / "Game.cs").write_text(block.body, encoding="utf-8")
    (tmp_path / "Asker.cs").write_text(ASKER, encoding="utf-8")
    words = ["Game.cs", "Asker.cs", "--endpoint", serve("04_background_client")[1], "--seconds", "2"]
    code, lines = play(*words, folder=tmp_path)
    assert code == 0
    assert sorted(lines) == ["heard world", "one game: True"]


# An old example does this: its Stop waits for a thread that waits for a server. And what most first attempts do.
FREEZES = """using System.Threading;
using UnityEngine;

class Freezes : MonoBehaviour
{
    [SerializeField] bool inUpdate = false;
    void Update() { if (inUpdate) Thread.Sleep(-1); }
    void OnDestroy() { Thread.Sleep(-1); }
}
"""


def test_a_script_that_would_freeze_the_editor_is_ended_and_says_so(play, tmp_path):
    """In Update, and at Stop."""
    (tmp_path / "Freezes.cs").write_text(FREEZES, encoding="utf-8")
    said = (
        "gave up: a script has held the main thread for 10 s, in Update or at Stop: Unity's editor would be frozen now"
    )
    for where in ["--inUpdate"], []:
        assert play(tmp_path / "Freezes.cs", "--seconds", "0.1", *where) == (1, [said])


# Scripts for UDP and first scripts of one's own do this, with a server that answers.
ENDS = """using System;
using System.Threading;
using NetMQExample;
using UnityEngine;

public class Ends : MonoBehaviour
{
    [SerializeField] private string endpoint = "";
    [SerializeField] private bool abort = false;
    private Thread receiveThread;
    private BackgroundClient client;
    public bool Done => true;

    private void Start()
    {
        receiveThread = new Thread(() => { while (true) Thread.Sleep(10); });
        receiveThread.Start();
        client = new BackgroundClient(endpoint);
        client.Request("hello", Debug.Log);
    }

    private void Update() => throw new InvalidOperationException("in Update");

    private void OnDestroy()
    {
        if (abort) receiveThread?.Abort();
        Debug.Log("closing");
        client.Dispose();
    }
}
"""


def test_what_a_script_forgets_is_said_once_and_the_play_ends(play, start, serve, tmp_path):
    """Poll, an exception in each frame, Abort of a thread as Unity's Mono has it, and a thread that keeps a process.
    --seconds counts more than Done."""
    (tmp_path / "Ends.cs").write_text(ENDS, encoding="utf-8")
    # With Unity's own switches, as ML-Agents starts a game.
    words = [tmp_path / "Ends.cs", "-batchmode", "-nographics", "-logFile", "no.log"]
    words += ["--endpoint", serve("04_background_client")[1], "--seconds"]
    program = start(PYTHON, ROOT / "kit.py", "play", *words, "300", "--abort=true")
    program.wait_for("^BackgroundClient: a reply waits, and nobody has called Poll")
    assert program.stop(limit=60) == 130
    said = "\n".join(program.lines)
    thrown = r"System\.InvalidOperationException: in Update\s+at Ends\.Update\(\) in .*Ends\.cs:line 22$"
    assert len(re.findall(rf"^{thrown}", said, re.MULTILINE)) == 1, said
    assert len(re.findall(rf"^\d+ times more: {thrown}", said, re.MULTILINE)) == 1, said
    # The lines behind Abort in the same method run, and Dispose delivers the reply.
    for line in "closing", "world", "Thread.Abort: Unity's Mono can", "BackgroundClient: ":
        assert sum(each.startswith(line) for each in program.lines) == 1, said
    code, lines = play(*words, "0.1")
    assert code == 1 and "a thread of a script still runs 5 s after Stop" in lines[-1], lines


# People's scripts do this with a UI, with lines and pictures, and with what they drag into their fields.
PANEL = """using TMPro;
using UnityEngine;
using UnityEngine.UI;

public class Panel : MonoBehaviour
{
    public Text status;
    public Slider volume;
    public Button send;
    public TMP_InputField word;
    public GameObject[] points;
    public Transform wrist, elbow;
    private LineRenderer line;

    private void Start()
    {
        line = GetComponent<LineRenderer>();
        line.SetPosition(1, Vector3.up);
        line.positionCount = points.Length;
        for (var i = 0; i < points.Length; i++)
        {
            var place = points[i].transform.position;
            place[1] = i;
            line.SetPosition(i, place);
        }
        var editor = Application.platform == RuntimePlatform.WindowsEditor;
        Debug.Log($"{points[points.Length - 1].name} {line.GetPosition(2)[1]} {Application.dataPath} {editor}");
        var texture = new Texture2D(2, 2);
        var picture = new Texture2D(3, 1, TextureFormat.RGB24, false);
        picture.LoadRawTextureData(new byte[] { 255, 0, 0, 0, 255, 0, 0, 0, 255 });
        var loaded = texture.LoadImage(picture.EncodeToPNG());
        Debug.Log($"{loaded} {texture.width}x{texture.height} {texture.GetRawTextureData<byte>()[4]}");
        Debug.Log($"{texture.LoadImage(picture.EncodeToJPG())} {texture.LoadImage(new byte[9])}");
        Cursor.lockState = CursorLockMode.Locked;
        Cursor.visible = false;
        var screen = RenderTexture.active = new RenderTexture(3, 1, 24);
        picture.ReadPixels(new Rect(0, 0, 3, 1), 0, 0);
        screen.Release();
        Debug.Log($"read {picture.GetRawTextureData().Length} {picture.GetRawTextureData()[0]}");
        send.onClick.AddListener(() => status.text = "sent " + word.text);
        volume.onValueChanged.AddListener(value => status.text = $"volume {value}");
    }

    private void Awake()
    {
        var mesh = gameObject.AddComponent<MeshFilter>().mesh = new Mesh { vertices = new Vector3[3] };
        mesh.triangles = new[] { 0, 1, 2 };
        mesh.RecalculateNormals();
        gameObject.AddComponent<Animator>().Play("Wave");
        var source = gameObject.AddComponent<AudioSource>();
        source.clip = AudioClip.Create("beep", 2, 1, 44100, false);
        source.Play();
        Debug.Log($"{mesh.vertexCount} {source.clip.name} {source.clip.samples} {source.isPlaying}");
    }

    private void Update() { wrist.Rotate(0, 1, 0); elbow.position = wrist.position; }
    public void Stop() { Application.Quit(); }
}
"""


def test_a_scripts_ui_and_what_its_inspector_names(play, start, tmp_path):
    """Also: each list of files is built once."""
    (tmp_path / "Panel.cs").write_text(PANEL, encoding="utf-8")
    (tmp_path / "Bare.cs").write_text("class Bare { }", encoding="utf-8")
    ui = "--status Status --volume Volume --send Send --word Word --add LineRenderer --points Point*21"
    clicks = "--click Volume=0.5 --click Word=Ada --click Send --click Nobody --click Stop"
    words = [*ui.split(), "--Panel.wrist", "Wrist", *clicks.split()]
    # A second object, and a component that is there.
    code, lines = play("Panel.cs", *words, "--elbow", "Panel", folder=tmp_path)
    said = ["3 beep 2 True", f"Point20 2 {tmp_path} False", "True 3x1 0", "True False", "read 9 0"]
    said += ["[Volume] 0.5", "[Status] volume 0.5", "[Word] Ada", "[Status] sent Ada"]
    nobody = "--click Nobody: no button, toggle, slider or input field has this name, and no script such a method"
    assert code == 1 and sorted(lines) == sorted([*said, nobody])
    code, lines = play("Panel.cs", "Bare.cs", "--seconds", "0.1", folder=tmp_path)
    told = "Does Panel lack the component LineRenderer? --add LineRenderer gives it one", "--Panel.wrist NAME"
    words_of_unity = "UnassignedReferenceException: The variable wrist of Panel has not been assigned."
    assert code == 1 and all(each in "\n".join(lines) for each in (*told, words_of_unity)), lines
    program = start(PYTHON, ROOT / "kit.py", "play", "Panel.cs", *words, "--seconds", "0.1", folder=tmp_path)
    assert program.wait(300) == 1 and "variable elbow of Panel has not" in "\n".join(program.lines), program.lines
    assert not any("building" in line for line in program.lines)
    for wrong, says in {
        "--add Lin": "--add Lin: the player has no such component",
        "--wrist=": "--wrist: '' is no Transform",
    }.items():
        assert play("Panel.cs", *wrong.split(), folder=tmp_path) == (2, [says])


# Its Update would not be called by whoever calls the kit's.
HIDES = """class Hides : NetMQExample.NetworkBehaviour
{
    void Update() { }
    protected override void Talk(System.Threading.CancellationToken stop) { }
}
class Forces : NetMQExample.DrivenBehaviour
{
    public override double Speed => 0;
    public override void Step(double throttle, double brake, double steer) { }
    void FixedUpdate() { }
}
"""


ABSENT = "error CS0246: The type or namespace name '{}' could not be found"
NO_MEMBER = "error CS1061: 'Transform' does not contain a definition for '{}'"
ALL = "; all of Unity that it has is in csharp-support/unity-player/UnityEngine"


@pytest.mark.parametrize(
    ("error", "source", "cure"),
    [
        # These were written for gymize and for ML-Agents. A name that is no type is left to the compiler's own words.
        (
            "\nMine.cs(1,1): ".join(
                [
                    *(ABSENT.format(name) for name in ("NDArray", "VectorSensor")),
                    "error CS0115: 'Mine.CollectObservations(VectorSensor)': no suitable method found to override",
                    "error CS1061: 'MessageArray' does not contain a definition for 'GetSingle'",
                    *(f"error CS0103: The name '{name}' does not exist" for name in ("SetTerminated", "Transfrm")),
                ]
            ),
            "SetTerminated(); Transfrm.Find(name);",
            "docs/guide/from_gymize.md says what to write for NDArray, GetSingle\n"
            "docs/guide/from_ml_agents.md says what to write for VectorSensor, CollectObservations\n"
            f"the player has no Transfrm, but Transform{ALL}; if it is yours, name its file, too",
        ),
        (
            "\nMine.cs(1,1): ".join([NO_MEMBER.format(name) for name in ("DetachChildren", "hasChanged")]),
            "transform.DetachChildren();",
            f"the player's Transform has no DetachChildren, hasChanged{ALL}",
        ),
        (
            "error CS1061: 'NativeArray<byte>' does not contain a definition for 'Reinterpret'"
            "\nMine.cs(1,1): error CS7036: … the required parameter 'b' of 'RenderTexture.RenderTexture(int, int)'"
            "\nMine.cs(1,1): error CS1729: 'Texture2D' does not contain a constructor that takes 9 arguments",
            "new RenderTexture(1);",
            f"the player's NativeArray has no Reinterpret{ALL}\n"
            f"the player's RenderTexture has not every overload{ALL}\n"
            f"the player's Texture2D has not every overload{ALL}",
        ),
        (ABSENT.format("List<>"), "List<int> a;", "List: write `using System.Collections.Generic;`"),
        # Next to it, elsewhere in the project, and beside another fault.
        (ABSENT.format("HelloRequester"), "HelloRequester a;", "name HelloRequester.cs, too"),
        (ABSENT.format("Far<,>"), "Far<int, int> a;", "name {game}/Assets/Deep/Far.cs, too"),
        (
            "\nMine.cs(1,1): ".join([ABSENT.format("HelloRequester"), ABSENT.format("Kompass")]),
            "HelloRequester a; Kompass b;",
            f"name HelloRequester.cs, too\nthe player has no Kompass{ALL}; if it is yours, name its file, too",
        ),
        (
            ABSENT.format("MessagePack"),
            "using MessagePack;",
            "nothing here has the namespace MessagePack: if it is yours, name its files, too; the player takes no DLL",
        ),
        (
            ABSENT.format("NetMQContext"),
            "NetMQContext a;",
            "docs/guide/from_hello_requester.md says what to write for NetMQContext",
        ),
    ],
)
def test_a_hint_leads_to_what_is_missing(error, source, cure, tmp_path):
    game = tmp_path / "Game"
    script = game / "Assets" / "Mine" / "Mine.cs"
    (game / "ProjectSettings").mkdir(parents=True)
    (game / "ProjectSettings" / "ProjectVersion.txt").write_text("m_EditorVersion: 6000.0.32f1\n")
    for path in script, script.with_name("HelloRequester.cs"), game / "Assets" / "Deep" / "Far.cs":
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(source, encoding="utf-8")
    errors = f"Mine.cs(1,1): {error}"
    said = player.why(errors, [script], []).split("\n")[1 + len(errors.split("\n")) :]
    assert said == cure.format(game=game).split("\n")


def test_what_cannot_be_played_is_named(play, tmp_path):
    (tmp_path / "Broken.cs").write_text(MINE, encoding="utf-8")
    code, lines = play(tmp_path / "Broken.cs")
    assert code == 1
    # Each error once, then what most often is the cause.
    assert lines[0] == "kit    | your script does not compile:"
    assert re.search(r"Broken\.cs\(8,\d+\): error CS0246: .*'Greeting'[^\[]*$", lines[1])
    assert lines[2:] == [f"the player has no Greeting{ALL}; if it is yours, name its file, too"]
    (tmp_path / "Hides.cs").write_text(HIDES, encoding="utf-8")
    code, lines = play(tmp_path / "Hides.cs")
    assert code == 1 and len(lines) == 3
    for line, method in ((3, "Hides.Update"), (10, "Forces.FixedUpdate")):
        assert any(re.search(rf"Hides\.cs\({line},\d+\): error CS0114: '{method}", each) for each in lines), lines
    (tmp_path / "Bare.cs").write_text("class Bare { }", encoding="utf-8")
    assert play(tmp_path / "Bare.cs") == (2, ["there is no MonoBehaviour in these files"])
    assert play(tmp_path / "absent.cs") == (2, [f"kit    | there is no C# file {tmp_path / 'absent.cs'}"])
    code, lines = play(tmp_path / "Bare.cs", tmp_path / "Bare.cs")
    assert code == 2 and "Bare.cs is named twice: new GameObject(" in lines[0]
    # With double quotes: cmd knows no others.
    cure = 'a value with blanks is a word of its own: --scale "0, 1, 0"'
    assert play("--scale=0, 1, 0") == (2, [f"kit    | there is no C# file {ROOT / '--scale=0, 1, 0'}; {cure}"])
