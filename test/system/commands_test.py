# SPDX-License-Identifier: Apache-2.0
"""The command line on a running robot."""
import json
import os
import pathlib
import pty
import re
import signal
import subprocess
import threading
import time
import unittest

from robot import LAUNCH_FILE, PROGRAM, SLOW, STREAMS_HZ, RunningRobotTest, wait_for


def swap_camera(test, times=3):
    """Takes the camera out of the running robot and puts it back: its library leaves the process, and images come again."""
    maps = pathlib.Path(f"/proc/{test.robot.pid}/maps")
    test.assertIn("nacelle_camera.so", maps.read_text())
    for _ in range(times):
        test.expect_exit(test.run_program("component", "unload", "camera"), 0)
        # An image may be in the detector's hands at that moment: kept, with a name, until it is given back.
        wait_for("nothing holds the camera's library", lambda: "held by" not in test.run_program("component", "list").stdout)
        test.assertNotIn("nacelle_camera.so", maps.read_text())
        test.expect_exit(test.run_program("component", "load", "camera"), 0)
        test.assertIn("nacelle_camera.so", maps.read_text())
        before = test.streams()["/camera/image_raw"]["published"]
        wait_for("the camera gives images again", lambda b=before: test.streams()["/camera/image_raw"]["published"] > b + 5)


