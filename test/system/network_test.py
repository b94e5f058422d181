# SPDX-License-Identifier: Apache-2.0
"""A robot that is exported to a LAN: peers read and drive it there, and networks come and go meanwhile."""
import json
import os
import re
import subprocess
import unittest

from machines import Lines, cable, drive_until
from on_the_network import ASKS_THE_ROBOT, PEERS, SILENCE_S, NetworkTest, is_odometry, speed_of
from robot import LAUNCH_FILE, PROGRAM, SLOW, nightly, wait_for

# One topic for all robots, as in ROS 2.
SHARED = {"/diagnostics", "/parameter_events", "/rosout"}


class Exported(NetworkTest):
    def check_both_ways(self, vendor):
        robot = self.start_robot("network:=export")
        self.assertEqual(robot.line, "network: shown to the LAN; to keep it on this machine: network:=local")
        reader = self.reads_odometry(vendor, self.laptop)
        line = reader.wait_for("odometry on the laptop", is_odometry)
        self.assertEqual(line.split()[2:], ["odom", "base_footprint"])
        self.assertAlmostEqual(speed_of(line), 0.0, delta=0.01)
        driver = drive_until(lambda limit_s: reader.wait_for("the robot drives as the laptop says", lambda line: speed_of(line) > 0.1, limit_s),
                             lambda: self.drives(vendor, self.laptop), robot)  # fmt: skip
        driver.close()
        reader.wait_for("it stops when the laptop falls silent", lambda line: is_odometry(line) and speed_of(line) < 0.01)

    def test_a_cyclone_laptop_reads_odometry_and_drives(self):
        self.check_both_ways("cyclone")

    @unittest.skipUnless("fastdds" in PEERS, "built without the Fast DDS peer")
    def test_a_fast_dds_laptop_reads_odometry_and_drives(self):
        self.check_both_ways("fastdds")

    def test_what_the_list_does_not_name_does_not_leave(self):
        launch = self.folder / "listed.launch.yaml"
        launch.write_text(f"launch:\n- network: {{mode: export, export: [{{topic: /odom, max_hz: 5}}]}}\n- include: {{file: {LAUNCH_FILE}}}\n")
        command = self.robot_machine.within(PROGRAM, "launch", launch, "--name", "robot")
        robot = Lines(command, self.environment)
        self.addCleanup(robot.interrupt)
        robot.wait_for("the robot is up", lambda line: " active in " in line, 60)
        scans = self.peer("cyclone", self.laptop, "echo", "--topic", "rt/camera/image_raw", "--type", "image", "--best-effort")
        reader = self.reads_odometry("cyclone", self.laptop)
        reader.wait_for("the first odometry", is_odometry)
        reader.seen.clear()
        wait_for("ten messages more", lambda: sum(map(is_odometry, reader.read())) >= 10)
        self.assertEqual(scans.read(), [])
        figures = json.loads(self.nacelle("doctor", "net", "--json").stdout)["containers"][0]["figures"]
        # Fifty a second are published; the tenth of them went, by the rule's clock and not by this test's.
        self.assertGreater(figures["held_back"], 6 * figures["sent"])
        self.assertGreater(figures["hidden"], 20)
        self.assertEqual(figures["writers"], 1)

    def drop_multicast(self):
        """As some a Wi-Fi does."""
        for machine in (self.robot_machine, self.laptop):
            machine.run("nft", "add table ip wifi; add chain ip wifi out { type filter hook output priority 0; }; "
                               "add rule ip wifi out oifname lan0 ip daddr 224.0.0.0/4 counter drop")

    def check_by_static_peers(self, vendor, of_robot, **variables):
        """The peer gets what rmw_cyclonedds makes of ROS_STATIC_PEERS."""
        self.drop_multicast()
        self.start_robot("network:=export", **of_robot)
        self.reads_odometry(vendor, self.laptop, **variables).wait_for("odometry on the laptop", is_odometry)
        blocked = re.search(r"counter packets (\d+)", self.laptop.run("nft", "list", "ruleset").stdout)
        self.assertGreater(int(blocked[1]), 0, "the laptop has tried it by multicast")

    def test_where_multicast_is_blocked_a_cyclone_laptop_is_found_by_static_peers(self):
        self.check_by_static_peers("cyclone", {"ROS_STATIC_PEERS": "10.77.0.2"}, CYCLONEDDS_URI=ASKS_THE_ROBOT)

    @nightly
    def test_where_multicast_is_blocked_it_is_enough_that_the_laptop_knows_the_robot(self):
        self.check_by_static_peers("cyclone", {}, CYCLONEDDS_URI=ASKS_THE_ROBOT)
        environment = {**self.environment, "ROS_STATIC_PEERS": "10.77.0.1"}
        listed = subprocess.run(self.laptop.within(PROGRAM, "node", "list", "--remote", "--spin-time", "3"), env=environment,
                                capture_output=True, text=True, timeout=60 * SLOW, check=True)
        self.assertIn("/diff_drive\n", listed.stdout)

    @unittest.skipUnless("fastdds" in PEERS, "built without the Fast DDS peer")
    @nightly
    def test_where_multicast_is_blocked_a_fast_dds_laptop_is_found_by_static_peers(self):
        self.check_by_static_peers("fastdds", {"ROS_STATIC_PEERS": "10.77.0.2"})


