# SPDX-License-Identifier: Apache-2.0
"""A robot under a service manager: what it tells it, when it stops feeding the watchdog, reloads, and the entries in the journal."""
import contextlib
import ctypes
import json
import os
import pathlib
import signal
import socket
import struct
import subprocess
import threading
import unittest

from robot import PROGRAM, SLOW, RobotTest, interrupt, wait_for

PERIOD_S = 2.0 * SLOW  # of the watchdog; it is fed four times in it
FILE = """
launch:
- arg: {{name: note, default: "{note}"}}
- node_container:
    pkg: nacelle
    exec: nacelle
    name: robot
    namespace: ''
    composable_node:
    - {{pkg: nacelle_test, plugin: "nacelle::test::Chaos", name: chaos, param: [{{name: note, value: $(var note)}}{more}]}}
    - {{pkg: nacelle_test, plugin: "nacelle::test::Chaos", name: own, thread: own}}
    - {{pkg: nacelle_test, plugin: "nacelle::test::Chaos", name: vital, on_fault: restart_container}}
"""


class Manager:
    """The notification socket of a service manager."""

    def __init__(self, folder):
        self.path = f"{folder}/notify"
        with contextlib.suppress(FileNotFoundError):
            os.unlink(self.path)
        self.socket = socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM)
        self.socket.bind(self.path)
        self.told = []  # every assignment so far

    def read(self):
        with contextlib.suppress(BlockingIOError):
            while True:
                self.told += self.socket.recv(4096, socket.MSG_DONTWAIT).decode().split("\n")
        return list(self.told)

    def wait_for(self, wanted, limit_s=30):
        wait_for(f"{wanted} of {self.told[-10:]}", lambda: wanted in self.read(), limit_s)

    def forget(self):
        self.read()
        self.told.clear()

    def feeds_within(self, seconds):
        self.forget()
        threading.Event().wait(seconds)  # the window
        return self.read().count("WATCHDOG=1")

    def close(self):
        self.socket.close()


class ServiceTest(RobotTest):
    def setUp(self):
        self.manager = Manager(self.folder)
        self.addCleanup(self.manager.close)
        self.file = self.folder / "robot.launch.yaml"
        self.write_file("as launched")
        self.robot = None

    def write_file(self, note, more=""):
        self.file.write_text(FILE.format(note=note, more=more))

    def start(self, *arguments, managed=True, prefix=(), **variables):
        environment = {**self.environment, **variables}
        if managed:
            environment |= {"NOTIFY_SOCKET": self.manager.path, "WATCHDOG_USEC": str(int(PERIOD_S * 1e6))}
        log = open(self.folder / "log", "w+", encoding="utf-8")
        self.addCleanup(log.close)
        self.robot = subprocess.Popen([*prefix, PROGRAM, "launch", str(self.file), *arguments], env=environment, stdout=log, stderr=log,
                                      start_new_session=True)  # fmt: skip
        self.addCleanup(interrupt, self.robot)
        if managed:
            self.manager.wait_for("READY=1", 60)
        else:
            wait_for("it is up", lambda: " active in " in self.said(), 60)

    def said(self):
        return (self.folder / "log").read_text()

    def order(self, who, what):
        self.run_program("topic", "pub", "--once", f"/{who}/do", "std_msgs/msg/String", json.dumps({"data": what}))

    def fault_codes(self):
        report = self.run_program("faults", "--json").stdout
        return [event["code"] for event in json.loads(report)["history"]] if report else []

    def note(self):
        return self.run_program("param", "get", "chaos", "note", "--hide-type").stdout.strip()


