# SPDX-License-Identifier: Apache-2.0
"""Calibration by driving, with a simulated robot whose errors are known: UMBmark squares find the wheels, figures of eight how the IMU sits."""
import json
import math
import os
import re
import signal
import subprocess
import unittest

from calibration_test import Talk
from robot import LAUNCH_FILE, SLOW, RobotTest, interrupt, nightly, wait_for

CONFIG = os.path.join(os.path.dirname(LAUNCH_FILE), "config", "robot.yaml")
DESCRIPTION = os.path.join(os.path.dirname(LAUNCH_FILE), "robot.urdf")
# A sanitizer's robot has its readings late, which is another measurement; the commands run there in the other cases.
in_time = unittest.skipIf(SLOW > 1, "a sanitizer's robot measures late")
DIFF_DRIVE = "left_wheel_radius_multiplier", "right_wheel_radius_multiplier", "wheel_separation_multiplier"
SLIP = "slip.distance_stddev_per_sqrt_m", "slip.heading_stddev_per_sqrt_m", "slip.heading_stddev_per_sqrt_rad"


class DrivingRobot(RobotTest):
    """A robot of wheels and an IMU, in a world with errors that the test has chosen; the truth is on /ground_truth."""

    left, right, separation, slip = 0.02, 0.012, -0.03, 0.002
    imu_yaw_deg, imu_x, imu_y = 5.0, 0.10, -0.04
    seed = 7

    def setUp(self):
        # A robot for each case: it begins in the middle of the room, where squares have room.
        self.place = self.folder / self.id().rpartition(".")[2]
        self.place.mkdir()
        file = self.place / "robot.launch.yaml"
        world = (f"sim world --dir {self.place}/sim --seed {self.seed} --left-radius-error {self.left} --right-radius-error {self.right} "
                 f"--separation-error {self.separation} --slip {self.slip} --imu-yaw {self.imu_yaw_deg} --imu-x {self.imu_x} --imu-y {self.imu_y}")  # fmt: skip
        file.write_text(f"""launch:
- node: {{pkg: nacelle, exec: nacelle, exec_name: world, args: {world}, required: true}}
- node_container:
    name: robot
    namespace: ''
    composable_node:
    - pkg: nacelle_transforms
      plugin: nacelle::transforms::TransformsComponent
      name: transforms
      param: [{{name: robot_description_file, value: {DESCRIPTION}}}]
    - pkg: nacelle_odometry
      plugin: nacelle::odometry::OdometryComponent
      name: odometry
      param: [{{name: robot_description_file, value: {DESCRIPTION}}}, {{name: base_frame_id, value: base_footprint}}]
    - pkg: nacelle_diff_drive
      plugin: nacelle::diff_drive::DiffDriveComponent
      name: diff_drive
      param: [{{from: {CONFIG}}}, {{name: serial_port, value: {self.place}/sim/base}}, {{name: robot_description_file, value: {DESCRIPTION}}}]
    - pkg: nacelle_imu
      plugin: nacelle::imu::ImuComponent
      name: imu
      param: [{{name: port, value: {self.place}/sim/imu}}]
""")
        log = open(self.place / "log", "w", encoding="utf-8")
        self.addCleanup(log.close)
        self.robot = self.start_program("launch", file, "--name", "robot", stdout=log, stderr=subprocess.STDOUT)
        self.addCleanup(interrupt, self.robot)
        wait_for("every component is active", self.is_up, 60)
        publisher = self.start_program("sim", "truth", "--dir", self.place / "sim", "--publish", "ground_truth", stdout=log)
        self.addCleanup(interrupt, publisher)
        wait_for("the truth is published", lambda: "/ground_truth\n" in self.run_program("topic", "list").stdout)

    def is_up(self):
        if self.robot.poll() is not None:
            raise AssertionError("the robot ended: " + (self.place / "log").read_text())
        listed = self.run_program("component", "list", "--json")
        rows = json.loads(listed.stdout)["components"] if listed.returncode == 0 else []
        return len(rows) == 4 and all(row["state"] == "active" for row in rows)

    def truth(self):
        return json.loads(self.expect_exit(self.run_program("sim", "truth", "--dir", f"{self.place}/sim"), 0).stdout)

    def talk(self, *words, output="out.yaml"):
        talk = Talk((*words, "--wait", "60", "--output", str(self.place / output)), self.environment)
        self.addCleanup(talk.close)
        return talk

    def numbers(self, output, names):
        """The parameters of a written file; all of them must be of these names."""
        written = dict(re.findall(r"^    ([\w.]+): ([-+0-9.e]+)$", (self.place / output).read_text(), re.MULTILINE))
        self.assertEqual(set(written), set(names))
        return {name: float(value) for name, value in written.items()}

    def expect_wheels(self, values):
        self.assertEqual(self.truth()["contacts"], 0, "a wall held the robot")
        for name, error in zip(DIFF_DRIVE, (self.left, self.right, self.separation)):
            self.assertAlmostEqual(values[name] / (1.0 + error), 1.0, delta=0.005, msg=f"{name}: {values[name]}")


