# SPDX-License-Identifier: Apache-2.0
"""A laptop whose clock is not the robot's: told with its name, and only if it is so."""
import json
import unittest

from machines import Lines
from network_test import PEERS, NetworkTest


def is_skew(line):
    return "clock skew" in line


def milliseconds_of(line):
    words = line.split()
    return int(words[words.index("is") + 1])


class ClockSkew(NetworkTest):
    def sends_commands(self, ahead_ms, host="laptop", count=1000000):
        """A program on plain Cyclone DDS that stamps so far ahead what it sends twenty times a second."""
        named = ("unshare", "--uts", "sh", "-c", f'hostname {host}; exec "$@"', "sh")
        peer = Lines(self.laptop.within(*named, PEERS["cyclone"], "pub", "--topic", "rt/cmd_vel", "--type", "twist", "--speed", 0,
                                        "--every", 50, "--count", count, "--ahead", ahead_ms, "--as-delivered"), self.environment)
        self.addCleanup(peer.close)
        peer.wait_for("the peer is ready", lambda line: line == "ready")
        peer.go()
        return peer

    def lose(self, percent):
        for machine in (self.robot_machine, self.laptop):
            for words in ("add table netdev wire",
                          "add chain netdev wire lose { type filter hook ingress device lan0 priority 0; }",
                          f"add rule netdev wire lose numgen random mod 100 < {percent} drop"):
                machine.run("nft", *words.split())

    def clocks(self):
        """What the robot's container says of others' clocks."""
        return json.loads(self.nacelle("doctor", "net", "--json").stdout)["containers"][0]["clock_skews"]

    def test_a_clock_that_is_ahead(self):
        robot = self.start_robot("network:=export")
        self.sends_commands(150)
        line = robot.wait_for("the clock is told", is_skew)
        self.assertIn("clock skew: host laptop is ", line)
        self.assertIn(" ms ahead; ", line)
        self.assertIn("chrony", line)
        # By what the fastest message needed, less; on a busy machine that is some milliseconds.
        self.assertLessEqual(milliseconds_of(line), 150)
        self.assertGreater(milliseconds_of(line), 100)
        [found] = self.clocks()
        self.assertEqual(found["host"], "laptop")
        self.assertAlmostEqual(found["ahead_s"], 0.15, delta=0.05)
        self.assertIn("clock       robot: host laptop is ", self.nacelle("doctor", "net").stdout)
        # A second program of that host is no news, one of another is.
        self.sends_commands(150)
        self.sends_commands(400, host="tablet")
        self.assertIn("host tablet is ", robot.wait_for("the other clock is told", is_skew))

    def test_a_clock_that_is_behind(self):
        robot = self.start_robot("network:=export")
        self.sends_commands(-150)
        line = robot.wait_for("the clock is told", is_skew)
        self.assertIn("clock skew: host laptop is ", line)
        self.assertIn(" ms behind, or its messages come that late", line)
        self.assertGreaterEqual(milliseconds_of(line), 150)
        self.assertLess(milliseconds_of(line), 200)

    # A message that left 50 ms ago by a clock that is 5 ms ahead has a stamp of 45 ms ago.
    def test_nobody_is_told_of_5_ms_on_a_slow_and_lossy_link_and_of_150_ms_there_he_is(self):
        robot = self.start_robot("network:=export")
        self.lose(30)
        good = self.sends_commands(-45, count=400)
        good.wait_for("twenty seconds of messages", lambda line: line == "wrote 400", 60)
        self.assertEqual([line for line in robot.read() if is_skew(line)], [])
        self.assertEqual(self.clocks(), [])
        self.sends_commands(150 - 50, host="tablet")
        self.assertIn("host tablet is ", robot.wait_for("the clock is told", is_skew))


if __name__ == "__main__":
    unittest.main()
