#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""What the last run of the tests shows.

usage: last_run.py failed|skipped|slowest BUILD_DIRECTORY

failed   where each failed test went wrong
skipped  what was skipped, a line each: whole tests, and cases of tests that passed
slowest  the ten slowest tests, cases of system tests and compile units
"""
import re
import sys
import xml.etree.ElementTree as xml
from pathlib import Path

MOST = 10
MOST_LINES = 30  # of a failed test, about
# A failure begins and ends so in the output of GoogleTest, of unittest and of the sanitizers.
FAILURES = re.compile(r".*: Failure$|\[  FAILED  \]|(FAIL|ERROR): |.*(ERROR: \w+Sanitizer|WARNING: ThreadSanitizer|runtime error:)")
ENDS = re.compile(r"\[ +(RUN|OK|-*) +\]|\[  FAILED  \]|={70}|Ran \d+ tests?|SUMMARY: ")
FIRST_LINES, LAST_LINES = 4, 8  # of a long one; the last ones of a traceback say what it is


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
        for begin, line in enumerate(lines):
            if FAILURES.match(line) and len(shown) < MOST_LINES:
                end = next((n for n in range(begin + 1, len(lines)) if ENDS.match(lines[n])), len(lines))
                shown.update(n for n in range(max(0, begin - 1), end) if n < begin + FIRST_LINES or n >= end - LAST_LINES)
        # What says nothing of the kind was ended, or ended itself: its last lines.
        shown = shown or range(max(0, len(lines) - LAST_LINES), len(lines))
        yield test.get("name"), [lines[number] for number in sorted(shown)]


def skipped(build):
    """Name of each test that was skipped, and of each case, with its reason where the output says it."""
    for test in results(build):
        if test.get("status") in ("notrun", "disabled"):
            said = (test.findtext("system-out") or "").split("\n")[-2:]
            yield f"{test.get('name')}: {' '.join(said).strip() or 'disabled'}"
    log = build / "Testing" / "Temporary" / "LastTest.log"  # unlike the XML, it has the whole output of what passed
    name, reason, case, unnamed = "", "", "", 0
    for line in log.read_text(encoding="utf-8", errors="replace").splitlines() if log.is_file() else ():
        if found := re.match(r"\d+/\d+ Testing: (.*)", line):
            name = found.group(1)
        elif reason is None:
            reason = line
        elif line.endswith(": Skipped"):
            reason = None
        elif found := re.match(r"\[  SKIPPED \] (\S+) \(\d+ ms\)", line):
            yield f"{name}, {found.group(1)}: {reason}"
        elif found := re.search(r"\.\.\. skipped (['\"])(.*)\1$", line):
            unnamed -= 1
            yield f"{name}, {re.sub(r' .*', '', line) if line.startswith('test_') else case}: {found.group(2)}"
        elif found := re.match(r"(test_\w+) \(", line):
            case = found.group(1)
        elif found := re.match(r"(?:OK|FAILED) \(.*skipped=(\d+)", line):
            unnamed += int(found.group(1))
            yield from [f"{name}: a case"] * unnamed
            unnamed = 0


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
    elif what == "skipped":
        for line in skipped(build):
            print(line)
        return
    else:
        for kind, rows in (("tests", tests(build)), ("cases of system tests", cases(build)), ("compile units", units(build))):
            print(f"\nslowest {kind}:")
            for name, seconds in sorted(rows, key=lambda row: -row[1])[:MOST]:
                print(f"  {seconds:7.1f} s  {re.sub(r'CMakeFiles/|Unity/', '', name)}")
    print()


if __name__ == "__main__":
    main()
