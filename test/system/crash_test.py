# SPDX-License-Identifier: Apache-2.0
"""The ways in which a component ends its container's process: the stop frames, the record, and what a resumed run leaves out."""
import json
import os
import signal
import subprocess
import time
import unittest

from robot import SLOW, RobotTest, wait_for

CHAOS = "nacelle::test::Chaos"
STOP = "STOP\n"


class CrashTest(RobotTest):
    def setUp(self):
        self.log_path = self.folder / "log"
        self.stop_file = self.folder / "stop"
        self.record_path = self.folder / "nacelle/box.composition.crash"
        self.container = None
        # A crash ends the process by its signal, as without a sanitizer.
        for sanitizer in ("ASAN_OPTIONS", "TSAN_OPTIONS"):
            self.environment[sanitizer] = os.environ.get(sanitizer, "") + ":handle_segv=0:handle_abort=0"

    def tearDown(self):
        if self.container and self.container.poll() is None:
            self.container.kill()
            self.container.wait()
        for path in (self.stop_file, *(self.folder / "nacelle").glob("box.composition*")):
            path.unlink(missing_ok=True)

    def begin(self, *arguments):
        with open(self.log_path, "w") as log:
            self.container = self.start_program(*arguments, stdout=log, stderr=subprocess.STDOUT)

    def start(self, *arguments):
        self.begin(*arguments)
        wait_for("it is up", lambda: " active in " in self.said() or self.container.poll() is not None)
        self.assertIsNone(self.container.poll(), self.said())

    def said(self):
        return self.log_path.read_text()

    def ask(self, *arguments):
        return self.expect_exit(self.run_program(*arguments), 0).stdout

    def load(self, name, *more):
        self.ask("component", "load", CHAOS, "--name", name, *more)

    def start_with_a_crane(self):
        self.start("container", "--name", "box")
        self.load("crane", "-p", f"stop_file:={self.stop_file}")
        self.load("chaos")
        self.assertEqual(self.stop_file.read_text(), "")

    def end_by(self, order, who="chaos"):
        """Sends the order; returns the exit status and what the record says."""
        self.run_program("topic", "pub", "--once", f"/{who}/do", "std_msgs/msg/String", json.dumps({"data": order}))
        status = self.container.wait(20)
        if not self.record_path.exists():
            return status, {}
        record = self.record_path.read_text()
        self.assertIn(record, self.said(), "the same is on stderr")
        return status, dict(line.split(": ", 1) for line in record.splitlines() if ": " in line)

    def expect_stops(self, count):
        wait_for(f"{count} stops", lambda: self.stop_file.read_text() == STOP * count, 5)
        wait_for("the watcher reports its stop frame", lambda: "stop frames written by its watcher: 1" in self.said(), 5)


class Ends(CrashTest):
    def test_a_call_of_exit_stops_the_wheels_and_names_the_component(self):
        for order, call in (("exit", "exit(0)"), ("quick exit", "quick_exit(0)")):
            with self.subTest(order):
                self.start_with_a_crane()
                status, record = self.end_by(order)
                self.assertEqual(status, 1, "a supervisor that restarts on failure must see one")
                self.assertEqual(record["signal"], call + " was called")
                self.assertEqual((record["component"], record["callback"]), ("/chaos", "subscription /chaos/do"))
                self.assertRegex(record["component code"], r"/nacelle_test_chaos\.so \+0x[0-9a-f]+$")
                self.expect_stops(3)  # before and after the record, and by the watcher
                self.tearDown()

    def test_an_end_without_a_word_is_the_watchers(self):
        self.start_with_a_crane()
        begin = time.monotonic()
        self.container.kill()
        self.container.wait()
        self.expect_stops(1)
        print(f"SIGKILL to the stop frame, as this test sees it: {(time.monotonic() - begin) * 1e3:.1f} ms")
        self.tearDown()
        self.start_with_a_crane()
        self.assertEqual(self.end_by("_exit"), (0, {}))
        self.expect_stops(1)

    def test_an_orderly_end_leaves_no_process_and_no_stop_of_the_watcher(self):
        self.start_with_a_crane()
        self.container.send_signal(signal.SIGINT)
        self.assertEqual(self.container.wait(20), 0)
        self.assertNotIn("watcher", self.said())

    @unittest.skipIf(SLOW != 1, "a sanitizer defines the same functions of the C library")
    def test_a_thread_that_blocks_all_signals_leaves_a_record(self):
        for order, number in (("blocked abort", signal.SIGABRT), ("overflow", signal.SIGSEGV)):
            with self.subTest(order):
                self.start_with_a_crane()
                status, record = self.end_by(order)
                self.assertEqual(-status, number, self.said())
                self.assertEqual(sorted(record["component"].split(" or ")), ["/chaos", "/crane"])
                self.expect_stops(3)
                self.assertIn("go_deeper" if order == "overflow" else "Chaos", record["symbol"], record)
                self.tearDown()


