"""Lesson 06, the router: takes requests of many clients in, lets workers have them in turn, and sends replies out.

Take home: this file and workers.py, with server.py as the example of their use.
"""

from __future__ import annotations

from collections import OrderedDict

import zmq
from workers import Workers
from zmq.utils.monitor import recv_monitor_message


class Router:
    """Answers requests over a ROUTER socket, which it alone uses."""

    def __init__(self, socket: zmq.Socket[bytes], workers: Workers, queue: int) -> None:
        self.socket, self.workers, self.queue = socket, workers, queue
        # client -> id -> text: the clients in the order in which it is their turn, each with its own queue.
        self.waiting: OrderedDict[bytes, OrderedDict[bytes, bytes]] = OrderedDict()
        self.at_work: set[tuple[bytes, bytes]] = set()
        self.monitor = socket.get_monitor_socket(zmq.EVENT_ACCEPTED | zmq.EVENT_DISCONNECTED)

    def serve(self) -> None:
        poller = zmq.Poller()
        for readable in (self.socket, self.workers.bell, self.monitor):
            poller.register(readable, zmq.POLLIN)
        clients = 0
        while True:
            # A poll with a limit, because on Windows Ctrl-C does not interrupt a wait without one.
            ready = dict(poller.poll(200))
            if self.monitor in ready:
                clients += 1 if recv_monitor_message(self.monitor)["event"] == zmq.EVENT_ACCEPTED else -1
                print(f"clients: {clients}", flush=True)
            if self.socket in ready:
                self.take_in()
            for client, request_id, text in self.workers.finished():
                self.at_work.discard((client, request_id))
                self.reply(client, request_id, text)
            self.hand_out()

    def take_in(self) -> None:
        """Everything that has arrived, up to a limit: one poll for many requests is what makes it fast."""
        receive, more = self.socket.recv, self.socket.getsockopt
        try:
            for _ in range(1000):
                # Frame by frame: recv_multipart asks more questions for each message, and costs a third of the rate.
                client, request_id = receive(zmq.NOBLOCK), receive(zmq.NOBLOCK)
                text = receive(zmq.NOBLOCK) if more(zmq.RCVMORE) else b""
                while more(zmq.RCVMORE):
                    # More frames than two are no request, and the empty text is answered with an error.
                    text = receive(zmq.NOBLOCK)[:0]
                # Handing it to a worker's thread would cost more than this answer.
                if text.startswith(b"echo "):
                    self.reply(client, request_id, text[5:])
                else:
                    self.enqueue(client, request_id, text)
        except zmq.Again:
            pass

    def enqueue(self, client: bytes, request_id: bytes, text: bytes) -> None:
        # A retry of what is at work or waits already is done once and answered once.
        if (client, request_id) in self.at_work:
            return
        mine = self.waiting.setdefault(client, OrderedDict())
        if len(mine) >= self.queue and request_id not in mine:
            self.reply(client, request_id, b"error: busy: %d requests of yours wait already" % self.queue)
        else:
            mine[request_id] = text

    def hand_out(self) -> None:
        """One request of each client in turn, however many one of them has waiting."""
        while self.waiting and self.workers.free:
            client, mine = self.waiting.popitem(last=False)
            request_id, text = mine.popitem(last=False)
            self.at_work.add((client, request_id))
            self.workers.take((client, request_id, text))
            if mine:
                self.waiting[client] = mine

    def reply(self, client: bytes, request_id: bytes, text: bytes) -> None:
        try:
            self.socket.send(client, zmq.SNDMORE | zmq.NOBLOCK)
            self.socket.send(request_id, zmq.SNDMORE)
            self.socket.send(text)
        except zmq.Again:
            # It does not read its replies. Keeping them would fill the memory; it may ask again.
            pass
        except zmq.ZMQError:
            # It is gone: nobody waits for the rest of its requests.
            self.waiting.pop(client, None)