class TwoRobots(NetworkTest):
    """Whole ones on two machines of one LAN, both shown to it."""

    def start_both(self, **what_of):
        """`what_of`: arguments and variables of a robot by its name."""
        both = []
        for name, machine in (("one", self.robot_machine), ("other", self.laptop)):
            variables = dict(what_of.get(name, {}))
            both.append(self.start_robot("network:=export", *variables.pop("arguments", ()), machine=machine, name=name, **variables))
        return both

    def on_the_network(self):
        found = json.loads(self.nacelle("doctor", "net", "--json").stdout)["containers"]
        return {container["name"]: container for container in found}

    def crossed(self, name):
        """Ends of others on its topics, and messages, requests and answers that came from the network."""
        figures = self.on_the_network()[name]["figures"]
        return {key: figures[key] for key in ("others", "received") if figures[key] != 0}

    def speed(self, name, topic="/odom"):
        echoed = self.nacelle("topic", "echo", topic, "--once", "--json", "--container", name)
        return json.loads(echoed.stdout)["twist"]["twist"]["linear"]["x"]

    def check_below(self, namespace, name):
        """Its topics and services are all below it, and so are the nodes at both ends of each topic."""
        topics = {row["name"] for row in json.loads(self.nacelle("topic", "list", "--json", "--container", name).stdout)} - SHARED
        services = self.nacelle("service", "list", "--all", "--container", name).stdout.split()
        self.assertGreater(len(services), 30)
        ends = "".join(self.nacelle("topic", "info", topic, "-v", "--container", name).stdout for topic in topics)
        nodes = re.findall(r"^Node namespace: (\S+)$", ends, flags=re.MULTILINE)
        self.assertGreater(len(nodes), 30)
        for found in (topics, services, nodes):
            self.assertEqual([one for one in found if not f"{one}/".startswith(f"{namespace}/")], [])
        self.assertIn(f"{namespace}/tf", topics)
        self.assertIn(f"{namespace}/cmd_vel", topics)

    def test_on_one_domain_they_meet_and_both_say_whose_nodes_have_one_name(self):
        robots = self.start_both()
        clashes = [wait_for("the clash of names", lambda robot=robot: self.clashes_of(robot)) for robot in robots]
        for (line,) in clashes:
            self.assertIn(f"on {os.uname().nodename}", line)
            self.assertIn("ROS_DOMAIN_ID", line)
        wait_for("doctor net shows every node", lambda: {"/lidar", "/ekf"} <= {
            clash["node"] for clash in self.on_the_network()["one"]["namesakes"]})
        # A line for each of the two, and not for each of their nodes.
        def lines():
            return [line for line in self.nacelle("doctor", "net").stdout.splitlines() if line.startswith("node ")]

        wait_for("doctor net has a line for each robot", lambda: len(lines()) == 2)
        for line in lines():
            self.assertRegex(line, r"two of [^:]*/ekf, [^:]*/lidar[^:]*: also in nacelle \(process \d+ on [^)]+\); put one into a namespace or ")
        self.assertIn("received", self.crossed("one"))
        self.assertEqual([len(self.clashes_of(robot)) for robot in robots], [1, 1], "it is reported once, and not for each node")

    @staticmethod
    def clashes_of(robot):
        told = robot.before + [line for line in robot.read() if line not in robot.before]
        return [line for line in told if ": two nodes of " in line]

    def test_on_two_domains_they_do_not_meet(self):
        self.start_both(one={"ROS_DOMAIN_ID": "1"}, other={"ROS_DOMAIN_ID": "2"})
        # A program that drives one of them is heard by this one alone.
        drive_until(lambda limit_s: wait_for("the one drives", lambda: self.speed("one") > 0.1, limit_s),
                    lambda: self.drives("cyclone", self.laptop, "--domain", 1))  # fmt: skip
        self.assertLess(self.speed("other"), 0.01)
        self.assertIn("received", self.crossed("one"))
        self.assertEqual(self.crossed("other"), {})
        for name in ("one", "other"):
            self.assertEqual(self.on_the_network()[name]["namesakes"], [])


    @nightly
    def test_in_two_namespaces_of_one_domain_they_do_not_meet(self):
        self.start_both(**{name: {"arguments": [f"namespace:={name}"]} for name in ("one", "other")})
        reader = self.peer("cyclone", self.laptop, "echo", "--topic", "rt/one/odom", "--type", "odometry", "--count", 1000000)
        reader.wait_for("a program on the machine of the other sees the one", is_odometry)
        drive_until(lambda limit_s: reader.wait_for("the one drives", lambda line: speed_of(line) > 0.1, limit_s),
                    lambda: self.drives("cyclone", self.laptop, topic="rt/one/cmd_vel"))  # fmt: skip
        self.assertLess(self.speed("other", "/other/odom"), 0.01)
        for name in ("one", "other"):
            self.check_below(f"/{name}", name)
        self.assertEqual(self.on_the_network()["other"]["namesakes"], [])


