# SPDX-License-Identifier: Apache-2.0
"""A laptop whose clock differs from the robot's is reported by name, and only if it does differ."""
import json
import os
import unittest

from machines import Lines, named, slow_cable
from on_the_network import PEERS, NetworkTest
from robot import nightly, wait_for


def is_skew(line):
    return "clock skew" in line


def milliseconds_of(line):
    words = line.split()
    return int(words[words.index("is") + 1])


class ClockSkew(NetworkTest):
    def sends_commands(self, ahead_ms, host="laptop", count=1000000):
        """Starts a program on plain Cyclone DDS that sends twenty commands a second, with stamps that are `ahead_ms` ahead."""
        peer = Lines(self.laptop.within(*named(host), PEERS["cyclone"], "pub", "--topic", "rt/cmd_vel", "--type", "twist", "--speed", 0,
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
        line = robot.wait_for("the clock is reported", is_skew)
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
        self.assertIn("host tablet is ", robot.wait_for("the other clock is reported", is_skew))

    @nightly
    def test_a_clock_that_is_behind(self):
        robot = self.start_robot("network:=export")
        self.sends_commands(-150)
        line = robot.wait_for("the clock is reported", is_skew)
        self.assertIn("clock skew: host laptop is ", line)
        self.assertIn(" ms behind, or its messages come that late", line)
        self.assertGreaterEqual(milliseconds_of(line), 150)
        self.assertLess(milliseconds_of(line), 200)

    # A message that left 50 ms ago by a clock that is 5 ms ahead has a stamp of 45 ms ago.
    @nightly
    def test_reports_150_ms_but_not_5_ms_on_a_slow_and_lossy_link(self):
        robot = self.start_robot("network:=export")
        self.lose(30)
        good = self.sends_commands(-45, count=400)
        good.wait_for("twenty seconds of messages", lambda line: line == "wrote 400", 60)
        self.assertEqual([line for line in robot.read() if is_skew(line)], [])
        self.assertEqual(self.clocks(), [])
        self.sends_commands(150 - 50, host="tablet")
        self.assertIn("host tablet is ", robot.wait_for("the clock is reported", is_skew))


class TwoRobots(NetworkTest):
    """On one domain, each on a machine and in a namespace of its own, with /tf in common or not."""

    def start_both(self, *arguments, ahead_s=0.0):
        """The second one's clock is ahead by so much from the start."""
        fifo = self.folder / f"clock-{self.id()}"
        os.mkfifo(fifo)
        clock = os.open(fifo, os.O_RDWR)  # until the robot reads it
        self.addCleanup(os.close, clock)
        os.write(clock, f"{ahead_s}\n".encode())
        one = self.start_robot("network:=export", "namespace:=robot1", *arguments, name="robot1", host="first")
        two = self.start_robot("network:=export", "namespace:=robot2", *arguments, "--test-clock", fifo, name="robot2",
                               machine=self.laptop, host="second")
        return one, two, fifo

    def tree(self, *more):
        return self.nacelle("tf", "tree", "--container", "robot1", *more).stdout

    def frames(self):
        return {row["child"]: row for row in json.loads(self.tree("--json"))["frames"]}

    def test_share_their_transforms_and_report_that_one_clock_is_ahead(self):
        one, two, fifo = self.start_both("tf:=frames")
        wait_for("the other's frames", lambda: "robot2/base_footprint" in self.frames() and "robot2/lidar_link" in self.frames())
        self.assertEqual({name.split("/")[0] for name in self.frames()}, {"robot1", "robot2"})
        with open(fifo, "w", encoding="ascii") as clock:
            clock.write("0.3\n")
        line = one.wait_for("the clock that is ahead", is_skew)
        self.assertIn("clock skew: host second is ", line)
        self.assertIn(" ms ahead", line)
        self.assertIn("clock skew: host first is ", two.wait_for("to the other one is behind", is_skew))
        frames = self.frames()
        self.assertIn("host second is ", frames["robot2/base_footprint"]["clock_skew"])
        self.assertNotIn("clock_skew", frames["robot1/base_footprint"])
        self.assertRegex(self.tree(), r"clock skew: host second is \d+ ms ahead \(.*robot2/base_footprint")

    def figures(self, name):
        containers = json.loads(self.nacelle("doctor", "net", "--json").stdout)["containers"]
        return next(row["figures"] for row in containers if row["name"] == name)

    @nightly
    def test_report_a_clock_that_is_40_ms_behind_because_its_nodes_are_queried(self):
        one, two, _ = self.start_both("tf:=frames", ahead_s=-0.04)
        line = one.wait_for("the clock that is behind", is_skew, 60)
        self.assertIn("clock skew: host second is ", line)
        self.assertIn(" ms behind; ", line)
        self.assertNotIn("or its messages", line)
        # What is sure is the offset less the way of the question.
        self.assertGreaterEqual(milliseconds_of(line), 20)
        self.assertLessEqual(milliseconds_of(line), 40)
        self.assertRegex(self.nacelle("doctor", "net").stdout, r"clock +robot1: host second is \d+ ms behind;")
        self.assertGreaterEqual(self.figures("robot1")["clock_answers"], 1)
        # To the other one it is ahead, which messages show by themselves.
        self.assertIn(" ms ahead; ", two.wait_for("the same of the other side", is_skew, 60))
        self.assertEqual(self.figures("robot2")["clock_questions"], 0)

    @nightly
    def test_do_not_take_a_way_of_130_ms_for_a_clock(self):
        self.laptop.ip("link", "del", "lan0")
        way = slow_cable(self.robot_machine, self.laptop, self.machine(), 0.13)
        way.__enter__()
        self.addCleanup(way.__exit__, None, None, None)
        one, two, _ = self.start_both("tf:=frames")
        wait_for("the other's nodes have answered", lambda: self.figures("robot1")["clock_answers"] >= 3, 60)
        # A wrong guess would be reported with the first message of the next two seconds.
        for robot in (one, two):
            self.assertFalse(robot.within(5, is_skew), robot.seen[-5:])

    def test_do_not_meet_with_topics_of_their_own(self):
        self.start_both()

        def others():
            """Endpoints of the other robot on topics of this one: both have /diagnostics and /rosout."""
            containers = json.loads(self.nacelle("doctor", "net", "--json").stdout)["containers"]
            return next(row["figures"]["others"] for row in containers if row["name"] == "robot1")

        wait_for("they are on the same network", lambda: others() > 0)
        self.assertEqual([name for name in self.frames() if "/" in name], [])
        topics = {row["name"]: row for row in json.loads(self.nacelle("topic", "list", "--container", "robot1", "--json").stdout)}
        self.assertEqual([name for name in topics if name.startswith("/robot2/") or name.startswith("/tf")], [])
        self.assertEqual(topics["/robot1/odom"]["writers"], 1)


if __name__ == "__main__":
    unittest.main()
