"""The allow-list: a server lets in the clients whose public keys it has, and knows with each message whose it is.

    allowed = AllowList(Path("keys"))      the server's own pair, and the keys in keys/allowed
    allowed.answer(context)                from now on it is asked about each handshake; before bind
    allowed.guard(socket)                  the socket gets its keys, and asks; before bind
    frame = socket.recv_multipart(copy=False)[-1]
    allowed.name_of(frame)                 whose message it is; an empty text if the key is not on the list

CURVE encrypts, and proves that the client has the secret key that belongs to its public one. Which keys may come in,
libzmq asks by ZAP (RFC 27): a request to the address inproc://zeromq.zap.01. pyzmq has an authenticator that answers,
zmq.auth.thread; on Windows it needs tornado, and it does not say which key was refused. So here is one of twenty lines.
"""

import logging
import threading
import time
from pathlib import Path

import zmq
from zmq.utils import z85

from netmq_example import arguments, check
from netmq_example.errors import ListenError
from netmq_example.program import Context, Socket
from netmq_example.security.keys import example, key_in, listed, load
from netmq_example.trouble import Trouble

DOMAIN = b"lesson"
Stamp = tuple[int, int, int]
# How often it is reported that refused keys came again, and how many new ones are named meanwhile.
REPORT_SECONDS = 5.0
MOST_NAMED = 10
# Of so many refused keys it is kept how often they came again.
MOST_COUNTED = 1000

log = logging.getLogger("netmq_example.security")


class AllowList:
    """The clients that may come in: the files in allowed/, as they are at this moment. For any thread."""

    def __init__(self, folder: Path | str) -> None:
        """ValueError if there is no server.key_secret in this folder. Each refused key is logged as a warning."""
        # In full: there may be more than one folder `keys`, and a key enrolled in the wrong one is noticed so.
        self.folder = arguments.path("folder", folder).absolute()
        self.public, self.secret = load(self.folder / "server.key_secret")
        self.trouble = Trouble(log.warning)
        self.listed: dict[str, Path] = {}
        self.look_again = 0.0
        # Each key that was let in, with its file and the stamp that the file had then.
        self.known: dict[str, tuple[Path, Stamp]] = {}
        # How often each refused key came again, and what was refused without being named.
        self.refused: dict[str, int] = {}
        self.others = 0
        self.named = 0
        self.reported = time.monotonic()

    def guard(self, socket: Socket) -> None:
        """Before bind."""
        check.instance("socket", socket, zmq.Socket)
        socket.curve_server = True
        socket.curve_secretkey = self.secret
        # Without a domain that must be asked about, anybody with the server's public key comes in when nobody answers.
        socket.zap_domain = DOMAIN
        socket.setsockopt(zmq.ZAP_ENFORCE_DOMAIN, 1)

    def answer(self, context: Context) -> None:
        """Begin to answer libzmq's questions, on a thread of its own, until the context ends. Before bind."""
        check.instance("context", context, zmq.Context)
        # Of the same context, which through this name does not know it: a socket is closed on its own thread.
        zap: Socket = zmq.Context.shadow(context.underlying).socket(zmq.REP)
        zap.linger = 0
        try:
            zap.bind("inproc://zeromq.zap.01")
        except zmq.ZMQError:
            zap.close()
            raise ValueError("this context has an allow-list, or had one: make a new context for this one") from None
        threading.Thread(target=self._answer, args=(zap,), daemon=True, name="netmq_example keys").start()

    def name_of(self, frame: zmq.Frame) -> str:
        """Asked with each message: the handshake of a revoked key may have been long ago."""
        return self.name(self.key_of(frame))

    def key_of(self, frame: zmq.Frame) -> str:
        """The client's public key; an empty text if nobody was asked at the handshake."""
        if not isinstance(frame, zmq.Frame):
            raise ValueError(f"frame takes a zmq.Frame, as recv_multipart(copy=False) gives it, not {frame!r:.40}")
        try:
            return str(frame.get("User-Id"))
        except zmq.ZMQError:
            return ""

    def name(self, key: str) -> str:
        """The name under which a key is on the list; an empty text if it is not."""
        check.instance("key", key, str)
        # An empty key would be that of a file that holds none.
        if not key:
            return ""
        if key in self.known:
            path, stamp = self.known[key]
            if stamp_of(path) == stamp:
                return path.stem
        return self._look_up(key)

    def _look_up(self, key: str) -> str:
        try:
            return self._read_list(key)
        except OSError as error:
            # As many connections of strangers as files may be open. The thread that answers libzmq must outlive that.
            self.trouble(f"cannot read the list: {error.strerror}; nobody new comes in until that is over")
            return ""

    def _read_list(self, key: str) -> str:
        # Strangers may come by the thousand, and a list be long: a tenth of the time is enough to read it.
        began = time.monotonic()
        if began >= self.look_again:
            try:
                self.listed = {key_in(path): path for path in reversed(listed(self.folder))}
            finally:
                self.look_again = time.monotonic() + min(1, 9 * (time.monotonic() - began))
        if key not in self.listed:
            return ""
        path = self.listed[key]
        # First when, then what: a file that is changed in between is read again.
        stamp = stamp_of(path)
        if stamp is None or key_in(path) != key:
            return ""
        self.known[key] = path, stamp
        return path.stem

    def _answer(self, zap: Socket) -> None:
        with zap:
            try:
                while True:
                    if zap.poll(1000):
                        self._answer_one(zap)
                    if time.monotonic() > self.reported + REPORT_SECONDS:
                        self.report_again()
            except zmq.ContextTerminated:
                pass

    def _answer_one(self, zap: Socket) -> None:
        version, request, domain, address, _, mechanism, *credentials = zap.recv_multipart()
        key = z85.encode(credentials[0]).decode() if mechanism == b"CURVE" and domain == DOMAIN else ""
        welcome = bool(self.name(key))
        status = [b"200", b"OK", key.encode()] if welcome else [b"400", b"not on the list", b""]
        zap.send_multipart([version, request, *status, b""])
        if not welcome:
            self.refuse(key, address.decode())

    def refuse(self, key: str, address: str) -> None:
        """Report a refused key once, and count how often it comes again: no stranger floods the log."""
        if key in self.refused:
            self.refused[key] += 1
        elif self.named < MOST_NAMED:
            self.refused[key] = 0
            self.named += 1
            log.warning("refused: key %s from %s is not in %s", key, address, self.folder / "allowed")
        else:
            self.others += 1

    def report_again(self) -> None:
        """Report how often refused keys came again since the last time."""
        # A copy: a gate refuses on a thread of its own.
        for key, times in list(self.refused.items()):
            if times:
                log.warning("refused: key %s %s times more", key, times)
                self.refused[key] = 0
        if self.others:
            log.warning("refused: other keys, %s times", self.others)
        if len(self.refused) > MOST_COUNTED:
            self.refused.clear()
        self.others = 0
        self.named = 0
        self.reported = time.monotonic()


def stamp_of(path: Path) -> Stamp | None:
    """Another file may have the same time: a copy keeps it, and an archive may give one time to all."""
    try:
        found = path.stat()
    except OSError:
        return None
    return found.st_mtime_ns, found.st_ctime_ns, found.st_ino


def keys_for(folder: Path | str, make: bool = False) -> AllowList:
    """A server's allow-list. ListenError: it can have none. With `make` it makes its first keys."""
    try:
        if make and not Path(folder).exists():
            example(Path(folder))
            log.info("keys: made %s, with this server's and one client's, alice", Path(folder).absolute())
        return AllowList(folder)
    except (ValueError, OSError) as error:
        raise ListenError(0, str(error)) from None
