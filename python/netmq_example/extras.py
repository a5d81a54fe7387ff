"""A package that is missing is named with its cure: the kernel of a notebook has packages of its own."""

from netmq_example.errors import pip_install

# The name on PyPI, where it is another one than that of the module.
ON_PYPI = {"zmq": "pyzmq", "PIL": "pillow", "socketio": "python-socketio"}


def without(error: ImportError) -> ImportError:
    """The same with its cure, unless it has one. Where the package is there and broken, it needs another one."""
    if not isinstance(error, ModuleNotFoundError) or ": " in str(error):
        return error
    package = str(error.name).partition(".")[0]
    return ModuleNotFoundError(f"{error}: {pip_install(ON_PYPI.get(package, package))}", name=error.name)