class CrashesAgain(CrashTest):
    """A component that crashes soon after its activation is left out of the third run."""

    LAUNCH = """
launch:
- node_container:
    name: box
    composable_node:
    - {{pkg: t, plugin: {chaos}, name: good}}
    - {{pkg: t, plugin: {chaos}, name: bad, param: [{{name: fail_in, value: crash}}]}}
"""

    def launch_and_crash(self, *more):
        self.begin("launch", self.file, *more)
        self.assertEqual(-self.container.wait(20), signal.SIGSEGV, self.said())

    def states(self):
        return {row["node"]: row["state"] for row in json.loads(self.ask("component", "list", "--json"))["components"]}

    def test_a_crash_of_the_activation(self):
        self.file = self.folder / "box.launch.yaml"
        self.file.write_text(self.LAUNCH.format(chaos=CHAOS))
        self.launch_and_crash("--resume")
        self.launch_and_crash("--resume")
        self.assertIn("the last run crashed: SIGSEGV at address 0x0 in /bad", self.said())
        self.start("launch", self.file, "--resume")
        self.assertIn("left out: /bad: 2 crashes within 30 s of its activation, the last: SIGSEGV at address 0x0 in /bad", self.said())
        self.assertEqual(self.states(), {"/good": "active"})
        left_out = json.loads(self.ask("faults", "--json"))["left_out"]
        self.assertEqual([(row["node"], row["plugin"]) for row in left_out], [("/bad", CHAOS)])
        self.assertIn("/bad  left out: 2 crashes", self.ask("faults"))
        shown = json.loads(self.ask("topic", "echo", "/diagnostics", "--once", "--json", "--full"))["status"]
        self.assertIn("LEFT_OUT: 2 crashes within 30 s", next(row["message"] for row in shown if row["name"] == "/bad"))
        # Further runs leave it out. It returns by hand, or with a start that resumes nothing.
        self.container.kill()
        self.container.wait()
        self.start("launch", self.file, "--resume")
        self.assertNotIn("the last run crashed", self.said(), "it was killed")
        self.assertEqual(self.states(), {"/good": "active"})
        self.load("bad")
        self.assertEqual(self.states(), {"/good": "active", "/bad": "active"})
        self.assertEqual(json.loads(self.ask("faults", "--json"))["left_out"], [])
        self.container.kill()
        self.container.wait()
        self.launch_and_crash()

    def test_a_crash_soon_after_the_activation_and_what_moves_something_rests(self):
        self.start_with_a_crane()
        for _ in range(2):
            status, record = self.end_by("crash")
            self.assertEqual(-status, signal.SIGSEGV)
            self.assertRegex(record["component age"], r"^[0-9]+ ms since its activation$")
            self.assertIn("Chaos", record["symbol"])
            self.start("container", "--name", "box", "--resume")
        self.assertIn("left out: /chaos: 2 crashes within 30 s", self.said())
        self.assertEqual(self.states(), {"/crane": "inactive"})
        wait_for("the reason is printed", lambda: "/crane moves something, so it was restored as inactive on purpose" in self.said())
        self.assertIn("`nacelle lifecycle set /crane activate` activates it", self.said())
        self.ask("lifecycle", "set", "/crane", "activate")
        self.assertEqual(self.states(), {"/crane": "active"})


if __name__ == "__main__":
    unittest.main()
