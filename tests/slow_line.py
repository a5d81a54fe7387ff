"""A far server on this machine: a TCP proxy that hands everything on late, as a line with a long round trip does."""

from __future__ import annotations

import contextlib
import queue
import socket
import threading
import time


@contextlib.contextmanager
def slow_line(endpoint, round_trip):
    """Where to connect instead of the endpoint, as long as the with block lasts."""
    port, ends = int(endpoint.rpartition(":")[2]), []

    def copy(source, target):
        waiting = queue.SimpleQueue()

        def deliver():
            with contextlib.suppress(OSError):
                while True:
                    due, data = waiting.get()
                    time.sleep(max(0.0, due - time.monotonic()))
                    if not data:
                        break
                    target.sendall(data)
                target.shutdown(socket.SHUT_WR)

        threading.Thread(target=deliver, daemon=True).start()
        data = b"?"
        while data:
            try:
                data = source.recv(65536)
            except OSError:
                data = b""
            waiting.put((time.monotonic() + round_trip / 2, data))

    def serve(near):
        # To connect takes a round trip of its own.
        time.sleep(round_trip)
        with contextlib.suppress(OSError):
            far = socket.create_connection(("127.0.0.1", port))
            ends.append(far)
            threading.Thread(target=copy, args=(far, near), daemon=True).start()
            copy(near, far)

    def accept(listener):
        with contextlib.suppress(OSError):
            while True:
                near, _ = listener.accept()
                ends.append(near)
                threading.Thread(target=serve, args=(near,), daemon=True).start()

    with socket.create_server(("127.0.0.1", 0)) as listener:
        threading.Thread(target=accept, args=(listener,), daemon=True).start()
        try:
            yield f"tcp://127.0.0.1:{listener.getsockname()[1]}"
        finally:
            for end in [listener, *ends]:
                with contextlib.suppress(OSError):
                    end.shutdown(socket.SHUT_RDWR)
            for end in ends:
                end.close()
