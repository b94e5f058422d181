# SPDX-License-Identifier: Apache-2.0
"""Faults injected into the running simulated robot: which component is faulted, why, the consequences, and the effect on the others."""
import json
import os
import pathlib
import select
import signal
import subprocess
import threading
import time
import unittest

from control import Control
from cpu_waits import BUSY_S, CpuWatch
from robot import SLOW, RobotTest, RunningRobotTest, nightly, wait_for

CHAOS = pathlib.Path(__file__).parent / "chaos/chaos.launch.yaml"
# What a fault elsewhere must not touch.
STEADY_HZ = {"/imu/data_raw": 100, "/odom": 50, "/odometry/filtered": 50, "/camera/image_raw": 30}


class ChaosTest(RunningRobotTest):
    """The simulated robot with /chaos (degrade), /patient (restart, two times) and /crane (it moves something)."""

    @classmethod
    def setUpClass(cls):
        super(RunningRobotTest, cls).setUpClass()
        cls.stop_file = cls.folder / "stop"
        for sanitizer in ("ASAN_OPTIONS", "TSAN_OPTIONS"):  # a crash ends the process by its signal, as without one
            cls.environment[sanitizer] = os.environ.get(sanitizer, "") + ":handle_segv=0:handle_abort=0"
        cls.start_robot()

    MORE = ""  # components

    @classmethod
    def start_robot(cls, *more):
        cls.log = open(cls.folder / "log", "w+")
        file = cls.folder / "chaos.launch.yaml"
        file.write_text(CHAOS.read_text() + cls.MORE.format(folder=cls.folder))
        cls.robot = cls.start_program("launch", file, f"sim_dir:={cls.folder}/sim", f"stop_file:={cls.stop_file}", "--name", "robot", *more,
                                      stdout=cls.log, stderr=subprocess.STDOUT)  # fmt: skip
        try:
            wait_for("every component is active", cls.is_up, 60)
        except BaseException:
            cls.tearDownClass()
            raise

    def order(self, who, what, kills=False):
        sent = self.run_program("topic", "pub", "--once", f"/{who}/do", "std_msgs/msg/String", json.dumps({"data": what}))
        if not kills:
            self.expect_exit(sent, 0)

    def said(self):
        return (self.folder / "log").read_text()

    def faults(self):
        return json.loads(self.expect_exit(self.run_program("faults", "--json"), 0).stdout)

    def last_of(self, node, code=None):
        """The last fault of a node, once it has one (with this code)."""
        def look():
            mine = [event for event in self.faults()["history"] if event["node"] == node and code in (None, event["code"])]
            return mine[-1] if mine else None

        return wait_for(f"{node} is faulted{' with ' + code if code else ''}: {self.faults()}", look)

    def state_of(self, node):
        listed = json.loads(self.expect_exit(self.run_program("component", "list", "--json"), 0).stdout)
        return {row["node"]: row for row in listed["components"]}.get(node)

    def expect_steady(self, seconds=5.0):
        """Over a window that begins now, each stream keeps its rate within 1 % (and the one message that the window's ends cut).

        If the machine makes the robot wait for a CPU, the window says nothing about the robot, and the next one is used.
        """
        control = Control(self.folder / "nacelle" / "robot.sock")  # a command of its own takes a tenth of a second and more to ask
        self.addCleanup(control.close)
        question = json.dumps({"verb": "service.call", "service": "/robot/_container/get_statistics",
                               "type": "nacelle_interfaces/srv/GetStatistics", "request": {}, "timeout_s": 5}).encode()  # fmt: skip

        def counts():
            asked = time.monotonic()
            control.send(b"j", question)
            streams = json.loads(control.receive()[1])["response"]["streams"]
            told = time.monotonic()
            return asked, {row["name"]: row["published"] for row in streams}, told

        for windows_left in reversed(range(4)):
            first_asked, first, first_told = counts()
            with CpuWatch() as watch:
                threading.Event().wait(seconds)  # the window
            last_asked, last, last_told = counts()
            least_s, most_s = last_asked - first_told, last_told - first_asked
            published = {name: last[name] - first[name] for name in STEADY_HZ}
            for name in STEADY_HZ:
                self.assertGreater(published[name], 0, name)
            if SLOW != 1:  # the sanitizer would be measured
                return
            late = [name for name, hz in STEADY_HZ.items() if not 0.99 * hz * least_s - 1 <= published[name] <= 1.01 * hz * most_s + 1]
            if not late:
                return
            if watch.longest_s < BUSY_S or windows_left == 0:
                self.fail(f"{late} of {published} in {least_s:.3f} to {most_s:.3f} s; a thread waited {watch.longest_s * 1e3:.0f} ms for a CPU")


