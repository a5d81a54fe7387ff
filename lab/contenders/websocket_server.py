"""A WebSocket server for the performance lab, with the package websockets on asyncio.

Bytes: one binary message each way. Its first byte says what to do: 1 answers with the same bytes, 0 does nothing, 2
publishes to all clients.
"""

from __future__ import annotations

import asyncio

from websockets.asyncio.server import ServerConnection, broadcast, serve

CLIENTS: set[ServerConnection] = set()


async def act(connection: ServerConnection) -> None:
    CLIENTS.add(connection)
    try:
        async for message in connection:
            if not isinstance(message, bytes):
                continue
            if message[0] == 1:
                await connection.send(message)
            elif message[0] == 2:
                clients, count = (int.from_bytes(message[start : start + 4], "little") for start in (1, 5))
                # The last round's have left, but this server may not know it yet.
                while len(CLIENTS) != clients:
                    await asyncio.sleep(0.001)
                for _ in range(count):
                    broadcast(CLIENTS, message)
                    # The sockets are written to in between.
                    await asyncio.sleep(0)
    finally:
        CLIENTS.remove(connection)


async def main() -> None:
    # Compression costs time and gains nothing on one machine.
    async with serve(act, "127.0.0.1", 0, compression=None, max_size=None, ping_interval=None) as server:
        print(f"listening on tcp://127.0.0.1:{server.sockets[0].getsockname()[1]}", flush=True)
        await server.serve_forever()


if __name__ == "__main__":
    try:
        asyncio.run(main())
    except KeyboardInterrupt:
        pass
