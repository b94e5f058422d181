# SPDX-License-Identifier: Apache-2.0
"""What the system tests share: the built program, folders of a test's own, waiting for events with a deadline."""
import contextlib
import json
import os
import pathlib
import shutil
import signal
import subprocess
import tempfile
import time
import unittest

PROGRAM = os.environ["NACELLE_PROGRAM"]
# A shell without job control lets background jobs ignore SIGINT, and the programs started here would inherit that.
signal.signal(signal.SIGINT, signal.default_int_handler)
LAUNCH_FILE = os.environ["NACELLE_LAUNCH_FILE"]
SLOW = float(os.environ.get("NACELLE_TEST_SLOWNESS", "1"))  # sanitizers need more patience
STREAMS_HZ = {"/camera/image_raw": 30, "/scan": 10, "/imu/data_raw": 100, "/odom": 50, "/odometry/filtered": 50}
COUNTER = os.environ.get("NACELLE_ALLOCATION_COUNTER")  # libnacelle_allocation_counter.so; a sanitizer's build has none
# Threads that may allocate: OpenCV's and those that write text.
MAY_ALLOCATE = ("detector", "monitor")
# What the undefined behaviour sanitizer cannot run: it probes memory through a pipe, which needs two descriptors.
needs_no_sanitizer = unittest.skipIf(SLOW > 1, "a sanitizer needs file descriptors of its own")
# It writes a file before main(), and holds a signal back until a write() that waits returns.
needs_no_thread_sanitizer = unittest.skipIf(os.environ.get("NACELLE_SANITIZER") == "thread", "the thread sanitizer is in the way")
# CI sets NACELLE_SHORT and leaves these out. The nightly run and ./dev test have them.
SHORT = bool(os.environ.get("NACELLE_SHORT"))
# For tests of the output of commands: each start takes 0.4 s under a sanitizer, and other tests execute most of the same code.
of_words = unittest.skipIf(SHORT and SLOW > 1, "words are the same under a sanitizer: NACELLE_SHORT is set")
# A case of real time that repeats what a shorter one shows.
nightly = unittest.skipIf(SHORT, "a long case of real time: NACELLE_SHORT is set")


def counting(environment):
    """The environment in which a robot's allocations are counted."""
    libraries = [library for library in (COUNTER, environment.get("LD_PRELOAD")) if library]
    return {**environment, "LD_PRELOAD": ":".join(libraries)}


def wait_for(what, condition, limit_s=20.0):
    """Polls until the condition answers something true, and returns that."""
    deadline = time.monotonic() + limit_s * SLOW
    while True:
        answer = condition()
        if answer:
            return answer
        if time.monotonic() > deadline:
            raise AssertionError(f"not within {limit_s} s: {what}")
        time.sleep(0.02)  # the polling period, not a synchronisation


def expect_rate(read, expected, delta):
    """Reads a rate until it is expected +- delta. Other tests run at the same time: a robot that waits for a processor has another
    rate for some seconds. Rates that must hold at the first reading are checked by the tests named *_in_time, which run alone."""
    seen = []

    def fits():
        seen.append(read())
        return abs(seen[-1] - expected) <= delta * SLOW

    try:
        wait_for(f"{expected} +- {delta}", fits)
    except AssertionError as late:
        raise AssertionError(f"{late}: {seen}") from None


def interrupt(process):
    """Ends it as Ctrl-C does, if it still runs; returns when it has ended."""
    process.send_signal(signal.SIGINT)
    try:
        process.wait(30 * SLOW)
    except subprocess.TimeoutExpired:
        process.kill()
        process.wait()


