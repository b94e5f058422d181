# SPDX-License-Identifier: Apache-2.0
"""What `nacelle doctor net` finds before a robot runs."""
import json
import re
import subprocess
import unittest

from on_the_network import NetworkTest
from robot import PROGRAM


class Ports(NetworkTest):
    def test_reports_a_domain_whose_ports_the_kernel_may_give_away(self):
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


class OtherUsers(NetworkTest):
    """Who can log in on the machine can do to a robot in mode local what its owner can."""

    OWN_MOUNTS = ("unshare", "-m", "--propagation", "private")

    def setUp(self):
        super().setUp()
        tried = subprocess.run([*self.OWN_MOUNTS, "true"], capture_output=True, text=True, check=False)
        if tried.returncode != 0:
            self.skipTest(f"no mounts of its own, as in a chroot whose root is no mount point: {tried.stderr.strip()}")

    def doctor(self, network, *people):
        launch, users = self.folder / "users.launch.yaml", self.folder / "passwd"
        launch.write_text(f"launch:\n- network: {{{network}}}\n")
        users.write_text("root:x:0:0::/:/bin/sh\n" + "".join(f"{name}:x:{1001 + i}:1000::/:/bin/sh\n" for i, name in enumerate(people)))
        command = self.robot_machine.within(*self.OWN_MOUNTS, "sh", "-c", f"mount --bind {users} /etc/passwd && exec {PROGRAM} doctor net {launch}")
        return subprocess.run(command, env=self.environment, capture_output=True, text=True, check=True).stdout

    def test_other_people_of_the_machine_are_a_warning_with_the_way_to_keep_them_out(self):
        warning = re.search(r"^warning +(.*)$", self.doctor("mode: local", "pupil", "guest"), re.MULTILINE)[1]
        self.assertTrue(warning.startswith("guest, pupil can log in on this machine"), warning)
        self.assertIn("network:=off or security keeps them out", warning)
        self.assertNotIn("warning", self.doctor("mode: local"))
        self.assertNotIn("warning", self.doctor("mode: off", "pupil"))


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

    def test_the_join_test_sends_nothing_to_the_lan(self):
        for mode in ("off", "local"):
            self.assertIsNone(self.doctor(f"mode: {mode}")["problem"])
        self.assertEqual(self.robot_machine.sent("lan0"), 0)
        packets = self.capture(self.laptop)
        self.assertIsNone(self.doctor("mode: export")["problem"])
        packets.stop()
        self.assertEqual([line for line in packets.frames() if line.startswith("udp ")], [])

    def test_reports_a_peer_without_an_address(self):
        words = "peer nosuch.invalid: this name has no address: it is not used as a peer"
        net = self.doctor(ROS_STATIC_PEERS="nosuch.invalid;10.77.0.2")
        self.assertIsNone(net["problem"])
        self.assertEqual([f"{one['where']}: {one['what']}" for one in net["remarks"]], [words])
        robot = self.start_robot(ROS_STATIC_PEERS="nosuch.invalid;10.77.0.2")
        self.assertEqual(sum(words in line for line in robot.before), 1, robot.before)


if __name__ == "__main__":
    unittest.main()
