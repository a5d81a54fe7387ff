"""The lab's echo behind a tunnel of SSH, from this machine to this machine, with keys made for it alone.

It needs the programs sshd, ssh and ssh-keygen: on Debian the package openssh-server. The client talks to ssh, ssh to
sshd in secret, and sshd to zmq_server.py.
"""

from __future__ import annotations

import contextlib
import getpass
import shutil
import signal
import socket
import subprocess
import sys
import tempfile
import time
from pathlib import Path


def free_port() -> int:
    with socket.socket() as found:
        found.bind(("127.0.0.1", 0))
        return int(found.getsockname()[1])


def wait_for(port: int) -> None:
    end = time.monotonic() + 20
    while True:
        with contextlib.suppress(OSError), socket.create_connection(("127.0.0.1", port)):
            return
        if time.monotonic() > end:
            sys.exit(f"nobody listens on port {port}: ssh or sshd has printed why")
        time.sleep(0.05)


def main() -> None:
    # sshd wants to be called by its whole path, and is not on everybody's.
    sshd = shutil.which("sshd", path="/usr/sbin:/usr/local/sbin:/usr/bin")
    if not sshd or not shutil.which("ssh"):
        sys.exit("no sshd here: install openssh-server")
    # Where sshd that is started by root keeps itself apart.
    with contextlib.suppress(OSError):
        Path("/run/sshd").mkdir(exist_ok=True)
    behind, gate, front = (free_port() for _ in range(3))
    with contextlib.ExitStack() as stack:
        folder = Path(stack.enter_context(tempfile.TemporaryDirectory()))

        def start(*words: str) -> None:
            program = subprocess.Popen(words, stdin=subprocess.PIPE, stdout=subprocess.DEVNULL)
            stack.callback(program.terminate)

        for name in ("host", "user"):
            subprocess.run(["ssh-keygen", "-q", "-t", "ed25519", "-N", "", "-f", folder / name], check=True)
        options = [f"AuthorizedKeysFile={folder}/user.pub", "StrictModes=no", f"PidFile={folder}/pid", "UsePAM=no"]
        words = ["-D", "-f", "/dev/null", "-h", f"{folder}/host", "-p", str(gate), "-o", "ListenAddress=127.0.0.1"]
        start(sys.executable, str(Path(__file__).with_name("zmq_server.py")), f"tcp://127.0.0.1:{behind}")
        start(sshd, *words, *(word for option in options for word in ("-o", option)))
        wait_for(gate)
        known = ["-o", "StrictHostKeyChecking=no", "-o", f"UserKnownHostsFile={folder}/known", "-o", "LogLevel=ERROR"]
        # Not with -N: before OpenSSH 10.1 sshd sends at once (TCP_NODELAY) only where a command or a shell runs as
        # well. Otherwise the rest of a message waits for the client's next acknowledgement, up to 44 ms.
        way = ["-T", "-L", f"127.0.0.1:{front}:127.0.0.1:{behind}", "-i", f"{folder}/user", "-p", str(gate)]
        start("ssh", *known, *way, f"{getpass.getuser()}@127.0.0.1", "cat")
        wait_for(front)
        print(f"listening on tcp://127.0.0.1:{front}", flush=True)
        # Its processes end with it.
        signal.signal(signal.SIGTERM, lambda *_: sys.exit())
        while True:
            time.sleep(3600)


if __name__ == "__main__":
    main()
