# SPDX-License-Identifier: Apache-2.0
"""`isolate: process`: the default robot with its LiDAR driver and its detector in processes of their own."""
import json
import os
import pathlib
import re
import signal
import subprocess
import unittest

from machines import Lines
from robot import LAUNCH_FILE, PROGRAM, SLOW, RobotTest, RunningRobotTest, interrupt, wait_for

ISOLATED = ("lidar", "detector")


class IsolatedRobot(RunningRobotTest):
    @classmethod
    def start_program(cls, *arguments, **options):
        if arguments and arguments[0] == "launch":
            source = pathlib.Path(LAUNCH_FILE)
            text = source.read_text()
            for name in ISOLATED:
                text, count = re.subn(rf"^( +)name: {name}$", rf"\1name: {name}\n\1isolate: process", text, flags=re.MULTILINE)
                assert count == 1, name
            text = cls.changed(text)
            copy = cls.folder / "isolated.launch.yaml"
            copy.write_text(text)
            own = (f"config:={source.parent}/config/robot.yaml", f"description:={source.parent}/robot.urdf")
            arguments = ("launch", copy, *own, *arguments[2:])
        return super().start_program(*arguments, **options)

    @classmethod
    def changed(cls, text):
        """The launch file's text with what else is different."""
        return text

    def components(self):
        rows = json.loads(self.expect_exit(self.run_program("component", "list", "--json"), 0).stdout)["components"]
        return {row["node"]: row for row in rows}

    def child_of(self, node):
        """The process id of an isolated component; None: it has none."""
        for entry in pathlib.Path("/proc").glob("[0-9]*"):
            try:
                words = (entry / "cmdline").read_bytes().split(b"\0")
                parent = int((entry / "stat").read_text().rsplit(")", 1)[1].split()[1])
            except (OSError, IndexError):
                continue
            if parent == self.robot.pid and b"isolated" in words and node.encode() in words:
                return int(entry.name)
        return None

    def expect_flow(self, topic):
        """Messages come."""
        before = self.streams()[topic]["published"]
        wait_for(f"{topic} flows", lambda: self.streams()[topic]["published"] >= before + 3)

    def rate(self, topic):
        text = self.expect_exit(self.run_program("topic", "hz", topic, "--once"), 0).stdout
        return float(re.search(r"average rate: ([\d.]+)", text)[1])


