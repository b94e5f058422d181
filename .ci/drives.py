#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""Fails if a drive on an installed Nacelle differs from one on this machine: message counts by more than 2 %, or a final error that is
more than twice as large. Times and latencies are not compared: the other drive may be emulated.

usage: drives.py HERE.json THERE.json    two reports of `nacelle drive --report`
"""
import json
import sys
from pathlib import Path

MOST_COUNT, MOST_ERROR = 0.02, 2.0
SMALLEST_ERROR_M = 0.005  # below it, "twice" says nothing: the simulated encoder counts 2 mm steps


def rates(report):
    """Messages of each stream in a second of the robot's own run; streams of events have no rate."""
    return {stream["name"]: stream["hz"] for stream in report["streams"] if stream["hz"] >= 1}


def complaints(here, there):
    if here["bringup"]["order"] != there["bringup"]["order"]:
        yield f"components came up in another order: {there['bringup']['order']}"
    wanted, found = rates(here), rates(there)
    for name in sorted(wanted.keys() | found.keys()):
        one, other = wanted.get(name, 0), found.get(name, 0)
        if abs(one - other) > MOST_COUNT * one:
            yield f"{name}: {other:.2f} messages a second, here {one:.2f}"
    for key in ("odometry_error_m", "ekf_error_m"):
        one, other = here["drive"][key], there["drive"][key]
        if other > max(MOST_ERROR * one, SMALLEST_ERROR_M):
            yield f"{key}: {other} m, here {one} m"


def main():
    here, there = (json.loads(Path(name).read_text(encoding="utf-8")) for name in sys.argv[1:3])
    found = list(complaints(here, there))
    for complaint in found:
        print(complaint)
    compared = len(rates(here))
    drives = [f"{report['drive']['odometry_error_m'] * 1e3:.1f} and {report['drive']['ekf_error_m'] * 1e3:.1f} mm" for report in (here, there)]
    print(f"{compared} streams compared; odometry and EKF end {drives[0]} off here, {drives[1]} there")
    return 1 if found or compared == 0 else 0


if __name__ == "__main__":
    sys.exit(main())
