# SPDX-License-Identifier: Apache-2.0
"""Publish/subscribe graphs in the words of the program `topology` (topology/graph.hpp)."""
import json
import re
from pathlib import Path

TOPOLOGIES = Path(__file__).resolve().parent.parent / "data" / "topologies"


def _type_and_size(entry):
    """stamped9_float32: nine floats and a stamp; stamped250kb: that many bytes; stamped_vector: as many as msg_size says."""
    name = entry["msg_type"]
    if name == "stamped9_float32":
        return name, 44
    if "msg_size" in entry:
        return "bytes", entry["msg_size"]
    bulk = re.fullmatch(r"stamped(\d+)(b|kb|mb)", name)
    if bulk:
        return "bytes", int(bulk[1]) * {"b": 1, "kb": 1000, "mb": 1_000_000}[bulk[2]]
    numbers = re.fullmatch(r"stamped(\d*)_(int|float)(\d+)", name)
    return "bytes", int(numbers[1] or 1) * int(numbers[3]) // 8 if numbers else 0


def topology(name):
    """The lines of test/data/topologies/NAME.json."""
    lines = []
    graph = json.loads((TOPOLOGIES / f"{name}.json").read_text())
    types = {p["topic_name"]: _type_and_size(p) for node in graph["nodes"] for p in node.get("publishers", [])}
    for node in graph["nodes"]:
        lines.append(f"node {node['node_name']}")
        for p in node.get("publishers", []):
            kind, size = types[p["topic_name"]]
            period_us = round(p["period_ms"] * 1000 if "period_ms" in p else 1e6 / p["freq_hz"])
            lines.append(f"pub /{p['topic_name']} {kind} {period_us} {size} as_is")
        for s in node.get("subscribers", []):
            lines.append(f"sub /{s['topic_name']} {types.get(s['topic_name'], ('bytes', 0))[0]}")
    return lines


def saturation(size):
    """50 topics of 63 to 2000 Hz: 51,575 messages per second."""
    rates = [63 + (2000 - 63) * i / 49 for i in range(50)]
    return (
        ["node writer"] + [f"pub /s{i} bytes {round(1e6 / hz)} {size} as_is" for i, hz in enumerate(rates)]
        + ["node reader"] + [f"sub /s{i} bytes" for i in range(50)]
    )  # fmt: skip


def plain_robot():
    """Nine components that only move messages; rates and sizes of the goals' plain robot graph."""
    image, scan, imu = "sensor_msgs/msg/Image", "sensor_msgs/msg/LaserScan", "sensor_msgs/msg/Imu"
    odometry, tf, twist = "nav_msgs/msg/Odometry", "tf2_msgs/msg/TFMessage", "geometry_msgs/msg/TwistStamped"
    return [
        "node camera", f"pub /image {image} 33333 {640 * 480 * 3} as_is",
        "node lidar", f"pub /scan {scan} 100000 {455 * 4} as_is",
        "node imu", f"pub /imu {imu} 10000 0 as_is",
        "node wheels", f"pub /wheel_odometry {odometry} 20000 0 as_is",
        "node ekf", f"sub /imu {imu}", f"sub /wheel_odometry {odometry}",
        f"pub /odometry {odometry} 20000 0 as_is", f"pub /tf {tf} 20000 0 as_is",
        "node diff_drive", f"sub /cmd_vel {twist}",
        "node sender", f"pub /cmd_vel {twist} 20000 0 as_is",
        "node image_reader", f"sub /image {image}",
        "node scan_reader", f"sub /scan {scan}",
    ]  # fmt: skip


def cloud(readers):
    """A 1920 x 1080 cloud of 16-byte points, 30 times a second: 1 GB/s. Every byte is written by the publisher."""
    lines = ["node camera", f"pub /cloud bytes 33333 {1920 * 1080 * 16} filled"]
    for i in range(readers):
        lines += [f"node reader{i}", "sub /cloud bytes"]
    return lines