class Isolated(IsolatedRobot):
    def test_1_streams_flow_across_the_border(self):
        for name in ISOLATED:
            self.assertIsNotNone(self.child_of(f"/{name}"))
        self.expect_flow("/scan")
        self.assertGreater(wait_for("a scan is counted as copied", lambda: self.streams()["/scan"]["copies"]), 0)
        # Both ends of a stream: the images go there, the detections come back.
        wait_for("a detection", lambda: self.streams()["/detections"]["published"] > 0)

    def test_2_its_lifecycle_is_that_of_any_component(self):
        self.expect_exit(self.run_program("lifecycle", "set", "/lidar", "deactivate"), 0)
        self.assertEqual(self.run_program("lifecycle", "get", "/lidar").stdout, "inactive [2]\n")
        # ROS 2's tools see each step.
        heard = self.folder / "events"
        with open(heard, "w") as file:
            listening = self.start_program("topic", "echo", "/lidar/transition_event", "--json", stdout=file, stderr=subprocess.DEVNULL)
        try:
            def steps_have_come():
                for transition in ("activate", "deactivate"):
                    self.expect_exit(self.run_program("lifecycle", "set", "/lidar", transition), 0)
                events = [json.loads(line) for line in heard.read_text().split("\n")[:-1]]
                return {(e["start_state"]["label"], e["goal_state"]["label"]) for e in events} >= {
                    ("inactive", "activating"), ("activating", "active"), ("active", "deactivating"), ("deactivating", "inactive")}

            wait_for("its transitions are published", steps_have_come)
        finally:
            listening.kill()
            listening.wait()
        refused = self.expect_exit(self.run_program("lifecycle", "set", "/lidar", "configure"), 1)
        self.assertIn("could not configure", refused.stderr)
        self.expect_exit(self.run_program("lifecycle", "set", "/lidar", "activate"), 0)
        self.expect_flow("/scan")

    def test_2b_its_services_are_those_of_any_component(self):
        def call(service, kind, values="{}"):
            text = self.expect_exit(self.run_program("service", "call", service, kind, values, "--json"), 0).stdout
            return json.loads(text)["response"]

        for label, state in (("deactivate", "inactive"), ("activate", "active")):
            answer = call("/lidar/change_state", "lifecycle_msgs/srv/ChangeState", f"{{transition: {{label: {label}}}}}")
            self.assertEqual(answer, {"success": True})
            self.assertEqual(call("/lidar/get_state", "lifecycle_msgs/srv/GetState")["current_state"]["label"], state)
        read = call("/lidar/get_parameters", "rcl_interfaces/srv/GetParameters", "{names: [frame_id]}")
        before = read["values"][0]["string_value"]
        self.assertIn("frame_id", self.expect_exit(self.run_program("param", "list", "lidar"), 0).stdout)
        self.expect_exit(self.run_program("param", "set", "lidar", "frame_id", "elsewhere"), 0)
        self.assertIn("elsewhere", self.expect_exit(self.run_program("param", "get", "lidar", "frame_id"), 0).stdout)
        refused = call("/lidar/set_parameters", "rcl_interfaces/srv/SetParameters", "{parameters: [{name: topic_name, value: {type: 4, string_value: x}}]}")
        self.assertIn("read-only", refused["results"][0]["reason"])
        self.expect_exit(self.run_program("param", "set", "lidar", "frame_id", before), 0)
        listed = self.expect_exit(self.run_program("service", "list", "--all"), 0).stdout.split("\n")
        self.assertEqual(len([name for name in listed if name.startswith("/lidar/")]), 12, listed)
        self.assertNotIn("/lidar/", self.expect_exit(self.run_program("service", "list"), 0).stdout)
        self.assertNotIn("_container/", "".join(name for name in listed if "lidar" in name), "its process has no container of its own")
        graph = json.loads(self.expect_exit(self.run_program("topic", "info", "/rosout", "--json"), 0).stdout)
        self.assertIn("/lidar", [end["node"] for end in graph["publishers"]], "its log comes from its own process")

    def faults(self, node):
        """What `nacelle faults` shows of a component now ({}: nothing), and what happened to it."""
        told = json.loads(self.expect_exit(self.run_program("faults", "--json"), 0).stdout)
        now = [row for row in told["components"] if row["node"] == node]
        return now[0] if now else {}, [event for event in told["history"] if event["node"] == node]

    def test_2c_a_lost_device_is_an_open_fault_in_the_container_until_it_is_back(self):
        pid = self.child_of("/lidar")
        self.addCleanup(self.run_program, "sim", "plug", "lidar", "--dir", self.folder / "sim")
        self.expect_exit(self.run_program("sim", "unplug", "lidar", "--dir", self.folder / "sim"), 0)
        row = wait_for("the open fault", lambda: self.faults("/lidar")[0])
        self.assertEqual(row["state"], "active")
        self.assertNotIn("fault", row, "on_fault is not applied")
        self.assertEqual([fault["code"] for fault in row["open_faults"]], ["DEVICE_LOST"])
        self.assertIn(f"{self.folder}/sim/lidar", row["open_faults"][0]["text"])
        listed = self.components()["/lidar"]
        self.assertEqual(listed["state"], "active")
        self.assertEqual([fault["code"] for fault in listed["open_faults"]], ["DEVICE_LOST"])
        event = self.faults("/lidar")[1][-1]
        self.assertEqual((event["code"], event["open"]), ("DEVICE_LOST", True))
        diagnostics = Lines([PROGRAM, "topic", "echo", "/diagnostics"], self.environment)
        try:
            diagnostics.wait_for("/diagnostics says so", lambda line: "DEVICE_LOST" in line)
        finally:
            diagnostics.interrupt()

        self.expect_exit(self.run_program("sim", "plug", "lidar", "--dir", self.folder / "sim"), 0)
        wait_for("the fault is over", lambda: not self.faults("/lidar")[0])
        self.assertNotIn("open_faults", self.components()["/lidar"])
        event = self.faults("/lidar")[1][-1]
        self.assertEqual((event["code"], event["open"]), ("DEVICE_LOST", False))
        self.assertGreater(event["lasted_s"], 0)
        self.expect_flow("/scan")
        self.assertEqual(self.child_of("/lidar"), pid, "it is the same process")

    def test_3_a_killed_process_faults_its_component_only(self):
        pid = self.child_of("/lidar")
        os.kill(pid, signal.SIGKILL)
        fault = wait_for("the component is faulted", lambda: self.components()["/lidar"].get("fault"))
        self.assertIn("killed by signal 9", fault["text"])
        others = {node: row for node, row in self.components().items() if node != "/lidar"}
        self.assertFalse([node for node, row in others.items() if "fault" in row], others)
        self.expect_flow("/imu/data_raw")
        self.assertFalse(pathlib.Path(f"/proc/{pid}").exists(), "it is reaped")
        self.expect_exit(self.run_program("component", "unload", "lidar"), 0)
        self.assertNotIn("/lidar", self.components())

    def test_4_it_can_be_loaded_again_and_unload_ends_its_process(self):
        self.expect_exit(self.run_program("component", "load", "lidar"), 0)
        pid = self.child_of("/lidar")
        self.expect_flow("/scan")
        self.expect_exit(self.run_program("component", "unload", "lidar"), 0)
        self.assertIsNone(self.child_of("/lidar"))
        self.assertFalse(pathlib.Path(f"/proc/{pid}").exists())
        self.expect_exit(self.run_program("component", "load", "lidar"), 0)

    def test_5_nothing_is_left_when_the_robot_ends(self):
        children = [self.child_of(f"/{name}") for name in ISOLATED]
        self.assertNotIn(None, children)
        self.robot.send_signal(signal.SIGINT)
        self.assertEqual(self.robot.wait(30 * SLOW), 0, (self.folder / "log").read_text())
        for pid in children:
            self.assertFalse(pathlib.Path(f"/proc/{pid}").exists())
        self.assertFalse(list(self.folder.glob("**/*.sock")))
        streams = {row["name"]: row for row in json.loads(self.report_file.read_text())["streams"]}
        self.assertGreater(streams["/scan"]["copies"], 0)