class Commands(RunningRobotTest):
    def test_topics_are_listed_with_their_types(self):
        names = self.expect_exit(self.run_program("topic", "list"), 0).stdout.split()
        self.assertEqual(names, sorted(set(names)))
        for name in ("/camera/image_raw", "/camera/camera_info", "/detections", "/scan", "/imu/data_raw", "/imu/data", "/imu/mag", "/cmd_vel",
                     "/joint_states", "/battery/state", "/odom", "/odometry/filtered", "/tf", "/tf_static", "/robot_description", "/diagnostics"):  # fmt: skip
            self.assertIn(name, names)
        typed = self.expect_exit(self.run_program("topic", "list", "-t"), 0).stdout.splitlines()
        self.assertIn("/scan [sensor_msgs/msg/LaserScan]", typed)
        self.assertIn("/cmd_vel [geometry_msgs/msg/Twist, geometry_msgs/msg/TwistStamped]", typed)

    def test_echo_shows_a_message_and_hides_no_reader(self):
        text = self.expect_exit(self.run_program("topic", "echo", "/odom", "--once"), 0).stdout
        self.assertIn("frame_id: odom\n", text)
        self.assertTrue(text.endswith("---\n"), text)
        scan = json.loads(self.expect_exit(self.run_program("topic", "echo", "scan", "--once", "--json"), 0).stdout)
        self.assertEqual(scan["header"]["frame_id"], "lidar_link")
        raw = self.expect_exit(self.run_program("topic", "echo", "/odom", "--once", "--raw"), 0).stdout
        self.assertRegex(raw, r"^00010000([0-9a-f]{2})+\n---\n$")
        self.assertIn(b"base_footprint".hex(), raw)
        image = self.expect_exit(self.run_program("topic", "echo", "/camera/image_raw", "--once"), 0).stdout
        self.assertIn("- '...'", image)
        self.assertLess(len(image), 4000)

    def test_echo_of_a_topic_with_history_shows_what_was_sent_before(self):
        # Many times: whether the message comes in one piece with the reply or behind it is a matter of luck.
        for _ in range(10):
            text = self.expect_exit(self.run_program("topic", "echo", "/robot_description", "--once", "--full", limit_s=10), 0).stdout
            self.assertIn("<robot", text)
            self.assertIn("transforms:", self.expect_exit(self.run_program("topic", "echo", "/tf_static", "--once", limit_s=10), 0).stdout)

    def test_a_topic_that_is_not_there_is_1_with_the_nearest_name(self):
        outcome = self.expect_exit(self.run_program("topic", "echo", "/scam", "--once"), 1)
        self.assertIn("did you mean '/scan'", outcome.stderr)

    def test_a_topic_of_another_type_is_1_with_its_type(self):
        for command in ("echo", "hz"):
            outcome = self.expect_exit(self.run_program("topic", command, "/scan", "sensor_msgs/msg/Image", "--once", limit_s=10), 1)
            self.assertIn("/scan: has the type sensor_msgs/msg/LaserScan, not sensor_msgs/msg/Image", outcome.stderr)

    def test_a_reader_that_leaves_ends_what_writes_to_it(self):
        for words in (("topic", "echo", "/odom"), ("topic", "hz", "/odom"), ("tf", "echo", "odom", "base_footprint"), ("streams", "--json", "--interval", "0.1"),
                      ("topic", "pub", "/said", "std_msgs/msg/String", "{}", "--rate", "20")):  # fmt: skip
            program = self.start_program(*words, stderr=subprocess.PIPE)
            program.stdout.readline()
            program.stdout.close()
            self.assertEqual((program.wait(20 * SLOW), program.stderr.read()), (0, ""), words)
            program.stderr.close()

    def test_output_that_cannot_be_written_is_1(self):
        with open("/dev/full", "w") as full:
            for words in (("topic", "list"), ("topic", "echo", "/odom"), ("interface", "show", "std_msgs/msg/Bool"), ("--help",)):
                program = self.start_program(*words, stdout=full, stderr=subprocess.PIPE)
                _, said = program.communicate(timeout=20 * SLOW)
                self.assertEqual(program.returncode, 1, words)
                self.assertIn("stdout: cannot be written: No space left on device", said)

    def test_pub_reaches_the_robot_and_bad_messages_do_not(self):
        before = sum(row["published"] for row in json.loads(self.run_program("streams", "--json", "--interval", "0.1").stdout)["streams"] if row["name"] == "/cmd_vel")
        self.expect_exit(self.run_program("topic", "pub", "--once", "/cmd_vel", "geometry_msgs/msg/Twist", "{}"), 0)
        after = sum(row["published"] for row in json.loads(self.run_program("streams", "--json", "--interval", "0.1").stdout)["streams"] if row["name"] == "/cmd_vel")
        self.assertEqual(after, before + 1)
        wrong = self.expect_exit(self.run_program("topic", "pub", "--once", "/cmd_vel", "geometry_msgs/msg/Twist", '{"linaer": {}}'), 2)
        self.assertIn("linear", wrong.stderr)

    def test_the_list_shows_id_node_and_state(self):
        lines = self.expect_exit(self.run_program("component", "list"), 0).stdout.splitlines()
        self.assertEqual(lines[0], "/robot")
        self.assertRegex("\n".join(lines), r"\n  \d+  /imu  active(\n|$)")
        self.assertIn("/imu  active  nacelle::imu::ImuComponent", self.expect_exit(self.run_program("component", "list", "-v"), 0).stdout)

    def test_the_lifecycle_can_be_seen_and_changed(self):
        self.assertEqual(self.expect_exit(self.run_program("lifecycle", "get", "/lidar"), 0).stdout, "active [3]\n")
        outcome = self.expect_exit(self.run_program("lifecycle", "set", "lidar", "deactivate"), 0)
        self.assertEqual(outcome.stdout, "Transitioning successful\n")
        self.assertEqual(self.run_program("lifecycle", "get", "lidar").stdout, "inactive [2]\n")
        refused = self.expect_exit(self.run_program("lifecycle", "set", "lidar", "configure"), 1)
        self.assertIn("could not configure", refused.stderr)
        self.expect_exit(self.run_program("lifecycle", "set", "lidar", "activate"), 0)
        self.expect_exit(self.run_program("lifecycle", "get", "lidr"), 1)

    def test_a_second_container_of_the_same_name_is_refused(self):
        outcome = self.expect_exit(self.run_program("launch", LAUNCH_FILE, f"sim_dir:={self.folder}/sim2", "--name", "robot"), 1)
        self.assertIn("running already", outcome.stderr)

    def test_a_plugin_is_loaded_with_its_own_name_and_unloaded_by_id(self):
        loaded = self.expect_exit(
            self.run_program("component", "load", "nacelle::monitor::MonitorComponent", "--name", "extra", "--namespace", "/lab", "--json"), 0)
        row = json.loads(loaded.stdout)
        self.assertEqual((row["node"], row["state"]), ("/lab/extra", "active"))
        again = self.expect_exit(self.run_program("component", "load", "nacelle::monitor::MonitorComponent", "--name", "extra", "--namespace", "/lab"), 1)
        self.assertIn("/lab/extra", again.stderr)
        outcome = self.expect_exit(self.run_program("component", "unload", row["id"]), 0)
        self.assertIn(f"Unloaded component {row['id']} ('/lab/extra')", outcome.stdout)
        wrong = self.expect_exit(self.run_program("component", "load", "nacelle::monitor::MonitorComponent", "--name", "x", "-p", ":=1"), 2)
        self.assertIn(":=1", wrong.stderr)

    def test_reports_an_unknown_parameter_even_if_the_load_fails(self):
        refused = self.run_program("component", "load", "nacelle::lidar::LidarComponent", "--name", "second", "-p", "port_nme:=/dev/null",
                                   "-p", "required_device:=true")  # fmt: skip
        self.expect_exit(refused, 1)
        self.assertIn("was unloaded again", refused.stderr)
        self.assertRegex(refused.stderr, r"'port_nme'.*did you mean 'port_name'")

    def test_reports_unused_settings_of_a_plugin_to_the_loader(self):
        loaded = self.run_program("component", "load", "nacelle::monitor::MonitorComponent", "--name", "warned", "-p", "no_such:=1", "-r", "diagnostisc:=/x",
                                  "-r", "/diagnostics:=/diagnostics_2")  # fmt: skip
        self.expect_exit(loaded, 0)
        self.expect_exit(self.run_program("component", "unload", "warned"), 0)
        warnings = [line for line in loaded.stderr.splitlines() if line.startswith("nacelle: warning: ")]
        self.assertEqual(len(warnings), 2, loaded.stderr)
        self.assertIn("'no_such'", warnings[0])
        self.assertIn("/warned has no topic or service 'diagnostisc'", warnings[1])

    def test_the_camera_can_be_taken_out_and_put_back_while_the_others_run(self):
        others = [name for name in STREAMS_HZ if name != "/camera/image_raw"]
        before = self.streams()
        swap_camera(self)
        for name in others:
            self.assertGreater(self.streams()[name]["published"], before[name]["published"], name)
        self.assertEqual(self.run_program("lifecycle", "get", "camera").stdout, "active [3]\n")


