# SPDX-License-Identifier: Apache-2.0
"""The one case of a bad network that every change must pass: 1 Mbit/s. The others are in long_test.py."""
import unittest

import wire
from wire import SMALL, STREAMS_HZ


class SlowWire(wire.WireTest):
    def test_small_streams_arrive_beside_images_at_1_mbit_per_s(self):
        robot, meter = self.start_robot(), self.start_meter()
        self.wait_until_heard(robot, meter)
        self.slow_down("1mbit")
        here, there = self.measure(5, robot, meter, "1 Mbit/s")
        self.expect_local_rates(5, here)
        for name in SMALL:
            self.assertGreater(there[name]["hz"], 0.8 * STREAMS_HZ[name], f"{name} there")
        self.assertLess(there["image"]["hz"], 1)
        self.assertGreater(here["during"]["overtaken"], 0, "images that were too many are counted")
        code, seconds = robot.close()
        self.assertEqual(code, 0)
        self.assertLess(seconds, 5, "its end does not wait for the image that is on its way")


if __name__ == "__main__":
    wire.become_root_of_an_own_world()
    unittest.main()
