# SPDX-License-Identifier: Apache-2.0
"""Guests of the control socket, and what a container may run out of: too many, silent, stopped, without descriptors or threads."""
import contextlib
import json
import os
import pathlib
import re
import resource
import signal
import socket
import struct
import subprocess
import time
import unittest

from control import Control
from robot import PROGRAM, SLOW, RobotTest, needs_no_sanitizer, wait_for

CHAOS, STRING = "nacelle::test::Chaos", "std_msgs/msg/String"
OTHER_USER = 12340
STOP = ("estop", "set", "--topic", "/emergency_stop")


def string(text):
    data = text.encode() + b"\0"
    return b"\0\1\0\0" + struct.pack("<I", len(data)) + data


class ContainerTest(RobotTest):
    """An empty container, filled by hand; one for each test."""

    LIMIT = 256  # of descriptors

    def setUp(self):
        self.log_path = self.folder / "log"
        self.sockets = contextlib.ExitStack()
        self.start()

    def tearDown(self):
        self.sockets.close()
        if self.container.poll() is None:
            self.container.send_signal(signal.SIGCONT)
            self.container.send_signal(signal.SIGINT)
            self.container.communicate(timeout=30 * SLOW)

    def start(self, **options):
        with open(self.log_path, "w") as log:
            self.container = self.start_program(
                "container", "--name", "box", stdout=log, stderr=subprocess.STDOUT,
                preexec_fn=lambda: resource.setrlimit(resource.RLIMIT_NOFILE, (self.LIMIT, self.LIMIT)), **options)  # fmt: skip
        wait_for("it is up", lambda: " active in " in self.said() or self.container.poll() is not None)
        self.assertIsNone(self.container.poll(), self.said())
        self.path = self.folder / "nacelle/box.sock"

    def said(self):
        return self.log_path.read_text()

    def load(self, name, *more):
        return self.expect_exit(self.run_program("component", "load", CHAOS, "--name", name, *more), 0)

    def connect(self):
        return self.sockets.enter_context(contextlib.closing(Control(self.path)))

    def silent(self):
        guest = self.sockets.enter_context(socket.socket(socket.AF_UNIX, socket.SOCK_STREAM))
        guest.settimeout(10)
        guest.connect(str(self.path))
        return guest

    def control_cpu_s(self):
        for task in os.listdir(f"/proc/{self.container.pid}/task"):
            fields = pathlib.Path(f"/proc/{self.container.pid}/task/{task}/stat").read_text()
            if "(control)" in fields:
                words = fields[fields.rindex(")") + 2:].split()
                return (int(words[11]) + int(words[12])) / os.sysconf("SC_CLK_TCK")
        raise AssertionError("no control thread")


