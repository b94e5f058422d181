# SPDX-License-Identifier: Apache-2.0
"""Runs the benchmark programs: plain, under callgrind, under strace. Figures per message are the difference of two run
lengths divided by the extra messages, so that start and end cancel."""
import contextlib
import json
import os
import platform
import re
import subprocess
import sys
import tempfile
from pathlib import Path


# glibc chooses memcpy and its like by the processor, and callgrind by the one that it plays: the same routines everywhere.
PLAIN_ROUTINES = {
    "x86_64": "glibc.cpu.hwcaps=-AVX512F,-AVX512VL,-AVX512BW,-AVX512DQ,-AVX2,-AVX,-AVX_Fast_Unaligned_Load,-ERMS,-FSRM,-BMI2,"
    "-SSE4_2,-SSE4_1,-SSSE3,-RTM",
    "aarch64": "glibc.cpu.name=generic",
}.get(platform.machine(), "")


class Crash(Exception):
    """A program did not end as it should: its command and its last words."""


class Programs:
    def __init__(self, folder):
        self.folder = Path(folder)
        self.calls_are_counted_by = "perf" if self._perf_may() else "strace"

    @staticmethod
    def _perf_may():
        try:
            said = subprocess.run(["perf", "stat", "-x", ",", "-e", "raw_syscalls:sys_enter", "true"],
                                  capture_output=True, text=True, check=False)  # fmt: skip
        except FileNotFoundError:
            return False
        return said.returncode == 0 and re.search(r"^\d+,", said.stderr, re.MULTILINE) is not None

    def _start(self, prefix, name, words, environment=None):
        command = [*prefix, str(self.folder / name), *(f"{key}={value}" for key, value in words.items())]
        return self._finish(command, environment=environment)

    def has(self, name):
        """Whether the program was built."""
        return (self.folder / name).is_file()

    @staticmethod
    def _finish(command, may_end_with=(0,), environment=None):
        try:
            done = subprocess.run(command, capture_output=True, text=True, timeout=600, check=False, env=os.environ | (environment or {}))
        except subprocess.TimeoutExpired as late:
            raise Crash(f"{' '.join(command)}: no end after {late.timeout:.0f} s") from None
        if done.returncode not in may_end_with:
            raise Crash(f"{' '.join(command)}: ended with {done.returncode}: {done.stderr.strip()[-400:]}")
        return done

    def run(self, name, **words):
        """The figures that the program prints."""
        return json.loads(self._start([], name, words).stdout.strip().splitlines()[-1])

    @contextlib.contextmanager
    def iceoryx(self):
        """Runs iceoryx's daemon; yields why there is none, or an empty text."""
        program = self.folder / "roudi_for_bench"
        if not program.is_file():
            yield "libiceoryx-posh-dev was not there when this was built"
            return
        with subprocess.Popen([str(program)], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True) as daemon:
            said = daemon.stdout.readline().strip()
            try:
                yield "" if said == "ready" else said or "its keeper crashed"
            finally:
                daemon.stdin.close()
                daemon.wait(timeout=60)

    def soak(self, cycles, peers=None):
        """The rows of the program soak-load, which judges itself; None where it is not built. `peers`: on a network, with so many others."""
        program = self.folder / "soak-load"
        if not program.is_file():
            return None
        with tempfile.NamedTemporaryFile(mode="r") as rows:
            network = [] if peers is None else ["--network", str(peers)]
            self._finish([str(program), "--cycles", str(cycles), "--json", rows.name, *network], may_end_with=(0, 1))
            return json.load(rows)

    def instructions(self, name, few=2000, many=12000, **words):
        """Instructions per message of all threads, as callgrind counts them (the vDSO is not seen)."""
        return self.executed(name, few, many, **words)["Ir"]

    def executed(self, name, few=2000, many=12000, **words):
        """The same ("Ir"), and how many of them are locked ("Ge", callgrind's name for a global bus event)."""

        def totals(messages):
            prefix = ["valgrind", "--tool=callgrind", "--collect-bus=yes", "--callgrind-out-file=/dev/null"]
            said = self._start(prefix, name, words | {"messages": messages}, {"GLIBC_TUNABLES": PLAIN_ROUTINES})
            events, figures = (re.search(rf"{row} *: (.*)", said.stderr)[1].split() for row in ("Events", "Collected"))
            return {event: int(figure) for event, figure in zip(events, figures, strict=True)}

        less, more = totals(few), totals(many)
        return {event: (more[event] - less[event]) / (many - few) for event in more}

    def syscalls(self, name, few=1000, many=3000, **words):
        """System calls per message of all threads. perf counts them as they happen; strace, where perf may not, stops the
        threads at each, so that a reader that was to be found asleep may be found awake."""

        def total(messages):
            with tempfile.NamedTemporaryFile(mode="r") as counts:
                if self.calls_are_counted_by == "perf":
                    prefix = ["perf", "stat", "-x", ",", "-e", "raw_syscalls:sys_enter", "-o", counts.name]
                else:
                    prefix = ["strace", "-f", "-c", "-U", "calls,name", "-o", counts.name]
                self._start(prefix, name, words | {"messages": messages})
                lines = [re.split("[ ,]+", line.strip()) for line in counts.read().splitlines()]
                return sum(int(line[0]) for line in lines if len(line) > 1 and line[0].isdigit() and line[1] != "total")

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
