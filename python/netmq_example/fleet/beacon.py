"""The beacon: once a second the hub announces in its network where it is, and `find` hears it. In C#: HubFinder.cs.

    beacon = Beacon("255.255.255.255:5567", "tcp://0.0.0.0:5567", key)        the hub's public key, if it has one
    beacon.tell()                                                             often: it says something once a second
    find(5567, key, timeout=30)                                               "tcp://192.168.0.7:5567"

Bytes: a UDP datagram, `NMQX1 PORT FINGERPRINT` in ASCII; the address is the sender's. The fingerprint is the beginning
of the SHA-256 of the hub's public key, or `-` without keys. Anybody can send such a datagram: so a simulator that has
the hub's key passes over all others, and one without keys trusts its network.
"""

import hashlib
import re
import socket
import time
from typing import Any

from netmq_example import check
from netmq_example.errors import GaveUp


def fingerprint(key: bytes) -> str:
    check.instance("key", key, bytes)
    return hashlib.sha256(key).hexdigest()[:16] if key else "-"


def udp_place(name: str, value: Any) -> str:
    """A rule, as those of check.py: an IPv4 address and a port."""
    parts = re.fullmatch(r"(\d{1,3}(?:\.\d{1,3}){3}):(\d{1,5})", value, re.ASCII) if isinstance(value, str) else None
    if parts and 0 < int(parts[2]) < 65536 and max(map(int, parts[1].split("."))) < 256:
        return str(value)
    raise ValueError(f"{name} takes an address and a port, such as 255.255.255.255:5567, not {value!r:.40}")


class Beacon:
    """Announces at `where`, an address and a UDP port, or nowhere; a broadcast address reaches the whole network."""

    def __init__(self, where: str | None, endpoint: str, key: bytes = b"") -> None:
        self.where: tuple[str, int] | None = None
        if where is not None:
            host, _, port = udp_place("where", where).rpartition(":")
            self.where = host, int(port)
        port = check.endpoint(endpoint, "tcp://127.0.0.1:5567").rpartition(":")[2]
        self.datagram = f"NMQX1 {port} {fingerprint(key)}".encode()
        self.sent = 0.0
        self.trouble = ""
        self.socket = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self.socket.setsockopt(socket.SOL_SOCKET, socket.SO_BROADCAST, 1)
        self.socket.setblocking(False)

    def tell(self) -> None:
        """Called often; it says something once a second. Without a network nobody hears it: that is printed once."""
        if self.where and time.monotonic() > self.sent + 1:
            self.sent = time.monotonic()
            try:
                self.socket.sendto(self.datagram, self.where)
            except OSError as error:
                trouble = str(error.strerror)
                if self.trouble != trouble:
                    self.trouble = trouble
                    cure = "give the broadcast address of your network, such as 192.168.0.255"
                    print(f"cannot announce at {self.where[0]}: {trouble}; {cure}", flush=True)


def find(port: int, key: bytes, timeout: float) -> str:
    """The endpoint of the first hub that is heard and has this key; TimeoutError if there is none."""
    wanted = fingerprint(key)
    check.count("port", port, most=65535)
    end = time.monotonic() + check.seconds("timeout", timeout)
    why = "; is the hub started with --announce, on this network?"
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as ear:
        # Several simulators of one machine listen on the same port.
        ear.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        try:
            ear.bind(("", port))
        except OSError as error:
            raise GaveUp(f"cannot listen on UDP port {port}: {error.strerror}; give --endpoint instead") from None
        ear.settimeout(0.2)
        while time.monotonic() < end:
            try:
                datagram, (address, _) = ear.recvfrom(65_536)
            except TimeoutError:
                continue
            heard = re.fullmatch(rb"NMQX1 (\d{1,5}) ([0-9a-f]{16}|-)", datagram)
            if not heard:
                continue
            if heard[2].decode() != wanted:
                cure = "have both sides the same server.key?" if key else "give its keys"
                why = f", only {'of another key' if key else 'one that has keys'}, {address}; {cure}"
            elif 0 < int(heard[1]) < 65536:
                return f"tcp://{address}:{int(heard[1])}"
    raise TimeoutError(f"no hub was heard on UDP port {port} within {timeout:g} s{why}")