class RobotTest(unittest.TestCase):
    """Each class has a runtime folder of its own, so that its containers are alone."""

    has_own_network = False  # else its robots stay off the network: those of other tests, and of this machine, do not meet them

    @classmethod
    def setUpClass(cls):
        cls.folder = pathlib.Path(tempfile.mkdtemp(prefix="nacelle-system-"))
        cls.environment = {**os.environ, "XDG_RUNTIME_DIR": str(cls.folder)}
        cls.environment.pop("NACELLE_CONTAINER", None)
        if not cls.has_own_network:
            cls.environment["ROS_AUTOMATIC_DISCOVERY_RANGE"] = "OFF"

    def run(self, result=None):
        """As unittest's; notes how long each case took, for .ci/last_run.py."""
        begin = time.monotonic()
        super().run(result)
        if "NACELLE_CASE_TIMES" in os.environ:
            with open(os.environ["NACELLE_CASE_TIMES"], "a", encoding="utf-8") as times:
                times.write(f"{time.monotonic() - begin:.2f}\t{self.id()}\n")

    @classmethod
    def tearDownClass(cls):
        shutil.rmtree(cls.folder, ignore_errors=True)

    @classmethod
    def run_program(cls, *arguments, limit_s=60, **options):
        # The address sanitizer looks for leaks at the end of a program, which doubles the time of a command. Robots, which
        # start_program() starts, are searched.
        without_leaks = {"ASAN_OPTIONS": f"{os.environ.get('ASAN_OPTIONS', '')}:detect_leaks=0"} if SLOW > 1 else {}
        options["env"] = {**options.get("env", cls.environment), **without_leaks}
        options.setdefault("capture_output", True)
        return subprocess.run([PROGRAM, *map(str, arguments)], text=True, timeout=limit_s * SLOW, **options)

    @classmethod
    def start_program(cls, *arguments, **options):
        options.setdefault("stdout", subprocess.PIPE)
        options.setdefault("stderr", subprocess.STDOUT)
        options.setdefault("env", cls.environment)
        return subprocess.Popen([PROGRAM, *map(str, arguments)], text=True, start_new_session=True, **options)

    def expect_exit(self, outcome, code):
        self.assertEqual(outcome.returncode, code, f"{outcome.args}\n{outcome.stdout}\n{outcome.stderr}")
        return outcome

    def our_processes(self):
        """Command lines of living processes that were given this class's folder."""
        found = []
        for entry in pathlib.Path("/proc").glob("[0-9]*"):
            with contextlib.suppress(OSError):
                command = (entry / "cmdline").read_bytes().replace(b"\0", b" ").decode(errors="replace")
                if str(self.folder) in command and PROGRAM in command:
                    found.append(command)
        return found


class RunningRobotTest(RobotTest):
    """One simulated robot for all tests of the class."""

    arguments = ()

    @classmethod
    def make_launch_file(cls):
        return LAUNCH_FILE

    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        cls.launch_file = cls.make_launch_file()
        cls.log = open(cls.folder / "log", "w+", encoding="utf-8")
        cls.report_file = cls.folder / "report.json"
        cls.robot = cls.start_program(
            "launch", cls.launch_file, "sim:=true", "seed:=5", f"sim_dir:={cls.folder}/sim", "--name", "robot", "--report", cls.report_file,
            *cls.arguments, stdout=cls.log, stderr=subprocess.STDOUT,
        )
        try:
            wait_for("every component is active", cls.is_up, 60)
        except BaseException:
            cls.tearDownClass()
            raise

    @classmethod
    def is_up(cls):
        if cls.robot.poll() is not None:
            raise AssertionError("the robot ended: " + (cls.folder / "log").read_text())
        listed = cls.run_program("component", "list", "--json")
        rows = json.loads(listed.stdout)["components"] if listed.returncode == 0 else []
        return len(rows) >= 10 and all(row["state"] in ("active", "") for row in rows)

    @classmethod
    def tearDownClass(cls):
        interrupt(cls.robot)
        cls.log.close()
        super().tearDownClass()

    def streams(self):
        return {row["name"]: row for row in json.loads(self.expect_exit(self.run_program("streams", "--json", "--interval", "0.1"), 0).stdout)["streams"]}
