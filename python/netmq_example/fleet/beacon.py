"""Lesson 17, the beacon: once a second the hub tells its network where it is, and `find` hears it. The
twin of HubFinder.cs.

Bytes: a UDP datagram, `NMQX1 PORT FINGERPRINT` in ASCII; the address is the sender's. The fingerprint is the beginning
of the SHA-256 of the hub's public key, or `-` without keys. Anybody can send such a datagram: so a simulator that has
the hub's key passes over all others, and one without keys trusts its network.
"""

import contextlib
import hashlib
import re
import socket
import time


def fingerprint(key: bytes) -> str:
    return hashlib.sha256(key).hexdigest()[:16] if key else "-"


class Beacon:
    """Tells `where`, an address and a UDP port, or nobody; a broadcast address reaches the whole network."""

    def __init__(self, where: tuple[str, int] | None, endpoint: str, key: bytes = b"") -> None:
        self.where, self.told, self.said = where, 0.0, ""
        self.datagram = f"NMQX1 {endpoint.rpartition(':')[2]} {fingerprint(key)}".encode()
        self.socket = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self.socket.setsockopt(socket.SOL_SOCKET, socket.SO_BROADCAST, 1)
        self.socket.setblocking(False)

    def tell(self) -> None:
        """Called often; it says something once a second. Without a network nobody hears it: that is printed once."""
        if self.where and time.monotonic() > self.told + 1:
            self.told = time.monotonic()
            try:
                self.socket.sendto(self.datagram, self.where)
            except OSError as error:
                if self.said != (why := str(error.strerror)):
                    self.said = why
                    cure = "give the broadcast address of your network, such as 192.168.0.255"
                    print(f"cannot announce at {self.where[0]}: {why}; {cure}", flush=True)


def find(port: int, key: bytes, timeout: float) -> str:
    """The endpoint of the first hub that is heard and has this key; TimeoutError if there is none."""
    end, own = time.monotonic() + timeout, fingerprint(key)
    why = "; is the hub started with --announce, on this network?"
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as ear:
        # Several simulators of one machine listen on the same port.
        ear.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        try:
            ear.bind(("", port))
        except OSError as error:
            raise TimeoutError(f"cannot listen on UDP port {port}: {error.strerror}; give --endpoint instead") from None
        ear.settimeout(0.2)
        while time.monotonic() < end:
            with contextlib.suppress(TimeoutError):
                datagram, (address, _) = ear.recvfrom(65_536)
                told = re.fullmatch(rb"NMQX1 (\d{1,5}) ([0-9a-f]{16}|-)", datagram)
                if told and told[2].decode() == own and 0 < int(told[1]) < 65536:
                    return f"tcp://{address}:{int(told[1])}"
                if told and told[2].decode() != own:
                    cure = "have both sides the same server.key?" if key else "give its keys"
                    why = f", only {'of another key' if key else 'one that has keys'}, {address}; {cure}"
    raise TimeoutError(f"no hub was heard on UDP port {port} within {timeout:g} s{why}")
