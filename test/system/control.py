# SPDX-License-Identifier: Apache-2.0
"""A client of the container's control socket, for tests that must know to the millisecond what was sent when."""
import math
import socket
import struct
import threading
import time

from robot import SLOW

TWIST, STAMPED, BOOL = "geometry_msgs/msg/Twist", "geometry_msgs/msg/TwistStamped", "std_msgs/msg/Bool"
CLOCK = "rosgraph_msgs/msg/Clock"


def twist(speed_mps, yaw_rate_rps=0.0):
    return b"\0\1\0\0" + struct.pack("<6d", speed_mps, 0, 0, 0, 0, yaw_rate_rps)


def stamped(speed_mps, age_s=0.0):
    # An empty frame_id is a length of 1 and a NUL; the doubles that follow are aligned to 8 behind the header.
    ns = time.time_ns() - int(age_s * 1e9)
    return b"\0\1\0\0" + struct.pack("<iIIc3x6d", ns // 10**9, ns % 10**9, 1, b"\0", speed_mps, 0, 0, 0, 0, 0)


def boolean(value):
    return b"\0\1\0\0" + struct.pack("<?", value)


def clock(time_s):
    return b"\0\1\0\0" + struct.pack("<iI", int(time_s), int(time_s % 1 * 1e9))


class Control:
    """Frames: length (u32), kind (a letter), payload; see interfaces/base/include/nacelle/base/frame.hpp."""

    def __init__(self, path):
        self.socket = socket.socket(socket.AF_UNIX, socket.SOCK_STREAM)
        self.socket.settimeout(10 * SLOW)
        self.socket.connect(str(path))

    def send(self, kind, payload):
        self.socket.sendall(struct.pack("<Ic", len(payload), kind) + payload)

    def read(self, count):
        got = b""
        while len(got) < count:
            more = self.socket.recv(count - len(got))
            if not more:
                raise ConnectionError("the container closed the connection")
            got += more
        return got

    def receive(self):
        length, kind = struct.unpack("<Ic", self.read(5))
        return kind, self.read(length)

    def open_writer(self, topic, type_name):
        self.send(b"w", topic.encode() + b"\0" + type_name.encode())
        kind, payload = self.receive()
        if kind != b"o":
            raise RuntimeError(payload.decode(errors="replace"))
        return payload

    def publish(self, handle, cdr):
        """Returns the monotonic time in ns just before it was sent."""
        before = time.monotonic_ns()
        self.send(b"p", handle + cdr)
        return before

    def close(self):
        self.socket.close()


class Sender(threading.Thread):
    """Publishes what make() gives, at a rate, until it is stopped; a pause is silence."""

    def __init__(self, path, topic, type_name, make, rate_hz=20.0):
        super().__init__(daemon=True)
        self.control = Control(path)
        self.handle = self.control.open_writer(topic, type_name)
        self.make = make
        self.period_s = 1.0 / rate_hz
        self.changed = threading.Condition()
        self.paused = self.ended = False
        self.sent_ns = 0
        self.start()

    def run(self):
        with self.changed:
            while not self.ended:
                if not self.paused:
                    try:
                        self.sent_ns = self.control.publish(self.handle, self.make())
                    except OSError:
                        return  # the container is gone
                self.changed.wait(None if self.paused else self.period_s)

    def say(self, make):
        """Publishes another message from now on, starting at once. Returns the time at which the old one was last published."""
        with self.changed:
            last = self.sent_ns
            self.make, self.paused = make, False
            self.changed.notify()
            return last

    def pause(self):
        with self.changed:
            self.paused = True
            return self.sent_ns

    def stop(self):
        with self.changed:
            self.ended = True
            self.changed.notify()
        self.join()
        self.control.close()


NAN = math.nan
