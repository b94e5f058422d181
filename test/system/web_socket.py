# SPDX-License-Identifier: Apache-2.0
"""A WebSocket client (RFC 6455) that speaks Foxglove's protocol, for tests of the server: it can also say what no client should."""
import base64
import hashlib
import json
import os
import socket
import struct
import time
import urllib.parse

SLOW = float(os.environ.get("NACELLE_TEST_SLOWNESS", "1"))  # sanitizers need more patience
TEXT, BINARY, CLOSE, PING, PONG = 1, 2, 8, 9, 10


class Refused(Exception):
    """The server's answer was no welcome; `status` is that of HTTP."""

    def __init__(self, head):
        super().__init__(head)
        self.status = int(head.split()[1]) if head else None


def request(link, path, headers):
    """Sends an HTTP request; returns the socket and the head and body that have come so far."""
    address = urllib.parse.urlsplit(link)
    connection = socket.create_connection((address.hostname, address.port), timeout=10 * SLOW)
    headers = {"Host": address.netloc, **headers}
    lines = "".join(f"{name}: {value}\r\n" for name, value in headers.items() if value is not None)
    connection.sendall(f"GET {path} HTTP/1.1\r\n{lines}\r\n".encode())
    came = b""
    while b"\r\n\r\n" not in came:
        more = connection.recv(4096)
        if not more:
            break
        came += more
    head, _, rest = came.partition(b"\r\n\r\n")
    return connection, head.decode(), rest


def fetch(link, path, **headers):
    """The status, head and body of a page."""
    connection, head, body = request(link, path, {"Connection": "close", **headers})
    with connection:
        while more := connection.recv(65536):
            body += more
    return int(head.split()[1]), head, body


class WebSocket:
    def __init__(self, link, protocols="foxglove.sdk.v1, foxglove.websocket.v1", **headers):
        address = urllib.parse.urlsplit(link)
        key = base64.b64encode(os.urandom(16)).decode()
        wanted = {"Upgrade": "websocket", "Connection": "Upgrade", "Sec-WebSocket-Key": key, "Sec-WebSocket-Version": 13,
                  "Sec-WebSocket-Protocol": protocols, **headers}  # fmt: skip
        self.socket, head, self.came = request(link, f"{address.path}?{address.query}", wanted)
        if " 101 " not in head.split("\r\n")[0]:
            self.socket.close()
            raise Refused(head)
        accepted = base64.b64encode(hashlib.sha1((key + "258EAFA5-E914-47DA-95CA-C5AB0DC85B11").encode()).digest()).decode()
        assert accepted in head, head
        self.head = head
        self.channels, self.services, self.texts, self.messages, self.responses, self.info = {}, {}, [], [], {}, None

    def close(self):
        self.socket.close()

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.close()

    def send_frame(self, kind, payload, is_last=True):
        mask = os.urandom(4)
        size = len(payload)
        short = size if size < 126 else 126 if size < 65536 else 127
        head = bytes([kind | (0x80 if is_last else 0), 0x80 | short]) + (struct.pack(">H", size) if short == 126 else struct.pack(">Q", size) if short == 127 else b"")
        whole = int.from_bytes(payload, "little") ^ int.from_bytes((mask * (size // 4 + 1))[:size], "little")
        self.socket.sendall(head + mask + whole.to_bytes(size, "little"))

    def say(self, op, **fields):
        self.send_frame(TEXT, json.dumps({"op": op, **fields}).encode())

    def _exactly(self, size):
        while len(self.came) < size:
            more = self.socket.recv(1 << 20)
            if not more:
                raise ConnectionError("the server has ended the connection")
            self.came += more
        taken, self.came = self.came[:size], self.came[size:]
        return taken

    def receive_frame(self):
        first, second = self._exactly(2)
        size = second & 127
        if size == 126:
            size = struct.unpack(">H", self._exactly(2))[0]
        elif size == 127:
            size = struct.unpack(">Q", self._exactly(8))[0]
        return first & 15, self._exactly(size)

    def step(self):
        """Takes one frame and keeps what it says."""
        kind, payload = self.receive_frame()
        if kind == PING:
            self.send_frame(PONG, payload)
        elif kind == CLOSE:
            raise ConnectionError(f"closed: {payload}")
        elif kind == TEXT:
            self._take(json.loads(payload))
        elif kind == BINARY and payload[0] == 1:
            subscription, stamp = struct.unpack_from("<IQ", payload, 1)
            self.messages.append((subscription, stamp, payload[13:]))
        elif kind == BINARY and payload[0] == 3:
            service, call, encoding = struct.unpack_from("<III", payload, 1)
            self.responses[call] = payload[13 + encoding:]

    def _take(self, said):
        self.texts.append(said)
        if said["op"] == "serverInfo":
            self.info = said
        elif said["op"] == "advertise":
            self.channels.update({channel["topic"]: channel for channel in said["channels"]})
        elif said["op"] == "unadvertise":
            self.channels = {topic: channel for topic, channel in self.channels.items() if channel["id"] not in said["channelIds"]}
        elif said["op"] == "advertiseServices":
            self.services.update({service["name"]: service for service in said["services"]})

    def until(self, what, condition, limit_s=20):
        """Takes frames until the condition answers something true, and returns that."""
        deadline = time.monotonic() + limit_s * SLOW
        while not (answer := condition()):
            if time.monotonic() > deadline:
                raise AssertionError(f"not within {limit_s} s: {what}; the last texts: {str(self.texts[-3:])[-1000:]}")
            self.socket.settimeout(max(0.01, deadline - time.monotonic()))
            self.step()
        return answer

    def said(self, op, **fields):
        """The texts of an operation that have these fields."""
        return [one for one in self.texts if one["op"] == op and all(one.get(name) == value for name, value in fields.items())]

    def subscribe(self, subscription, topic):
        channel = self.until(topic, lambda: self.channels.get(topic))
        self.say("subscribe", subscriptions=[{"id": subscription, "channelId": channel["id"]}])

    def count(self, subscription):
        return sum(1 for message in self.messages if message[0] == subscription)

    def call(self, number, service, wish=None):
        """Calls a service in JSON; returns its response, or the text of the failure."""
        found = self.until(service, lambda: self.services.get(service))
        data = json.dumps(wish or {}).encode()
        self.send_frame(BINARY, struct.pack("<BIII", 2, found["id"], number, 4) + b"json" + data)
        self.until(f"a response of {service}", lambda: number in self.responses or self.said("serviceCallFailure", callId=number))
        if number in self.responses:
            return json.loads(self.responses[number])
        return self.said("serviceCallFailure", callId=number)[0]["message"]

    def publish(self, channel, message):
        self.send_frame(BINARY, struct.pack("<BI", 1, channel) + json.dumps(message).encode())