class Teleop(RunningRobotTest):
    def setUp(self):
        self.commands = []
        self.echo = self.start_program("topic", "echo", "/cmd_vel", "geometry_msgs/msg/Twist", "--json")
        self.reader = threading.Thread(target=self.read_commands)
        self.reader.start()
        self.keyboard, terminal = pty.openpty()
        self.teleop = subprocess.Popen([PROGRAM, "teleop", "--twist"], env=self.environment, stdin=terminal, stdout=subprocess.PIPE,
                                       stderr=subprocess.STDOUT, start_new_session=True)  # fmt: skip
        os.close(terminal)

    def tearDown(self):
        if self.teleop.poll() is None:
            self.teleop.kill()
        self.teleop.communicate()
        self.echo.send_signal(signal.SIGINT)
        self.reader.join(10)
        self.echo.communicate(timeout=10)
        if self.keyboard is not None:
            os.close(self.keyboard)

    def read_commands(self):
        for line in self.echo.stdout:
            message = json.loads(line)
            self.commands.append((message["linear"]["x"], message["angular"]["z"]))

    def drive_forward(self):
        def forward_command_came():
            # Typed again: teleop drops keys that come before it has set the terminal's mode, and the echo may not listen yet.
            os.write(self.keyboard, b"i")
            return any(x > 0 for x, _ in self.commands)

        wait_for("a command to drive forward", forward_command_came)

    def ends_with_zero(self):
        return bool(self.commands) and self.commands[-1] == (0, 0)

    def test_shows_an_emergency_stop_instead_of_a_speed(self):
        said = bytearray()

        def read():
            while piece := self.teleop.stdout.read1(4096):
                said.extend(piece)

        reader = threading.Thread(target=read)
        reader.start()
        try:
            self.expect_exit(self.run_program("estop", "set"), 0)
            wait_for("teleop shows the stop", lambda: b"/emergency_stop is set: stands still" in said)
            before = len(said)
            os.write(self.keyboard, b"i")
            wait_for("the key is answered", lambda: b"\r" in said[before:])
            self.assertNotIn(b"now", said[before:])
        finally:
            self.expect_exit(self.run_program("estop", "release"), 0)
        wait_for("teleop shows the release", lambda: b"now" in said[before:])
        self.teleop.send_signal(signal.SIGTERM)
        self.assertEqual(self.teleop.wait(10 * SLOW), 0)
        reader.join(10)

    def test_a_released_key_stops_the_robot(self):
        self.drive_forward()
        wait_for("the robot gets a stop", self.ends_with_zero)
        self.assertIsNone(self.teleop.poll())

    def test_without_a_terminal_it_is_wrong_usage(self):
        outcome = self.expect_exit(self.run_program("teleop", stdin=subprocess.DEVNULL), 2)
        self.assertIn("needs a terminal", outcome.stderr)

    def test_a_closed_terminal_stops_the_robot(self):
        self.drive_forward()
        os.close(self.keyboard)
        self.keyboard = None
        self.assertEqual(self.teleop.wait(10 * SLOW), 0)
        wait_for("the robot gets a stop", self.ends_with_zero)

    def test_a_signal_stops_the_robot(self):
        self.drive_forward()
        self.teleop.send_signal(signal.SIGTERM)
        self.assertEqual(self.teleop.wait(10 * SLOW), 0)
        wait_for("the robot gets a stop", self.ends_with_zero)


