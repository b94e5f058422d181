# SPDX-License-Identifier: Apache-2.0
"""Runs the benchmark programs: plain, under callgrind, under strace. Figures per message are the difference of two run
lengths divided by the extra messages, so that start and end cancel."""
import json
import re
import subprocess
import sys
import tempfile
from pathlib import Path


class Crash(Exception):
    """A program did not end as it should: its command and its last words."""


class Programs:
    def __init__(self, folder):
        self.folder = Path(folder)

    def _start(self, prefix, name, words):
        command = [*prefix, str(self.folder / name), *(f"{key}={value}" for key, value in words.items())]
        try:
            done = subprocess.run(command, capture_output=True, text=True, timeout=600, check=False)
        except subprocess.TimeoutExpired as late:
            raise Crash(f"{' '.join(command)}: no end after {late.timeout:.0f} s") from None
        if done.returncode != 0:
            raise Crash(f"{' '.join(command)}: ended with {done.returncode}: {done.stderr.strip()[-400:]}")
        return done

    def run(self, name, **words):
        """The figures that the program prints."""
        return json.loads(self._start([], name, words).stdout.strip().splitlines()[-1])

    def instructions(self, name, few=2000, many=12000, **words):
        """Instructions per message of all threads, as callgrind counts them (the vDSO is not seen)."""

        def total(messages):
            said = self._start(["valgrind", "--tool=callgrind", "--callgrind-out-file=/dev/null"], name, words | {"messages": messages})
            return int(re.search(r"Collected : (\d+)", said.stderr).group(1))

        return (total(many) - total(few)) / (many - few)

    def syscalls(self, name, few=1000, many=3000, **words):
        """System calls per message of all threads."""

        def total(messages):
            with tempfile.NamedTemporaryFile(mode="r") as counts:
                self._start(["strace", "-f", "-c", "-o", counts.name], name, words | {"messages": messages})
                last = [line for line in counts.read().splitlines() if line.endswith("total")][-1].split()
                return int(last[2]) if last[2].isdigit() else int(last[3])

        return (total(many) - total(few)) / (many - few)

    def steps(self, few=100, many=300, **words):
        """What the executor's thread really executes per message, by single-stepping; None where that is not allowed."""
        try:
            a, b = (self.run("handover", step=1, messages=n, **words) for n in (few, many))
        except Crash as crash:
            print(f"  single-stepping: {crash}", file=sys.stderr)
            return None
        return {key: (b[key] - a[key]) / (many - few) for key in a}


def median(values):
    ordered = sorted(values)
    return ordered[len(ordered) // 2]
