#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Prints the odometry and IMU messages of a ROS 1 bag (version 2.0), one a line: kind, topic, time of the recording, stamp, numbers.

usage: ros1_bag_messages.py FILE.bag > FILE.txt
"""
import bz2
import struct
import sys

MESSAGE, CHUNK, CONNECTION = 2, 5, 7


def fields(data):
    found, at = {}, 0
    while at < len(data):
        size = struct.unpack_from("<I", data, at)[0]
        name, _, value = data[at + 4 : at + 4 + size].partition(b"=")
        found[name.decode()] = value
        at += 4 + size
    return found


def records(data):
    at = 0
    while at + 4 <= len(data):
        size = struct.unpack_from("<I", data, at)[0]
        header = fields(data[at + 4 : at + 4 + size])
        at += 4 + size
        size = struct.unpack_from("<I", data, at)[0]
        yield header, data[at + 4 : at + 4 + size]
        at += 4 + size


class Reader:
    """A serialised message, from its header on."""

    def __init__(self, data):
        self.data, self.at = data, 0

    def integer(self):
        self.at += 4
        return struct.unpack_from("<I", self.data, self.at - 4)[0]

    def text(self):
        size = self.integer()
        self.at += size
        return self.data[self.at - size : self.at].decode("latin1")

    def numbers(self, count):
        self.at += 8 * count
        return struct.unpack_from(f"<{count}d", self.data, self.at - 8 * count)

    def stamp_ns(self):
        """Of a std_msgs/Header, which it reads to its end."""
        self.integer()
        seconds, nanoseconds = self.integer(), self.integer()
        self.text()
        return seconds * 10**9 + nanoseconds


def messages_of(data, types, found):
    for header, body in records(data):
        kind = header["op"][0]
        if kind == CONNECTION:
            types[header["conn"]] = (header["topic"].decode(), fields(body)["type"].decode())
        elif kind == MESSAGE:
            seconds, nanoseconds = struct.unpack("<II", header["time"])
            found.append((seconds * 10**9 + nanoseconds, header["conn"], body))
        elif kind == CHUNK:
            messages_of(bz2.decompress(body) if header["compression"] == b"bz2" else body, types, found)


def main():
    with open(sys.argv[1], "rb") as file:
        magic = file.readline()
        assert magic == b"#ROSBAG V2.0\n", magic
        types, found = {}, []
        messages_of(file.read(), types, found)
    for time_ns, connection, body in sorted(found, key=lambda message: message[0]):
        topic, kind = types[connection]
        reader = Reader(body)
        if kind == "nav_msgs/Odometry":
            stamp_ns = reader.stamp_ns()
            reader.text()
            print("odom", topic, time_ns, stamp_ns, *map(repr, reader.numbers(7 + 36 + 6 + 36)))
        elif kind == "sensor_msgs/Imu":
            stamp_ns = reader.stamp_ns()
            print("imu", topic, time_ns, stamp_ns, *map(repr, reader.numbers(4 + 9 + 3 + 9 + 3 + 9)))


main()
