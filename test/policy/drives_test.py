#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""The test of .ci/drives.py, which compares a drive of an installed package with one of this machine."""
import copy
import json
import subprocess
import sys
import tempfile
import unittest
from pathlib import Path

DRIVES = Path(__file__).resolve().parents[2] / ".ci" / "drives.py"
SOUND = {
    "bringup": {"order": ["lidar", "imu"]},
    "streams": [{"name": "/scan", "hz": 10.0}, {"name": "/tf_static", "hz": 0.05}],
    "drive": {"odometry_error_m": 0.0208, "ekf_error_m": 0.0043},
}


class Drives(unittest.TestCase):
    def compare(self, change):
        other = copy.deepcopy(SOUND)
        change(other)
        with tempfile.TemporaryDirectory() as folder:
            files = [Path(folder) / name for name in ("here.json", "there.json")]
            for file, report in zip(files, (SOUND, other)):
                file.write_text(json.dumps(report), encoding="utf-8")
            return subprocess.run([sys.executable, "-I", str(DRIVES), *map(str, files)], capture_output=True, text=True, check=False)

    def test_accepts_small_differences_and_rare_messages(self):
        for change in (
            lambda report: report["streams"][0].update(hz=10.1),
            lambda report: report["streams"][1].update(hz=0.2),
            lambda report: report["drive"].update(odometry_error_m=0.04),
            lambda report: report["drive"].update(ekf_error_m=0.001),
        ):
            answer = self.compare(change)
            self.assertEqual(answer.returncode, 0, answer.stdout)

    def test_fails_on_each_difference_that_counts(self):
        for words, change in (
            ("/scan: 9.70 messages a second, here 10.00", lambda report: report["streams"][0].update(hz=9.7)),
            ("/scan: 0.00 messages a second", lambda report: report["streams"].pop(0)),
            ("/odom: 50.00 messages a second, here 0.00", lambda report: report["streams"].append({"name": "/odom", "hz": 50.0})),
            ("odometry_error_m: 0.05 m, here 0.0208 m", lambda report: report["drive"].update(odometry_error_m=0.05)),
            ("ekf_error_m: 0.009 m", lambda report: report["drive"].update(ekf_error_m=0.009)),
            ("another order", lambda report: report["bringup"].update(order=["imu", "lidar"])),
        ):
            with self.subTest(words):
                answer = self.compare(change)
                self.assertEqual(answer.returncode, 1, answer.stdout)
                self.assertIn(words, answer.stdout)


if __name__ == "__main__":
    unittest.main()
