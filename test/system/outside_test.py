#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""What comes from outside, of any size and depth: refused with a reason, and the container goes on."""
import json
import os
import resource
import subprocess
import unittest

from control import Control
from robot import RobotTest, interrupt, needs_no_thread_sanitizer, wait_for

DEPTH = 150_000  # below the length that a request may have


class Outside(RobotTest):
    """One empty container for all tests."""

    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        cls.container = cls.start_program("container", "--name", "robot", "network:=off", stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        wait_for("the container runs", lambda: cls.run_program("component", "list").returncode == 0)

    @classmethod
    def tearDownClass(cls):
        interrupt(cls.container)
        super().tearDownClass()

    def tearDown(self):
        self.assertIsNone(self.container.poll(), "the container ended")
        self.expect_exit(self.run_program("component", "list"), 0)

    def ask(self, text):
        control = Control(self.folder / "nacelle" / "robot.sock")
        control.send(b"j", text.encode())
        kind, payload = control.receive()
        control.close()
        self.assertEqual(kind, b"r")
        return json.loads(payload)

    def load(self, params_file, code=1):
        words = ("component", "load", "nacelle::lidar::LidarComponent", "--name", "lidar", "--params-file", params_file)
        return self.expect_exit(self.run_program(*words), code).stderr

    def test_a_request_that_is_nested_without_end_is_refused(self):
        request = '{"verb": "service.call", "service": "/a", "type": "std_srvs/srv/Empty", "request": %s}'
        for nested in ("[" * DEPTH + "]" * DEPTH, '{"a":' * DEPTH + "1" + "}" * DEPTH):
            problem = self.ask(request % nested)["problem"]
            self.assertEqual((problem["where"], problem["what"]), ("request", "line 1: lists and objects are nested deeper than 64 levels"))

    def test_a_message_that_is_nested_without_end_is_refused(self):
        for words in (("service", "call", "/a", "std_srvs/srv/SetBool"), ("topic", "pub", "--once", "/a", "std_msgs/msg/String")):
            outcome = self.run_program(*words, "{data: " + "[" * 20_000)
            self.assertEqual(outcome.returncode, 2, outcome.stderr)
            self.assertIn("more than 64 levels of nesting", outcome.stderr)

    def test_a_parameter_file_that_is_no_regular_file_is_refused_at_once(self):
        fifo = self.folder / "fifo"
        os.mkfifo(fifo)

        self.assertIn(f"{fifo}: cannot be read: it is a FIFO", self.load(fifo))
        self.assertIn("/dev/zero: cannot be read: it is a device", self.load("/dev/zero"))
        self.assertIn(f"{self.folder}: cannot be read: it is a folder", self.load(self.folder))
        self.assertIn("/no/such: cannot be read: No such file or directory", self.load("/no/such"))

    def test_a_parameter_file_reaches_its_component(self):
        file = self.folder / "lidar.yaml"
        file.write_text("lidar:\n  ros__parameters:\n    port_name: 7\n")

        self.assertIn("parameter 'port_name' is string but was given integer", self.load(file))
        file.write_text("# " + "x" * 600_000)
        self.assertIn("has more than 458752 bytes, the limit for such a file", self.load(file))

    def test_every_other_file_is_refused_when_it_is_none(self):
        fifo = self.folder / "pipe.launch.yaml"
        os.mkfifo(fifo)
        for words in (("check", fifo), ("launch", fifo), ("import", fifo), ("xacro", fifo), ("check", "--params", "x::Y", fifo)):
            with self.subTest(words=words):
                outcome = self.run_program(*words)
                self.assertNotEqual(outcome.returncode, 0, outcome.stderr)

    def test_a_name_without_end_is_refused_and_not_repeated(self):
        name = "x" * 900_000
        loaded = self.compose("load", component="a::" + name)
        self.assertEqual(loaded["problem"]["what"], "its class name has 900003 bytes; at most 255 are allowed")
        self.assertLess(len(loaded["problem"]["where"]), 100)
        self.assertFalse(self.compose("load", component=name)["success"])
        self.assertFalse(self.compose("unload", component=name)["success"])

    def compose(self, what, **request):
        reply = self.ask(json.dumps({"verb": "service.call", "service": f"/robot/_container/{what}_component",
                                     "type": f"nacelle_interfaces/srv/{what.title()}Component", "request": request}))  # fmt: skip
        return reply["response"]


class Names(RobotTest):
    """Frame ids are text of any kind, of any sender on the network."""

    HOSTILE = "a\x1b[2J\n12:00:00.000 info [base] released"

    def publish(self, parent, child):
        message = json.dumps({"transforms": [{"header": {"frame_id": parent}, "child_frame_id": child}]})
        self.expect_exit(self.run_program("topic", "pub", "--once", "-w", "1", "/tf", "tf2_msgs/msg/TFMessage", message), 0)

    def test_a_frame_id_neither_moves_the_cursor_nor_forges_a_line(self):
        log = self.folder / "log"
        with log.open("w") as output:
            container = self.start_program("container", "--name", "robot", "network:=off", stdout=output, stderr=subprocess.STDOUT)
        self.addCleanup(interrupt, container)
        wait_for("the container runs", lambda: self.run_program("component", "list").returncode == 0)
        words = ("nacelle::transforms::TransformsComponent", "--name", "transforms", "-p", 'static_transforms:=["0 0 0 0 0 0 base_link laser"]')
        self.expect_exit(self.run_program("component", "load", *words), 0)

        self.publish(self.HOSTILE, self.HOSTILE)  # is refused
        self.publish("odom", self.HOSTILE)

        wait_for("the refusal is logged", lambda: "was refused" in log.read_text())
        tree = wait_for("the frame is there", lambda: "odom" in (shown := self.run_program("tf", "tree").stdout) and shown)
        self.assertIn("a\\x1b[2J\\x0a12:00:00.000 info [base] released", tree)
        self.assertEqual(len(tree.splitlines()), 4, tree)
        said = log.read_text()
        self.assertIn("transform 'a\\x1b[2J\n  | 12:00:00.000 info [base] released' -> ", said)
        self.assertNotIn("\n12:00:00.000 info", said)
        for text in (said, tree):
            self.assertNotIn("\x1b", text)

    def test_a_parameter_is_printed_without_control_characters(self):
        container = self.start_program("container", "--name", "robot", "network:=off", stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        self.addCleanup(interrupt, container)
        wait_for("the container runs", lambda: self.run_program("component", "list").returncode == 0)
        words = ("nacelle::lidar::LidarComponent", "--name", "lidar", "-p", 'port_name:="/dev/\\x1b[2Jx"')
        self.expect_exit(self.run_program("component", "load", *words), 0)

        for command in (("param", "get", "lidar", "port_name"), ("component", "info", "lidar"), ("param", "dump", "lidar")):
            shown = self.expect_exit(self.run_program(*command), 0).stdout
            self.assertNotIn("\x1b", shown)
            self.assertRegex(shown, r"/dev/\\(x1b|u001b)\[2Jx")
        got = json.loads(self.run_program("param", "get", "lidar", "port_name", "--json").stdout)
        self.assertEqual(got["value"], "/dev/\x1b[2Jx")


class Limits(RobotTest):
    def start(self, *arguments, file_bytes):
        return self.run_program(*arguments, preexec_fn=lambda: resource.setrlimit(resource.RLIMIT_FSIZE, (file_bytes, file_bytes)))

    def write(self, name, text):
        file = self.folder / name
        file.write_text(text)
        return file

    @needs_no_thread_sanitizer
    def test_a_limit_of_file_sizes_is_an_error_and_no_death(self):
        launch = self.write("r.launch.yaml", "launch:\n- node_container: {name: r, namespace: ''}\n")
        drawing = self.folder / "robot.dot"

        outcome = self.start("check", launch, "--graph", drawing, file_bytes=0)

        self.expect_exit(outcome, 1)
        self.assertIn(f"{drawing}: cannot be written: File too large", outcome.stderr)
        self.assertEqual(list(self.folder.glob("robot.dot*")), [])

    @needs_no_thread_sanitizer
    def test_a_container_that_may_write_no_file_reports_it_and_is_not_killed(self):
        program = self.start_program(
            "container", "--name", "small", "network:=off", preexec_fn=lambda: resource.setrlimit(resource.RLIMIT_FSIZE, (0, 0))
        )
        wait_for("it runs or has ended", lambda: program.poll() is not None or self.run_program("component", "list").returncode == 0)
        interrupt(program)
        said = program.stdout.read()
        program.stdout.close()
        self.assertGreaterEqual(program.returncode, 0, f"killed by signal {-program.returncode}")
        self.assertIn("File too large", said)

    def test_a_full_disk_is_named_and_the_old_drawing_stays(self):
        launch = self.write("r.launch.yaml", "launch:\n- node_container: {name: r, namespace: ''}\n")
        full = self.folder / "full.dot"
        full.symlink_to("/dev/full")

        outcome = self.run_program("check", launch, "--graph", full)

        self.expect_exit(outcome, 1)
        self.assertIn("full.dot: cannot be written: No space left on device; make room", outcome.stderr)

    def seconds_to_check(self, links):
        """Processor time: time itself is no measure on a machine that does other things."""
        text = "".join(f'<link name="l{i}"/>' for i in range(links)) + "".join(
            f'<joint name="j{i}" type="fixed"><parent link="l{i - 1}"/><child link="l{i}"/></joint>' for i in range(1, links)
        )
        urdf = self.write("long.urdf", f'<robot name="long">{text}</robot>')
        launch = self.write("long.launch.yaml", f"""launch:
- node_container:
    name: r
    namespace: ''
    composable_node:
    - pkg: nacelle_transforms
      plugin: nacelle::transforms::TransformsComponent
      name: transforms
      param: [{{name: robot_description_file, value: {urdf}}}]
""")
        before = resource.getrusage(resource.RUSAGE_CHILDREN)
        self.expect_exit(self.run_program("check", launch, limit_s=240), 0)
        after = resource.getrusage(resource.RUSAGE_CHILDREN)
        return after.ru_utime - before.ru_utime

    def test_a_description_costs_in_proportion_to_its_links(self):
        # Four times as many: 16 times the time where each is compared with each.
        self.assertLess(self.seconds_to_check(20_000) / self.seconds_to_check(5_000), 8)


if __name__ == "__main__":
    unittest.main()
