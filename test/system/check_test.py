# SPDX-License-Identifier: Apache-2.0
"""`nacelle check`, `params --explain` and the same proof in `nacelle launch`."""
import json
import os
import pathlib
import re
import socket
import subprocess
import unittest
import xml.etree.ElementTree

from robot import LAUNCH_FILE, SLOW, RobotTest

HERE = pathlib.Path(__file__).resolve().parent
BROKEN = HERE / "broken"
MARK = "# finds: "

# Says nothing wrong, and claims no frame.
LIDAR = """launch:
- arg: {{name: port, default: /no/such/port}}
- node_container:
    name: c
    namespace: ''
    composable_node:
    - pkg: nacelle_lidar
      plugin: nacelle::lidar::LidarComponent
      name: lidar
      param: [{{name: port_name, value: $(var port)}}{more}]
      required: {required}
"""


def pattern_of(expected):
    """`...` stands for a path of this machine."""
    return ".*".join(re.escape(part) for part in expected.split("..."))


class Check(RobotTest):
    def check(self, *arguments, code=0, **options):
        return self.expect_exit(self.run_program("check", *arguments, **options), code)

    def write(self, name, text):
        path = self.folder / name
        path.write_text(text)
        return path

    def test_each_broken_file_gives_exactly_its_finding(self):
        files = sorted(BROKEN.glob("*.launch.yaml"))
        self.assertGreaterEqual(len(files), 30)
        for file in files[:: 1 if SLOW == 1 else 4]:  # under a sanitizer each takes two seconds
            with self.subTest(file=file.name):
                expected = [line[len(MARK):] for line in file.read_text().splitlines() if line.startswith(MARK)]
                self.assertEqual(len(expected), 1, "one mistake, one line that begins with " + MARK)
                outcome = self.check("--json", file.name, code=1, cwd=BROKEN)
                answer = json.loads(outcome.stdout)
                self.assertEqual(answer["verdict"], "error")
                # A part of a robot reads what its other parts publish: that warns, and is none of these mistakes.
                answer["findings"] = [f for f in answer["findings"] if (f["severity"], f["about"]) != ("warning", "stream")]
                found = [f"{f['code']}: {f['where']}: {f['what']}" + ("; " + f["way_out"] if f["way_out"] else "")
                         for f in answer["findings"]]  # fmt: skip
                self.assertEqual(len(found), 1, found)
                self.assertRegex(found[0], "^" + pattern_of(expected[0]) + "$")
                self.assertEqual(outcome.stderr, "")

    def test_every_file_of_the_folder_belongs_to_a_mistake(self):
        launch_files = {file.name.split(".")[0] for file in BROKEN.glob("*.launch.yaml")}
        self.assertEqual({file.name.split(".")[0] for file in BROKEN.iterdir()}, launch_files)

    def test_the_robot_is_sound_simulated_and_real(self):
        for arguments in ([], ["sim:=false"]):
            with self.subTest(arguments=arguments):
                outcome = self.check(LAUNCH_FILE, *arguments, "--json")
                self.assertEqual(json.loads(outcome.stdout)["findings"], [])
                self.assertEqual(json.loads(outcome.stdout)["components"], 10)
                self.assertEqual(outcome.stderr, "")

    def test_a_line_of_export_that_shows_nothing_warns(self):
        exports = ["{topic: /odom, max_hz: 5}", "{topic: /odm}", "{topic: /lidar/get_parameters}", "{topic: /later}",
                   "{topic: /robot/_container/list_nodes}", "{topic: /camera/image_raw, compressed_only: true}"]  # fmt: skip
        file = self.write("exports.launch.yaml", "launch:\n- network:\n    mode: export\n    export:\n"
                          + "".join(f"    - {one}\n" for one in exports) + f"- include: {{file: {LAUNCH_FILE}}}\n")  # fmt: skip
        answer = json.loads(self.check("--json", file).stdout)
        self.assertEqual(answer["verdict"], "warning")
        found = {f"{f['about']}: {f['where'].rpartition('/')[2]}: {f['what']}; {f['way_out']}" for f in answer["findings"]}
        self.assertEqual(found, {
            "export: exports.launch.yaml:6: export: no node has a topic or service '/odm': this entry exports nothing; did you mean '/odom'?",
            "export: exports.launch.yaml:8: export: no node has a topic or service '/later': this entry exports nothing; "
            "fine if a component that is loaded later has it",
            "export: exports.launch.yaml:10: no component publishes a compressed form of '/camera/image_raw': it is not exported; "
            "add what publishes '/camera/image_raw/compressed', or leave compressed_only out",
        })  # fmt: skip

    def test_a_tag_that_ros2_control_does_not_know_only_warns(self):
        source = pathlib.Path(LAUNCH_FILE).parent / "robot.urdf"
        text = source.read_text().replace("  </ros2_control>", "    <controler/>\n  </ros2_control>")
        line = text.splitlines().index("    <controler/>") + 1
        robot = self.write("robot.urdf", text)
        outcome = self.check(LAUNCH_FILE, f"description:={robot}", "--json")
        findings = json.loads(outcome.stdout)["findings"]
        self.assertEqual([(f["severity"], f["where"]) for f in findings], [("warning", f"{robot}:{line}")])
        self.assertIn("<controler> is not a tag of ros2_control inside <ros2_control>, and is ignored", findings[0]["what"])

    def test_finds_all_that_is_wrong_and_not_the_first_only(self):
        more = ", {name: scan_points, value: 0}, {name: range_max, value: far}, {name: nosuch, value: 1}, {name: product_name, value: X}"
        outcome = self.check(self.write("all.launch.yaml", LIDAR.format(more=more, required="true")), code=1)
        for word in ("scan_points", "range_max", "nosuch", "product_name"):
            self.assertIn(word, outcome.stdout)
        self.assertIn("4 errors", outcome.stdout)

    def test_the_services_that_every_node_has_may_be_waited_for(self):
        text = (BROKEN / "after_one_that_stays_inactive.launch.yaml").read_text().replace("      autostart: inactive\n", "")
        for condition, code in (("service(/imu/get_state)", 0), ("service(get_parameters)", 1), ("service(/imu/get_stat)", 1),
                                ("service(imu/list_parameters)", 0)):  # fmt: skip
            with self.subTest(condition=condition):
                file = self.write("after.launch.yaml", text.replace("when: active", f"when: {condition}"))
                findings = json.loads(self.check("--json", file, code=code).stdout)["findings"]
                offered = [f for f in findings if "which no component offers" in f["what"]]
                self.assertEqual(len(offered), code, findings)

    def test_a_component_that_is_not_required_only_warns(self):
        more = ", {name: scan_points, value: 0}"
        outcome = self.check(self.write("optional.launch.yaml", LIDAR.format(more=more, required="false")))
        self.assertRegex(outcome.stdout, r"^warning: .*scan_points")
        self.assertIn("1 warning", outcome.stdout)

    def found(self, text, code=0):
        outcome = self.check("--json", self.write("found.launch.yaml", text), code=code)
        return [(f["severity"], f["about"], f["what"], f["way_out"]) for f in json.loads(outcome.stdout)["findings"]]

    def test_warns_about_unpublished_topics_except_external_ones(self):
        ekf = "{pkg: nacelle_ekf, plugin: 'nacelle::ekf::EkfComponent', name: ekf, param: [{name: odom0, value: /odom}, {name: odom0_config, value: [false, false, false, false, false, false, true, true, false, false, false, false, false, false, false]}]}"
        base = "{pkg: nacelle_diff_drive, plugin: 'nacelle::diff_drive::DiffDriveComponent', name: base, param: [{name: left_wheel_names, value: [a]}, {name: right_wheel_names, value: [b]}]}"
        head = "launch:\n- node_container:\n    name: c\n    namespace: ''\n    composable_node:\n"
        self.assertEqual(self.found(head + f"    - {ekf}\n"), [
            ("warning", "stream", "/ekf reads '/odom' (nav_msgs/msg/Odometry), which no component publishes", "fine if another container does, or if it is not needed")])  # fmt: skip
        self.assertEqual([f for f in self.found(head + f"    - {base}\n") if f[1] == "stream"], [], "commands come from people and programs")

    def test_warns_about_a_history_that_is_not_used(self):
        switches = "[" + ", ".join(["true"] * 6 + ["false"] * 9) + "]"
        ekf = ("launch:\n- node_container:\n    name: c\n    namespace: ''\n    composable_node:\n"
               "    - {pkg: nacelle_ekf, plugin: 'nacelle::ekf::EkfComponent', name: ekf, param: [{name: pose0, value: /pose}, "
               f"{{name: pose0_config, value: {switches}}}, {{name: history_length, value: 1.0}}]}}\n")  # fmt: skip
        found = [(f[0], f[3]) for f in self.found(ekf) if f[1] == "parameter"]
        self.assertEqual(found, [("warning", "set smooth_lagged_data: true, or leave history_length out")])

    def test_a_topic_that_a_component_publishes_is_no_slip_for_one_that_it_reads(self):
        relay = "    - {pkg: nacelle_test_relay, plugin: 'nacelle::test::Relay', name: relay}\n"
        head = "launch:\n- node_container:\n    name: c\n    namespace: ''\n    composable_node:\n"
        self.assertEqual(self.found(head + relay), [])
        other = "    - {pkg: nacelle_test_relay, plugin: 'nacelle::test::Relay', name: other, remap: [{from: chatter, to: /x}, {from: nchatter, to: /chattr}]}\n"
        self.assertEqual([f[0::3] for f in self.found(head + relay + other)], [("warning", "did you mean '/chattr'?")])

    def test_what_an_optional_component_has_part_in_only_warns(self):
        text = (BROKEN / "reliability.launch.yaml").read_text()
        first = text.index("      name: ")
        end = text.index("\n", first)
        optional = text[:end] + "\n      required: false" + text[end:]
        self.assertEqual({f[0] for f in self.found(optional) if f[1] == "qos"}, {"warning"})

    def test_a_file_that_only_other_nodes_read_warns(self):
        self.write("both.yaml", "lidar: {ros__parameters: {frame_id: laser}}\nrelay: {ros__parameters: {start_type_description_service: true}}\n")
        text = LIDAR.format(more=", {from: both.yaml}", required="true") + "    - {pkg: nacelle_test_relay, plugin: 'nacelle::test::Relay', name: relay}\n"
        self.assertIn(
            ("warning", "parameter", "the parameters for '/relay' are not used: that node does not read this file", "give it `param: [{from: FILE}]`, too"),
            self.found(text))  # fmt: skip

    def test_a_class_of_another_package_warns(self):
        text = LIDAR.format(more="", required="true").replace("pkg: nacelle_lidar", "pkg: nacelle_lidr")
        self.assertEqual(self.found(text), [
            ("warning", "plugin", "/lidar: the class nacelle::lidar::LidarComponent is not of the package 'nacelle_lidr'", "write pkg: nacelle_lidar")])  # fmt: skip

    def test_every_wrong_parameter_of_the_container_is_reported(self):
        text = LIDAR.format(more="", required="true").replace("    name: c\n", "    name: c\n    param: [{name: hang_aftr, value: 3.0}, {name: hang_after, value: -1}]\n")
        found = self.found(text, code=1)
        self.assertEqual([f[1] for f in found], ["parameter", "parameter"], found)
        outcome = self.expect_exit(self.run_program("launch", self.folder / "found.launch.yaml"), 1)
        self.assertIn("found.launch.yaml:5: the container has no parameter 'hang_aftr'; did you mean 'hang_after'?", outcome.stderr)
        self.assertIn("found.launch.yaml:5: parameter 'hang_after' of the container must be seconds", outcome.stderr)

    def test_one_device_that_is_opened_under_two_names_is_found(self):
        ours, theirs = os.openpty()
        self.addCleanup(os.close, ours)
        self.addCleanup(os.close, theirs)
        device, other_name = os.ttyname(theirs), self.folder / "usb-imu-if00"
        other_name.symlink_to(device)  # as udev's names in /dev/serial/by-id
        text = (BROKEN / "device_opened_twice.launch.yaml").read_text().replace("port_name, value: /dev/ttyUSB7", f"port_name, value: {device}")
        text = text.replace("port, value: /dev/ttyUSB7", f"port, value: {other_name}")
        (severity, about, what, _), = self.found(text, code=1)
        self.assertEqual((severity, about), ("error", "device"))
        self.assertRegex(what, rf"^/imu \(parameter port\) opens the device '{other_name}', which /lidar \(parameter port_name, .*:13\) "
                               rf"opens, too as '{device}'$")  # fmt: skip
        another, slave = os.openpty()
        self.addCleanup(os.close, another)
        self.addCleanup(os.close, slave)
        self.assertEqual(self.found(text.replace(f"value: {device}", f"value: {os.ttyname(slave)}")), [])

    def test_starts_no_program_and_makes_no_socket(self):
        before = sorted(self.folder.rglob("*"))
        self.check(LAUNCH_FILE, f"sim_dir:={self.folder}/sim")
        self.assertEqual(sorted(self.folder.rglob("*")), before)

    def test_draws_the_pipeline(self):
        svg, dot = self.folder / "robot.svg", self.folder / "robot.dot"
        self.check(LAUNCH_FILE, "--graph", svg)
        self.check(LAUNCH_FILE, "--graph", dot)
        root = xml.etree.ElementTree.parse(svg).getroot()
        texts = ["".join(element.itertext()) for element in root.iter("{http://www.w3.org/2000/svg}text")]
        self.assertIn("/lidar", texts)
        self.assertTrue(any(re.match(r"keep_last \d+, best_effort", text) for text in texts), texts)
        self.assertRegex(dot.read_text(), r'n\d+:p\d+:e -> n\d+:p\d+:w \[tooltip="/scan"\]')
        self.expect_exit(self.run_program("check", LAUNCH_FILE, "--graph", "robot.jpeg"), 2)

    def test_without_graphviz_it_writes_the_dot_file_and_the_command_that_draws_it(self):
        svg = self.folder / "undrawn.svg"
        outcome = self.check(LAUNCH_FILE, "--graph", svg, env={**self.environment, "PATH": "/no/such/folder"})
        self.assertIn(f"dot -Tsvg {self.folder}/undrawn.dot -o {svg}", outcome.stderr)
        self.assertIn("digraph", (self.folder / "undrawn.dot").read_text())
        self.assertFalse(svg.exists())

    def test_marks_pairs_that_cannot_talk_in_the_drawing(self):
        dot = self.folder / "clash.dot"
        self.check(BROKEN / "reliability.launch.yaml", "--graph", dot, code=1)
        self.assertEqual(dot.read_text().count('color="red">/scan<'), 2)
        self.assertEqual(dot.read_text().count("color=red];"), 1)

    def test_launch_reports_the_same_and_starts_nothing(self):
        for name in ("unknown_parameter", "two_parents", "reliability", "program"):
            with self.subTest(name=name):
                file = BROKEN / f"{name}.launch.yaml"
                finding = self.check(file, code=1).stdout.splitlines()[0]
                outcome = self.expect_exit(self.run_program("launch", file), 1)
                self.assertIn("nacelle: " + finding, outcome.stderr)
                self.assertIn("the plan is unsound: 1 error", outcome.stderr)
                self.assertNotIn("could not configure", outcome.stderr)

    def test_launch_checks_a_component_in_a_process_of_its_own(self):
        text = LIDAR.format(more=", {name: scan_points, value: 0}, {name: nosuch, value: 1}", required="true") + "      isolate: process\n"
        outcome = self.expect_exit(self.run_program("launch", self.write("apart.launch.yaml", text)), 1)
        self.assertRegex(outcome.stderr, r"error: .*apart.launch.yaml:10: /lidar: .*scan_points")
        self.assertRegex(outcome.stderr, r"error: .*apart.launch.yaml:10: /lidar has no parameter 'nosuch'")
        self.assertIn("2 errors", outcome.stderr)

    def test_takes_wheels_of_the_base_for_odometry_that_was_given_none(self):
        text = (BROKEN / "wheels_of_two_sizes.launch.yaml").read_text().replace("      param: [{name: wheel_separation, value: 0.40}]\n", "")
        self.assertNotIn("0.40", text)
        self.assertNotIn("wheel_separation is", self.check(self.write("one_base.launch.yaml", text)).stdout.replace("# finds", ""))

    def test_writes_each_line_of_errors_at_once(self):
        """A packet of this socket is one system call. Two processes that share a stream could interleave partial writes."""
        ours, theirs = socket.socketpair(socket.AF_UNIX, socket.SOCK_SEQPACKET)
        with ours, theirs:
            outcome = self.run_program("launch", BROKEN / "two_parents.launch.yaml", capture_output=False, stdout=subprocess.DEVNULL,
                                       stderr=theirs)  # fmt: skip
            theirs.close()
            self.assertEqual(outcome.returncode, 1)
            packets = list(iter(lambda: ours.recv(65536), b""))
        self.assertTrue(any(len(packet) > 128 for packet in packets), packets)
        for packet in packets:
            self.assertTrue(packet.endswith(b"\n"), packets)

    def test_wrong_usage_is_2(self):
        for words in (["check"], ["check", LAUNCH_FILE, "sim"], ["params", LAUNCH_FILE], ["import"]):
            with self.subTest(words=words):
                self.assertTrue(self.expect_exit(self.run_program(*words), 2).stderr)


