# SPDX-License-Identifier: Apache-2.0
"""What the robot of the default launch file uses: memory, processor, wake-ups, disk, start-up (M6, M18).

The simulated devices run in a process of their own, as a world that is there before the robot is ("hardware ready"), and are not counted. The
camera is the test pattern. NACELLE_SHORT: 5 s and one start instead of 60 s and five.
"""
import contextlib
import os
import re
import signal
import subprocess
import tempfile
import time
from pathlib import Path

from goals import at_most, exactly, row
from measure import Crash, median

ROOT = Path(__file__).resolve().parents[2]
SHORT = bool(os.environ.get("NACELLE_SHORT"))
SECONDS, STARTS = (5, 1) if SHORT else (60, 5)
SETTLING_S = 3
CGROUP_BYTES = 600 << 20
TICKS = os.sysconf("SC_CLK_TCK")
UP = re.compile(r"^(\d+) components? active in (\d+) ms", re.MULTILINE)


class MemoryGroup:
    """A cgroup of 600 MB, of version 1 or 2; `why_not` is why there is none."""

    def __init__(self, root="/sys/fs/cgroup"):
        self.why_not, self.folder = "", None
        v1, v2 = Path(root, "memory"), Path(root)
        name = f"nacelle-footprint-{os.getpid()}"
        try:
            if (v1 / "memory.limit_in_bytes").exists():
                self.limit, self.peak, folder = "memory.limit_in_bytes", "memory.max_usage_in_bytes", v1 / name
            elif "memory" in (v2 / "cgroup.subtree_control").read_text().split():
                self.limit, self.peak, folder = "memory.max", "memory.peak", v2 / name
            else:
                self.why_not = f"{v2} does not pass its memory controller on"
                return
            folder.mkdir()
            self.folder = folder
            (folder / self.limit).write_text(str(CGROUP_BYTES))
        except OSError as refused:
            self.why_not = f"no memory cgroup can be made here ({refused.strerror})"

    def peak_mb(self):
        with contextlib.suppress(OSError):
            return int((self.folder / self.peak).read_text()) / 1e6
        return None  # memory.peak came with Linux 5.19

    def close(self):
        if self.folder is not None:
            self.folder.rmdir()


def fields(path, separator=":"):
    return {key.strip(): rest.split()[0] for key, _, rest in (line.partition(separator) for line in Path(path).read_text().splitlines()) if rest.split()}


class Usage:
    """What a process has used until now, and uses."""

    def __init__(self, process):
        proc = Path("/proc", str(process))
        self.at = time.monotonic()
        stat = (proc / "stat").read_text().rpartition(")")[2].split()
        self.minor_faults, self.major_faults = int(stat[7]), int(stat[9])
        self.cpu_s = (int(stat[11]) + int(stat[12])) / TICKS
        self.written = int(fields(proc / "io")["write_bytes"])
        memory = fields(proc / "smaps_rollup", ": ") if (proc / "smaps_rollup").exists() else {}
        status = fields(proc / "status")
        self.rss, self.anonymous, self.pss = int(status["VmRSS"]) * 1024, int(status["RssAnon"]) * 1024, int(memory.get("Pss", 0)) * 1024
        self.threads, self.switches = {}, {}
        for task in (proc / "task").iterdir():
            with contextlib.suppress(OSError):  # a thread that has just ended
                self.threads[task.name] = (task / "comm").read_text().strip()
                self.switches[task.name] = int(fields(task / "status")["voluntary_ctxt_switches"])

    def wake_ups_since(self, before):
        """Voluntary switches per second of each thread name: a thread that waited, and was woken."""
        rates = {}
        for task, name in self.threads.items():
            since = (self.switches[task] - before.switches.get(task, 0)) / (self.at - before.at)
            rates[name] = rates.get(name, 0) + since
        return rates


class Robot:
    """The container of the default launch file, beside a world that runs already."""

    def __init__(self, program, folder, network, group=None, arguments=()):
        self.log = folder / "log"
        environment = {name: text for name, text in os.environ.items() if not name.startswith(("ROS_", "RMW_", "CYCLONEDDS_"))}
        environment["XDG_RUNTIME_DIR"] = str(folder)
        environment["ROS_DOMAIN_ID"] = "77"
        lines = [f"{name}_port:={folder}/sim/{name}" for name in ("lidar", "imu", "base")]
        command = [program, "launch", ROOT / "launch/robot.launch.yaml", "sim:=false", "camera_device:=pattern", f"network:={network}", *lines, *arguments]

        def join():
            if group is not None:
                (group.folder / "cgroup.procs").write_text(str(os.getpid()))

        with open(self.log, "w", encoding="utf-8") as log:
            self.process = subprocess.Popen(list(map(str, command)), stdout=log, stderr=subprocess.STDOUT, env=environment,  # noqa: S603
                                            start_new_session=True, preexec_fn=join)  # fmt: skip
        until = time.monotonic() + 60
        while not UP.search(self.log.read_text()):
            if self.process.poll() is not None or time.monotonic() > until:
                self.close()
                raise Crash("the robot did not come up: " + self.log.read_text()[-400:])
            time.sleep(0.05)
        found = UP.search(self.log.read_text())
        self.components, self.start_s = int(found[1]), int(found[2]) / 1000

    def close(self):
        if self.process.poll() is None:
            self.process.send_signal(signal.SIGINT)
        self.process.wait(timeout=60)

    def watcher(self):
        """The process that writes the last stop frames (ADR 0019)."""
        children = (Path("/proc", str(self.process.pid), "task", str(self.process.pid)) / "children").read_text().split()
        return next((child for child in children if "watcher" in Path("/proc", child, "comm").read_text()), None)


