"""The beacon: a client asks its network for a server by name, and the server answers. In C# it is BeaconSearch.cs.

    python python/03_publish_subscribe/server.py --endpoint tcp://0.0.0.0:5553 --open-to-anyone --beacon lab
    python python/03_publish_subscribe/client.py --endpoint beacon://lab:5553

Bytes: UDP datagrams in ASCII, on the port number that the server has for TCP. `NMQX2 lab?` asks and `NMQX2 lab!`
answers; the server is where the answer comes from. The question goes to this machine and, by broadcast, to each of
its networks; after half a second without an answer also to each of the 254 addresses around one's own, since iOS sends
no broadcast and some networks carry none. Anybody can answer: who the server is, only lesson 15's keys prove.
"""

import contextlib
import logging
import re
import socket
import sys
import threading
import time
from collections.abc import Iterator
from typing import Any

from netmq_example.errors import Error
from netmq_example.trouble import cure

if sys.platform != "win32":
    import fcntl

    # SIOCGIFADDR and SIOCGIFNETMASK of `man 7 netdevice`, and macOS's.
    ADDRESS_AND_MASK = (0x8915, 0x891B) if sys.platform == "linux" else (0xC0206921, 0xC0206925)

# From one question to the next, in seconds.
ROUND = 0.5
# From one piece of a question to the next, where the system takes no more at once.
PIECE = 0.02
# More than any question or answer. A longer datagram is cut off, or refused.
DATAGRAM_BYTES = 100
EVERYBODY = ("127.0.0.1", "255.255.255.255")
MOST_NETWORKS = 4
NAME = "[A-Za-z0-9._-]{1,32}"

log = logging.getLogger("netmq_example.server")


def beacon_name(name: str, value: Any) -> str:
    """A rule, as those of check.py: what a server is asked for by."""
    if isinstance(value, str) and re.fullmatch(NAME, value):
        return value
    raise ValueError(f"{name} takes 1 to 32 letters, digits, dots and dashes, without umlauts, not {value!r:.40}")


def datagram(name: str, mark: str) -> bytes:
    return f"NMQX2 {name}{mark}".encode()


@contextlib.contextmanager
def answering(name: str | None, endpoint: str) -> Iterator[None]:
    """Answers for a server that is bound to tcp://ADDRESS:PORT, on a thread, and logs its beacon. Error if nobody
    could hear it. Without a name nothing is done.
    """
    if not name:
        yield
        return
    host, _, port = endpoint.partition("://")[2].rpartition(":")
    if host.startswith("127."):
        cure = f"give the endpoint tcp://0.0.0.0:{port}, with --open-to-anyone, open_to_anyone or keys"
        raise Error(f"no beacon for {endpoint}, which no other machine reaches: {cure}")
    over = threading.Event()
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as ear:
        try:
            ear.bind((host, int(port)))
        except OSError as error:
            raise Error(f"no beacon on UDP port {port}: {error.strerror}; give --endpoint another port") from None
        ear.settimeout(0.2)
        thread = threading.Thread(target=answer, args=(ear, name, over), daemon=True, name="netmq_example beacon")
        thread.start()
        log.info("found as beacon://%s:%s", name, port)
        try:
            yield
        finally:
            over.set()
            thread.join()


def answer(ear: socket.socket, name: str, over: threading.Event) -> None:
    # The wait leaves the processor to the server, however many datagrams come.
    while not over.wait(0.001):
        # Windows also reports here that somebody did not wait for an answer.
        with contextlib.suppress(OSError):
            heard, sender = ear.recvfrom(DATAGRAM_BYTES)
            if heard == datagram(name, "?"):
                ear.sendto(datagram(name, "!"), sender)


