# SPDX-License-Identifier: Apache-2.0
"""The simulated robot on ROS 2's network: who sees it in which mode, with peers that have nothing of Nacelle in them."""
import json
import os
import signal
import subprocess
import unittest

from machines import Lines, Machine, cable, named, need_namespaces
from robot import LAUNCH_FILE, PROGRAM, SLOW, RobotTest, wait_for

PEERS = {name: os.environ[variable] for name, variable in (("cyclone", "NACELLE_CYCLONE_PEER"), ("fastdds", "NACELLE_FASTDDS_PEER"))
         if os.environ.get(variable)}
# Packets that a participant sends in its first second are many; this is for a machine that is busy.
SILENCE_S = 3.0
# A robot's own variables are those of the test, not of the shell that runs it.
FOREIGN = ("ROS_", "RMW_", "CYCLONEDDS_")
# What rmw_cyclonedds makes of ROS_AUTOMATIC_DISCOVERY_RANGE=LOCALHOST.
AT_HOME = ("<General><AllowMulticast>false</AllowMulticast></General><Discovery><ParticipantIndex>auto</ParticipantIndex>"
           "<MaxAutoParticipantIndex>32</MaxAutoParticipantIndex><Peers><Peer address=\"localhost\"/></Peers></Discovery>")
LO = '<General><Interfaces><NetworkInterface name="lo" multicast="true"/></Interfaces></General>'


class NetworkTest(RobotTest):
    has_own_network = True

    @classmethod
    def setUpClass(cls):
        need_namespaces()
        super().setUpClass()
        cls.environment = {name: value for name, value in cls.environment.items() if not name.startswith(FOREIGN)}

    def setUp(self):
        self.robot_machine, self.laptop = self.machine(), self.machine()
        cable(self.robot_machine, self.laptop)

    def machine(self):
        machine = Machine()
        self.addCleanup(machine.close)
        return machine

    def start_robot(self, *arguments, machine=None, name="robot", host=None, **variables):
        """Returns when it is up, with what it has said so far."""
        command = (machine or self.robot_machine).within(
            *(named(host) if host else ()), PROGRAM, "launch", LAUNCH_FILE, "sim:=true", f"sim_dir:={self.folder}/sim-{name}", "--name", name, *arguments)
        robot = Lines(command, {**self.environment, **variables})
        robot.said = []

        def end():
            if robot.process.poll() is None:
                robot.process.send_signal(signal.SIGINT)
                try:
                    robot.process.wait(30 * SLOW)
                except subprocess.TimeoutExpired:
                    robot.process.kill()
            robot.close()

        self.addCleanup(end)
        robot.wait_for("the robot is up", lambda line: " active in " in line, 60)
        robot.line = robot.wait_for("the bring-up's last line", lambda line: line.startswith("network: "), 5)
        return robot

    def peer(self, vendor, machine, *arguments, **variables):
        how = () if {"--at-home", "--on-loopback"} & set(arguments) else ("--as-delivered",)
        arguments = [word for word in arguments if word != "--on-loopback"]  # which it does by itself
        peer = Lines(machine.within(PEERS[vendor], *arguments, *how), {**self.environment, **variables})
        self.addCleanup(peer.close)
        peer.wait_for(f"the {vendor} peer is ready", lambda line: line == "ready")
        return peer

    def reads_odometry(self, vendor, machine, *more, **variables):
        return self.peer(vendor, machine, "echo", "--topic", "rt/odom", "--type", "odometry", "--count", 1000000, *more, **variables)

    def nacelle(self, *words, code=0):
        return self.expect_exit(self.run_program(*words), code)

    def state(self):
        return json.loads(self.nacelle("export", "off", "--json").stdout)


def is_odometry(line):
    return line.startswith("odometry ")


def speed_of(line):
    return float(line.split()[1]) if is_odometry(line) else 0.0


class Exported(NetworkTest):
    def check_both_ways(self, vendor):
        robot = self.start_robot("network:=export")
        self.assertEqual(robot.line, "network: shown to the LAN; to keep it on this machine: network:=local")
        reader = self.reads_odometry(vendor, self.laptop)
        line = reader.wait_for("odometry on the laptop", is_odometry)
        self.assertEqual(line.split()[2:], ["odom", "base_footprint"])
        self.assertAlmostEqual(speed_of(line), 0.0, delta=0.01)
        driver = self.peer(vendor, self.laptop, "pub", "--topic", "rt/cmd_vel", "--type", "twist", "--speed", 0.15,
                           "--every", 50, "--count", 1000000)
        driver.go()
        reader.wait_for("the robot drives as the laptop says", lambda line: speed_of(line) > 0.1)
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
        self.addCleanup(robot.close)
        self.addCleanup(robot.process.send_signal, signal.SIGINT)
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


