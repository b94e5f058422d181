# SPDX-License-Identifier: Apache-2.0
"""The simulated robot on ROS 2's network: who sees it in which mode, with peers that have nothing of Nacelle in them."""
import json
import os
import re
import signal
import subprocess
import unittest

from capture import Capture
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
ASKS_THE_ROBOT = ('<Discovery><ParticipantIndex>auto</ParticipantIndex><MaxAutoParticipantIndex>32</MaxAutoParticipantIndex>'
                  '<Peers><Peer address="10.77.0.1"/></Peers></Discovery>')
# One topic for all robots, as in ROS 2.
SHARED = {"/diagnostics", "/parameter_events", "/rosout"}
ASKS_THE_ROBOT = ('<Discovery><ParticipantIndex>auto</ParticipantIndex><MaxAutoParticipantIndex>32</MaxAutoParticipantIndex>'
                  '<Peers><Peer address="10.77.0.1"/></Peers></Discovery>')
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
        robot.before = []  # what it said until it was up, and perhaps a little more

        self.addCleanup(robot.interrupt)
        wait_for("the robot is up or has ended", lambda: any(" active in " in line for line in robot.read()) or robot.process.poll() is not None, 60)
        robot.before += robot.seen
        robot.wait_for("the robot is up", lambda line: " active in " in line, 1)
        robot.line = robot.wait_for("the bring-up's last line", lambda line: line.startswith("network: "), 5)
        return robot

    def peer(self, vendor, machine, *arguments, **variables):
        how = () if {"--at-home", "--on-loopback"} & set(arguments) else ("--as-delivered",)
        arguments = [word for word in arguments if word != "--on-loopback"]  # which it does by itself
        peer = Lines(machine.within(PEERS[vendor], *arguments, *how), {**self.environment, **variables})
        self.addCleanup(peer.close)
        peer.wait_for(f"the {vendor} peer is ready", lambda line: line == "ready")
        return peer

    def capture(self, machine, link="lan0"):
        capture = Capture(machine, link)
        self.addCleanup(capture.close)
        return capture

    def drives(self, vendor, machine, *more, topic="rt/cmd_vel", **variables):
        driver = self.peer(vendor, machine, "pub", "--topic", topic, "--type", "twist", "--speed", 0.15, "--every", 50,
                           "--count", 1000000, *more, **variables)
        driver.go()
        return driver

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
        driver = self.drives(vendor, self.laptop)
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

    def drop_multicast(self):
        """As some a Wi-Fi does."""
        for machine in (self.robot_machine, self.laptop):
            machine.run("nft", "add table ip wifi; add chain ip wifi out { type filter hook output priority 0; }; "
                               "add rule ip wifi out oifname lan0 ip daddr 224.0.0.0/4 counter drop")

    def check_by_static_peers(self, vendor, of_robot, **variables):
        """What the peer is told is what rmw_cyclonedds makes of ROS_STATIC_PEERS."""
        self.drop_multicast()
        self.start_robot("network:=export", **of_robot)
        self.reads_odometry(vendor, self.laptop, **variables).wait_for("odometry on the laptop", is_odometry)
        blocked = re.search(r"counter packets (\d+)", self.laptop.run("nft", "list", "ruleset").stdout)
        self.assertGreater(int(blocked[1]), 0, "the laptop has tried it by multicast")

    def test_where_multicast_is_blocked_a_cyclone_laptop_is_found_by_static_peers(self):
        self.check_by_static_peers("cyclone", {"ROS_STATIC_PEERS": "10.77.0.2"}, CYCLONEDDS_URI=ASKS_THE_ROBOT)

    def test_where_multicast_is_blocked_it_is_enough_that_the_laptop_knows_the_robot(self):
        self.check_by_static_peers("cyclone", {}, CYCLONEDDS_URI=ASKS_THE_ROBOT)
        environment = {**self.environment, "ROS_STATIC_PEERS": "10.77.0.1"}
        listed = subprocess.run(self.laptop.within(PROGRAM, "node", "list", "--remote", "--spin-time", "3"), env=environment,
                                capture_output=True, text=True, timeout=60 * SLOW, check=True)
        self.assertIn("/diff_drive\n", listed.stdout)

    @unittest.skipUnless("fastdds" in PEERS, "built without the Fast DDS peer")
    def test_where_multicast_is_blocked_a_fast_dds_laptop_is_found_by_static_peers(self):
        self.check_by_static_peers("fastdds", {"ROS_STATIC_PEERS": "10.77.0.2"})