class BeaconSearch:
    """Where an endpoint is: tcp:// where it says, beacon:// where its server answers."""

    def __init__(self, endpoint: str) -> None:
        self.endpoint = endpoint
        named = re.fullmatch(rf"beacon://({NAME}):([0-9]+)", endpoint)
        self.name, self.port = (named[1], int(named[2])) if named else ("", 0)
        self.ear: socket.socket | None = None
        self.due = 0.0
        # How many questions had no answer yet, by which broadcasts, who is still to be asked, and who was.
        self.vain = 0
        self.broadcasts: list[str] = []
        self.unasked: list[str] = []
        self.asked: set[str] = set()

    def find(self, wait: float) -> str:
        """Such as tcp://192.168.0.7:5553; an empty text if there is no answer within so many seconds."""
        if not self.name:
            return self.endpoint
        end = time.monotonic() + wait
        while True:
            if not self.ear or time.monotonic() >= self.due:
                self.begin_question()
            self.ask()
            pause = PIECE if self.unasked else ROUND
            where = self.hear(min(end, self.due, time.monotonic() + pause) - time.monotonic())
            if where or time.monotonic() >= end:
                return where

    def begin_question(self) -> None:
        if not self.ear:
            self.ear = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
            self.ear.setsockopt(socket.SOL_SOCKET, socket.SO_BROADCAST, 1)
        here = networks()
        self.broadcasts = [EVERYBODY[1], *here.values()]
        near = dict.fromkeys(address.rpartition(".")[0] for address in here)
        numbers = range(1, 255) if self.vain else []
        around = [f"{network}.{last}" for network in list(near)[:MOST_NETWORKS] for last in numbers]
        # Those that the last question did not reach come before the others.
        self.unasked = list(dict.fromkeys([EVERYBODY[0], *self.broadcasts, *self.unasked, *around]))
        self.vain += 1
        self.due = time.monotonic() + ROUND

    def ask(self) -> None:
        assert self.ear
        self.ear.setblocking(False)
        while self.unasked:
            # Where one of them cannot be asked, others can.
            with contextlib.suppress(OSError):
                try:
                    self.ear.sendto(datagram(self.name, "?"), (self.unasked[0], self.port))
                    self.asked.add(self.unasked[0])
                except BlockingIOError:
                    # The system has no room for more: it takes them a moment later.
                    return
            del self.unasked[0]

    def hear(self, wait: float) -> str:
        assert self.ear
        self.ear.settimeout(max(0.0, wait))
        try:
            heard, (address, port) = self.ear.recvfrom(DATAGRAM_BYTES)
        except OSError:
            return ""
        if heard != datagram(self.name, "!") or port != self.port:
            return ""
        self.close()
        return f"tcp://{address}:{port}"

    def cure(self, otherwise: str) -> str:
        """Says where to look when nothing came: at the network, as long as nobody has answered."""
        if not self.vain:
            return cure(self.endpoint, otherwise)
        broadcasts = [each for each in dict.fromkeys(self.broadcasts) if each in self.asked]
        single = len(self.asked) - len(broadcasts)
        return (
            f"asked {', '.join(broadcasts) or 'no network'} and {single} single addresses: "
            f"is a server with --beacon {self.name} in this network, and that no guest network, does its firewall "
            f"let in UDP and TCP port {self.port}, and may this program use the local network?"
        )

    def close(self) -> None:
        """The next search begins anew."""
        if self.ear:
            self.ear.close()
        self.ear = None
        self.vain = 0
        self.unasked = []
        self.asked = set()


def networks() -> dict[str, str]:
    """The addresses of this machine, and for each the one of its network's broadcasts. The way out comes first."""
    found: list[str] = []
    masks: dict[str, str] = {}
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as probe:
        with contextlib.suppress(OSError):
            # This sends nothing: it is the system's choice of one's own address that counts.
            probe.connect(("198.51.100.1", 9))
            found.append(probe.getsockname()[0])
        if sys.platform == "win32":
            with contextlib.suppress(OSError):
                found += socket.gethostbyname_ex(socket.gethostname())[2]
        else:
            for _, device in socket.if_nameindex():
                with contextlib.suppress(OSError):
                    # A struct ifreq, with the name before and the address after.
                    ifreq = device.encode().ljust(40, b"\0")
                    address, mask = (fcntl.ioctl(probe, request, ifreq)[20:24] for request in ADDRESS_AND_MASK)
                    found.append(socket.inet_ntoa(address))
                    masks[found[-1]] = socket.inet_ntoa(mask)
    return {each: broadcast(each, masks.get(each, "")) for each in found if not each.startswith("127.")}


def broadcast(address: str, mask: str) -> str:
    """Of the address's network. Where its mask is not known: a plain cable is a /16, and most others are a /24."""
    mask = mask or ("255.255.0.0" if address.startswith("169.254.") else "255.255.255.0")
    pairs = zip(socket.inet_aton(address), socket.inet_aton(mask), strict=True)
    return socket.inet_ntoa(bytes(mine | (255 - fixed) for mine, fixed in pairs))
