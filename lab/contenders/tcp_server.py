"""The limit of the performance lab: echoes over a plain TCP socket, with a thread for each client.

Bytes: the length of a message in four bytes, little-endian, then the message; the answer has the same form.
"""

from __future__ import annotations

import socket
import threading


def serve(connection: socket.socket) -> None:
    """Take a whole message before it is answered, as every contender does, into a buffer that is made once."""
    buffer = memoryview(bytearray(65536))
    size = receive(connection, buffer)
    while True:
        while size < 4:
            size += receive(connection, buffer[size:])
        whole = 4 + int.from_bytes(buffer[:4], "little")
        if whole > len(buffer):
            larger = memoryview(bytearray(whole))
            larger[:size] = buffer[:size]
            buffer = larger
        while size < whole:
            size += receive(connection, buffer[size:])
        connection.sendall(buffer[:whole])
        # The rest is the beginning of the next one.
        rest = buffer[whole:size].tobytes()
        buffer[: len(rest)] = rest
        size = len(rest) or receive(connection, buffer)


def receive(connection: socket.socket, buffer: memoryview) -> int:
    size = connection.recv_into(buffer)
    if size == 0:
        raise ConnectionError("the client is gone")
    return size


def main() -> None:
    with socket.create_server(("127.0.0.1", 0), backlog=1024) as listener:
        print(f"listening on tcp://127.0.0.1:{listener.getsockname()[1]}", flush=True)
        while True:
            connection, _ = listener.accept()
            connection.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
            threading.Thread(target=run, args=(connection,), daemon=True).start()


def run(connection: socket.socket) -> None:
    try:
        serve(connection)
    except OSError:
        pass


if __name__ == "__main__":
    main()