class Faults(ChaosTest):
    def test_an_exception_faults_only_its_component(self):
        self.order("chaos", "throw")
        event = self.last_of("/chaos", "EXCEPTION")
        self.assertEqual((event["text"], event["callback"]), ("told to throw", "subscription /chaos/do"))
        row = self.state_of("/chaos")
        self.assertEqual(row["state"], "unconfigured")
        self.assertEqual(row["fault"]["code"], "EXCEPTION")
        self.expect_steady()
        text = self.expect_exit(self.run_program("faults"), 0).stdout
        self.assertIn("/chaos  unconfigured  faulted: EXCEPTION: told to throw  (in subscription /chaos/do)\n  on_fault: degrade", text)
        diagnostics = json.loads(self.expect_exit(self.run_program("topic", "echo", "/diagnostics", "--once", "--json", "--full"), 0).stdout)
        self.assertIsInstance(diagnostics["status"], list)
        self.recover("chaos")

    def recover(self, who):
        self.expect_exit(self.run_program("lifecycle", "set", who, "configure"), 0)
        self.expect_exit(self.run_program("lifecycle", "set", who, "activate"), 0)
        self.assertNotIn("fault", self.state_of(f"/{who}"))

    def test_a_reader_thread_that_ends_faults_its_component(self):
        self.order("chaos", "thread")
        event = self.last_of("/chaos", "READER_ENDED")
        self.assertEqual((event["text"], event["callback"]), ("the decoder gave up", "thread chaos_rx"))
        self.recover("chaos")

    def test_a_reported_fault_and_a_failed_transition_are_kept_with_their_reason(self):
        self.order("chaos", "fault")
        self.assertEqual(self.last_of("/chaos", "TOLD_TO")["text"], "a fault on command")
        self.expect_exit(self.run_program("lifecycle", "get", "chaos"), 0)
        self.recover("chaos")
        loaded = self.run_program("component", "load", "nacelle::test::Chaos", "--name", "broken", "-p", "fail_in:=configure")
        self.expect_exit(loaded, 1)
        self.assertIn("cannot be configured", loaded.stderr)
        event = self.last_of("/broken", "TRANSITION_FAILED")
        self.assertEqual((event["text"], event["callback"]), ("cannot be configured", "transition on_configure"))

    def test_publishes_states_as_ros_does(self):
        listening = self.start_program("topic", "echo", "/chaos/transition_event", "--json", stderr=subprocess.DEVNULL)
        try:
            def events_have_come():
                for transition in ("deactivate", "activate"):
                    self.expect_exit(self.run_program("lifecycle", "set", "chaos", transition), 0)
                return select.select([listening.stdout], [], [], 0)[0]

            wait_for("a listener is there", events_have_come)
            self.expect_exit(self.run_program("lifecycle", "set", "chaos", "deactivate"), 0)
            self.expect_exit(self.run_program("lifecycle", "set", "chaos", "activate"), 0)
            events = [json.loads(listening.stdout.readline()) for _ in range(4)]
        finally:
            listening.kill()
            listening.communicate()
        seen = [(e["transition"]["id"], e["transition"]["label"], e["start_state"]["label"], e["goal_state"]["label"]) for e in events]
        down = [(4, "deactivate", "active", "deactivating"), (40, "transition_success", "deactivating", "inactive")]
        up = [(3, "activate", "inactive", "activating"), (30, "transition_success", "activating", "active")]
        ring = down + up  # the first one that is heard may be any of them
        self.assertIn(seen, [ring[first:] + ring[:first] for first in range(4)])

    def test_a_flood_a_leak_and_a_lie_do_not_harm_other_components(self):
        self.order("chaos", "leak")
        self.order("chaos", "lie")
        self.order("chaos", "flood")
        # The flooding callback ends within handover_after's reach of half a second; then the window begins.
        wait_for("the flood is over", lambda: self.streams()["/chaos/alive"]["published"] > 1000)
        self.expect_steady()
        self.order("chaos", "reset")
        self.assertEqual(self.state_of("/chaos")["state"], "active")
        self.assertEqual(self.faults()["robot_stopped_by"], None)

    @nightly
    def test_load_on_every_core_faults_no_component(self):
        burners = [subprocess.Popen(["/usr/bin/python3", "-c", "while True: pass"]) for _ in range(os.cpu_count() or 1)]
        try:
            before = len(self.faults()["history"])
            threading.Event().wait(float(os.environ.get("NACELLE_TEST_LOAD_S", "4")))  # the load
            self.assertEqual(len(self.faults()["history"]), before)
        finally:
            for burner in burners:
                burner.kill()
                burner.wait()


