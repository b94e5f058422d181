# SPDX-License-Identifier: Apache-2.0
"""`nacelle replay`: the filter of the simulated robot on a recording of it."""
import hashlib
import json
import os
import pathlib
import unittest

from robot import SLOW, RobotTest, RunningRobotTest

RUNS = int(os.environ.get("NACELLE_REPLAYS", "3"))  # at night: 10
SECONDS = int(os.environ.get("NACELLE_REPLAYED_SECONDS", "4"))  # at night: 30
FILTER = ("--nodes", "transforms", "--nodes", "ekf")
# The filter of the robot had begun before the recording, and its timer has another phase: up to two periods of 20 ms apart. The robot
# turns by less than half a turn, so that no quaternion changes its sign.
TOLERANCE = """
"*":
  header.stamp: {ignore: true}
/odometry/filtered:
  pose.pose.position: 0.05
  pose.pose.orientation: 0.05
  pose.covariance[*]: {ignore: true}
  twist: {ignore: true}
"""


class Replay(RunningRobotTest):
    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        cls.bag = cls.folder / "drive"
        recorder = cls.start_program("bag", "record", "-a", "-x", "^/camera|^/detections", "--for", SECONDS, "-o", cls.bag)
        words = recorder.stdout.readline()  # from now on it records
        drive = cls.start_program("topic", "pub", "-r", "20", "/cmd_vel", "geometry_msgs/msg/Twist", '{"linear": {"x": 0.2}, "angular": {"z": 0.08}}')
        try:
            words += recorder.communicate(timeout=(SECONDS + 60) * SLOW)[0]
        finally:
            drive.terminate()
            drive.communicate()
        if recorder.returncode != 0:
            raise AssertionError(words)

    def replay(self, name, *words):
        out = self.folder / name
        done = self.expect_exit(self.run_program("replay", self.launch_file, "--from", self.bag, "--record", out, "--json", *words), 0)
        return out, json.loads(done.stdout), done.stderr

    def test_every_run_of_the_filter_writes_the_same_bytes(self):
        sums, took = set(), []
        for number in range(RUNS):
            out, said, _ = self.replay(f"{number}.mcap", *FILTER)
            sums.add(hashlib.sha256(out.read_bytes()).hexdigest())
            took.append(said["took_s"])
        print(f"{said['recorded_s']:.1f} s replayed in {min(took):.2f} to {max(took):.2f} s, {said['played']} messages in, {said['messages']} out")
        self.assertEqual(len(sums), 1)
        self.assertEqual(sorted(said["runs"]), ["/ekf", "/transforms"])
        self.assertGreater(said["messages"]["/odometry/filtered"], 40 * SECONDS)
        self.expect_exit(self.run_program("bag", "check", out), 0)
        self.expect_exit(self.run_program("bag", "diff", self.folder / "0.mcap", out), 0)

    def test_the_filter_goes_where_that_of_the_robot_went(self):
        out, _, _ = self.replay("path.mcap", *FILTER)
        tolerance = self.folder / "tolerance.yaml"
        tolerance.write_text(TOLERANCE)
        done = self.run_program("bag", "diff", self.bag, out, "--topics", "/odometry/filtered", "--tolerance", tolerance, "--json")
        (topic,) = json.loads(done.stdout)["topics"]
        self.assertGreater(topic["equal"], 40 * SECONDS)
        self.assertEqual(topic["different"], 0, topic)
        self.assertLess(abs(topic["messages_a"] - topic["messages_b"]), 10, topic)

    def test_all_but_drivers_and_what_reads_nothing_run_by_default(self):
        out, said, err = self.replay("default.mcap")
        self.assertEqual(sorted(said["runs"]), ["/ekf", "/monitor", "/monitor_2", "/odometry", "/transforms"])
        self.assertEqual(sorted(said["left_out"]), ["/camera", "/detector", "/diff_drive", "/imu", "/lidar"])
        self.assertIn("driver: it opens ", said["left_out"]["/lidar"])
        self.assertEqual(said["programs"], ["world"])
        self.assertIn("warning: /camera/image_raw was not recorded, and /camera is left out; read by /monitor", err)
        self.assertGreater(said["messages"]["/odom"], 40 * SECONDS)
        again, _, _ = self.replay("again.mcap")
        self.assertEqual(out.read_bytes(), again.read_bytes())

    def test_with_all_the_inputs_are_written_too(self):
        out, said, _ = self.replay("all.mcap", *FILTER, "--all", "--compression", "zstd")
        info = json.loads(self.expect_exit(self.run_program("bag", "info", out, "--json"), 0).stdout)
        counts = {topic["name"]: topic["messages"] for topic in info["topics"]}
        recorded = json.loads(self.expect_exit(self.run_program("bag", "info", self.bag, "--json"), 0).stdout)
        before = {topic["name"]: topic["messages"] for topic in recorded["topics"]}
        self.assertEqual(counts["/imu/data_raw"], before["/imu/data_raw"])
        self.assertEqual(counts["/odometry/filtered"], said["messages"]["/odometry/filtered"])
        self.assertEqual(info["compression"], "zstd")

    def test_wrong_words_are_refused_and_leave_no_file(self):
        out = self.folder / "none.mcap"
        for words, what in ((("--nodes", "efk"), "did you mean 'ekf'?"), (("--nodes", "lidar"), "/lidar is a driver: it opens ")):
            with self.subTest(words=words):
                refused = self.run_program("replay", self.launch_file, "--from", self.bag, "--record", out, *words)
                self.assertEqual(refused.returncode, 1)
                self.assertIn(what, refused.stderr)
                self.assertFalse(out.exists())
        out.write_text("mine")
        kept = self.run_program("replay", self.launch_file, "--from", self.bag, "--record", out, *FILTER)
        self.assertEqual((kept.returncode, out.read_text()), (1, "mine"), kept.stderr)


class Files(RobotTest):
    def test_what_is_no_recording_is_refused(self):
        launch = os.environ["NACELLE_LAUNCH_FILE"]
        for path in ("none.mcap", launch):
            with self.subTest(path=path):
                refused = self.run_program("replay", launch, "--from", path, "--record", self.folder / "out.mcap")
                self.assertEqual(refused.returncode, 1, refused.stderr)
                self.assertIn(pathlib.Path(path).name, refused.stderr)
                self.assertFalse((self.folder / "out.mcap").exists())


if __name__ == "__main__":
    unittest.main()