class Rates(RunningRobotTest):
    """Alone on the machine: a robot that waits for a processor publishes at another rate for a second, and hz says so."""

    def test_hz_measures_a_rate(self):
        text = self.expect_exit(self.run_program("topic", "hz", "/imu/data_raw", "--once"), 0).stdout
        rate = float(re.search(r"average rate: ([\d.]+)", text)[1])
        self.assertAlmostEqual(rate, 100, delta=5 * SLOW)

    def test_the_others_keep_their_rates_while_the_camera_is_taken_out_and_put_back(self):
        others = {name: hz for name, hz in STREAMS_HZ.items() if name != "/camera/image_raw"}
        watches = {name: self.start_program("topic", "hz", name) for name in others}
        lines = {name: [] for name in others}
        threads = [threading.Thread(target=lambda n=name: lines[n].extend(watches[n].stdout)) for name in others]
        for thread in threads:
            thread.start()
        for name in others:
            wait_for(f"{name} is measured", lambda n=name: lines[n])

        swap_camera(self)

        deadline = time.monotonic() + 4
        wait_for("a few seconds were measured", lambda: time.monotonic() > deadline)
        for name in others:
            watches[name].send_signal(signal.SIGINT)
        for thread in threads:
            thread.join(10)
        for watch in watches.values():
            watch.communicate(timeout=10)
        for name, hz in others.items():
            rates = re.findall(r"average rate: ([\d.]+)", "".join(lines[name]))
            self.assertTrue(rates, name)
            self.assertAlmostEqual(float(rates[-1]), hz, delta=0.02 * hz * SLOW, msg=name)


if __name__ == "__main__":
    unittest.main()
