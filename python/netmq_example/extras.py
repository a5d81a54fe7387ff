"""A package that is missing is named with its cure: the kernel of a notebook has packages of its own."""

import contextlib
import shlex
import subprocess
import sys
from collections.abc import Iterator

# The name on PyPI, where it is another one than that of the module.
ON_PYPI = {"zmq": "pyzmq", "PIL": "pillow", "socketio": "python-socketio"}


def without(error: ImportError) -> ImportError:
    """The same with its cure, unless it has one. Where the package is there and broken, it needs another one."""
    if not isinstance(error, ModuleNotFoundError) or ": " in str(error):
        return error
    package = str(error.name).partition(".")[0]
    return ModuleNotFoundError(f"{error}: {pip_install(ON_PYPI.get(package, package))}", name=error.name)


def pip_install(*words: str) -> str:
    """The command that installs these for the Python that runs this."""
    return shell(sys.executable, "-m", "pip", "install", *words)


def shell(*words: str) -> str:
    """A command as this system's shell takes it."""
    return subprocess.list2cmdline(words) if sys.platform == "win32" else shlex.join(words)


@contextlib.contextmanager
def importing(needs: str, stopped: str | None = None) -> Iterator[None]:
    """Around the imports of large packages. One that is missing is named with its cure, and Ctrl-C is heard already."""
    try:
        yield
    except ImportError as error:
        if str(error.name).startswith("netmq_example"):
            raise SystemExit(f"{error}: CHANGELOG.md says what has another name now") from None
        # Beyond the colon stands how it is installed without the kit.
        why = str(error).partition(": ")[0] if isinstance(error, ModuleNotFoundError) else error
        raise SystemExit(f"{why}: this lesson needs {needs}") from None
    except KeyboardInterrupt:
        raise SystemExit(stopped) from None
