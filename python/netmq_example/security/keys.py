"""The keys of CURVE: a pair for each side, and the list of the clients that may come in.

    python -m netmq_example.security.keys make server           keys/server.key and keys/server.key_secret
    python -m netmq_example.security.keys make client           keys/client.key and keys/client.key_secret
    python -m netmq_example.security.keys enrol alice=FILE      lets that key in, as alice; FILE is her client.key
    python -m netmq_example.security.keys enrol "alice=KEY"     the same with the key itself
    python -m netmq_example.security.keys revoke alice          nobody is let in by that name any more
    python -m netmq_example.security.keys rotate client         a new pair; the old one is kept as client.1.key_secret
    python -m netmq_example.security.keys list                  who may come in

A file that ends in .key is public: give it to anybody. A file that ends in .key_secret never leaves its machine. Only
its owner may read it (mode 0600), and it is never overwritten. A running server notices each enrol and revoke at once.
The files are those of czmq (zcert): zmq.auth.load_certificate reads them. A key is 40 characters of Z85.

From Python: make(folder, "server"), enrol(folder, "alice", key), revoke(folder, "alice"); load(path) gives the keys in
a file. ValueError says what is wrong with a name, a key or a file.
"""

import argparse
import contextlib
import errno
import os
import re
import struct
import sys
import tempfile
from pathlib import Path
from typing import Any

import zmq
import zmq.auth
from zmq.utils import z85

from netmq_example import arguments
from netmq_example.program import run

NAME = r"[\w-]{1,40}"
# A key has 200 bytes, with the comments that some write above it more.
LARGEST_FILE_BYTES = 4096
# The argument of each verb.
FORMS = {
    "make": "(server|client)",
    "rotate": "(server|client)",
    "enrol": f"({NAME})=(.+)",
    "revoke": f"({NAME})",
    "list": "",
}
NO_KEY = "keys.py makes keys, and server.key is a copy of the server's"
NOT_THEIRS = "enrol takes the path of a client's client.key, or the 40 characters in it"


def make(folder: Path, role: str) -> bytes:
    """A new pair for a server or a client, and its public key."""
    path = arguments.path("folder", folder) / f"{checked_role(role)}.key_secret"
    public, secret = zmq.curve_keypair()
    write(path, public, secret)
    try:
        write(path.with_suffix(".key"), public)
    except ValueError:
        # A new secret key beside an old public one would be a pair that fits nobody.
        path.unlink()
        raise
    return public


def rotate(folder: Path, role: str) -> tuple[bytes, Path]:
    """A new pair: its public key, and where the old secret key is, under the next free number."""
    path = arguments.path("folder", folder) / f"{checked_role(role)}.key_secret"
    # Named, if there is none.
    path.stat()
    number = 1
    while path.with_name(f"{role}.{number}.key_secret").exists():
        number += 1
    # On the same disk, which may be full: the old pair stays where it is until the new one is whole.
    with tempfile.TemporaryDirectory(dir=path.parent) as new:
        public = make(Path(new), role)
        old = path.rename(path.with_name(f"{role}.{number}.key_secret"))
        for name in (f"{role}.key", f"{role}.key_secret"):
            Path(new, name).replace(path.with_name(name))
    return public, old


def enrol(folder: Path, name: str, key: str) -> Path:
    """Let in the client that has this key, or the key in this file."""
    path = arguments.path("folder", folder) / "allowed" / f"{checked_name(name)}.key"
    if not isinstance(key, str | os.PathLike):
        raise ValueError(f"key takes 40 characters or the path of a file, not {key!r:.40}")
    text = str(key)
    public = checked(text.encode()) if len(text) == 40 and not Path(text).exists() else load(Path(text), NOT_THEIRS)[0]
    others = {other.stem for other in listed(path.parent.parent) if key_in(other) == public.decode()} - {name}
    if others:
        raise ValueError(f"that key is on the list already, as {others.pop()}, and could be revoked by one name only")
    write(path, public)
    return path


def revoke(folder: Path, name: str) -> None:
    """FileNotFoundError if nobody has that name."""
    (arguments.path("folder", folder) / "allowed" / f"{checked_name(name)}.key").unlink()


def example(folder: Path) -> None:
    """For the first start on one machine: a server's pair, and that of a client, alice, who may come in."""
    make(folder, "server")
    make(folder, "client")
    enrol(folder, "alice", str(Path(folder) / "client.key"))


