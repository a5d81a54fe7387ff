"""ML-Agents' own trainer, mlagents-learn, over ZeroMQ: the kit stands in the place of its package mlagents_envs.

    python -m netmq_example.mlagents_learn config.yaml --env=Build/Game --run-id=first
    python -m netmq_example.mlagents_learn config.yaml --run-id=first                     and press Play

All words are those of mlagents-learn; --env may also name a simulator's script. It needs ML-Agents' Python packages,
and says what is missing. The page train_by_mlagents_learn.md has more.
"""

import functools
import importlib
import importlib.util
import inspect
import logging
import pkgutil
import sys
import types
from importlib import metadata
from typing import Any

from netmq_example.extras import pip_install
from netmq_example.mlagents_envs.exception import UnityException

__all__ = ["main", "take_place"]

log = logging.getLogger("netmq_example.envs")

# The modules that ML-Agents imports, and how pip installs each in a version that fits to its last release.
NEEDS = {
    "torch": "torch>=2.1.1",
    "numpy": "numpy<2",
    # pip reads that these want Python 3.10, and older packages than they need.
    "mlagents": "--no-deps --ignore-requires-python mlagents==1.1.0",
    "mlagents_envs": "--no-deps --ignore-requires-python mlagents_envs==1.1.0",
    "google.protobuf": "protobuf==3.20.3",
    "pkg_resources": "setuptools==69.5.1",
    "cattr": "cattrs==1.5.0",
    "attr": "attrs",
    "cloudpickle": "cloudpickle",
    "h5py": "h5py",
    "PIL": "pillow",
    "tensorboard": "tensorboard",
    "yaml": "pyyaml",
}
# The first versions with which it ends in a traceback.
TOO_NEW = {"google.protobuf": ("protobuf", (3, 21)), "cattr": ("cattrs", (1, 7))}
# Python 3.12 lists what is installed in a way that ML-Agents' search for plugins does not understand.
LAST_PYTHON = (3, 11)
# Names that numpy 1.24 dropped, and that ML-Agents uses.
DROPPED = {"float": float, "long": int}
# The release that all of this was tried with.
TRIED = (1, 1, 0)


def main() -> None:
    lines = missing()
    if lines:
        raise SystemExit("\n".join(lines))
    take_place()
    learn: Any = importlib.import_module("mlagents.trainers.learn")
    errors: Any = importlib.import_module("mlagents.trainers.exception")
    keep_exporter(importlib.import_module("torch"))
    say_what_is_wrong(errors.TrainerConfigError)
    try:
        options = learn.parse_command_line()
    except (TypeError, ValueError) as error:
        # A text where the file needs a number, or several simulators without a program for them.
        raise SystemExit(f"mlagents-learn ended: {error}: look at the file and the options") from None
    except errors.TrainerConfigError as error:
        raise SystemExit(f"mlagents-learn ended: {error}") from None
    if options.env_settings.num_envs < 1:
        # It would wait for ever for the first of none.
        raise SystemExit("mlagents-learn ended: with no simulator nobody plays: write --num-envs=1, or leave it out")
    try:
        learn.run_cli(options)
    except (errors.TrainerError, errors.TrainerConfigError, UnityException) as error:
        raise SystemExit(f"mlagents-learn ended: {error}") from None


def missing() -> list[str]:
    """A line for each package that is not there, or too new, with the command that installs it."""
    if sys.version_info[:2] > LAST_PYTHON and version("mlagents") <= TRIED:
        return ["ML-Agents 1.1.0 needs Python 3.11 or older: python3.11 -m venv .venv, and install all there"]
    lines = [f"{module} is not installed: {install(module)}" for module in NEEDS if not found(module)]
    for module, (package, limit) in TOO_NEW.items():
        if version(package) >= limit:
            lines.append(f"{package} {metadata.version(package)} is too new for ML-Agents: {install(module)}")
    if not lines and version("torch") < (2,) and version("numpy") >= (1, 24):
        cure = f"set summary_freq above max_steps, or {install('torch')}"
        log.warning("this torch fails at TensorBoard's histograms with numpy 1.24 and later: %s", cure)
    return lines


def install(module: str) -> str:
    return pip_install(*NEEDS[module].split())


def found(module: str) -> bool:
    try:
        return importlib.util.find_spec(module) is not None
    except ModuleNotFoundError:
        return False


def version(package: str) -> tuple[int, ...]:
    """Its numbers; none where it is not installed."""
    try:
        words = metadata.version(package).split(".")
    except metadata.PackageNotFoundError:
        return ()
    return tuple(int(word) for word in words if word.isdecimal())


def take_place() -> None:
    """From now on mlagents_envs is the kit's, in this process; modules that only ML-Agents has stay its own.

    A trainer of your own calls it before it imports mlagents, at the top of its script, which spawned workers read too.
    """
    own = importlib.util.find_spec("mlagents_envs")
    if own is None or "mlagents_envs" in sys.modules:
        raise ImportError("take_place comes before the first import of mlagents_envs, which has to be installed")
    kit = importlib.import_module("netmq_example.mlagents_envs")
    package = sys.modules["mlagents_envs"] = types.ModuleType("mlagents_envs")
    for each in pkgutil.walk_packages(kit.__path__, f"{kit.__name__}."):
        sys.modules[each.name.removeprefix("netmq_example.")] = importlib.import_module(each.name)
    # Beside them stay communicator_objects and rpc_utils, which read demonstrations.
    vars(package).update(vars(kit), __name__="mlagents_envs", __spec__=own, __path__=own.submodule_search_locations)
    if version("mlagents") <= TRIED:
        numpy = importlib.import_module("numpy")
        for dropped, value in DROPPED.items():
            vars(numpy).setdefault(dropped, value)


def keep_exporter(torch: Any) -> None:
    """The exporter of a newer torch writes two files, in an opset that Unity does not read."""
    if "dynamo" in inspect.signature(torch.onnx.export).parameters:
        torch.onnx.export = functools.partial(torch.onnx.export, dynamo=False)


def say_what_is_wrong(error: Any) -> None:
    """ML-Agents ends in a traceback where a file has no settings, and in silence where a simulator is lost for good."""
    settings: Any = importlib.import_module("mlagents.trainers.settings")
    controller: Any = importlib.import_module("mlagents.trainers.trainer_controller")
    yaml: Any = importlib.import_module("yaml")
    load = settings.load_config

    def load_config(path: str) -> Any:
        try:
            config = load(path)
        except yaml.YAMLError as wrong:
            raise error(f"{path} is no YAML: {' '.join(str(wrong).split())}") from None
        if not isinstance(config, dict):
            raise error(f"{path} has no settings: write behaviors:, and below it those of each behavior")
        return config

    settings.load_config = load_config
    # Ctrl-C is the only end that is no error.
    controller.UnityCommunicatorStoppedException = KeyboardInterrupt


if __name__ == "__mp_main__":
    # A worker that was spawned reads this module before all others.
    take_place()

if __name__ == "__main__":
    main()