@contextlib.contextmanager
def world(program, folder):
    with subprocess.Popen([str(program), "sim", "world", "--dir", str(folder / "sim")], stderr=subprocess.DEVNULL) as process:
        try:
            until = time.monotonic() + 60
            while not (folder / "sim/ready").exists():
                if process.poll() is not None or time.monotonic() > until:
                    raise Crash("the simulated world did not start")
                time.sleep(0.05)
            yield
        finally:
            process.terminate()


def rows_of(robot, place, network):
    before = Usage(robot.process.pid)
    time.sleep(SECONDS)  # the length of the measurement
    after = Usage(robot.process.pid)
    seconds = after.at - before.at
    what = f"{place}, network {network}: "
    yield row("M18", what + "RSS", after.rss / 1e6, "MB", at_most(40), f"{after.anonymous / 1e6:.1f} of it not backed by a file")
    watcher = robot.watcher()
    beside = Usage(watcher).pss / 1e6 if watcher else 0
    yield row("M18", what + "PSS", (after.pss + beside * 1e6) / 1e6, "MB", None, f"{beside:.1f} of it the process that writes the last stop")
    yield row("M18", what + "threads", len(after.threads), "", None)
    yield row("M18", what + "CPU", 100 * (after.cpu_s - before.cpu_s) / seconds, "% of one", at_most(10), "camera pattern and two monitors included, detector " + ("not" if "Debian" in place else "too"))
    rates = after.wake_ups_since(before)
    most = ", ".join(f"{name} {rate:.0f}" for name, rate in sorted(rates.items(), key=lambda item: -item[1])[:6])
    yield row("M18", what + "wake-ups", sum(rates.values()), "1/s", None, most)
    yield row("M18", what + "wake-ups without an event: the supervisor's", rates.get("supervisor", 0), "1/s", at_most(1), "it checks for hangs")
    yield row("M18", what + "minor page faults", (after.minor_faults - before.minor_faults) / seconds, "1/s", None)
    yield row("M18", what + "major page faults", after.major_faults - before.major_faults, "", exactly(0))
    yield row("M18", what + "bytes written to disk, start-up included", after.written, "B", exactly(0))


def footprint(programs, say):
    program = programs.folder.parent / "bin/nacelle"
    if not program.exists():
        raise Crash(f"{program} is not there: ./dev build")
    if os.getloadavg()[0] > 0.5:
        say(f"this machine is busy: load {os.getloadavg()[0]:.2f}")
    with tempfile.TemporaryDirectory(prefix="nacelle-footprint-", dir="/dev/shm") as name, world(program, Path(name)):
        # debian/rules: the robot of the package has no detector.
        for place, arguments in (("native", ()), ("native, as in the Debian package", ("detector:=false",)), ("cgroup of 600 MB", ())):
            group = MemoryGroup() if place.startswith("cgroup") else None
            if group is not None and group.why_not:
                yield row("M18", f"{place}: RSS", None, "MB", at_most(40), "", f"not measured: {group.why_not}")
                continue
            try:
                for network, mode in (("off", "off"), ("on", "local")):
                    yield from one_setting(program, Path(name), place, network, mode, group, arguments, say)
            finally:
                if group is not None:
                    group.close()


def one_setting(program, folder, place, network, mode, group, arguments, say):
    starts = []
    for number in range(STARTS):
        robot = Robot(program, folder, mode, group, arguments)
        try:
            starts.append(robot.start_s)
            if number + 1 < STARTS:
                continue
            time.sleep(SETTLING_S)  # start-up is not counted
            say(f"{place}, network {network}: {robot.components} components, {SECONDS} s; load {os.getloadavg()[0]:.2f}")
            yield from rows_of(robot, place, network)
        finally:
            robot.close()
    yield row("M18", f"{place}, network {network}: exec to all active, hardware ready", median(starts), "s", at_most(1.5),
              f"{min(starts):.2f} to {max(starts):.2f} of {STARTS}")  # fmt: skip
    if group is not None and (peak := group.peak_mb()) is not None:
        yield row("M18", f"{place}, network {network}: most that the cgroup held", peak, "MB", None, "of 629; without files that were in the page cache before")