def load(path: Path, cure: str = NO_KEY) -> tuple[bytes, bytes]:
    """The public key in a file, and the secret one if it is a .key_secret; ValueError, with this cure, if not.

    OSError: too many files are open, and nobody knows what is in this one.
    """
    path = arguments.path("path", path)
    try:
        public, secret = zmq.auth.load_certificate(arguments.regular_file(path, LARGEST_FILE_BYTES))
        return checked(public), checked(secret or b"") if path.suffix == ".key_secret" else b""
    except PermissionError:
        cure = "start as the user who made it, or give it to this one"
        raise ValueError(f"this user may not read {path.absolute()}; {cure}") from None
    # pyzmq raises the last one for a file that ends in the middle of its line.
    except (OSError, ValueError, IndexError) as error:
        if getattr(error, "errno", 0) in (errno.EMFILE, errno.ENFILE):
            raise
        raise ValueError(f"no key in {path.absolute()}; {cure}") from None


def key_in(path: Path) -> str:
    """The public key in a file; nothing if the file holds none, is half written, or has just gone."""
    try:
        return load(path)[0].decode()
    except ValueError:
        return ""


def listed(folder: Path) -> list[Path]:
    """The files of the clients that may come in; OSError if the list cannot be read."""
    allowed = folder / "allowed"
    try:
        # Not Path.glob: from 3.12 on it finds nothing where it cannot look.
        names = os.listdir(allowed)
    except FileNotFoundError:
        return []
    return [allowed / name for name in sorted(names) if name.endswith(".key")]


def write(path: Path, public: bytes, secret: bytes = b"") -> None:
    """A new file, or ValueError. No other user can read it, not even for a moment, if it holds a secret."""
    path = arguments.path("path", path)
    text = f'curve\n    public-key = "{checked(public).decode()}"\n'
    if secret:
        text += f'    secret-key = "{checked(secret).decode()}"\n'
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        file = os.open(path, os.O_CREAT | os.O_EXCL | os.O_WRONLY, 0o600 if secret else 0o644)
        try:
            with open(file, "w", encoding="ascii") as new:
                new.write(text)
        except OSError:
            # On a full disk: an empty file would be in the way ever after.
            path.unlink()
            raise
    except FileExistsError as error:
        cure = "rotate makes a new pair, revoke frees a name"
        raise ValueError(f"{error.filename} is there, and is never overwritten; {cure}") from None
    except OSError as error:
        raise ValueError(f"cannot write {path}: {error.strerror}; --keys names another folder") from None


def checked(key: bytes) -> bytes:
    """This key; ValueError if it is none. A socket would only say so when it is used, and not what is wrong."""
    if not isinstance(key, bytes):
        raise ValueError(f"a key is 40 bytes of Z85, not {key!r:.40}")
    with contextlib.suppress(ValueError, KeyError, struct.error):
        if len(z85.decode(key)) == 32:
            return key
    raise ValueError(f"no key: {key.decode(errors='replace')!r:.60}; a key has 40 characters, as in server.key")


def checked_role(role: Any) -> str:
    if role in ("server", "client"):
        return str(role)
    raise ValueError(f"role is server or client, not {role!r:.40}")


def checked_name(name: Any) -> str:
    """It is the name of a file."""
    if isinstance(name, str) and re.fullmatch(NAME, name):
        return name
    raise ValueError(f"name takes 1 to 40 letters, digits, - and _, not {name!r:.40}")


def done(verb: str, words: list[str], folder: Path) -> str:
    if verb == "list":
        lines = [f"{path.stem}: {key_in(path) or 'no key in it'}" for path in listed(folder)]
        return "\n".join(lines) or "nobody may come in"
    if verb == "revoke":
        revoke(folder, *words)
        return f"revoked: {words[0]}"
    if verb == "enrol":
        return f"enrolled: {words[0]}, in {enrol(folder, *words)}"
    (role,) = words
    kept = ""
    if verb == "rotate":
        public, old = rotate(folder, role)
        kept = f"; the old pair is in {old}"
    else:
        public = make(folder, role)
    return f"made {folder / role}.key and {role}.key_secret, public key {public.decode()}{kept}"


def main() -> None:
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    parser.add_argument("verb", choices=FORMS)
    parser.add_argument("what", nargs="?", default="", help="server or client; alice=client.key; alice")
    parser.add_argument("--keys", type=Path, default="keys", metavar="DIR", help="where they are; default: keys")
    options = parser.parse_args()
    form = re.fullmatch(FORMS[options.verb], options.what)
    if not form:
        parser.error(f"{options.verb} does not take '{options.what}': see the top of {Path(__file__).name}")
    try:
        print(done(options.verb, list(form.groups()), options.keys.absolute()))
    except ValueError as error:
        sys.exit(str(error))
    except OSError as error:
        sys.exit(f"{error.filename}: {error.strerror}")


if __name__ == "__main__":
    run(main, stopped="stopped")
