# SPDX-License-Identifier: Apache-2.0
"""What `nacelle look` costs the robot of the default launch file: the server's thread with no viewer, one, ten and a hundred, with ten that
never read and with one that is hostile, and how far the rates of the robot's streams are then from those without a viewer.

A viewer sees what the page shows on a laptop: scan, transforms, odometry, diagnostics and small pictures. Viewers are a process of the
lowest priority, since they would be another machine. NACELLE_SHORT: 5 s instead of 30 s.
"""
import json
import multiprocessing
import os
import random
import subprocess
import sys
import tempfile
import threading
import time
from pathlib import Path

from footprint import SHORT, TICKS, Robot, world
from goals import at_most, row
from measure import Crash

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "system"))
from web_socket import BINARY, TEXT, Refused, WebSocket  # noqa: E402  (a client of the system tests)

SECONDS = 5 if SHORT else 30
VIEW = ("/scan", "/tf", "/tf_static", "/odom", "/odometry/filtered", "/diagnostics", "/camera/image_raw/look")
RATES = ("/scan", "/imu/data_raw", "/odom", "/odometry/filtered", "/camera/image_raw")
CROWDS = {  # what stands in the table: how many, who they are, the goal for the server's thread
    "0 viewers": (0, "readers", at_most(0)),
    "1 viewer": (1, "readers", at_most(5)),
    "10 viewers": (10, "readers", None),
    "100 viewers": (100, "readers", None),
    "10 viewers that never read": (10, "lazy", None),
    "a hostile viewer": (1, "hostile", None),
}


class Reader:
    """Reads as fast as it can, on a thread."""

    def __init__(self, link):
        self.socket = WebSocket(link)
        for number, topic in enumerate(VIEW):
            self.socket.subscribe(number, topic)
        self.bytes, self.pictures, self.ends = 0, 0, False
        self.thread = threading.Thread(target=self.read)
        self.thread.start()

    def read(self):
        self.socket.socket.settimeout(1)
        while not self.ends:
            try:
                self.socket.step()
            except TimeoutError:
                continue
            for subscription, _, data in self.socket.messages:
                self.bytes += len(data)
                self.pictures += subscription == len(VIEW) - 1
            self.socket.messages.clear()

    def end(self):
        self.ends = True
        self.thread.join()


class Lazy:
    """Subscribes to everything, raw pictures too, and never reads again."""

    bytes = pictures = 0

    def __init__(self, link):
        self.socket = WebSocket(link)
        for number, topic in enumerate((*VIEW, "/camera/image_raw")):
            self.socket.subscribe(number, topic)

    def end(self):
        self.socket.close()


class Hostile:
    """Connects, says what no viewer should say as fast as the server takes it, and connects again when it is thrown out."""

    bytes = pictures = 0

    def __init__(self, link):
        self.link, self.ends, self.random = link, False, random.Random(1)
        self.thread = threading.Thread(target=self.attack)
        self.thread.start()

    def attack(self):
        while not self.ends:
            try:
                with WebSocket(self.link) as socket:
                    socket.socket.settimeout(1)
                    while not self.ends:
                        self.say(socket)
            except (OSError, Refused, AssertionError):
                continue

    def say(self, socket):
        number = self.random.randrange(1 << 31)
        socket.send_frame(TEXT, self.random.choice((
            b'{"op":"subscribe","subscriptions":[{"id":%d,"channelId":%d}]}' % (number, number % 64),
            b'{"op":"getParameters","parameterNames":[],"id":"%d"}' % number,
            b'{"op":"setParameters","parameters":[{"name":"/ekf.frequency","value":%d}]}' % number,
            b'{"op":"fetchAsset","requestId":%d,"uri":"package://../../etc/passwd"}' % number,
            b'{"op":"advertise","channels":[{"id":%d,"topic":"/cmd_vel","encoding":"cdr","schemaName":"x"}]}' % number,
            b'{"op":' * 1000, b"[" * 100_000, b"\xff" * 1000)))  # fmt: skip
        socket.send_frame(BINARY, bytes([self.random.randrange(4)]) + self.random.randbytes(self.random.randrange(1 << 12)))

    def end(self):
        self.ends = True
        self.thread.join()