class Explain(RobotTest):
    def explain(self, *arguments):
        return self.expect_exit(self.run_program("params", "--explain", *arguments), 0).stdout

    def test_each_value_has_its_file_and_line(self):
        lines = self.explain("diff_drive", LAUNCH_FILE).splitlines()
        config = pathlib.Path(LAUNCH_FILE).parent / "config/robot.yaml"
        number = next(i for i, line in enumerate(config.read_text().splitlines(), 1) if "update_rate" in line)
        at = {line.split(":")[0]: line.split("#")[1].strip() for line in lines}
        self.assertEqual(at["update_rate"], f"{config}:{number}")
        self.assertEqual(at["battery_rate"], "default")
        self.assertRegex(at["serial_port"], r"robot\.launch\.yaml:\d+$")

    def test_the_value_that_won_is_shown(self):
        text = LIDAR.format(more=", {name: port_name, value: /dev/second}", required="true")
        (self.folder / "won.launch.yaml").write_text(text)
        answer = json.loads(self.explain("/lidar", self.folder / "won.launch.yaml", "--json"))
        row = next(row for row in answer["parameters"] if row["name"] == "port_name")
        self.assertEqual((row["value"], row["type"]), ("/dev/second", "string"))

    def test_an_unknown_node_is_reported_with_the_nearest_name(self):
        outcome = self.expect_exit(self.run_program("params", "--explain", "lidr", LAUNCH_FILE), 1)
        self.assertIn("did you mean '/lidar'?", outcome.stderr)


