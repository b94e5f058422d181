# SPDX-License-Identifier: Apache-2.0
"""What one run cannot show, for the nightly run: eleven seeds of the drive, and one order in twenty bring-ups. ~4 minutes."""
import concurrent.futures
import json
import statistics
import unittest

from robot import MAY_ALLOCATE, RobotTest, counting

AT_ONCE = 3  # a drive takes a twentieth of a core; more at once and a busy machine would be measured


class ManyRuns(RobotTest):
    def report_of(self, name, *arguments):
        folder = self.folder / name  # runs beside each other find their own container only
        folder.mkdir()
        environment = {**counting(self.environment), "XDG_RUNTIME_DIR": str(folder)}
        self.expect_exit(self.run_program("drive", "--report", folder / "report.json", *arguments, env=environment), 0)
        return json.loads((folder / "report.json").read_text())

    def test_eleven_seeds(self):
        with concurrent.futures.ThreadPoolExecutor(AT_ONCE) as pool:
            reports = list(pool.map(lambda seed: self.report_of(f"seed_{seed}", "--seed", seed), range(1, 12)))
        for report in reports:
            drive, process = report["drive"], report["process"]
            print(
                f"seed {report['seed']:2}: odometry {drive['odometry_error_m'] * 1000:5.1f} mm, EKF {drive['ekf_error_m'] * 1000:4.1f} mm, "
                f"cmd_vel to wheels p99 {report['command_to_wheel_ms']['p99']:.1f} ms, {process['cpu_percent']:.1f} %, {process['rss_mb']:.1f} MB, "
                f"heap calls/s {process['allocations_per_second']}",
                flush=True,
            )
        odometry = [report["drive"]["odometry_error_m"] for report in reports]
        ekf = [report["drive"]["ekf_error_m"] for report in reports]
        print(f"odometry: median {statistics.median(odometry) * 1000:.1f} mm, worst {max(odometry) * 1000:.1f}")
        print(f"EKF:      median {statistics.median(ekf) * 1000:.1f} mm, worst {max(ekf) * 1000:.1f}", flush=True)
        # A world without error would prove nothing.
        self.assertGreater(statistics.median(odometry), 0.02)
        self.assertLess(statistics.median(odometry), 0.08)
        self.assertLess(max(odometry), 0.25)
        self.assertLessEqual(statistics.median(ekf), statistics.median(odometry) / 2)
        self.assertLess(max(ekf), 0.04)
        for report in reports:
            with self.subTest(seed=report["seed"]):
                self.assertLess(report["command_to_wheel_ms"]["p99"], 40)
                for thread, rate in report["process"]["allocations_per_second"].items():
                    if not thread.startswith(MAY_ALLOCATE):
                        self.assertEqual(rate, 0, f"thread {thread} allocates")

    def test_one_seed_gives_one_order_twenty_times(self):
        orders = set()
        for run in range(20):
            report = self.report_of(f"run_{run}", "--for", "0.5", "--seed", 5)
            orders.add((tuple(report["bringup"]["order"]), tuple(report["shutdown"]["order"])))
        self.assertEqual(len(orders), 1, orders)


if __name__ == "__main__":
    unittest.main()