class Driven(DrivingRobot):
    @in_time
    def test_squares_both_ways_find_the_wheels_to_half_a_per_cent(self):
        talk = self.talk("base", "calibrate", "--umbmark", "--truth", "ground_truth", "--squares", "1", "--side", "0.5", "--speed", "0.5", "--turn", "2.0",
                         "--yes")  # fmt: skip
        self.assertEqual(talk.end(180), 0, talk.said)
        values = self.numbers("out.yaml", DIFF_DRIVE + SLIP)
        self.expect_wheels(values)
        # A relative slip of s for a second each, at v m/s: s sqrt(v / 2) m a root of a metre, of the middle; at most 1 mm here, and counts of 0.14 mm.
        self.assertLess(values[SLIP[0]], 0.005)
        self.assertLess(values[SLIP[1]], 0.02)
        self.assertIn("UMBmark: clockwise (", talk.said)
        alpha = float(re.search(r"Type A, separation: alpha ([-0-9.]+) degrees", talk.said).group(1))
        # 3 % closer together and 1.6 % larger wheels: a corner of 90 degrees is one of 94.3.
        self.assertAlmostEqual(alpha, 90 * (1 - 1.016 / 0.97), delta=1.0)

    @in_time
    def test_figures_of_eight_find_how_the_imu_sits(self):
        talk = self.talk("imu", "calibrate", "--drive", "--eights", "2", "--yaw-rate", "1.5", "--radius", "0.3", "--yes", output="imu.yaml")
        self.assertEqual(talk.end(180), 0, talk.said)
        written = (self.place / "imu.yaml").read_text()
        roll, pitch, yaw = map(float, re.search(r"mounting_rpy: \[(.*), (.*), (.*)\]", written).groups())
        self.assertAlmostEqual(math.degrees(yaw), self.imu_yaw_deg, delta=0.5, msg=talk.said)
        self.assertAlmostEqual(math.hypot(roll, pitch), 0.0, delta=1e-6)
        x, y, z = map(float, re.search(r'<origin xyz="(\S+) (\S+) (\S+)"', written).groups())
        self.assertAlmostEqual(x, self.imu_x, delta=0.01, msg=talk.said)
        self.assertAlmostEqual(y, self.imu_y, delta=0.01, msg=talk.said)
        self.assertEqual(z, 0.04)  # of the description
        self.assertIn("accel_bias: [0.00000000, 0.00000000, 0.00000000]", written)

    def test_ctrl_c_in_a_drive_stops_the_wheels_and_writes_nothing(self):
        for words, moves in ((("base", "calibrate", "--umbmark", "--truth", "ground_truth"), "speed_mps"), (("imu", "calibrate", "--drive"), "yaw_rate_rps")):
            talk = self.talk(*words, "--yes", output="interrupted.yaml")
            wait_for("the robot moves", lambda moves=moves: abs(self.truth()[moves]) > 0.1, 60)
            talk.process.send_signal(signal.SIGINT)
            self.assertEqual(talk.end(), 130, talk.said)
            wait_for("the wheels stand", lambda: self.truth()["left_command_mps"] == 0)
            self.assertIn("nothing was written", talk.said)
            self.assertFalse((self.place / "interrupted.yaml").exists())

    def test_what_cannot_measure_is_refused_before_the_drive(self):
        squares = ("base", "calibrate", "--umbmark", "--yes")
        for words, code, said in (((*squares, "--truth", "joint_states"), 1, "topic /joint_states: is not of poses"),
                                  ((*squares, "--measured-end", "0.1"), 2, "'0.1' is not X,Y in metres"),
                                  ((*squares, "--truth", "ground_truth", "--measured-end", "0,0"), 2, "--measured-end"),
                                  (("imu", "calibrate", "--drive", "--yes", "--base", "imu"), 1, "name the base's node with --base")):  # fmt: skip
            outcome = self.expect_exit(self.run_program(*words, "--output", self.place / "refused.yaml", stdin=subprocess.DEVNULL), code)
            self.assertIn(said, outcome.stderr)
        self.assertFalse((self.place / "refused.yaml").exists())
        self.assertEqual(self.truth()["left_command_mps"], 0)

    @in_time
    @nightly
    def test_an_operator_measures_a_line_and_the_ends_of_squares(self):
        talk = self.talk("base", "calibrate", "--umbmark", "--distance", "0.5", "--squares", "2", "--side", "0.5", "--speed", "0.5", "--turn", "2.0",
                         output="asked.yaml")  # fmt: skip
        talk.expect("squares of 0.50 m, 2 to the right(.|\n)*Clear the place, then press Enter")
        talk.answer()
        talk.expect("mark on the floor where the robot stands, then press Enter")
        begin = self.truth()
        talk.answer()
        talk.expect("how many metres did it really drive")
        end = self.truth()
        talk.answer(f"{math.hypot(end['x_m'] - begin['x_m'], end['y_m'] - begin['y_m']):.4f}")
        for number in range(1, 5):
            talk.expect(f"square {number} of 4(.|\n)*then press Enter")
            begin = self.truth()
            talk.answer()
            talk.expect("how many metres ahead")
            end = self.truth()
            dx, dy = end["x_m"] - begin["x_m"], end["y_m"] - begin["y_m"]
            c, s = math.cos(begin["yaw_rad"]), math.sin(begin["yaw_rad"])
            if number == 1:
                talk.answer("a little")
                talk.expect("'a little' is no number(.|\n)*how many metres ahead")
            talk.answer(f"{c * dx + s * dy:.4f}")
            talk.expect("how many metres left")
            talk.answer(f"{c * dy - s * dx:.4f}")
        self.assertEqual(talk.end(), 0, talk.said)
        self.expect_wheels(self.numbers("asked.yaml", DIFF_DRIVE + SLIP))

    @in_time
    @nightly
    def test_a_drive_that_excites_too_little_is_refused_with_the_way_out(self):
        talk = self.talk("imu", "calibrate", "--drive", "--eights", "1", "--yaw-rate", "0.5", "--radius", "0.1", "--yes", output="slow.yaml")
        self.assertEqual(talk.end(180), 1, talk.said)
        self.assertIn("the robot hardly accelerated", talk.said)
        self.assertIn("drive faster (--yaw-rate) or in wider circles (--radius)", talk.said)
        self.assertFalse((self.place / "slow.yaml").exists())