class Import(RobotTest):
    def test_the_result_is_sound_and_each_key_is_reported(self):
        out = self.folder / "imported.yaml"
        files = sorted((HERE.parent / "data/ros_parameters").glob("*.yaml"))
        self.assertGreaterEqual(len(files), 6)
        told = json.loads(self.expect_exit(self.run_program("import", *files, "-o", out, "--json"), 0).stdout)
        for file in files:
            for number, line in enumerate(file.read_text().splitlines(), 1):
                if "# key" not in line:
                    continue
                with self.subTest(file=file.name, line=number):
                    self.assertTrue(any(row["where"] == f"{file}:{number}" and row["text"] for row in told["keys"]), line)
        launch = self.folder / "imported.launch.yaml"
        # Two of the files are for LiDARs, two for cameras: the second of each has a name of its own.
        nodes = {"diff_drive": "diff_drive::DiffDrive", "odometry": "odometry::Odometry", "ekf": "ekf::Ekf", "lidar": "lidar::Lidar",
                 "lidar_2": "lidar::Lidar", "camera": "camera::Camera", "v4l2_camera": "camera::Camera",
                 "joy_node": "joy::Joy", "teleop_twist_joy_node": "joy::TeleopTwistJoy"}  # fmt: skip
        launch.write_text("launch:\n- node_container:\n    name: c\n    namespace: ''\n    composable_node:\n" + "".join(
            f"    - {{pkg: nacelle_{plugin.split(':')[0]}, plugin: 'nacelle::{plugin}Component', name: {node}, param: [{{from: imported.yaml}}]}}\n" for node, plugin in nodes.items()))
        outcome = self.run_program("check", launch, "--json")
        findings = [f for f in json.loads(outcome.stdout)["findings"] if f["about"] not in ("frame", "stream")]
        self.assertEqual(findings, [], outcome.stdout)

    def test_writes_over_no_file_that_it_reads(self):
        path = self.folder / "mine.yaml"
        path.write_text("ekf: {ros__parameters: {frequency: 30.0}}\n")
        outcome = self.expect_exit(self.run_program("import", path, "-o", path), 1)
        self.assertRegex(outcome.stderr, r"mine\.yaml: would be written over .*; give another -o FILE")
        self.assertEqual(path.read_text(), "ekf: {ros__parameters: {frequency: 30.0}}\n")

    def test_a_file_of_an_unknown_driver_is_a_failure_that_names_it(self):
        path = self.folder / "mpu6050.yaml"
        path.write_text("mpu6050: {ros__parameters: {frequency: 30.0, calibrate: true}}\n")
        outcome = self.expect_exit(self.run_program("import", path), 1)
        self.assertIn("mpu6050", outcome.stdout + outcome.stderr)
        self.assertNotIn("ekf", outcome.stdout)

    def test_a_file_that_is_none_is_a_problem_with_its_line(self):
        path = self.folder / "none.yaml"
        path.write_text("ekf: [1, 2\n")
        outcome = self.expect_exit(self.run_program("import", path), 1)
        self.assertRegex(outcome.stderr, r"none\.yaml:\d+: ")


if __name__ == "__main__":
    unittest.main()
