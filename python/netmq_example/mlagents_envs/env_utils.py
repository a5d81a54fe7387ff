"""Builds by their paths, as mlagents_envs.env_utils finds and starts them.

    validate_environment_path("Build/Game.exe")          also on Linux: "…/Build/Game.x86_64"; None if there is none
    process = launch_executable("Build/Game", ["-batchmode"])

A script of Python is run by it. Capabilities are what UnityEnvironment says of itself.
"""

import glob
import os
import subprocess
import sys
from typing import NamedTuple

from netmq_example.launch import game, start_program
from netmq_example.mlagents_envs.exception import UnityEnvironmentException

ENDINGS = (".app", ".exe", ".x86_64", ".x86")


def get_platform() -> str:
    return sys.platform


def validate_environment_path(env_path: str) -> str | None:
    """The program of this system that a path means, whichever system's ending it has."""
    path = stem = os.fspath(env_path).strip()
    for ending in ENDINGS:
        stem = stem.removesuffix(ending)
    # The editor builds for Windows into a folder of that name.
    inside = sorted(glob.glob(f"{glob.escape(stem)}/*.exe")) if stem else []
    for candidate in (stem, path, *(exe for exe in inside if "UnityCrashHandler" not in exe)):
        try:
            return game(candidate)
        except FileNotFoundError:
            pass
    return None


def launch_words(file_name: str) -> list[str]:
    if file_name.endswith(".py") and os.path.isfile(file_name):
        return [sys.executable, os.path.abspath(file_name)]
    program = validate_environment_path(file_name)
    if not program:
        if os.path.isfile(file_name):
            cure = "give the build, or an executable script"
            raise UnityEnvironmentException(f"{file_name} is no program of this system: {cure}")
        raise UnityEnvironmentException(f"no game at {file_name}: neither this file, nor one with {', '.join(ENDINGS)}")
    return [program]


def is_player(program: str) -> bool:
    """Whether it is a build of Unity's, which has its data beside it."""
    stem = program.removesuffix(".x86_64").removesuffix(".x86").removesuffix(".exe")
    return os.path.isdir(f"{stem}_Data") or ".app/Contents/MacOS/" in program


def launch_executable(file_name: str, args: list[str]) -> subprocess.Popen[bytes]:
    """The process ends when this program does."""
    words = launch_words(file_name)
    try:
        return start_program([*words, *args])
    except OSError as error:
        raise UnityEnvironmentException(str(error)) from None


class Capabilities(NamedTuple):
    """With the names of ML-Agents' message: the kit has no analytics."""

    baseRLCapabilities: bool = True
    concatenatedPngObservations: bool = True
    compressedChannelMapping: bool = True
    hybridActions: bool = True
    trainingAnalytics: bool = False
    variableLengthObservation: bool = True
    multiAgentGroups: bool = True