class Hangs(ChaosTest):
    def test_a_hanging_component_is_named_and_replaced_and_the_others_keep_their_rate(self):
        self.order("patient", "hang")
        event = self.last_of("/patient", "HUNG")
        self.assertEqual(event["callback"], "subscription /patient/do")
        self.assertIn("/patient has been running for", event["text"])
        wait_for("a new one stands beside it", lambda: "/patient was restarted" in self.said())
        self.assertEqual(self.state_of("/patient")["state"], "active")
        self.expect_steady()
        kept = json.loads(self.run_program("component", "list", "--json").stdout)["kept_images"]
        self.assertIn("/patient", [row["node"] for row in kept])


class StopsTheRobot(ChaosTest):
    def test_a_fault_of_what_moves_something_stops_everything_that_moves(self):
        self.order("patient", "throw")  # its restart is due after the stop
        self.last_of("/patient", "EXCEPTION")
        self.order("crane", "throw")
        wait_for("the robot is stopped", lambda: self.faults()["robot_stopped_by"] == "/crane")
        self.assertIn("STOP\n", self.stop_file.read_text())
        rows = {row["node"]: row["state"] for row in json.loads(self.run_program("component", "list", "--json").stdout)["components"]}
        self.assertNotIn("active", rows.values(), rows)
        self.assertEqual([row for row in self.faults()["components"] if "next_restart_s" in row], [], "nothing comes back by itself")
        self.assertEqual(rows["/diff_drive"], "inactive")
        # It stays to be looked at, and the run says at its end that something went wrong.
        self.robot.send_signal(signal.SIGINT)
        self.assertEqual(self.robot.wait(30 * SLOW), 1)


class StopsBesideAHang(ChaosTest):
    """/far is an actuator in a process of its own, and its deactivation never returns."""

    MORE = """    - pkg: nacelle_test
      plugin: nacelle::test::Chaos
      name: far
      isolate: process
      param: [{{name: stop_file, value: {folder}/far_stop}}, {{name: fail_in, value: deactivate for ever}}]
"""

    def test_the_stop_reaches_what_is_far_at_once_and_a_signal_is_obeyed_though_it_hangs(self):
        far = self.folder / "far_stop"
        self.assertEqual(far.read_text(), "")
        begin = time.monotonic()
        self.order("crane", "throw")
        wait_for("the far one is stopped", lambda: "STOP\n" in far.read_text(), 5)
        took = time.monotonic() - begin
        print(f"a fault here to the stop in another process, with the program that orders it: {took * 1e3:.0f} ms")
        self.assertIn("STOP\n", self.stop_file.read_text())
        self.assertLess(took, 5 * SLOW, "and not after the 30 s of a deactivation")
        begin = time.monotonic()
        self.robot.send_signal(signal.SIGINT)
        self.assertEqual(self.robot.wait(30 * SLOW), 1)
        took = time.monotonic() - begin
        print(f"SIGINT to the end, beside a deactivation that hangs: {took:.1f} s")
        self.assertLess(took, 15 * SLOW)
        self.assertEqual(self.our_processes(), [])


class ClosesTheDescriptorsOfItsProcess(ChaosTest):
    MORE = """    - pkg: nacelle_test
      plugin: nacelle::test::Chaos
      name: far
      isolate: process
      param: [{{name: stop_file, value: {folder}/far_stop}}]
"""

    def test_its_process_ends_with_its_stop_frame_and_the_robot_stops(self):
        self.order("far", "close")
        wait_for("its process has ended and says why", lambda: "a component closed file descriptors of its process" in self.said())
        self.assertIn("STOP\n", (self.folder / "far_stop").read_text())
        self.assertIn("its process exited with 1", self.last_of("/far")["text"])
        self.assertEqual(self.faults()["robot_stopped_by"], "/far")


