# SPDX-License-Identifier: Apache-2.0
"""launch/gps.launch.yaml on the simulated robot: two filters in one container, held by the simulated receiver."""
import json
import math
import pathlib
import re
import unittest

from robot import LAUNCH_FILE, RobotTest, interrupt, wait_for

GPS_FILE = pathlib.Path(LAUNCH_FILE).parent / "gps.launch.yaml"
# Of the simulated world's origin (components/simulation/model/world_settings.hpp).
DATUM = (49.8728, 8.6512)
METRES_NORTH = 111_239.0  # of a degree there


class Gps(RobotTest):
    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        # A map that begins at the world's origin, so that the truth can be compared.
        text = (GPS_FILE.parent / "config/gps.yaml").read_text()
        datum = f"    wait_for_datum: true\n    datum: [{DATUM[0]}, {DATUM[1]}, 0.0]\n"
        text = text.replace("    zero_altitude: true", datum + "    zero_altitude: true")
        cls.config = cls.folder / "gps.yaml"
        cls.config.write_text(text)
        cls.log = open(cls.folder / "log", "w+", encoding="utf-8")
        cls.robot = cls.start_program(
            "launch", GPS_FILE, "sim:=true", "seed:=3", f"sim_dir:={cls.folder}/sim", f"gps_config:={cls.config}", "camera_device:=pattern",
            "detector:=false", stdout=cls.log)  # fmt: skip

    @classmethod
    def tearDownClass(cls):
        interrupt(cls.robot)
        cls.log.close()
        super().tearDownClass()

    def message(self, topic):
        """The next message of a topic."""
        outcome = self.run_program("topic", "echo", topic, "--once", "--json")
        return json.loads(outcome.stdout.splitlines()[0]) if outcome.returncode == 0 and outcome.stdout else None

    def truth(self):
        return json.loads(self.expect_exit(self.run_program("sim", "truth", "--dir", self.folder / "sim"), 0).stdout)

    def logged(self):
        return pathlib.Path(self.log.name).read_text(encoding="utf-8")

    def test_the_map_is_held_by_the_gps_and_moves_the_odometrys_frame(self):
        wait_for("the frames are aligned", lambda: "aligned: datum 49.8728000, 8.6512000" in self.logged(), 40)
        rows = {row["node"] for row in json.loads(self.expect_exit(self.run_program("component", "list", "--json"), 0).stdout)["components"]}
        self.assertLessEqual({"/ekf", "/ekf_map", "/navsat_transform", "/gps"}, rows)
        position = wait_for("a position of the GPS", lambda: self.message("/odometry/gps"))
        self.assertEqual((position["header"]["frame_id"], position["child_frame_id"]), ("map", "base_footprint"))
        self.assertAlmostEqual(math.sqrt(position["pose"]["covariance"][0]), 0.9, delta=0.05, msg="HDOP 0.9 times 1 m")
        self.expect_exit(self.run_program("topic", "pub", "/cmd_vel", "geometry_msgs/msg/Twist", "{linear: {x: 0.2}, angular: {z: 0.4}}",
                                          "--rate", "10", "--times", "200"), 0)  # fmt: skip

        def error_m():
            estimate, truth = self.message("/odometry/global"), self.truth()
            at = estimate["pose"]["pose"]["position"]
            return math.hypot(at["x"] - truth["x_m"], at["y"] - truth["y_m"])

        # The receiver errs by 0.9 m in each direction; the robot stands while truth and estimate are read.
        self.assertLess(error_m(), 0.8)
        fix, truth = self.message("/gps/filtered"), self.truth()
        north_m = (fix["latitude"] - DATUM[0]) * METRES_NORTH
        self.assertAlmostEqual(north_m, truth["y_m"], delta=0.8)
        moved = self.expect_exit(self.run_program("tf", "echo", "map", "odom", "--once"), 0).stdout
        self.assertRegex(moved, r"-?\d+\.\d+")
        point = f"{{ll_point: {{latitude: {DATUM[0] + 10 / METRES_NORTH}, longitude: {DATUM[1]}}}}}"
        answer = self.expect_exit(self.run_program("service", "call", "/fromLL", "robot_localization/srv/FromLL", point), 0).stdout
        self.assertAlmostEqual(float(re.search(r"\by=(-?[\d.]+)", answer)[1]), 10.0, delta=0.02)

    def test_the_plan_is_sound_simulated_and_real(self):
        for arguments in (["sim:=true"], ["sim:=false"]):
            with self.subTest(arguments=arguments):
                outcome = self.expect_exit(self.run_program("check", GPS_FILE, *arguments, "--json"), 0)
                self.assertEqual(json.loads(outcome.stdout)["findings"], [])


if __name__ == "__main__":
    unittest.main()
