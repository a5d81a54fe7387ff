"""Lesson 06, the router: takes in requests of many clients, hands them to workers in turn, and sends the replies.

Take home: this file, workers.py, server_processes.py, which shows their use, and server.py.
"""

import contextlib
import time
from collections import OrderedDict

import zmq
from workers import Work, Workers, attempt
from zmq.utils.monitor import recv_monitor_message

# The bytes of a text, and of all that wait, whoever sent them: who comes and goes leaves some behind for a while. And
# what a request takes in memory beside its own bytes, roughly.
LIMIT, ALL_LIMIT, OVERHEAD = 65_536, 100_000_000, 300


def footprint(request_id: bytes, text: bytes) -> int:
    return len(request_id) + len(text) + OVERHEAD


class Router:
    """Answers requests over a ROUTER socket, which it alone uses."""

    # What begins so is answered by the router itself: handing it to a worker would cost more than this work.
    at_once: tuple[bytes, ...] = ()

    def __init__(self, socket: zmq.Socket[bytes], workers: Workers, work: Work, queue: int) -> None:
        self.socket, self.workers, self.work, self.queue = socket, workers, work, queue
        # client -> id -> text: the clients in the order in which it is their turn, each with its own queue.
        self.waiting: OrderedDict[bytes, OrderedDict[bytes, bytes]] = OrderedDict()
        self.size = 0
        self.at_work: set[tuple[bytes, bytes]] = set()
        self.monitor = socket.get_monitor_socket(zmq.EVENT_ACCEPTED | zmq.EVENT_DISCONNECTED)

    def serve(self) -> None:
        poller = zmq.Poller()
        for readable in (self.socket, self.workers.bell, self.monitor):
            poller.register(readable, zmq.POLLIN)
        clients, told, said = 0, 0, 0.0
        while True:
            # A poll with a limit, because on Windows Ctrl-C does not interrupt a wait without one.
            poller.poll(200)
            clients += self.newcomers()
            # One such line a second: many that come and go must not fill a disk.
            if clients != told and time.monotonic() >= said + 1:
                print(f"clients: {clients}", flush=True)
                told, said = clients, time.monotonic()
            self.take_in()
            for client, request_id, text in self.workers.finished():
                self.at_work.discard((client, request_id))
                self.reply(client, request_id, text)
            self.hand_out()

    def newcomers(self) -> int:
        """How many clients more there are than before."""
        more = 0
        while self.monitor.poll(0):
            more += 1 if recv_monitor_message(self.monitor)["event"] == zmq.EVENT_ACCEPTED else -1
        return more

    def take_in(self) -> None:
        """Everything that has arrived, up to a limit: one poll for many requests is what makes it fast."""
        receive, more = self.socket.recv, self.socket.getsockopt
        with contextlib.suppress(zmq.Again):
            for _ in range(1000):
                # Frame by frame: recv_multipart asks more questions for each message, and costs a third of the rate.
                client, request_id = receive(zmq.NOBLOCK), receive(zmq.NOBLOCK)
                text = receive(zmq.NOBLOCK) if more(zmq.RCVMORE) else b""
                while more(zmq.RCVMORE):
                    # More frames than two are no request, and the empty text is answered with an error.
                    text = receive(zmq.NOBLOCK)[:0]
                if text.startswith(self.at_once):
                    self.reply(client, request_id, attempt(self.work, text))
                else:
                    self.enqueue(client, request_id, text)

    def enqueue(self, client: bytes, request_id: bytes, text: bytes) -> None:
        mine = self.waiting.get(client, OrderedDict())
        # A retry of what is at work or waits already is done once and answered once.
        if (client, request_id) in self.at_work or request_id in mine:
            return
        if len(mine) >= self.queue:
            self.reply(client, request_id, b"error: busy: %d requests of yours wait already" % self.queue)
        elif self.size + footprint(request_id, text) > ALL_LIMIT:
            self.reply(client, request_id, b"error: busy: %d bytes of requests wait already" % self.size)
        else:
            self.waiting.setdefault(client, mine)[request_id] = text
            self.size += footprint(request_id, text)

    def hand_out(self) -> None:
        """One request of each client in turn, however many one of them has waiting."""
        while self.waiting and self.workers.free:
            client, mine = self.waiting.popitem(last=False)
            request_id, text = mine.popitem(last=False)
            self.size -= footprint(request_id, text)
            self.at_work.add((client, request_id))
            self.workers.take((client, request_id, text))
            if mine:
                self.waiting[client] = mine

    def reply(self, client: bytes, request_id: bytes, text: bytes) -> None:
        if len(text) > LIMIT:
            text = b"error: the reply has %d bytes, the limit is %d" % (len(text), LIMIT)
        try:
            self.socket.send_multipart([client, request_id, text], zmq.NOBLOCK)
        except zmq.Again:
            # It does not read its replies. Keeping them would fill the memory; it may ask again.
            pass
        except zmq.ZMQError:
            # It is gone: nobody waits for the rest of its requests.
            mine = self.waiting.pop(client, OrderedDict())
            self.size -= sum(footprint(*request) for request in mine.items())
