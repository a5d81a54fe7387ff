"""Lesson 15, the allow-list: a server lets in whose public key it has, and knows with each message whose it is.

    allowed = AllowList(Path("keys"))      the server's own pair, and the keys in keys/allowed
    allowed.answer(context)                from now on it is asked about each handshake; before bind
    allowed.guard(socket)                  the socket gets its keys, and asks; before bind
    allowed.name_of(frame)                 with each message: whose it is, or nothing

CURVE encrypts, and proves that the client has the secret key that belongs to its public one. Which keys are welcome,
libzmq asks by ZAP (RFC 27): a request to the address inproc://zeromq.zap.01. pyzmq has an authenticator that answers,
zmq.auth.thread; on Windows it needs tornado, and it does not tell who was refused. So here is one of twenty lines.
"""

import contextlib
import threading
import time
from collections.abc import Callable
from pathlib import Path

import zmq
from zmq.utils import z85

from netmq_example.security.keys import key_in, load

DOMAIN = b"lesson"
# How often a key that comes again and again is told of, and how many new ones are named meanwhile.
SPAN, NAMED = 5.0, 10


class AllowList:
    """Who may come in: the files in allowed/, as they are at this moment."""

    def __init__(self, folder: Path, say: Callable[[str], object] = print) -> None:
        self.public, self.secret = load(folder / "server.key_secret")
        # In full: there may be more than one folder `keys`, and who enrols into the wrong one is to see it.
        self.folder, self.say = folder.absolute(), say
        self.listed, self.look_again = dict[str, Path](), 0.0
        # Each key that was let in, with its file and what that file was then.
        self.known: dict[str, tuple[Path, int]] = {}
        self.refused: dict[str, int] = {}
        self.others, self.told, self.named = 0, time.monotonic(), 0

    def guard(self, socket: zmq.Socket[bytes]) -> None:
        socket.curve_server, socket.curve_secretkey = True, self.secret
        # Without a domain that must be asked about, whoever has the server's public key comes in when nobody answers.
        socket.zap_domain = DOMAIN
        socket.setsockopt(zmq.ZAP_ENFORCE_DOMAIN, 1)

    def answer(self, context: zmq.Context[zmq.Socket[bytes]]) -> None:
        """Begin to answer libzmq's questions, on a thread of its own, until the context ends."""
        # Of the same context, which through this name does not know it: a socket is closed on its own thread.
        zap: zmq.Socket[bytes] = zmq.Context.shadow(context.underlying).socket(zmq.REP)
        zap.linger = 0
        zap.bind("inproc://zeromq.zap.01")
        threading.Thread(target=self._answer, args=(zap,), daemon=True).start()

    def name_of(self, frame: zmq.Frame) -> str:
        """Asked with each message: the handshake of a revoked key may have been long ago."""
        return self.name(self.key_of(frame))

    def key_of(self, frame: zmq.Frame) -> str:
        """Nothing, if nobody was asked at the handshake."""
        with contextlib.suppress(zmq.ZMQError):
            return str(frame.get("User-Id"))
        return ""

    def name(self, key: str) -> str:
        path, stamp = self.known.get(key, (self.folder, 0))
        with contextlib.suppress(OSError):
            if path.stat().st_mtime_ns == stamp:
                return path.stem
        # No key is what a file without one has, too.
        return self._look_up(key) if key else ""

    def _look_up(self, key: str) -> str:
        with contextlib.suppress(KeyError, OSError):
            # Strangers may come by the thousand, and a list be long: a tenth of the time is enough to read it.
            if (began := time.monotonic()) >= self.look_again:
                self.listed = {key_in(path): path for path in sorted(self.folder.glob("allowed/*.key"), reverse=True)}
                self.look_again = time.monotonic() + min(1, 9 * (time.monotonic() - began))
            # First when, then what: a file that is changed in between is read again.
            stamp = (path := self.listed[key]).stat().st_mtime_ns
            if key_in(path) == key:
                self.known[key] = path, stamp
                return path.stem
        return ""

    def _answer(self, zap: zmq.Socket[bytes]) -> None:
        with zap, contextlib.suppress(zmq.ContextTerminated):
            while True:
                if zap.poll(1000):
                    version, request, domain, address, _, mechanism, *credentials = zap.recv_multipart()
                    key = z85.encode(credentials[0]).decode() if mechanism == b"CURVE" and domain == DOMAIN else ""
                    welcome = bool(key and self.name(key))
                    status = [b"200", b"OK", key.encode()] if welcome else [b"400", b"not on the list", b""]
                    zap.send_multipart([version, request, *status, b""])
                    if not welcome:
                        self.refuse(key, address.decode())
                if time.monotonic() > self.told + SPAN:
                    self._tell()

    def refuse(self, key: str, address: str) -> None:
        """One line for each key. How often it came again is told from time to time: no stranger floods the log."""
        if key in self.refused:
            self.refused[key] += 1
        elif self.named < NAMED:
            self.refused[key], self.named = 0, self.named + 1
            self.say(f"refused: key {key} from {address} is not in {self.folder / 'allowed'}")
        else:
            self.others += 1

    def _tell(self) -> None:
        # A copy: a gate refuses on a thread of its own.
        for key, times in list(self.refused.items()):
            if times:
                self.say(f"refused: key {key} {times} times more")
                self.refused[key] = 0
        if self.others:
            self.say(f"refused: other keys, {self.others} times")
        if len(self.refused) > 1000:
            self.refused.clear()
        self.others, self.told, self.named = 0, time.monotonic(), 0
