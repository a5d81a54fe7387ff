"""Installs into a user's own Unity project; what that takes has a room of its own, kitlib/unity/."""

import argparse
from pathlib import Path

from kitlib.unity.install import install
from kitlib.unity.package import write_package

ABOUT = (
    "Copies the Unity scripts and NetMQ's DLLs into a Unity project, where what you have changed stays;"
    " or packs them into one file."
)
EXAMPLES = [
    "unity ../MyGame                    the whole package",
    "unity ../MyGame --lesson 4         only what lesson 04 needs",
    "unity ../MyGame --scripts-only     NetMQ comes from elsewhere",
    "unity ../MyGame --dlls ../NetMQ    its DLLs are in this folder; NuGet is not asked",
    "unity --package Kit.unitypackage   all in one file, for Assets > Import Package",
]
CURE = 'a path with a space in it goes between quotation marks: unity "../My Game"'


def add_options(parser: argparse.ArgumentParser) -> None:
    where = parser.add_mutually_exclusive_group(required=True)
    help = "the folder that holds Assets and ProjectSettings"
    where.add_argument("project", type=Path, nargs="?", metavar="PATH", help=help)
    where.add_argument("--package", type=Path, metavar="FILE", help="write a .unitypackage instead")
    parser.add_argument("--lesson", help="copy only what this lesson needs")
    parser.add_argument("--force", action="store_true", help="overwrite files that were changed")
    dlls = parser.add_mutually_exclusive_group()
    dlls.add_argument("--scripts-only", action="store_true", help="leave the DLLs to you")
    dlls.add_argument("--dlls", type=Path, metavar="FOLDER", help="take the DLLs from there")


def do(options: argparse.Namespace) -> int:
    write, where = (write_package, options.package) if options.package else (install, options.project)
    write(where, options.lesson, options.force, options.scripts_only, options.dlls)
    return 0
