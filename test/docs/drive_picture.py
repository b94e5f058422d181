#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""Draws docs/drive.svg: a drive of the simulated robot, the true path beside those of the odometry and the EKF.

usage: NACELLE_PROGRAM=build/bin/nacelle test/docs/drive_picture.py docs/drive.svg
"""
import json
import os
import subprocess
import sys
import tempfile
import threading
import time

PROGRAM = os.environ["NACELLE_PROGRAM"]
SCALE, MARGIN = 300, 40  # pixels per metre; round the paths
PATHS = (("true path", "#888888", 6), ("odometry", "#d95f02", 2), ("EKF", "#1f5fbf", 2))


def listen(topic, env, into):
    """Appends the positions of an odometry topic until the robot ends."""
    command = [PROGRAM, "topic", "echo", topic, "--json", "--field", "pose.pose.position"]
    with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True, env=env) as echo:
        for line in echo.stdout:
            position = json.loads(line)
            into.append((position["x"], position["y"]))


def drive():
    """Returns the three paths of one drive, in metres."""
    true, odometry, ekf = [], [], []
    with tempfile.TemporaryDirectory() as folder:
        env = {**os.environ, "XDG_RUNTIME_DIR": folder}
        robot = subprocess.Popen([PROGRAM, "drive", "--seed", "4"], stdout=subprocess.PIPE, text=True, env=env)
        next(line for line in robot.stdout if "side 1 of 4" in line)
        listeners = [threading.Thread(target=listen, args=(topic, env, into), daemon=True)
                     for topic, into in (("/odom", odometry), ("/odometry/filtered", ekf))]  # fmt: skip
        for listener in listeners:
            listener.start()
        while robot.poll() is None:
            answer = subprocess.run([PROGRAM, "sim", "truth"], capture_output=True, text=True, env=env, check=False)
            if answer.returncode == 0:
                truth = json.loads(answer.stdout)
                true.append((truth["x_m"], truth["y_m"]))
            time.sleep(0.1)
        for listener in listeners:
            listener.join(10)
    return true, odometry, ekf


def thinned(path):
    """Leaves out points nearer than 1 cm to the last one."""
    kept = path[:1]
    for point in path:
        if (point[0] - kept[-1][0]) ** 2 + (point[1] - kept[-1][1]) ** 2 > 1e-4:
            kept.append(point)
    return kept


def draw(paths):
    points = [point for path in paths for point in path]
    left, top = min(x for x, _ in points), max(y for _, y in points)
    width = (max(x for x, _ in points) - left) * SCALE + 2 * MARGIN + 130
    height = (top - min(y for _, y in points)) * SCALE + 2 * MARGIN
    lines = [
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {width:.0f} {height:.0f}" font-family="sans-serif" font-size="14">',
        '<!-- SPDX-License-Identifier: Apache-2.0. Drawn by test/docs/drive_picture.py. -->',
        f'<rect width="{width:.0f}" height="{height:.0f}" fill="#ffffff"/>',
    ]
    for path, (name, colour, thick) in zip(paths, PATHS):
        text = " ".join(f"{(x - left) * SCALE + MARGIN:.0f},{(top - y) * SCALE + MARGIN:.0f}" for x, y in thinned(path))
        lines.append(f'<polyline points="{text}" fill="none" stroke="{colour}" stroke-width="{thick}"><title>{name}</title></polyline>')
    for row, (name, colour, thick) in enumerate(PATHS):
        y = MARGIN + 20 * row
        lines.append(f'<line x1="{width - 145:.0f}" y1="{y}" x2="{width - 115:.0f}" y2="{y}" stroke="{colour}" stroke-width="{thick}"/>')
        lines.append(f'<text x="{width - 105:.0f}" y="{y + 5}">{name}</text>')
    y = MARGIN + 100
    lines.append(f'<line x1="{width - 145:.0f}" y1="{y}" x2="{width - 145 + SCALE / 4:.0f}" y2="{y}" stroke="#000000"/>')
    lines.append(f'<text x="{width - 145:.0f}" y="{y + 18}">0.25 m</text>')
    return "\n".join([*lines, "</svg>", ""])


def main():
    if len(sys.argv) != 2:
        print(__doc__, file=sys.stderr)
        return 2
    with open(sys.argv[1], "w", encoding="utf-8") as file:
        file.write(draw(drive()))
    return 0


if __name__ == "__main__":
    sys.exit(main())
