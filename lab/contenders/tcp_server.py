"""The limit of the performance lab: echoes over a plain TCP socket, with a thread for each client.

Bytes: the length of a message in four bytes, little-endian, then the message; the answer has the same form. The first
byte of a message says what to do with it: 1 answers with the same bytes, 0 does nothing, 2 publishes to all clients.
"""

from __future__ import annotations

import socket
import threading
import time

CLIENTS: list[socket.socket] = []


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
        act(connection, buffer[:whole])
        # What came behind it is the beginning of the next one.
        rest = buffer[whole:size].tobytes()
        buffer[: len(rest)] = rest
        size = len(rest) or receive(connection, buffer)


def receive(connection: socket.socket, buffer: memoryview) -> int:
    size = connection.recv_into(buffer)
    if size == 0:
        raise ConnectionError("the client is gone")
    return size


def act(connection: socket.socket, message: memoryview) -> None:
    if message[4] == 1:
        connection.sendall(message)
    elif message[4] == 2:
        clients, count = (int.from_bytes(message[start : start + 4], "little") for start in (5, 9))
        # The last round's have left, but their threads may not know it yet.
        while len(CLIENTS) != clients:
            time.sleep(0.001)
        for _ in range(count):
            for client in CLIENTS:
                client.sendall(message)


def main() -> None:
    with socket.create_server(("127.0.0.1", 0), backlog=1024) as listener:
        print(f"listening on tcp://127.0.0.1:{listener.getsockname()[1]}", flush=True)
        while True:
            connection, _ = listener.accept()
            connection.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
            threading.Thread(target=run, args=(connection,), daemon=True).start()


def run(connection: socket.socket) -> None:
    CLIENTS.append(connection)
    try:
        serve(connection)
    except OSError:
        pass
    CLIENTS.remove(connection)


if __name__ == "__main__":
    try:
        main()
    except KeyboardInterrupt:
        pass
