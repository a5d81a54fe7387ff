"""The keys of lessons 08 to 10, where a project listens to the Input System alone, or to nothing that the kit knows."""

from __future__ import annotations

import json
import os
import re
import subprocess
from pathlib import Path

from kitlib.setup import dotnet
from tests.unity.conftest import PACKAGE

# What the script names of com.unity.inputsystem, as its Keyboard.cs and ButtonControl.cs declare it.
INPUT_SYSTEM = """
namespace UnityEngine.InputSystem
{
    public enum Key { Space = 1, Enter, A = 15, D = 18, S = 33, W = 37, LeftArrow = 61, RightArrow, UpArrow, DownArrow }
    public class KeyControl { public bool isPressed { get; set; } }
    public class Keyboard
    {
        public static Keyboard current { get; set; }
        public Key Pressed { get; set; }
        public KeyControl this[Key key] => new KeyControl { isPressed = key == Pressed };
    }
}
"""
SAY = """
void Say(object who) =>
    System.Console.WriteLine($"{who} {ArrowKeys.Horizontal} {ArrowKeys.Vertical} {ArrowKeys.Space} {ArrowKeys.Enter}");
"""
PRESS_EACH = """
Say("nobody");
foreach (UnityEngine.InputSystem.Key key in System.Enum.GetValues(typeof(UnityEngine.InputSystem.Key)))
{
    UnityEngine.InputSystem.Keyboard.current = new UnityEngine.InputSystem.Keyboard { Pressed = key };
    Say(key);
}
"""


def printed(folder: Path, unity: Path, define: str, program: str, types: str = "") -> list[str]:
    """What a program prints with the script compiled as Unity does in such a project."""
    (folder / "Program.cs").write_text(f"using NetMQExample;\n{SAY}\n{program}\n{types}", encoding="utf-8")
    (folder / "keys.csproj").write_text(
        f"""<Project Sdk="Microsoft.NET.Sdk">
  <PropertyGroup>
    <TargetFramework>net$(BundledNETCoreAppTargetFrameworkVersion)</TargetFramework>
    <OutputType>Exe</OutputType>
    <LangVersion>9.0</LangVersion>
    <DefineConstants>{define}</DefineConstants>
  </PropertyGroup>
  <ItemGroup>
    <Compile Include="{PACKAGE / "Shared" / "ArrowKeys.cs"}" />
    <Reference Include="{unity}" />
  </ItemGroup>
</Project>
""",
        encoding="utf-8",
    )
    run = ["dotnet", "run", "--project", str(folder), "-p:NuGetAudit=false"]
    environment: dict[str, str] = {**os.environ, **dotnet.ENVIRONMENT}
    done = subprocess.run(run, capture_output=True, text=True, env=environment, timeout=500)
    assert done.returncode == 0, done.stdout + done.stderr
    return (done.stdout + done.stderr).splitlines()


def test_the_input_system_alone_is_enough(editor_dll: Path, tmp_path: Path) -> None:
    unity = editor_dll.parent / "UnityPlayer.dll"
    assert printed(tmp_path, unity, "NETMQEXAMPLE_INPUT_SYSTEM", PRESS_EACH, INPUT_SYSTEM) == [
        "nobody 0 0 False False",
        "Space 0 0 True False",
        "Enter 0 0 False True",
        "A -1 0 False False",
        "D 1 0 False False",
        "S 0 -1 False False",
        "W 0 1 False False",
        "LeftArrow -1 0 False False",
        "RightArrow 1 0 False False",
        "UpArrow 0 1 False False",
        "DownArrow 0 -1 False False",
    ]


def test_without_either_one_line_says_what_to_do(editor_dll: Path, tmp_path: Path) -> None:
    unity = editor_dll.parent / "UnityPlayer.dll"
    lines = printed(tmp_path, unity, "", 'Say("once"); Say("twice");')
    assert sorted(lines) == [
        "no keyboard: install the package Input System, or set Project Settings, Player, Active Input Handling to Both",
        "once 0 0 False False",
        "twice 0 0 False False",
    ]


def test_no_other_script_asks_for_keys() -> None:
    asks = re.compile(r"\bInput\.(Get|mouse|touch|any)|ENABLE_(LEGACY_)?INPUT")
    found = [path.name for path in PACKAGE.rglob("*.cs") if asks.search(path.read_text(encoding="utf-8"))]
    assert found == ["ArrowKeys.cs"]
    definition = json.loads((PACKAGE / "NetMQExample.asmdef").read_text(encoding="utf-8"))
    # Unity passes over a reference by name to what is not there.
    assert definition["references"] == ["Unity.InputSystem"]
    define = {"name": "com.unity.inputsystem", "expression": "", "define": "NETMQEXAMPLE_INPUT_SYSTEM"}
    assert define in definition["versionDefines"]