class Watchdog(ServiceTest):
    def test_ready_comes_after_the_bring_up_then_feeds_and_stopping_at_the_end(self):
        self.start()
        told = self.manager.read()
        self.assertIn("STATUS=3 components", told)
        self.assertNotIn("WATCHDOG=1", told[: told.index("READY=1")])
        self.assertIn(" active in ", self.said())
        wait_for("some feeds", lambda: self.manager.read().count("WATCHDOG=1") >= 3)
        self.robot.send_signal(signal.SIGINT)
        self.assertEqual(self.robot.wait(30 * SLOW), 0)
        told = self.manager.read()
        self.assertIn("STOPPING=1", told)
        self.assertNotIn("RELOADING=1", told)

    def test_a_component_that_hangs_is_dealt_with_and_the_feeding_goes_on(self):
        """On the shared executor, which another thread takes over, and on its own."""
        self.start()
        for who in ("chaos", "own"):
            self.order(who, "hang")
        wait_for("both are faulted", lambda: self.fault_codes().count("HUNG") == 2)
        self.assertGreaterEqual(self.manager.feeds_within(PERIOD_S), 2)
        self.assertNotIn("is not fed", self.said())

    def test_a_main_thread_that_waits_for_a_component_feeds(self):
        """A restart, a load and a change of state have a limit, after which the process deals with the component."""
        self.start()
        load = self.start_program("component", "load", "nacelle::test::Chaos", "--name", "slow", "-p", "fail_in:=configure for ever")
        self.addCleanup(load.wait)
        self.addCleanup(load.kill)
        self.addCleanup(load.stdout.close)

        def main_thread_waits():
            try:
                self.run_program("component", "list", limit_s=2)
            except subprocess.TimeoutExpired:
                return True
            return False

        wait_for("the main thread answers no question", main_thread_waits, 60)
        self.assertIsNone(load.poll())
        self.assertGreaterEqual(self.manager.feeds_within(2 * PERIOD_S), 4)

    def test_a_hung_component_with_restart_container_stops_the_feeding_and_ends_the_robot(self):
        self.start()
        self.order("vital", "hang")
        wait_for("the robot has ended", lambda: self.robot.poll() is not None, 60)
        self.assertEqual(self.robot.returncode, 1, self.said())
        self.assertIn("/vital is faulted (HUNG", self.said())
        told = self.manager.read()
        self.assertNotIn("WATCHDOG=1", told[told.index("STOPPING=1"):])
        # The next start has the same components in the same states.
        self.manager.forget()
        self.start("--resume")
        rows = json.loads(self.run_program("component", "list", "--json").stdout)["components"]
        self.assertEqual([(row["node"], row["state"]) for row in rows], [("/chaos", "active"), ("/own", "active"), ("/vital", "active")])


class Tracer:
    """Stops single threads of a process, as ptrace(2) can."""

    SEIZE, INTERRUPT, DETACH = 0x4206, 0x4207, 17

    def __init__(self):
        self.call = ctypes.CDLL(None, use_errno=True).ptrace
        self.call.argtypes = [ctypes.c_long, ctypes.c_long, ctypes.c_void_p, ctypes.c_void_p]
        self.stopped = []

    def stop(self, thread):
        for request in (self.SEIZE, self.INTERRUPT):
            if self.call(request, thread, None, None) != 0:
                raise OSError(ctypes.get_errno(), "ptrace")
        os.waitpid(thread, 0x40000000)  # __WALL
        self.stopped.append(thread)

    def resume(self):
        for thread in self.stopped:
            self.call(self.DETACH, thread, None, None)
        self.stopped.clear()


class Stalled(ServiceTest):
    """A thread of the container is stopped: nothing in the process can deal with that."""

    def threads(self, name):
        found = []
        for task in pathlib.Path(f"/proc/{self.robot.pid}/task").iterdir():
            if (task / "comm").read_text().strip() == name:
                found.append(int(task.name))
        return found

    def expect_no_feeds_without(self, threads):
        tracer = Tracer()
        self.assertNotEqual(threads, [])
        self.assertGreaterEqual(self.manager.feeds_within(PERIOD_S), 2)
        try:
            for thread in threads:
                tracer.stop(thread)
        except OSError as failed:
            self.skipTest(f"threads cannot be stopped here: {failed}")
        try:
            self.manager.feeds_within(1.5 * PERIOD_S)  # two looks, and the last feed before them
            self.assertEqual(self.manager.feeds_within(2 * PERIOD_S), 0)
        finally:
            tracer.resume()
        self.assertGreaterEqual(self.manager.feeds_within(2 * PERIOD_S), 2, self.said())

    def test_nothing_is_fed_while_the_main_loop_stands_still(self):
        self.start()
        self.expect_no_feeds_without([self.robot.pid])

    def test_nothing_is_fed_while_the_supervisor_stands_still(self):
        self.start()
        self.expect_no_feeds_without(self.threads("supervisor"))
        self.assertIn("is not fed: the supervisor has made no progress", self.said())

    def test_nothing_is_fed_while_the_executor_stands_still(self):
        self.start()
        self.expect_no_feeds_without(self.threads("executor"))
        self.assertIn("is not fed: executor 'executor' has made no progress", self.said())

    def test_nothing_is_fed_while_the_executor_of_a_component_stands_still(self):
        self.start()
        self.expect_no_feeds_without(self.threads("own"))
        self.assertIn("is not fed: executor 'own' has made no progress", self.said())


