"""Lines of JSON with a picture in Base64, for the performance lab: what many first programs do.

It answers with the same picture.
"""

from __future__ import annotations

import base64
import json
import socketserver


class Handler(socketserver.StreamRequestHandler):
    disable_nagle_algorithm = True

    def handle(self) -> None:
        for line in self.rfile:
            image = base64.b64decode(json.loads(line)["image"])
            self.wfile.write(json.dumps({"image": base64.b64encode(image).decode()}).encode() + b"\n")


class Server(socketserver.ThreadingTCPServer):
    daemon_threads = True


if __name__ == "__main__":
    with Server(("127.0.0.1", 0), Handler) as server:
        print(f"listening on tcp://127.0.0.1:{server.server_address[1]}", flush=True)
        server.serve_forever()
