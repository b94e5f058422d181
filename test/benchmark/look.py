# SPDX-License-Identifier: Apache-2.0
"""What `nacelle look` costs the robot of the default launch file: the server's thread with no viewer, one and ten, and what they change for
the robot's streams. A viewer sees what the page shows on a laptop: scan, transforms, odometry, diagnostics and small pictures.

NACELLE_SHORT: 5 s instead of 30 s.
"""
import json
import os
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
from web_socket import WebSocket  # noqa: E402  (a client of the system tests)

SECONDS = 5 if SHORT else 30
VIEW = ("/scan", "/tf", "/tf_static", "/odom", "/odometry/filtered", "/diagnostics", "/camera/image_raw/look")
RATES = ("/scan", "/imu/data_raw", "/odom", "/odometry/filtered", "/camera/image_raw")


class Viewer:
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

    def close(self):
        self.ends = True
        self.thread.join()
        self.socket.close()


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
            return {stream["name"]: stream["published"] for stream in ask("streams", "--json", "--interval", "0.1")["streams"]}

        try:
            links = ask("look", "--port", "0", "--json")
            for count in (0, 1, 10):
                viewers = [Viewer(links["foxglove_view"]) for _ in range(count)]
                say(f"{count} viewers, {SECONDS} s; load {os.getloadavg()[0]:.2f}")
                time.sleep(1)  # what stays comes at once
                begin, before, streams, had = time.monotonic(), look_s(robot.process.pid), published(), [(viewer.bytes, viewer.pictures) for viewer in viewers]
                time.sleep(SECONDS)  # the length of the measurement
                passed, used, now = time.monotonic() - begin, look_s(robot.process.pid) - before, published()
                for viewer in viewers:
                    viewer.close()
                what = f"look, {count} viewer{'' if count == 1 else 's'}: "
                rates = ", ".join(f"{topic} {(now[topic] - streams[topic]) / passed:.2f}" for topic in RATES)
                yield row("look", what + "its thread", 100 * used / passed, "% of one", at_most((0, 5)[count]) if count < 2 else None, f"Hz: {rates}")
                if viewers:
                    kbit = 8e-3 * sum(viewer.bytes - one[0] for viewer, one in zip(viewers, had)) / passed / count
                    pictures = sum(viewer.pictures - one[1] for viewer, one in zip(viewers, had)) / passed / count
                    yield row("look", what + "messages to each", kbit, "kbit/s", None, f"{pictures:.1f} pictures a second")
        finally:
            robot.close()
