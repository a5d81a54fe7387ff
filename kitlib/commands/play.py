"""Plays scripts of a reader's own."""

import argparse
from pathlib import Path

from kitlib.lessons import PACKAGE, KitError, UsageError
from kitlib.programs import run_in_terminal
from kitlib.setup import dotnet
from kitlib.terminal import say
from kitlib.unity.player import for_dotnet, why
from kitlib.unity.project import scripts_of_the_kit

ABOUT = """Plays scripts of your own as Unity would, without Unity: every MonoBehaviour in these files, on one object.

  --seconds 5         stops then, or at Application.Quit(); without it also once every `public bool Done` is true
  --count 3           sets the serialized field `count`, as the inspector does
  --set count=3       the same, also for a field that has the name of an option, such as timeout; --endpoint counts more
  --MyClient.count 3  sets it in this class alone; without a class in each one that has it
  --wrist Wrist       makes the object, or its component, that a field names; --points Point*21 fills an array
  --add LineRenderer  gives the scripts' object this component, one of Unity's or of the kit's, such as GymManager
  --click Send        a second later; --click Volume=0.5 and --click Name=Ada a second after that, in a UI"""
EXAMPLES = [
    "play MyClient.cs",
    "play MyClient.cs MyQueue.cs --endpoint tcp://127.0.0.1:5554   with a class that it uses; sets a field",
    "play MyClient.cs --seconds 5                                  stops then, as the Stop button does",
]
PASSES_ON = True


def add_options(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("files", type=Path, nargs="+", metavar="FILE.cs", help="your scripts, wherever they are")


def do(options: argparse.Namespace) -> int:
    files: list[Path] = [path.resolve() for path in options.files]
    for path in files:
        if path.suffix != ".cs" or not path.is_file():
            cure = '; a value with blanks is a word of its own: --scale "0, 1, 0"' * path.name.startswith("--")
            raise UsageError(f"there is no C# file {path}{cure}")
    if twice := next((path for path in files if files.count(path) > 1), None):
        cure = f'new GameObject("second").AddComponent<{twice.stem}>() in another script makes a second one'
        raise UsageError(f"{twice.name} is named twice: {cure}")
    theirs = scripts_of_the_kit(files[0])
    if theirs is not None:
        # What is named here, there or in the kit, is not taken from there once more.
        named = {path.name for path in files if path in theirs or path.is_relative_to(PACKAGE)}
        theirs = [path for path in theirs if path.name not in named]
    elif changed := ", ".join(path.name for path in files if dotnet.changed_copy(path)):
        whose = "by the scripts named here; name each other file of the kit that needs it, too"
        say(f"{changed}: named like the kit's, and used in its place {whose}")
    netmq = dotnet.find_netmq()
    player = dotnet.build(netmq)
    try:
        scripts = dotnet.compile_scripts(netmq, [for_dotnet(path) for path in files], theirs)
    except dotnet.DoesNotCompile as error:
        raise KitError(why(str(error), files, theirs)) from None
    # A script keeps its files where its owner is, and not in the kit.
    return run_in_terminal(["dotnet", player, scripts, "--unity", *options.words], Path.cwd())
