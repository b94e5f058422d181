# SPDX-License-Identifier: Apache-2.0
"""The simulated robot on ROS 2's network, and the peers that look for it."""
import json
import os

from capture import Capture
from machines import Lines, Machine, cable, named, need_namespaces
from robot import LAUNCH_FILE, PROGRAM, RobotTest, wait_for

PEERS = {name: os.environ[variable] for name, variable in (("cyclone", "NACELLE_CYCLONE_PEER"), ("fastdds", "NACELLE_FASTDDS_PEER"))
         if os.environ.get(variable)}
# Packets that a participant sends in its first second are many; this is for a machine that is busy.
SILENCE_S = 3.0
# A robot's own variables are those of the test, not of the shell that runs it.
FOREIGN = ("ROS_", "RMW_", "CYCLONEDDS_")
ASKS_THE_ROBOT = ('<Discovery><ParticipantIndex>auto</ParticipantIndex><MaxAutoParticipantIndex>32</MaxAutoParticipantIndex>'
                  '<Peers><Peer address="10.77.0.1"/></Peers></Discovery>')


class ApartTest(RobotTest):
    """On machines of their own, and without what the shell that runs it says of ROS 2's network."""

    has_own_network = True

    @classmethod
    def setUpClass(cls):
        need_namespaces()
        super().setUpClass()
        cls.environment = {name: value for name, value in cls.environment.items() if not name.startswith(FOREIGN)}


class NetworkTest(ApartTest):
    """A machine for the robot and one beside it, on a cable; peers have nothing of Nacelle in them."""

    def setUp(self):
        self.robot_machine, self.laptop = self.machine(), self.machine()
        cable(self.robot_machine, self.laptop)

    def machine(self):
        machine = Machine()
        self.addCleanup(machine.close)
        return machine

    def start_robot(self, *arguments, machine=None, name="robot", host=None, **variables):
        """Starts a robot. Returns when it is up, with the lines that it has printed so far."""
        command = (machine or self.robot_machine).within(
            *(named(host) if host else ()), PROGRAM, "launch", LAUNCH_FILE, "sim:=true", f"sim_dir:={self.folder}/sim-{name}", "--name", name, *arguments)
        robot = Lines(command, {**self.environment, **variables})
        robot.before = []  # its lines until it was up, and perhaps a few more
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
