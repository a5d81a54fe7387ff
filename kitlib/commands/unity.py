"""Installs into a user's own Unity project; what that takes has a room of its own, kitlib/unity/."""

import argparse
from pathlib import Path

from kitlib.unity.install import install

ABOUT = "Copies the Unity scripts and NetMQ's DLLs into a Unity project. What you have changed there stays."
EXAMPLES = [
    "unity ../MyGame                   the whole package",
    "unity ../MyGame --lesson 4        only what lesson 04 takes home",
    "unity ../MyGame --scripts-only    NetMQ comes from elsewhere",
    "unity ../MyGame --dlls ../NetMQ   its DLLs are in this folder; NuGet is not asked",
]
CURE = 'a path with a space in it goes between quotation marks: unity "../My Game"'


def add_options(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("project", type=Path, metavar="PATH", help="the folder that holds Assets and ProjectSettings")
    parser.add_argument("--lesson", help="copy only this lesson's take-home files")
    parser.add_argument("--force", action="store_true", help="overwrite files that were changed")
    dlls = parser.add_mutually_exclusive_group()
    dlls.add_argument("--scripts-only", action="store_true", help="leave the DLLs to you")
    dlls.add_argument("--dlls", type=Path, metavar="FOLDER", help="take the DLLs from there")


def do(options: argparse.Namespace) -> int:
    install(options.project, options.lesson, options.force, options.scripts_only, options.dlls)
    return 0