class Changed(NetworkTest):
    def test_export_shows_and_hides_a_running_robot_and_its_streams_go_on(self):
        self.start_robot()
        reader = self.reads_odometry("cyclone", self.laptop)
        self.assertFalse(reader.within(1.0, is_odometry))
        self.assertEqual(self.nacelle("export", "on").stdout, "network: shown to the LAN; to keep it on this machine: network:=local\n")
        reader.wait_for("odometry once it is exported", is_odometry)
        net = json.loads(self.nacelle("doctor", "net", "--json").stdout)
        self.assertEqual(net["containers"][0]["differs"], ["mode", "interfaces"])
        before = self.stream("/odom")
        self.assertEqual(self.nacelle("export", "off").stdout, "network: local only; to show it to the LAN: network:=export\n")
        reader.read()
        reader.seen.clear()
        wait_for("the robot's own streams go on", lambda: self.stream("/odom")["published"] > before["published"] + 50)
        self.assertEqual(self.stream("/odom")["readers"], before["readers"] - 1, "the laptop counts no more")
        self.assertLess(sum(map(is_odometry, reader.read())), 10)

    def stream(self, name):
        rows = json.loads(self.nacelle("streams", "--json", "--interval", "0.1").stdout)["streams"]
        return next(row for row in rows if row["name"] == name)


class Moved(NetworkTest):
    def test_a_local_robot_is_seen_by_its_own_machine_whatever_becomes_of_the_lan(self):
        self.robot_machine.ip("link", "set", "lan0", "down")
        robot = self.start_robot()
        self.robot_machine.ip("link", "set", "lan0", "up")
        robot.wait_for("it has taken the LAN's address", lambda line: line.endswith("rejoined"))
        self.reads_odometry("cyclone", self.robot_machine).wait_for("odometry", is_odometry)
        self.robot_machine.ip("addr", "del", "10.77.0.1/24", "dev", "lan0")
        robot.wait_for("it has left that address", lambda line: line.endswith("rejoined"))
        self.robot_machine.ip("addr", "add", "10.77.0.9/24", "dev", "lan0")
        robot.wait_for("it has taken the next one", lambda line: line.endswith("rejoined"))
        self.reads_odometry("cyclone", self.robot_machine).wait_for("odometry", is_odometry)
        self.assertFalse(self.reads_odometry("cyclone", self.laptop).within(SILENCE_S, is_odometry))

    def test_a_robot_that_was_started_before_its_network_is_found_when_that_comes(self):
        self.robot_machine.ip("link", "set", "lan0", "down")
        reader = self.reads_odometry("cyclone", self.laptop)  # first: its own start is not part of the 3 s
        self.start_robot("network:=export")
        self.robot_machine.ip("link", "set", "lan0", "up")
        reader.wait_for("odometry, in 3 s", is_odometry, 3)

    def test_a_robot_that_was_started_without_any_interface_is_found_when_one_is_plugged_in(self):
        """Not even loopback is up, so that the participant cannot be made at the start."""
        robot_machine, laptop = self.machine(), self.machine()
        robot_machine.ip("link", "set", "lo", "down")
        robot = self.start_robot("network:=export", machine=robot_machine)
        self.assertRegex(robot.line, "^network: off")
        robot_machine.ip("link", "set", "lo", "up")
        cable(robot_machine, laptop)
        self.reads_odometry("cyclone", laptop).wait_for("odometry", is_odometry)

    def test_a_robot_whose_address_changes_is_found_again(self):
        self.start_robot("network:=export")
        reader = self.reads_odometry("cyclone", self.laptop)
        reader.wait_for("odometry", is_odometry)
        self.robot_machine.ip("addr", "del", "10.77.0.1/24", "dev", "lan0")
        self.robot_machine.ip("addr", "add", "10.77.0.9/24", "dev", "lan0")
        reader.seen.clear()
        reader.wait_for("odometry from the new address, in 3 s", is_odometry, 3)

    def test_a_robot_whose_link_was_lost_is_found_again(self):
        self.start_robot("network:=export")
        reader = self.reads_odometry("cyclone", self.laptop)
        reader.wait_for("odometry", is_odometry)
        self.robot_machine.ip("link", "set", "lan0", "down")
        self.assertFalse(self.nothing_for_a_second(reader))
        self.robot_machine.ip("link", "set", "lan0", "up")
        reader.seen.clear()
        reader.wait_for("odometry, in 3 s", is_odometry, 3)

    def nothing_for_a_second(self, reader):
        wait_for("messages in flight have arrived", lambda: (reader.seen.clear(), not reader.within(0.5, is_odometry))[1], 10)
        return reader.within(1.0, is_odometry)


if __name__ == "__main__":
    unittest.main()
