"""A page of lesson 16's tap without a screen, for the performance lab: it takes everything, and draws nothing.

python lab/contenders/page.py http://127.0.0.1:PORT/
"""

from __future__ import annotations

import asyncio
import sys

import aiohttp


async def look(address: str) -> None:
    """Until the tap ends."""
    async with aiohttp.ClientSession() as session, session.ws_connect(f"{address}live", max_msg_size=0) as page:
        async for _ in page:
            pass


if __name__ == "__main__":
    try:
        asyncio.run(look(sys.argv[1]))
    except KeyboardInterrupt:
        pass