class Slipping(DrivingRobot):
    """Wheels that slip as much as the default world's, and other errors."""

    left, right, separation, slip = -0.015, 0.01, 0.025, 0.005
    imu_yaw_deg, imu_x, imu_y = -95.0, -0.15, 0.08
    seed = 21

    @in_time
    @nightly
    def test_more_squares_make_up_for_the_slip(self):
        talk = self.talk("base", "calibrate", "--umbmark", "--truth", "ground_truth", "--squares", "3", "--side", "0.7", "--speed", "0.5", "--turn", "2.0",
                         "--yes")  # fmt: skip
        self.assertEqual(talk.end(400), 0, talk.said)
        values = self.numbers("out.yaml", DIFF_DRIVE + SLIP)
        self.expect_wheels(values)
        # A leg of 0.7 m takes three seconds with a slip of their own, in which the wheels roll about 0.2, 0.35 and 0.15 m: (0.005)^2 times the sum of
        # the squares is a wheel's variance; half of it is the middle's, twice of it over the separation squared the heading's.
        self.assertAlmostEqual(math.log2(values[SLIP[0]] / 0.0018), 0.0, delta=1.0)
        self.assertAlmostEqual(math.log2(values[SLIP[1]] / 0.0118), 0.0, delta=1.0)

    @in_time
    @nightly
    def test_an_imu_that_looks_to_the_right_is_found(self):
        talk = self.talk("imu", "calibrate", "--drive", "--eights", "3", "--yaw-rate", "1.2", "--radius", "0.4", "--yes", output="imu.yaml")
        self.assertEqual(talk.end(180), 0, talk.said)
        written = (self.place / "imu.yaml").read_text()
        yaw = float(re.search(r"mounting_rpy: \[.*, .*, (.*)\]", written).group(1))
        self.assertAlmostEqual(math.degrees(yaw), self.imu_yaw_deg, delta=0.5, msg=talk.said)
        x, y = map(float, re.search(r'<origin xyz="(\S+) (\S+) \S+"', written).groups())
        self.assertAlmostEqual(x, self.imu_x, delta=0.01, msg=talk.said)
        self.assertAlmostEqual(y, self.imu_y, delta=0.01, msg=talk.said)


if __name__ == "__main__":
    unittest.main()
