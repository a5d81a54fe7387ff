"""Installs into a user's own Unity project; what that takes has a room of its own, kitlib/unity/."""

import argparse
from pathlib import Path

from kitlib.lessons import UsageError
from kitlib.unity.install import install
from kitlib.unity.moving import move_in, undo
from kitlib.unity.package import write_package
from kitlib.unity.scripts import ML_AGENTS

ABOUT = (
    "Copies the Unity scripts and NetMQ's DLLs into a Unity project, where what you have changed stays;"
    " or packs them into one file."
)
EXAMPLES = [
    "unity ../MyGame                    the whole package",
    "unity ../MyGame --lesson 4         only what lesson 04 needs",
    "unity ../MyGame --scripts-only     NetMQ comes from elsewhere",
    "unity ../MyGame --dlls ../NetMQ    its DLLs are in this folder; NuGet is not asked",
    "unity ../MyGame --from ml-agents   what would change in an ML-Agents project; nothing does yet",
    "unity ../MyGame --from ml-agents --yes    move it in: using lines, scenes, assemblies, manifest",
    "unity ../MyGame --from ml-agents --undo   and take it back",
    "unity --package Kit.unitypackage   all in one file, for Assets > Import Package",
]
CURE = 'a path with a space in it goes between quotation marks: unity "../My Game"'


def add_options(parser: argparse.ArgumentParser) -> None:
    where = parser.add_mutually_exclusive_group(required=True)
    help = "the folder that holds Assets and ProjectSettings"
    where.add_argument("project", type=Path, nargs="?", metavar="PATH", help=help)
    where.add_argument("--package", type=Path, metavar="FILE", help="write a .unitypackage instead")
    what = parser.add_mutually_exclusive_group()
    what.add_argument("--lesson", help="copy only what this lesson needs")
    help = "move a project of ML-Agents in: says what it would change, and changes it with --yes"
    what.add_argument("--from", choices=[ML_AGENTS], dest="origin", help=help)
    sure = parser.add_mutually_exclusive_group()
    sure.add_argument("--yes", action="store_true", help="with --from: change it")
    sure.add_argument("--undo", action="store_true", help="with --from: take back what --yes has done")
    parser.add_argument("--force", action="store_true", help="overwrite files that were changed")
    dlls = parser.add_mutually_exclusive_group()
    dlls.add_argument("--scripts-only", action="store_true", help="leave the DLLs to you")
    dlls.add_argument("--dlls", type=Path, metavar="FOLDER", help="take the DLLs from there")


def do(options: argparse.Namespace) -> int:
    if options.origin:
        if options.package:
            raise UsageError("--from is for a project: name its folder and leave out --package")
        if options.undo:
            undo(options.project, options.force)
        else:
            move_in(options.project, options.yes, options.force, options.scripts_only, options.dlls)
        return 0
    if options.yes or options.undo:
        raise UsageError(f"--yes and --undo are for --from {ML_AGENTS}: add it, or leave them out")
    write, where = (write_package, options.package) if options.package else (install, options.project)
    write(where, options.lesson, options.force, options.scripts_only, options.dlls)
    return 0