class Reload(ServiceTest):
    def reload(self):
        self.manager.forget()
        self.robot.send_signal(signal.SIGHUP)
        self.manager.wait_for("READY=1")
        told = self.manager.read()
        self.assertLess(told.index("RELOADING=1"), told.index("READY=1"))
        self.assertTrue([line for line in told if line.startswith("MONOTONIC_USEC=")])

    def test_sighup_takes_the_parameters_of_the_file_as_it_is_now(self):
        self.start()
        self.assertEqual(self.note(), "as launched")
        self.write_file("changed", ", {name: share, value: 0.75}")
        self.reload()
        self.assertEqual(self.note(), "changed")
        self.assertIn("reloaded: 2 parameters set, 0 refused", self.said())

    def test_what_is_refused_or_cannot_change_is_reported(self):
        self.start()
        self.write_file("changed", ", {name: share, value: 7.0}")
        self.file.write_text(self.file.read_text().replace("name: own,", "name: other,"))
        self.reload()
        self.assertIn("reload: /chaos: share is not set: ", self.said())
        self.assertIn("reload: /other is new in the launch file; the next start loads it", self.said())
        self.assertIn("reload: /own is no longer in the launch file", self.said())
        self.assertIn("reloaded: 1 parameters set, 1 refused", self.said())

    def test_a_file_with_mistakes_changes_nothing(self):
        self.start()
        self.file.write_text(self.file.read_text().replace("thread: own", "thread: owned"))
        self.reload()
        self.assertIn("'thread' cannot be 'owned'", self.said())
        self.assertIn("reload failed: ", self.said())
        self.assertEqual(self.note(), "as launched")

    def test_a_component_that_hangs_delays_only_the_end_of_the_reload(self):
        self.start()
        self.order("chaos", "hang")
        wait_for("it is faulted", lambda: "HUNG" in self.fault_codes())
        self.write_file("changed")
        self.reload()
        self.assertIn("1 refused", self.said())

    def test_without_a_service_manager_sighup_ends_the_robot(self):
        self.start(managed=False)
        self.robot.send_signal(signal.SIGHUP)
        self.assertEqual(self.robot.wait(30 * SLOW), 0)


class Journal(ServiceTest):
    """The socket of the journal stands in a mount namespace of the robot's own."""

    def entries(self, journal):
        with contextlib.suppress(BlockingIOError):
            while True:
                data, fields = journal.recv(1 << 18, socket.MSG_DONTWAIT), {}
                while data:
                    name, _, rest = data.partition(b"\n")
                    (size,) = struct.unpack("<Q", rest[:8])
                    fields[name.decode()] = rest[8 : 8 + size].decode()
                    data = rest[9 + size :]
                self.seen.append(fields)
        return self.seen

    def test_lines_of_a_component_carry_its_name(self):
        if os.geteuid() != 0 or subprocess.run(["unshare", "-m", "true"], capture_output=True).returncode != 0:
            self.skipTest("a mount namespace needs root")
        self.seen = []
        run = self.folder / "run"
        (run / "systemd/journal").mkdir(parents=True)
        journal = socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM)
        self.addCleanup(journal.close)
        journal.bind(str(run / "systemd/journal/socket"))
        (self.folder / "log").touch()
        log = os.stat(self.folder / "log")  # start() writes to the same file
        self.start(prefix=("unshare", "-m", "sh", "-c", f'mount --bind {run} /run && exec "$@"', "sh"),
                   JOURNAL_STREAM=f"{log.st_dev}:{log.st_ino}")  # fmt: skip
        self.order("chaos", "throw")
        mine = wait_for("an entry of the component", lambda: [e for e in self.entries(journal) if "told to throw" in e["MESSAGE"]])
        self.assertEqual(mine[0]["SYSLOG_IDENTIFIER"], "nacelle")
        self.assertEqual(mine[0]["PRIORITY"], "3")
        self.assertEqual(mine[0]["NACELLE_COMPONENT"], "/chaos")
        self.assertNotIn("told to throw", self.said())


if __name__ == "__main__":
    unittest.main()