def be_viewers(kind, count, link, pipe):
    os.nice(19)
    viewers = [kind(link) for _ in range(count)]
    pipe.send("here")
    while pipe.recv() == "how much":
        pipe.send((sum(viewer.bytes for viewer in viewers), sum(viewer.pictures for viewer in viewers)))
    for viewer in viewers:
        viewer.end()


class Crowd:
    """Viewers in a process of their own."""

    def __init__(self, kind, count, link):
        self.pipe, theirs = multiprocessing.Pipe()
        self.process = multiprocessing.Process(target=be_viewers, args=(kind, count, link, theirs))
        self.process.start()
        theirs.close()
        self.pipe.recv()

    def had(self):
        """Bytes and pictures of all of them so far."""
        self.pipe.send("how much")
        return self.pipe.recv()

    def close(self):
        self.pipe.send("end")
        self.process.join()


def look_s(process):
    """Seconds that the server's thread has run."""
    for task in Path("/proc", str(process), "task").iterdir():
        if (task / "comm").read_text().strip() == "look":
            stat = (task / "stat").read_text().rpartition(")")[2].split()
            return (int(stat[11]) + int(stat[12])) / TICKS
    raise Crash("there is no thread 'look'")


def look(programs, say):
    program = programs.folder.parent / "bin/nacelle"
    if not program.exists():
        raise Crash(f"{program} is not there: ./dev build")
    with tempfile.TemporaryDirectory(prefix="nacelle-look-", dir="/dev/shm") as name, world(program, Path(name)):
        robot = Robot(program, Path(name), "off")
        environment = {**os.environ, "XDG_RUNTIME_DIR": name}

        def ask(*words):
            done = subprocess.run([program, *words], capture_output=True, text=True, check=True, env=environment)  # noqa: S603
            return json.loads(done.stdout)

        def published():
            """When, and how much each stream has published until then."""
            streams = ask("streams", "--json", "--interval", "0.1")["streams"]
            return time.monotonic(), {stream["name"]: stream["published"] for stream in streams}

        def rates(first, second):
            return {topic: (second[1][topic] - first[1][topic]) / (second[0] - first[0]) for topic in RATES}

        try:
            links = ask("look", "--port", "0", "--json")
            alone = None
            for what, (count, kind, goal) in CROWDS.items():
                crowd = Crowd({"readers": Reader, "lazy": Lazy, "hostile": Hostile}[kind], count, links["foxglove_view"])
                say(f"{what}, {SECONDS} s; load {os.getloadavg()[0]:.2f}")
                time.sleep(1)  # what stays comes at once
                before, begin, had = look_s(robot.process.pid), published(), crowd.had()
                time.sleep(SECONDS)  # the length of the measurement
                used, end, has = look_s(robot.process.pid) - before, published(), crowd.had()
                crowd.close()
                passed, now = end[0] - begin[0], rates(begin, end)
                yield row("look", f"look, {what}: its thread", 100 * used / passed, "% of one", goal, ", ".join(f"{topic} {hz:.2f} Hz" for topic, hz in now.items()))
                if alone is None:
                    alone = now
                    continue
                topic, off = max(((topic, 100 * abs(now[topic] / alone[topic] - 1)) for topic in RATES), key=lambda one: one[1])
                yield row("look", f"look, {what}: a stream's rate is off by", off, "%", at_most(1), topic)
                if kind == "readers":
                    kbit, pictures = 8e-3 * (has[0] - had[0]) / passed / count, (has[1] - had[1]) / passed / count
                    yield row("look", f"look, {what}: messages to each", kbit, "kbit/s", None, f"{pictures:.1f} pictures a second")
        finally:
            robot.close()