class Guests(ContainerTest):
    def test_idle_connections_block_neither_stops_nor_commands(self):
        for _ in range(64):
            self.silent()
        self.expect_exit(self.run_program(*STOP), 0)
        wait_for("the silent ones make room", lambda: self.run_program("component", "list").returncode == 0)

    def test_a_client_with_all_writers_does_not_block_a_stop(self):
        hoarder = self.connect()
        with self.assertRaisesRegex(RuntimeError, "too many writers"):
            for number in range(1000):
                hoarder.open_writer(f"/topic{number}", STRING)
        self.expect_exit(self.run_program(*STOP), 0)

    def test_pending_requests_do_not_end_the_robot(self):
        self.load("chaos")
        request = json.dumps({"verb": "service.call", "service": "/chaos/answer", "type": "std_srvs/srv/SetBool",
                              "request": {"data": False}, "timeout_s": 600})  # fmt: skip
        for _ in range(340):
            with contextlib.suppress(OSError):  # refused
                self.connect().send(b"j", request.encode())
        self.expect_exit(self.run_program(*STOP), 0)
        self.assertIsNone(self.container.poll(), self.said())
        newest = self.connect()
        newest.send(b"j", b'{"verb":"graph"}')
        _, answer = newest.receive()
        self.assertRegex(answer.decode(), "connections for requests are in use|only emergency stops and shutdown are accepted|too many requests are pending")

    @needs_no_sanitizer
    def test_a_limit_that_is_lowered_below_what_is_open_does_not_end_the_robot(self):
        for _ in range(60):
            self.connect()
        resource.prlimit(self.container.pid, resource.RLIMIT_NOFILE, (48, 48))  # poll() refuses more than that
        self.expect_exit(self.run_program(*STOP), 0)
        self.assertIsNone(self.container.poll(), self.said())

    @needs_no_sanitizer
    def test_out_of_descriptors_is_a_fault_and_accepts_a_stop(self):
        self.load("chaos")
        orders, listener = self.connect(), self.connect()
        handle = orders.open_writer("/chaos/do", STRING)
        listener.send(b"j", json.dumps({"verb": "topic.listen", "topic": "/diagnostics", "show": "json"}).encode())
        self.assertEqual(json.loads(listener.receive()[1]).get("ok"), True)
        orders.publish(handle, string("hoard"))
        descriptors = f"/proc/{self.container.pid}/fd"
        wait_for("all are taken", lambda: len(os.listdir(descriptors)) == self.LIMIT)

        self.expect_exit(self.run_program(*STOP), 0)

        wait_for("the log says so", lambda: "file descriptors of the process are in use" in self.said())
        wait_for("the diagnostics say so", lambda: b"out_of_descriptors" in listener.receive()[1])
        for _ in range(8):
            self.silent()  # they wait in the listener's queue, which stays readable
        before, begin = self.control_cpu_s(), time.monotonic()
        wait_for("a while is over", lambda: time.monotonic() - begin > 2, 5)
        self.assertLess(self.control_cpu_s() - before, 0.2 * (time.monotonic() - begin), "it spins")
        refused = self.run_program("component", "list")
        self.assertEqual(refused.returncode, 1)
        self.assertRegex(refused.stderr, "only emergency stops and shutdown are accepted")

        orders.publish(handle, string("reset"))
        wait_for("it is over", lambda: "file descriptors are available again" in self.said())
        wait_for("commands are served again", lambda: self.run_program("component", "list").returncode == 0)
        self.assertIsNone(json.loads(self.run_program("faults", "--json").stdout)["container"])

    def test_closed_descriptors_are_a_failure_with_a_stop_frame_and_a_kept_state(self):
        stop = self.folder / "stop"
        self.load("crane", "-p", f"stop_file:={stop}")
        orders = self.connect()
        handle = orders.open_writer("/crane/do", STRING)
        state = self.folder / "nacelle/box.composition"
        wait_for("the state is kept", lambda: "crane" in state.read_text())

        orders.publish(handle, string("close"))

        self.assertEqual(self.container.wait(30 * SLOW), 1, self.said())
        self.assertIn("STOP", stop.read_text())
        self.assertIn("a component closed file descriptors of the container", self.said())
        self.assertIn("crane", state.read_text())

    def test_a_stopped_container_is_reported_at_once(self):
        self.container.send_signal(signal.SIGSTOP)
        begin = time.monotonic()
        outcome = self.expect_exit(self.run_program("component", "list"), 1)
        self.assertLess(time.monotonic() - begin, 10 * SLOW)
        self.assertIn(f"its process {self.container.pid} is stopped", outcome.stderr)
        self.assertIn(f"kill -CONT {self.container.pid}", outcome.stderr)
        self.container.send_signal(signal.SIGCONT)
        self.expect_exit(self.run_program("component", "list"), 0)

    def test_a_low_limit_of_open_files_is_refused_at_start(self):
        for limit in (6, 8, 16, 63):
            outcome = self.run_program("container", "--name", "small", limit_s=20,
                                       preexec_fn=lambda n=limit: resource.setrlimit(resource.RLIMIT_NOFILE, (n, n)))  # fmt: skip
            self.expect_exit(outcome, 1)
            self.assertIn(f"the limit of {limit} open files is too low", outcome.stderr)
            self.assertIn("ulimit -n", outcome.stderr)


class Threads(ContainerTest):
    """RLIMIT_NPROC does not bind root, so the container is another user's then."""

    def start(self, **options):
        if os.geteuid() == 0:
            outcome = None
            with contextlib.suppress(OSError):
                outcome = subprocess.run([PROGRAM, "--version"], capture_output=True, **self.USER)
            if outcome is None or outcome.returncode != 0:
                self.container = subprocess.Popen(["true"])
                self.skipTest("another user cannot run the program here, and root has no limit of threads")
            os.chown(self.folder, OTHER_USER, OTHER_USER)
            options |= self.USER
        super().start(**options)

    USER = {"user": OTHER_USER, "group": OTHER_USER, "extra_groups": []} if os.geteuid() == 0 else {}

    def run_as_its_user(self, *arguments):
        return self.run_program(*arguments, **self.USER)

    def limit_threads(self, soft):
        subprocess.run(["prlimit", "--pid", str(self.container.pid), f"--nproc={soft}"], check=True, **self.USER)

    def test_a_component_for_which_no_thread_can_be_started_is_refused(self):
        self.expect_exit(self.run_as_its_user("component", "load", CHAOS, "--name", "first"), 0)
        limits = pathlib.Path(f"/proc/{self.container.pid}/limits").read_text()
        before = re.search(r"Max processes +(\d+|unlimited)", limits)[1]
        self.limit_threads("1:")
        for _ in range(3):
            refused = self.expect_exit(self.run_as_its_user("component", "load", CHAOS, "--name", "second"), 1)
            self.assertIn("Resource temporarily unavailable", refused.stderr)
        self.assertIsNone(self.container.poll(), self.said())
        self.expect_exit(self.run_as_its_user("component", "list"), 0)

        self.limit_threads(f"{before}:")

        self.expect_exit(self.run_as_its_user("component", "load", CHAOS, "--name", "second"), 0)
        self.expect_exit(self.run_as_its_user("component", "unload", "first"), 0)


if __name__ == "__main__":
    unittest.main()