class Crashes(ChaosTest):
    def crash(self, order, number):
        self.order("crane", order, kills=True)
        self.assertEqual(-self.robot.wait(20 * SLOW), number)
        record = (self.folder / "nacelle/robot.composition.crash").read_text()
        self.assertIn(record, self.said(), "the same is on stderr")
        self.assertTrue(record.endswith("end\n"), record)
        return dict(line.split(": ", 1) for line in record.splitlines() if ": " in line)

    def test_a_crash_leaves_stopped_wheels_and_a_record(self):
        record = self.crash("crash", signal.SIGSEGV)
        self.assertEqual((record["component"], record["callback"], record["stream"]), ("/crane", "subscription /crane/do", "/crane/do"))
        self.assertRegex(record["library"], r"/nacelle_test_chaos\.so \+0x[0-9a-f]+$")
        self.assertEqual(record["signal"], "SIGSEGV at address 0x0")
        self.assertEqual(record["safe stops written"], "2", "the crane's and the base's")
        wait_for("it is stopped before and after the record, and by the watcher", lambda: self.stop_file.read_text() == "STOP\n" * 3, 5)
        # After it everything is there again, what moves something at rest.
        self.log.close()
        begin = time.monotonic()
        type(self).log = open(self.folder / "log", "w+")
        type(self).robot = self.start_program("launch", self.folder / "chaos.launch.yaml", f"sim_dir:={self.folder}/sim", f"stop_file:={self.stop_file}", "--name", "robot", "--resume",
                                              stdout=self.log, stderr=subprocess.STDOUT)  # fmt: skip
        wait_for("it is up again", lambda: " active in " in self.said())
        print(f"back after {time.monotonic() - begin:.2f} s")
        self.assertIn("the last run crashed: SIGSEGV at address 0x0 in /crane, subscription /crane/do", self.said())
        self.assertEqual(self.state_of("/crane")["state"], "inactive")
        self.assertEqual(self.state_of("/diff_drive")["state"], "inactive")
        self.assertEqual(self.state_of("/lidar")["state"], "active")
        # An uncaught exception, in a thread of the component's own.
        record = self.crash_of_a_thread()
        self.assertEqual(record["signal"], "SIGABRT")
        self.assertEqual(sorted(record["component"].split(" or ")), ["/chaos", "/crane", "/patient"])
        self.assertRegex(record["component code"], r"/nacelle_test_chaos\.so \+0x[0-9a-f]+$")

    def crash_of_a_thread(self):
        self.order("chaos", "abort", kills=True)
        self.assertEqual(-self.robot.wait(20 * SLOW), signal.SIGABRT)
        record = (self.folder / "nacelle/robot.composition.crash").read_text()
        return dict(line.split(": ", 1) for line in record.splitlines() if ": " in line)


class DriveThatStays(RobotTest):
    def test_a_degraded_component_does_not_end_it_and_its_world_is_found(self):
        file = self.folder / "chaos.launch.yaml"
        file.write_text(CHAOS.read_text().replace("- include:", "- arg: {name: sim}\n- arg: {name: seed}\n- include:"))
        drive = self.start_program("drive", "--stay", file)
        try:
            wait_for("it runs", lambda: "running" in drive.stdout.readline(), 60)
            self.expect_exit(self.run_program("topic", "pub", "--once", "/chaos/do", "std_msgs/msg/String", '{"data": "throw"}'), 0)
            wait_for("it is faulted", lambda: "EXCEPTION" in self.run_program("faults").stdout)
            # Longer than a look of the drive at its components.
            self.expect_exit(self.run_program("topic", "hz", "/imu/data_raw", "--once"), 0)
            self.expect_exit(self.run_program("topic", "hz", "/imu/data_raw", "--once"), 0)
            self.assertIsNone(drive.poll())
            truth = json.loads(self.expect_exit(self.run_program("sim", "truth"), 0).stdout)
            self.assertEqual(truth["speed_mps"], 0)
        finally:
            drive.send_signal(signal.SIGINT)
            rest, _ = drive.communicate(timeout=60 * SLOW)
        self.assertIn("EXCEPTION", rest)
        self.assertIn("no simulated world runs there", self.expect_exit(self.run_program("sim", "truth"), 1).stderr)


if __name__ == "__main__":
    unittest.main()