class Supervised(IsolatedRobot):
    @classmethod
    def changed(cls, text):
        for line, added in ((r"- node_container:", "    param: [{name: transition_timeout, value: 3600}]"),
                            (r" +name: lidar", "      on_fault: {restart: {max: 1, backoff: 10ms}}")):
            text, count = re.subn(f"^({line}\n)", rf"\1{added}\n", text, flags=re.MULTILINE)
            assert count == 1, line
        return text

    def test_1_a_value_that_was_set_at_run_time_is_kept_when_its_process_is_restarted(self):
        self.expect_exit(self.run_program("param", "set", "lidar", "frame_id", "elsewhere"), 0)
        pid = self.child_of("/lidar")
        settings = json.loads(self.expect_exit(self.run_program("component", "info", "lidar", "--json"), 0).stdout)
        self.assertIn("elsewhere", json.dumps(settings), "the container knows it")
        os.kill(pid, signal.SIGKILL)
        wait_for("it was restarted", lambda: self.child_of("/lidar") not in (None, pid) and self.components()["/lidar"]["state"] == "active")
        self.assertIn("elsewhere", self.expect_exit(self.run_program("param", "get", "lidar", "frame_id"), 0).stdout)

    def test_a_process_that_does_not_answer_holds_up_the_end_no_longer_than_a_step_of_the_shutdown(self):
        pid = self.child_of("/detector")
        os.kill(pid, signal.SIGSTOP)
        self.robot.send_signal(signal.SIGINT)
        self.robot.wait(120 * SLOW)
        self.assertFalse(pathlib.Path(f"/proc/{pid}").exists())
        self.assertIn("has not answered within", (self.folder / "log").read_text())


class Rates(IsolatedRobot):
    """Runs alone on the machine (CMakeLists.txt), so that rates can be held."""

    def test_a_stream_crosses_the_border_at_its_rate_and_the_others_keep_theirs_when_its_process_is_killed(self):
        self.assertAlmostEqual(self.rate("/scan"), 10, delta=1 * SLOW)
        os.kill(self.child_of("/lidar"), signal.SIGKILL)
        wait_for("the component is faulted", lambda: self.components()["/lidar"].get("fault"))
        self.assertAlmostEqual(self.rate("/imu/data_raw"), 100, delta=5 * SLOW)


class Refused(RobotTest):
    def test_a_component_that_is_tied_to_its_process_is_refused_with_the_reason(self):
        source = pathlib.Path(LAUNCH_FILE)
        for name, tie in (("ekf", "shares the object 'transform_buffer'"), ("odometry", "claims the frame odom -> base_footprint")):
            copy = self.folder / f"{name}.launch.yaml"
            copy.write_text(re.sub(rf"^( +)name: {name}$", rf"\1name: {name}\n\1isolate: process", source.read_text(), flags=re.MULTILINE))
            own = (f"config:={source.parent}/config/robot.yaml", f"description:={source.parent}/robot.urdf", f"sim_dir:={self.folder}/sim")
            outcome = self.expect_exit(self.run_program("launch", copy, *own), 1)
            self.assertIn(f"component /{name}: cannot be isolated", outcome.stderr)
            self.assertIn(tie, outcome.stderr)
        self.assertEqual(self.our_processes(), [])

    def test_its_verb_is_not_for_people(self):
        self.assertIn("there is no container", self.expect_exit(self.run_program("isolated", "--name", "/x"), 2).stderr)


class Absent(RobotTest):
    def test_a_device_that_is_not_there_at_the_bring_up_is_named_by_the_launch(self):
        file, log = self.folder / "absent.launch.yaml", self.folder / "log"
        file.write_text("launch:\n- node_container:\n    name: robot\n    namespace: ''\n    composable_node:\n"
                        "    - {pkg: nacelle_lidar, plugin: 'nacelle::lidar::LidarComponent', name: lidar, isolate: process,\n"
                        f"       param: [{{name: port_name, value: {self.folder}/no-such-line}}]}}\n")  # fmt: skip
        with open(log, "w") as stream:
            robot = self.start_program("launch", file, stdout=stream)
        self.addCleanup(interrupt, robot)
        wait_for("the last line of the launch", lambda: "absent devices" in log.read_text())
        last = log.read_text().splitlines()[-1]
        self.assertIn(f"/lidar (DEVICE_LOST: {self.folder}/no-such-line: ", last)
        row = json.loads(self.expect_exit(self.run_program("faults", "--json"), 0).stdout)["components"][0]
        self.assertEqual((row["node"], row["state"], [fault["code"] for fault in row["open_faults"]]), ("/lidar", "active", ["DEVICE_LOST"]))


if __name__ == "__main__":
    unittest.main()