class Kept(NetworkTest):
    def test_off_has_no_socket(self):
        robot = self.start_robot("network:=off")
        self.assertEqual(robot.line, "network: off; to let tools of this machine see it: network:=local")
        self.assertEqual(self.robot_machine.udp_sockets(), [])
        self.assertEqual(self.robot_machine.sent("lan0"), 0)

    def test_local_sends_nothing_to_the_lan_and_is_seen_on_the_loopback(self):
        robot = self.start_robot()
        self.assertEqual(robot.line, "network: local only; to show it to the LAN: network:=export")
        reader = self.reads_odometry("cyclone", self.robot_machine, CYCLONEDDS_URI=LO)
        reader.wait_for("odometry on the robot itself", is_odometry)
        stranger = self.reads_odometry("cyclone", self.laptop)
        self.assertFalse(stranger.within(SILENCE_S, is_odometry))
        self.assertEqual(self.robot_machine.sent("lan0"), 0, "what a local robot sends stays on lo")

    # What docs/network.md tells people who want to see a local robot with programs on the robot itself.

    def sees(self, vendor, machine, *more, **variables):
        return self.reads_odometry(vendor, machine, *more, **variables).wait_for(f"{vendor} sees the robot", is_odometry)

    def test_programs_on_the_loopback_see_a_local_robot(self):
        self.start_robot()
        self.sees("cyclone", self.robot_machine, CYCLONEDDS_URI=LO)
        if "fastdds" in PEERS:
            self.sees("fastdds", self.robot_machine, "--on-loopback")

    def test_programs_with_the_range_localhost_see_a_robot_with_the_same(self):
        robot = self.start_robot(ROS_AUTOMATIC_DISCOVERY_RANGE="LOCALHOST")
        self.assertEqual(robot.line, "network: local only; to show it to the LAN: network:=export")
        self.sees("cyclone", self.robot_machine, CYCLONEDDS_URI=AT_HOME)
        if "fastdds" in PEERS:
            self.sees("fastdds", self.robot_machine, "--at-home")

    def test_programs_with_the_range_localhost_see_a_local_robot_where_there_is_no_lan(self):
        alone = self.machine()
        self.start_robot(machine=alone)
        self.sees("cyclone", alone, CYCLONEDDS_URI=AT_HOME)

    def test_programs_that_look_on_the_lan_do_not_see_a_local_robot(self):
        self.start_robot()
        readers = [self.reads_odometry(vendor, self.robot_machine) for vendor in PEERS]
        readers.append(self.reads_odometry("cyclone", self.robot_machine, CYCLONEDDS_URI=AT_HOME))
        for reader in readers:
            self.assertFalse(reader.within(SILENCE_S, is_odometry))

    def test_programs_on_the_robot_with_nothing_set_see_an_exported_robot(self):
        self.start_robot("network:=export")
        for vendor in PEERS:
            with self.subTest(vendor=vendor):
                self.sees(vendor, self.robot_machine)

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

    def test_a_robot_that_cannot_join_runs_and_says_why(self):
        robot = self.start_robot("network:=export", CYCLONEDDS_URI="<Generall/>")
        self.assertRegex(robot.line, r"^network: off, since DDS domain 0: .*the robot runs without it$")
        state = json.loads(self.nacelle("doctor", "net", "--json").stdout)["containers"][0]
        self.assertFalse(state["running"])
        self.nacelle("topic", "hz", "/odom", "--once")


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
        reader.seen.clear()
        wait_for("the robot's own streams go on", lambda: self.stream("/odom")["published"] > before["published"] + 50)
        self.assertEqual(self.stream("/odom")["readers"], before["readers"] - 1, "the laptop counts no more")
        self.assertLess(sum(map(is_odometry, reader.read())), 10)

    def stream(self, name):
        rows = json.loads(self.nacelle("topic", "list", "--json").stdout)
        rows = rows["topics"] if isinstance(rows, dict) else rows
        return next(row for row in rows if row["name"] == name)


class Moved(NetworkTest):
    def test_a_robot_that_was_started_before_its_network_is_found_when_that_comes(self):
        self.robot_machine.ip("link", "set", "lan0", "down")
        self.start_robot("network:=export")
        reader = self.reads_odometry("cyclone", self.laptop)
        self.robot_machine.ip("link", "set", "lan0", "up")
        reader.wait_for("odometry, in 3 s", is_odometry, 3)

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
        wait_for("what was on its way is through", lambda: (reader.seen.clear(), not reader.within(0.5, is_odometry))[1], 10)
        return reader.within(1.0, is_odometry)


if __name__ == "__main__":
    unittest.main()
