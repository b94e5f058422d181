# SPDX-License-Identifier: Apache-2.0
"""Networks as they are: slow, lossy and dead readers, and what becomes of local and of small streams. Figures in the output."""
import signal
import unittest

import wire
from wire import SMALL, STREAMS_HZ

SECONDS = 10
RELIABLE, BEST_EFFORT = (), ("--best-effort",)


class Networks(wire.WireTest):
    def through(self, reads, what, harm, mend, listens=True):
        """A good wire, then a bad one for twice ten seconds, then a good one. What the laptop heard on the bad one."""
        robot, meter = self.start_robot(*reads), self.start_meter(*reads)
        self.wait_until_heard(robot, meter)
        self.measure(5, robot, meter, f"a good wire {' '.join(reads)}")
        harm(meter)
        one, _ = self.measure(SECONDS, robot, meter if listens else None, what)
        two, there = self.measure(SECONDS, robot, meter if listens else None, what + ", later")
        mend(meter)
        self.wait_until_heard(robot, meter)
        self.measure(5, robot, meter, "a good wire again")
        self.expect_local_rates(SECONDS, one, two)
        # Less than five images, which is what each of two histories keeps; a leak of one per second would be nine.
        self.assertLess(two["rss_kib"], one["rss_kib"] + 4500, "memory grows")
        code, seconds = robot.close()
        self.assertEqual(code, 0)
        self.assertLess(seconds, 5, "the robot's end")
        return there

    def expect_small_streams(self, there, share, late_ms):
        for name in SMALL:
            self.assertGreater(there[name]["hz"], share * STREAMS_HZ[name], f"{name} there")
            self.assertLess(there[name]["p50_us"], 1000 * late_ms, f"{name} there")

    def expect_images_to_suffer_first(self, there):
        for name in SMALL:
            self.assertGreaterEqual(there[name]["hz"] / STREAMS_HZ[name], there["image"]["hz"] / STREAMS_HZ["image"], name)

    # --- slow --------------------------------------------------------------------------------------------------------

    def slow(self, reads, rate):
        there = self.through(reads, f"{rate} {' '.join(reads)}", lambda _: self.slow_down(rate), lambda _: self.mend())
        self.expect_images_to_suffer_first(there)
        self.expect_small_streams(there, 0.95, 500)
        return there

    def test_1_mbit_per_s_to_reliable_readers(self):
        self.slow(RELIABLE, "1mbit")

    def test_1_mbit_per_s_to_best_effort_readers(self):
        self.slow(BEST_EFFORT, "1mbit")

    def test_5_mbit_per_s_to_reliable_readers(self):
        there = self.slow(RELIABLE, "5mbit")
        self.assertGreater(there["image"]["heard"], 0, "images degrade, they do not end")

    # --- lossy -------------------------------------------------------------------------------------------------------

    def lossy(self, reads, percent):
        there = self.through(reads, f"{percent} % lost {' '.join(reads)}", lambda _: self.lose(percent), lambda _: self.mend())
        self.expect_images_to_suffer_first(there)

    def test_10_percent_lost_to_reliable_readers(self):
        self.lossy(RELIABLE, 10)

    # Best effort on both sides: of a reliable writer such a reader of Cyclone's never recovers (docs/adr/0012).
    def test_10_percent_lost_to_best_effort_readers(self):
        self.lossy(BEST_EFFORT, 10)

    def test_30_percent_lost_to_reliable_readers(self):
        self.lossy(RELIABLE, 30)

    def test_30_percent_lost_to_best_effort_readers(self):
        self.lossy(BEST_EFFORT, 30)

    # --- dead --------------------------------------------------------------------------------------------------------

    def test_a_reader_that_has_stopped(self):
        self.through(RELIABLE, "stopped", lambda meter: meter.signal(signal.SIGSTOP),
                     lambda meter: meter.signal(signal.SIGCONT), listens=False)

    def test_a_host_that_answers_nothing(self):
        self.through(RELIABLE, "nothing arrives", lambda _: self.lose(100), lambda _: self.mend())

    def test_a_host_whose_interface_is_down(self):
        self.through(RELIABLE, "its interface is down", lambda _: self.there.run("ip", "link", "set", "wire0", "down"),
                     lambda _: self.there.run("ip", "link", "set", "wire0", "up"))


if __name__ == "__main__":
    wire.become_root_of_an_own_world()
    unittest.main()
