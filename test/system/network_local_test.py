# SPDX-License-Identifier: Apache-2.0
"""A robot that is local to its machine: which programs see it there, and that no packet leaves the machine."""
import json
import unittest

from machines import Lines, drive_until
from on_the_network import ASKS_THE_ROBOT, PEERS, SILENCE_S, NetworkTest, is_odometry, speed_of
from robot import LAUNCH_FILE, PROGRAM, nightly, wait_for

# What rmw_cyclonedds makes of ROS_AUTOMATIC_DISCOVERY_RANGE=LOCALHOST.
AT_HOME = ("<General><AllowMulticast>false</AllowMulticast></General><Discovery><ParticipantIndex>auto</ParticipantIndex>"
           "<MaxAutoParticipantIndex>32</MaxAutoParticipantIndex><Peers><Peer address=\"localhost\"/></Peers></Discovery>")
LO = '<General><Interfaces><NetworkInterface name="lo" multicast="true"/></Interfaces></General>'


class Kept(NetworkTest):
    def test_off_has_no_socket(self):
        robot = self.start_robot("network:=off")
        self.assertEqual(robot.line, "network: off; to let tools of this machine see it: network:=local")
        self.assertEqual(self.robot_machine.udp_sockets(), [])
        self.assertEqual(self.robot_machine.sent("lan0"), 0)

    def test_a_local_robot_neither_sends_to_nor_receives_from_the_lan(self):
        """The LAN shouts by multicast and by unicast to the robot's own ports, in the names of its topics."""
        capture = self.capture(self.laptop)
        robot = self.start_robot()
        self.assertEqual(robot.line, "network: local only; to show it to the LAN: network:=export")
        reader = self.reads_odometry("cyclone", self.robot_machine, CYCLONEDDS_URI=LO)
        reader.wait_for("odometry on the robot itself", is_odometry)
        self.assertEqual(self.robot_machine.sent("lan0"), 0, "not even a group is joined on the LAN")
        strangers = [self.reads_odometry(vendor, self.laptop) for vendor in PEERS]
        strangers.append(self.reads_odometry("cyclone", self.laptop, CYCLONEDDS_URI=ASKS_THE_ROBOT))
        for more in ({}, {"CYCLONEDDS_URI": ASKS_THE_ROBOT}):
            self.drives("cyclone", self.laptop, "--readers", 0, **more)
        for stranger in strangers:
            self.assertFalse(stranger.within(SILENCE_S, is_odometry))
        self.assertEqual({frame.split()[0] for frame in capture.frames()} - {"arp", "icmp"}, set(), "the kernel's own answers aside")
        reader.seen.clear()
        self.assertLess(speed_of(reader.wait_for("odometry again", is_odometry)), 0.01)
        self.assertEqual(self.figures()["others"], 1, "the reader of its own machine")

    @nightly
    def test_cyclonedds_uri_does_not_take_a_local_robot_to_the_lan(self):
        """Neither with a peer there, nor with the LAN's interface alone."""
        peer = '<Discovery><Peers><Peer address="10.77.0.2"/></Peers></Discovery>'
        lan = '<General><Interfaces><NetworkInterface name="lan0"/></Interfaces></General>'
        outside = self.capture(self.laptop)
        for domain, (uri, tools) in enumerate(((LO, LO), (peer, LO), (lan + peer, AT_HOME))):
            with self.subTest(uri=uri):
                inside = self.capture(self.robot_machine, "lo")
                robot = self.start_robot(name=f"robot{domain}", ROS_DOMAIN_ID=str(domain), CYCLONEDDS_URI=uri)
                self.assertRegex(robot.line, "^network: local only.*as CYCLONEDDS_URI allows")
                wait_for("it announces itself to all that it knows of", inside.speakers)
                self.assertEqual(outside.frames(), [])
                self.assertEqual(self.robot_machine.sent("lan0"), 0)
                reader = self.reads_odometry("cyclone", self.robot_machine, "--domain", domain, CYCLONEDDS_URI=tools)
                reader.wait_for("odometry on the robot itself", is_odometry)
        stranger = self.reads_odometry("cyclone", self.laptop, "--domain", domain)
        self.assertFalse(stranger.within(SILENCE_S, is_odometry))

    def figures(self):
        return json.loads(self.nacelle("doctor", "net", "--json").stdout)["containers"][0]["figures"]

    def test_programs_with_nothing_set_see_a_local_robot_and_nothing_of_it_leaves(self):
        outside, inside = self.capture(self.laptop), self.capture(self.robot_machine, "lo")
        robot = self.start_robot()
        wait_for("the robot sends on its own machine", inside.speakers)
        speakers = inside.speakers()
        self.assertEqual(len(speakers), 1, inside.frames())
        for vendor in PEERS:
            with self.subTest(vendor=vendor):
                reader = self.reads_odometry(vendor, self.robot_machine)
                reader.wait_for("odometry", is_odometry)
                driver = drive_until(lambda limit_s: reader.wait_for("the robot follows the command", lambda line: speed_of(line) > 0.1, limit_s),
                                     lambda: self.drives(vendor, self.robot_machine), robot)  # fmt: skip
                driver.close()
                images = self.peer(vendor, self.robot_machine, "echo", "--topic", "rt/camera/image_raw", "--type", "image", "--best-effort",
                                   "--count", 3)
                images.wait_for("an image", lambda line: line.startswith("image "))
        self.assertEqual(self.reads_odometry("cyclone", self.laptop).within(SILENCE_S, is_odometry), False)
        self.assertTrue(outside.speakers(), "the programs themselves speak to the LAN: the capture works")
        self.assertEqual(outside.speakers() & speakers, set())

    # The settings of docs/network.md for programs on the robot itself that want to see a local robot.

    def sees(self, vendor, machine, *more, **variables):
        return self.reads_odometry(vendor, machine, *more, **variables).wait_for(f"{vendor} sees the robot", is_odometry)

    def test_a_program_with_incompatible_qos_does_not_prevent_loading(self):
        self.start_robot()
        self.peer("cyclone", self.robot_machine, "echo", "--topic", "rt/camera/image_raw", "--type", "image")

        def loads_with_a_warning():
            self.nacelle("component", "unload", "camera")
            loaded = json.loads(self.nacelle("component", "load", "camera", "--json").stdout)
            return [text for text in loaded["warnings"] if "reliability" in text]

        wait_for("the peer is known, and its clash a warning", loads_with_a_warning)

    def test_programs_on_the_loopback_see_a_local_robot(self):
        self.start_robot()
        self.sees("cyclone", self.robot_machine, CYCLONEDDS_URI=LO)
        if "fastdds" in PEERS:
            self.sees("fastdds", self.robot_machine, "--on-loopback")

    @nightly
    def test_programs_that_were_there_before_a_local_robot_see_it_at_once(self):
        readers = {vendor: self.reads_odometry(vendor, self.robot_machine) for vendor in PEERS}
        self.start_robot()
        for vendor, reader in readers.items():
            reader.wait_for(f"{vendor}, long before it announces itself again (30 s)", is_odometry, 10)

    @nightly
    def test_programs_with_the_range_localhost_see_a_local_robot_however_local_was_set(self):
        for name, variables in (("default", {}), ("localhost", {"ROS_AUTOMATIC_DISCOVERY_RANGE": "LOCALHOST", "ROS_DOMAIN_ID": "1"})):
            robot = self.start_robot(name=name, **variables)
            self.assertTrue(robot.line.startswith("network: local only"), robot.line)
            domain = ("--domain", variables.get("ROS_DOMAIN_ID", "0"))
            self.sees("cyclone", self.robot_machine, *domain, CYCLONEDDS_URI=AT_HOME)
            if "fastdds" in PEERS:
                self.sees("fastdds", self.robot_machine, "--at-home", *domain)

    def test_programs_with_the_range_localhost_see_a_local_robot_where_there_is_no_lan(self):
        alone = self.machine()
        self.start_robot(machine=alone)
        self.sees("cyclone", alone, CYCLONEDDS_URI=AT_HOME)

    def test_a_demonstration_drives_no_other_robot(self):
        for arguments, is_there in (((), False), (("network:=local",), True)):
            with self.subTest(arguments=arguments):
                drive = Lines(self.robot_machine.within(PROGRAM, "drive", LAUNCH_FILE, "--stay", "-v", *arguments), self.environment)
                self.addCleanup(drive.interrupt)
                drive.wait_for("the robot is up", lambda line: " active in " in line, 60)
                self.assertEqual(bool(self.robot_machine.udp_sockets()), is_there)
                drive.interrupt()

    def test_programs_on_the_robot_with_nothing_set_see_an_exported_robot(self):
        self.start_robot("network:=export")
        for vendor in PEERS:
            with self.subTest(vendor=vendor):
                self.sees(vendor, self.robot_machine)

    @nightly
    def test_more_programs_than_have_a_number_share_the_loopback(self):
        """33 have one; the rest meet by multicast."""
        self.start_robot()
        taken = ["ready"]
        command = self.robot_machine.within(PEERS["cyclone"], "echo", "--topic", "rt/odom", "--type", "odometry")
        while "ready" in taken[-1]:
            self.assertLess(len(taken), 40, "there are 33 numbers")
            peer = Lines(command, {**self.environment, "CYCLONEDDS_URI": AT_HOME})
            self.addCleanup(peer.close)
            taken.append(peer.wait_for("a peer is ready or has no number", lambda line: line == "ready" or "participant index" in line))
        late = self.start_robot(name="late")
        self.assertEqual(late.line, "network: local only; to show it to the LAN: network:=export")
        robots = json.loads(self.nacelle("doctor", "net", "--json").stdout)["containers"]
        self.assertEqual([robot["running"] for robot in robots], [True, True])
        self.sees("cyclone", self.robot_machine, CYCLONEDDS_URI=LO)

    def test_a_robot_that_cannot_join_runs_and_logs_the_reason(self):
        robot = self.start_robot("network:=export", CYCLONEDDS_URI="<Generall/>")
        self.assertRegex(robot.line, r"^network: off, since DDS domain 0: .*the robot runs without it$")
        state = json.loads(self.nacelle("doctor", "net", "--json").stdout)["containers"][0]
        self.assertFalse(state["running"])
        self.nacelle("topic", "hz", "/odom", "--once")


if __name__ == "__main__":
    unittest.main()
