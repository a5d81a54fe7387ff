"""Lesson 15, keys: a pair for each side, and the list of the clients that may come in.

    python python/15_security/keys.py make server           keys/server.key and keys/server.key_secret
    python python/15_security/keys.py make client           keys/client.key and keys/client.key_secret
    python python/15_security/keys.py enrol alice=FILE      lets that key in, as alice; FILE is her client.key
    python python/15_security/keys.py enrol "alice=KEY"     the same with the key itself
    python python/15_security/keys.py revoke alice          nobody is let in by that name any more
    python python/15_security/keys.py rotate client         a new pair; the old one is kept as client.1.key_secret
    python python/15_security/keys.py list                  who may come in

What ends in .key is public: give it to anybody. What ends in .key_secret never leaves its machine; it is written for
its owner's eyes alone (mode 0600), and never overwritten. A running server sees at once who was enrolled or revoked.
The files are those of czmq (zcert): zmq.auth.load_certificate reads them.
"""

import argparse
import contextlib
import os
import re
import struct
import sys
from pathlib import Path

import zmq
import zmq.auth
from zmq.utils import z85

FORMS = {"make": "(server|client)", "rotate": "(server|client)", "enrol": r"([\w-]{1,40})=(.+)", "revoke": r"([\w-]+)"}
THEIRS = "enrol takes the path of a client's client.key, or the 40 characters in it"


def write(path: Path, public: bytes, secret: bytes = b"") -> None:
    """A new file, or ValueError. No other user can read it, not even for a moment, if it holds a secret."""
    text = f'curve\n    public-key = "{public.decode()}"\n'
    if secret:
        text += f'    secret-key = "{secret.decode()}"\n'
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        file = os.open(path, os.O_CREAT | os.O_EXCL | os.O_WRONLY, 0o600 if secret else 0o644)
        with open(file, "w", encoding="ascii") as new:
            new.write(text)
    except FileExistsError as error:
        cure = "rotate makes a new pair, revoke frees a name"
        raise ValueError(f"{error.filename} is there, and is never overwritten; {cure}") from None
    except OSError as error:
        raise ValueError(f"cannot write {path}: {error.strerror}; --keys names another folder") from None


def make(folder: Path, role: str) -> bytes:
    """A new pair, and its public key."""
    public, secret = zmq.curve_keypair()
    path = folder / f"{role}.key_secret"
    write(path, public, secret)
    try:
        write(folder / f"{role}.key", public)
    except ValueError:
        # A new secret key beside an old public one would be a pair that fits nobody.
        path.unlink()
        raise
    return public


def checked(key: bytes) -> bytes:
    """What is no key is said here and not by a socket, later."""
    with contextlib.suppress(ValueError, KeyError, struct.error):
        if len(z85.decode(key)) == 32:
            return key
    raise ValueError(f"no key: {key.decode(errors='replace')!r:.60}; a key has 40 characters, as in server.key")


def load(path: Path, cure: str = "keys.py makes keys, and server.key is a copy of the server's") -> tuple[bytes, bytes]:
    """The public key in a file, and the secret one if there is one."""
    try:
        public, secret = zmq.auth.load_certificate(path)
        return checked(public), checked(secret or b"") if path.suffix == ".key_secret" else b""
    # The last is pyzmq's word for a file that ends in the midst of its line.
    except (OSError, ValueError, IndexError):
        raise ValueError(f"no key in {path.absolute()}; {cure}") from None


def enrol(folder: Path, name: str, key: str) -> Path:
    """Let in who has this key, or the key in this file."""
    path = folder / "allowed" / f"{name}.key"
    public = checked(key.encode()) if len(key) == 40 and not Path(key).exists() else load(Path(key), THEIRS)[0]
    if others := {old.stem for old in path.parent.glob("*.key") if key_in(old) == public.decode()} - {name}:
        raise ValueError(f"that key is on the list already, as {others.pop()}, and could be revoked by one name only")
    write(path, public)
    return path


def key_in(path: Path) -> str:
    """The public key; nothing if the file holds none, is half written, or has just gone."""
    with contextlib.suppress(ValueError):
        return load(path)[0].decode()
    return ""


def example(folder: Path) -> None:
    """For the first start on one machine: a server's pair, and a client's that may come in."""
    make(folder, "server")
    make(folder, "client")
    enrol(folder, "alice", str(folder / "client.key"))


def retire(folder: Path, role: str) -> Path:
    """The secret key of today gets the next free number."""
    old = next(path for n in range(1, 10_000) if not (path := folder / f"{role}.{n}.key_secret").exists())
    (folder / f"{role}.key_secret").rename(old)
    (folder / f"{role}.key").unlink(missing_ok=True)
    return old


def do(verb: str, words: list[str], folder: Path) -> str:
    if verb == "list":
        allowed = sorted((folder / "allowed").glob("*.key"))
        return "\n".join(f"{path.stem}: {key_in(path) or 'no key in it'}" for path in allowed) or "nobody may come in"
    if verb == "revoke":
        (folder / "allowed" / f"{words[0]}.key").unlink()
        return f"revoked: {words[0]}"
    if verb == "enrol":
        return f"enrolled: {words[0]}, in {enrol(folder, *words)}"
    old = f"; the old pair is in {retire(folder, words[0])}" if verb == "rotate" else ""
    return f"made {folder / words[0]}.key and {words[0]}.key_secret, public key {make(folder, words[0]).decode()}{old}"


def main() -> None:
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    parser.add_argument("verb", choices=[*FORMS, "list"])
    parser.add_argument("what", nargs="?", default="", help="server or client; alice=client.key; alice")
    parser.add_argument("--keys", type=Path, default="keys", metavar="DIR", help="where they are: keys, if not said")
    options = parser.parse_args()
    if not (form := re.fullmatch(FORMS.get(options.verb, "()"), options.what)):
        parser.error(f"{options.verb} does not take '{options.what}': see the top of {Path(__file__).name}")
    try:
        print(do(options.verb, list(form.groups()), options.keys.absolute()))
    except (OSError, ValueError) as error:
        sys.exit(str(error) if isinstance(error, ValueError) else f"{error.filename}: {error.strerror}")


if __name__ == "__main__":
    main()
