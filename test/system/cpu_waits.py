# SPDX-License-Identifier: Apache-2.0
"""How long the programs of a test were ready to run and had no CPU: what a busy machine does to a robot, and not the robot to itself."""
import contextlib
import os
import pathlib
import threading
import time

LOOK_S = 0.5  # between two looks: a thread that has ended is no longer in /proc
# In that time, a thread waits for a tenth of this on a free machine, if it wakes a hundred times a second. A queue of five messages at 100 Hz
# overflows after as long.
BUSY_S = 0.05
STEP_S, ALWAYS_LATE_S = 0.01, 0.002  # of the watching thread: its sleep, and by how much it wakes late on a free machine


def descendants():
    """Process ids of what this process has started, and of what that has."""
    children = {}
    for entry in pathlib.Path("/proc").glob("[0-9]*"):
        with contextlib.suppress(OSError):
            parent = int((entry / "stat").read_text().rpartition(")")[2].split()[1])
            children.setdefault(parent, []).append(int(entry.name))
    found = []
    waiting = [os.getpid()]
    while waiting:
        waiting.extend(own := children.get(waiting.pop(), []))
        found.extend(own)
    return found


def cpu_waits():
    """Seconds without a CPU of each thread of the descendants, since it began (schedstat's second number, in ns)."""
    waits = {}
    for pid in descendants():
        for task in pathlib.Path(f"/proc/{pid}/task").glob("*"):
            with contextlib.suppress(OSError):
                waits[pid, task.name] = int((task / "schedstat").read_text().split()[1]) * 1e-9
    return waits


class CpuWatch:
    """Between `with` and its end: `longest_s`, the most that any thread has waited between two looks.

    If the whole machine is stopped, no thread waits for a CPU: all of them sleep, and wake late. Therefore the watching thread wakes
    a hundred times a second, and its own lateness counts as well.
    """

    def __enter__(self):
        self.longest_s = self._late_s = 0.0
        self._last = cpu_waits()
        self._is_over = threading.Event()
        self._thread = threading.Thread(target=self._watch)
        self._thread.start()
        return self

    def __exit__(self, *_):
        self._is_over.set()
        self._thread.join()

    def _watch(self):
        while not self._is_over.is_set():
            looked = time.monotonic()
            while (began := time.monotonic()) < looked + LOOK_S and not self._is_over.wait(STEP_S):
                self._late_s += max(0.0, time.monotonic() - began - STEP_S - ALWAYS_LATE_S)
            self._look()

    def _look(self):
        waits = cpu_waits()
        grown = (wait_s - self._last.get(thread, 0.0) for thread, wait_s in waits.items())
        self.longest_s = max(self.longest_s, self._late_s, max(grown, default=0.0))
        self._last, self._late_s = waits, 0.0