class Kept(NetworkTest):
    def test_off_has_no_socket(self):
        robot = self.start_robot("network:=off")
        self.assertEqual(robot.line, "network: off; to let tools of this machine see it: network:=local")
        self.assertEqual(self.robot_machine.udp_sockets(), [])
        self.assertEqual(self.robot_machine.sent("lan0"), 0)

    def test_nothing_of_a_local_robot_leaves_and_nothing_from_outside_is_heard(self):
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
        self.start_robot()
        wait_for("the robot speaks at home", inside.speakers)
        robot = inside.speakers()
        self.assertEqual(len(robot), 1, inside.frames())
        for vendor in PEERS:
            with self.subTest(vendor=vendor):
                reader = self.reads_odometry(vendor, self.robot_machine)
                reader.wait_for("odometry", is_odometry)
                driver = self.drives(vendor, self.robot_machine)
                reader.wait_for("the robot drives as it is told", lambda line: speed_of(line) > 0.1)
                driver.close()
                images = self.peer(vendor, self.robot_machine, "echo", "--topic", "rt/camera/image_raw", "--type", "image", "--best-effort",
                                   "--count", 3)
                images.wait_for("an image", lambda line: line.startswith("image "))
        self.assertEqual(self.reads_odometry("cyclone", self.laptop).within(SILENCE_S, is_odometry), False)
        self.assertTrue(outside.speakers(), "the programs themselves speak to the LAN: the capture works")
        self.assertEqual(outside.speakers() & robot, set())

    # What docs/network.md tells people who want to see a local robot with programs on the robot itself.

    def sees(self, vendor, machine, *more, **variables):
        return self.reads_odometry(vendor, machine, *more, **variables).wait_for(f"{vendor} sees the robot", is_odometry)

    def test_a_program_whose_qos_fits_nobody_keeps_no_component_from_being_loaded(self):
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

    def test_programs_that_were_there_before_a_local_robot_see_it_at_once(self):
        readers = {vendor: self.reads_odometry(vendor, self.robot_machine) for vendor in PEERS}
        self.start_robot()
        for vendor, reader in readers.items():
            reader.wait_for(f"{vendor}, long before it announces itself again (30 s)", is_odometry, 10)

    def test_programs_with_the_range_localhost_see_a_local_robot_however_it_was_told_to_be_local(self):
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

    def test_a_demonstration_drives_nobody_else(self):
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
        clashes = [wait_for("the clash of names", lambda robot=robot: self.clashes_of("/lidar", robot)) for robot in robots]
        for (line,) in clashes:
            self.assertIn(f"on {os.uname().nodename}", line)
            self.assertIn("ROS_DOMAIN_ID", line)
        wait_for("doctor net shows every node", lambda: {"/lidar", "/ekf"} <= {
            clash["node"] for clash in self.on_the_network()["one"]["namesakes"]})
        self.assertIn("two of /lidar: also in nacelle (process ", self.nacelle("doctor", "net").stdout)
        self.assertIn("received", self.crossed("one"))
        self.assertEqual([len(self.clashes_of("/lidar", robot)) for robot in robots], [1, 1], "it is told once")

    @staticmethod
    def clashes_of(node, robot):
        told = robot.before + [line for line in robot.read() if line not in robot.before]
        return [line for line in told if f"{node}: two nodes of this name" in line]

    def test_on_two_domains_they_do_not_meet(self):
        self.start_both(one={"ROS_DOMAIN_ID": "1"}, other={"ROS_DOMAIN_ID": "2"})
        # A program that drives one of them is heard by this one alone.
        self.drives("cyclone", self.laptop, "--domain", 1)
        wait_for("the one drives", lambda: self.speed("one") > 0.1)
        self.assertLess(self.speed("other"), 0.01)
        self.assertIn("received", self.crossed("one"))
        self.assertEqual(self.crossed("other"), {})
        for name in ("one", "other"):
            self.assertEqual(self.on_the_network()[name]["namesakes"], [])


    def test_in_two_namespaces_of_one_domain_they_do_not_meet(self):
        self.start_both(**{name: {"arguments": [f"namespace:={name}"]} for name in ("one", "other")})
        reader = self.peer("cyclone", self.laptop, "echo", "--topic", "rt/one/odom", "--type", "odometry", "--count", 1000000)
        reader.wait_for("a program on the machine of the other sees the one", is_odometry)
        self.drives("cyclone", self.laptop, topic="rt/one/cmd_vel")
        reader.wait_for("the one drives", lambda line: speed_of(line) > 0.1)
        self.assertLess(self.speed("other", "/other/odom"), 0.01)
        for name in ("one", "other"):
            self.check_below(f"/{name}", name)
        self.assertEqual(self.on_the_network()["other"]["namesakes"], [])

