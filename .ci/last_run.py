#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""What the last run of the tests shows.

usage: last_run.py failed|slowest BUILD_DIRECTORY

failed   where each failed test went wrong
slowest  the ten slowest tests, cases of system tests and compile units
"""
import re
import sys
import xml.etree.ElementTree as xml
from pathlib import Path

MOST = 10
MOST_LINES = 30  # of a failed test
# A failure begins so in the output of GoogleTest, of unittest and of the sanitizers.
FAILURES = re.compile(r".*: Failure$|\[  FAILED  \]|(FAIL|ERROR): |.*(ERROR: \w+Sanitizer|WARNING: ThreadSanitizer|runtime error:)")
LINES_OF_A_FAILURE = 12


def results(build):
    """The tests of ctest's JUnit file. Control characters that programs print are no XML."""
    file = build / "test-results.xml"
    text = file.read_text(encoding="utf-8", errors="replace") if file.is_file() else "<none/>"
    return xml.fromstring(re.sub(r"[^\t\n\x20-\U0010ffff]", "?", text)).iter("testcase")


def tests(build):
    """Name and seconds of each test."""
    for test in results(build):
        yield test.get("name"), float(test.get("time"))


def failures(build):
    """Name of each failed test, and the lines of its output with which a failure begins and those that follow."""
    for test in results(build):
        if test.get("status") != "fail":
            continue
        lines = [line for line in (test.findtext("system-out") or "").splitlines() if line.strip()]
        shown = set()
        for number, line in enumerate(lines):
            if FAILURES.match(line) and len(shown) < MOST_LINES:
                shown.update(range(number, min(number + LINES_OF_A_FAILURE, len(lines))))
        # What says nothing of the kind was ended, or ended itself: its last lines.
        shown = shown or range(max(0, len(lines) - LINES_OF_A_FAILURE), len(lines))
        yield test.get("name"), [lines[number] for number in sorted(shown)]


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
    what, build = sys.argv[1], Path(sys.argv[2])
    if what == "failed":
        for name, lines in failures(build):
            print(f"\nfailed {name}:", *lines, sep="\n  ")
    else:
        for kind, rows in (("tests", tests(build)), ("cases of system tests", cases(build)), ("compile units", units(build))):
            print(f"\nslowest {kind}:")
            for name, seconds in sorted(rows, key=lambda row: -row[1])[:MOST]:
                print(f"  {seconds:7.1f} s  {re.sub(r'CMakeFiles/|Unity/', '', name)}")
    print()


if __name__ == "__main__":
    main()
