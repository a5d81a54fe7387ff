"""Lesson 06, a second server: the same, and by heartbeats it knows within two seconds that a client is gone.

    python python/06_many_in_flight/server_heartbeats.py        prints: listening on tcp://127.0.0.1:5556
    python python/06_many_in_flight/client.py                   and there: clients: 1, later clients: 0

Without heartbeats a server learns of a pulled cable only when it sends, and then after minutes. Trouble on command:
stop a whole client with Ctrl-Z. Take home: this file and server.py.
"""

import argparse
import contextlib
import signal
import sys
from threading import Thread

import zmq
from server import ENDPOINT, LARGEST, add_options, endpoint, serve
from zmq.utils.monitor import recv_monitor_message


def count(monitor: zmq.Socket[bytes]) -> None:
    """How many clients there are, at most twice a second: many that come and go must not fill a disk."""
    clients = told = 0
    # At the end the context closes it.
    with contextlib.suppress(zmq.ZMQError), monitor:
        while True:
            while monitor.poll(200):
                clients += 1 if recv_monitor_message(monitor)["event"] == zmq.EVENT_ACCEPTED else -1
            if clients != told:
                print(f"clients: {clients}", flush=True)
                told = clients


def main() -> None:
    # In a pipe Windows would use another encoding, and a character that it lacks would end the program.
    sys.stdout.reconfigure(encoding="utf-8", errors="replace")  # type: ignore[union-attr]
    parser = argparse.ArgumentParser(description="Answers many clients, and knows which are there.")
    parser.add_argument("--endpoint", type=endpoint, default=ENDPOINT, help="port 0 takes a free one")
    parser.add_argument("--open-to-anyone", action="store_true", help="also from other machines, without keys")
    add_options(parser)
    options = parser.parse_args()
    # SIGTERM, which kill and process managers send, ends the server as Ctrl-C does.
    signal.signal(signal.SIGTERM, signal.default_int_handler)
    with zmq.Context() as context, context.socket(zmq.ROUTER) as socket:
        socket.linger, socket.maxmsgsize, socket.rcvtimeo = 0, LARGEST, 200
        # Asks a silent client every 0.5 s whether it is there, and takes it for dead when 1 s brings no answer.
        # libzmq answers by itself on a thread of its own: a busy program is not a dead one.
        socket.heartbeat_ivl, socket.heartbeat_timeout = 500, 1000
        try:
            socket.bind(options.endpoint)
        except zmq.ZMQError as error:
            sys.exit(f"cannot listen on {options.endpoint}: {zmq.strerror(error.errno or 0)}")
        monitor = socket.get_monitor_socket(zmq.EVENT_ACCEPTED | zmq.EVENT_DISCONNECTED)
        Thread(target=count, args=(monitor,), daemon=True).start()
        print(f"listening on {socket.getsockopt_string(zmq.LAST_ENDPOINT)}", flush=True)
        serve(socket, options)


if __name__ == "__main__":
    with contextlib.suppress(KeyboardInterrupt):
        main()
