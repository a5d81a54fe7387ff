"""Peers and lines as they should not be: a slow line, a server that breaks ZeroMQ's protocol, and web servers."""

import contextlib
import queue
import socket
import threading
import time
from http.server import ThreadingHTTPServer


def greeting(mechanism=b"NULL"):
    """The first 64 bytes of a peer that speaks ZMTP 3.0 (rfc.zeromq.org/spec/23)."""
    return b"\xff" + bytes(8) + b"\x7f\x03\0" + mechanism.ljust(20, b"\0") + bytes(32)


def ready(kind):
    """The command by which a peer says what kind of socket it is."""
    body = b"\x05READY\x0bSocket-Type" + len(kind).to_bytes(4, "big") + kind
    return bytes([4, len(body)]) + body


def zmtp_frame(body, more=False):
    return bytes([1 if more else 0, len(body)]) + body


# Which kind of socket speaks to which.
PARTNERS = {"REP": "REQ", "ROUTER": "DEALER", "PUB": "SUB", "REQ": "REP", "DEALER": "ROUTER", "SUB": "PUB"}


def cuts_off_what_is_endless(peer):
    """Whether a peer hangs up on who announces a frame of 1 GB, of which nothing comes."""
    peer.settimeout(20)
    with peer.makefile("rb") as stream, contextlib.suppress(ConnectionError):
        peer.sendall(greeting())
        stream.read(64)
        metadata = stream.read(stream.read(2)[1])
        kind = metadata.partition(b"Socket-Type")[2]
        partner = PARTNERS[kind[4 : 4 + kind[3]].decode()].encode()
        peer.sendall(ready(partner))
        peer.sendall(b"\x02" + (2**30).to_bytes(8, "big"))
        try:
            while stream.read1():
                pass
        except TimeoutError:
            return False
    return True


class Listener:
    """Accepts connections on a free port of its own, each served by a thread, and never answers; a context manager."""

    def __enter__(self):
        self.socket = socket.create_server(("127.0.0.1", 0))
        self.endpoint = f"tcp://127.0.0.1:{self.socket.getsockname()[1]}"
        self.open = [self.socket]
        threading.Thread(target=self.accept, daemon=True).start()
        return self

    def accept(self):
        with contextlib.suppress(OSError):
            while True:
                peer, _ = self.socket.accept()
                self.open.append(peer)
                threading.Thread(target=self.served, args=(peer,), daemon=True).start()

    def served(self, peer):
        # The last where a peer left before the byte that was awaited.
        with contextlib.suppress(OSError, AssertionError, IndexError):
            self.serve(peer)

    def serve(self, peer):
        """Serve a peer; it may end in an exception when the peer leaves."""

    def __exit__(self, *_):
        for each in self.open:
            with contextlib.suppress(OSError):
                each.shutdown(socket.SHUT_RDWR)
            each.close()


class SlowLine(Listener):
    """A far server: hands everything on to a near one and back, as late as a line with this round trip does."""

    def __init__(self, endpoint, round_trip):
        self.port, self.round_trip = int(endpoint.rpartition(":")[2]), round_trip

    def cut(self):
        """What is connected now is told that the other side is gone; who connects from now on is served."""
        for each in self.open[1:]:
            with contextlib.suppress(OSError):
                each.shutdown(socket.SHUT_RDWR)

    def serve(self, peer):
        # To connect takes a round trip of its own.
        time.sleep(self.round_trip)
        server = socket.create_connection(("127.0.0.1", self.port))
        self.open.append(server)
        threading.Thread(target=self.copy, args=(server, peer), daemon=True).start()
        self.copy(peer, server)

    def copy(self, source, target):
        on_the_way = queue.SimpleQueue()
        threading.Thread(target=self.deliver, args=(on_the_way, target), daemon=True).start()
        data = b"?"
        while data:
            with contextlib.suppress(OSError):
                data = source.recv(65536)
                on_the_way.put((time.monotonic() + self.round_trip / 2, data))
                continue
            on_the_way.put((0, b""))
            return

    def deliver(self, on_the_way, target):
        data = b"?"
        while data:
            due, data = on_the_way.get()
            time.sleep(max(0.0, due - time.monotonic()))
            with contextlib.suppress(OSError):
                target.sendall(data) if data else target.shutdown(socket.SHUT_WR)


class ProtocolBreaker(Listener):
    """A REP server by hand that answers one request of each connection, and with the reply comes a frame too many."""

    def __init__(self, answer):
        self.answer = answer

    def serve(self, peer):
        with peer.makefile("rb") as stream:
            peer.sendall(greeting() + ready(b"REP"))
            stream.read(64)
            frames, more = [], True
            while more:
                flags = stream.read(1)[0]
                body = stream.read(int.from_bytes(stream.read(8 if flags & 2 else 1), "big"))
                # 4 is a command, 2 a frame of over 255 bytes, 1 one that is not the last.
                if not flags & 4:
                    frames.append(body)
                    more = bool(flags & 1)
            # The way back: an empty frame, and before it the request's number if the client correlates.
            body = frames.index(b"") + 1
            *first, last = [*frames[:body], *self.answer(frames[body:])]
            reply = b"".join(zmtp_frame(part, more=True) for part in first) + zmtp_frame(last)
            # REQ disconnects a peer that sends something without that empty frame.
            peer.sendall(reply + zmtp_frame(b"and no more"))
            stream.read()


@contextlib.contextmanager
def web_server(handler, port=0):
    """A web server in a thread of its own, as long as the with block lasts: its port."""
    with ThreadingHTTPServer(("127.0.0.1", port), handler) as server:
        thread = threading.Thread(target=server.serve_forever)
        thread.start()
        try:
            yield server.server_port
        finally:
            # Forgotten, as by a test that is skipped, it would wait on for whatever has its socket's number next, and
            # a listener of another test, when that is closed, would go on listening for up to half a second.
            server.shutdown()
            thread.join()


class NetMQsFault(Listener):
    """Greets with these bytes, which end NetMQ's own thread."""

    def __init__(self, mechanism, said):
        self.mechanism, self.said = mechanism, said

    def serve(self, peer):
        peer.sendall(greeting(self.mechanism))
        peer.recv(64, socket.MSG_WAITALL)
        peer.sendall(self.said)
        while peer.recv(4096):
            pass
