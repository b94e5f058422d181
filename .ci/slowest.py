#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""Prints the ten slowest tests, and cases of system tests, of the last run and the ten slowest compile units of the last build.

usage: slowest.py BUILD_DIRECTORY
"""
import re
import sys
from pathlib import Path

MOST = 10


def tests(build):
    """Name and seconds of each test, from ctest's JUnit file."""
    results = build / "test-results.xml"
    text = results.read_text(encoding="utf-8", errors="replace") if results.is_file() else ""
    for found in re.finditer(r"<testcase ([^>]*)>", text):
        words = dict(re.findall(r'(\w+)="([^"]*)"', found.group(1)))
        yield words["name"], float(words["time"])


def cases(build):
    """Name and seconds of each case of the system tests."""
    times = build / "case-times.tsv"
    for line in times.read_text(encoding="utf-8").splitlines() if times.is_file() else ():
        seconds, name = line.split("\t")
        yield name.removeprefix("__main__."), float(seconds)


def units(build):
    """Name and seconds of each object file, from ninja's log; the last entry of an output counts."""
    log = build / ".ninja_log"
    times = {}
    for line in log.read_text(encoding="utf-8").splitlines() if log.is_file() else ():
        words = line.split("\t")
        if len(words) >= 4 and words[3].endswith(".o"):
            times[words[3]] = (int(words[1]) - int(words[0])) / 1000
    return times.items()


def main():
    build = Path(sys.argv[1])
    for what, rows in (("tests", tests(build)), ("cases of system tests", cases(build)), ("compile units", units(build))):
        slowest = sorted(rows, key=lambda row: -row[1])[:MOST]
        print(f"\nslowest {what}:")
        for name, seconds in slowest:
            print(f"  {seconds:7.1f} s  {re.sub(r'CMakeFiles/|Unity/', '', name)}")
    print()


if __name__ == "__main__":
    main()