class Ports(NetworkTest):
    def test_a_domain_whose_ports_the_kernel_gives_to_anybody_is_a_remark_with_the_ports(self):
        self.robot_machine.run("sh", "-c", "echo 10000 12000 > /proc/sys/net/ipv4/ip_local_port_range")

        def remarks(domain):
            command = self.robot_machine.within(PROGRAM, "doctor", "net", "--json")
            told = subprocess.run(command, env={**self.environment, "ROS_DOMAIN_ID": domain}, capture_output=True, text=True, check=True)
            return [remark["what"] for remark in json.loads(told.stdout)["remarks"]]

        self.assertEqual(remarks("0"), [])
        self.assertEqual(remarks("11"), ["its UDP ports 10150 to 10225 reach those from 10000 to 12000 that the kernel gives to any program"])
        self.robot_machine.run("sh", "-c", "echo 10150-10225 > /proc/sys/net/ipv4/ip_local_reserved_ports")
        self.assertEqual(remarks("11"), [], "the way out of the remark")
        self.robot_machine.run("sh", "-c", "echo > /proc/sys/net/ipv4/ip_local_reserved_ports")
        robot = self.start_robot(ROS_DOMAIN_ID="11")
        self.assertTrue(any("UDP ports 10150 to 10225" in line for line in robot.before), robot.before)


class Tried(NetworkTest):
    """`doctor net` says what a robot that is started with the same words says."""

    def doctor(self, network="", **variables):
        launch = self.folder / "tried.launch.yaml"
        launch.write_text(f"launch:\n- network: {{{network}}}\n")
        command = self.robot_machine.within(PROGRAM, "doctor", "net", launch, "--json")
        told = subprocess.run(command, env={**self.environment, **variables}, capture_output=True, text=True, check=False)
        net = json.loads(told.stdout)
        self.assertEqual(told.returncode, 0 if net["problem"] is None else 1)
        return net

    def test_a_network_that_cannot_be_had_is_a_problem_in_the_robots_words(self):
        for network, variables, words in (
                ("mode: export, interfaces: [wlan9]", {}, "wlan9: does not match an available interface"),
                ("mode: export, interfaces: [10.9.9.9]", {}, "10.9.9.9: does not match"),
                ("", {"CYCLONEDDS_URI": "file:///no/such.xml"}, "can't open configuration file file:///no/such.xml"),
                ("", {"CYCLONEDDS_URI": "<General><"}, "parser error"),
                ("", {"CYCLONEDDS_URI": "<General><Foo/></General>"}, "Foo: unknown element"),
                ("", {"ROS_SECURITY_ENABLE": "true", "ROS_SECURITY_STRATEGY": "Enforce"}, "no keystore is named")):
            net = self.doctor(network, **variables)
            self.assertIn(words, net["problem"]["what"])
            self.assertTrue(net["line"].startswith("network: off, since "), net["line"])
        robot = self.start_robot(CYCLONEDDS_URI="<General><Foo/></General>")
        self.assertEqual(robot.line, self.doctor(CYCLONEDDS_URI="<General><Foo/></General>")["line"])

    def test_nothing_is_said_to_the_lan_when_it_is_tried(self):
        for mode in ("off", "local"):
            self.assertIsNone(self.doctor(f"mode: {mode}")["problem"])
        self.assertEqual(self.robot_machine.sent("lan0"), 0)
        packets = self.capture(self.laptop)
        self.assertIsNone(self.doctor("mode: export")["problem"])
        packets.stop()
        self.assertEqual([line for line in packets.frames() if line.startswith("udp ")], [])

    def test_a_peer_without_an_address_is_told(self):
        words = "peer nosuch.invalid: this name has no address: it is not asked"
        net = self.doctor(ROS_STATIC_PEERS="nosuch.invalid;10.77.0.2")
        self.assertIsNone(net["problem"])
        self.assertEqual([f"{one['where']}: {one['what']}" for one in net["remarks"]], [words])
        robot = self.start_robot(ROS_STATIC_PEERS="nosuch.invalid;10.77.0.2")
        self.assertEqual(sum(words in line for line in robot.before), 1, robot.before)


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
        rows = json.loads(self.nacelle("topic", "list", "--json").stdout)
        rows = rows["topics"] if isinstance(rows, dict) else rows
        return next(row for row in rows if row["name"] == name)


class Moved(NetworkTest):
    def test_a_local_robot_is_seen_by_its_own_machine_whatever_becomes_of_the_lan(self):
        self.robot_machine.ip("link", "set", "lan0", "down")
        robot = self.start_robot()
        self.robot_machine.ip("link", "set", "lan0", "up")
        robot.wait_for("it has taken the LAN's address", lambda line: line.endswith("joined anew"))
        self.reads_odometry("cyclone", self.robot_machine).wait_for("odometry", is_odometry)
        self.robot_machine.ip("addr", "del", "10.77.0.1/24", "dev", "lan0")
        robot.wait_for("it has let go of it", lambda line: line.endswith("joined anew"))
        self.robot_machine.ip("addr", "add", "10.77.0.9/24", "dev", "lan0")
        robot.wait_for("it has taken the next one", lambda line: line.endswith("joined anew"))
        self.reads_odometry("cyclone", self.robot_machine).wait_for("odometry", is_odometry)
        self.assertFalse(self.reads_odometry("cyclone", self.laptop).within(SILENCE_S, is_odometry))

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
