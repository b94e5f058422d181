# SPDX-License-Identifier: Apache-2.0
"""What a container announces of its nodes, beside what rclcpp and rclpy announced of nodes of the same names and kinds."""
import json
import os
import pathlib
import re
import unittest

from capture import Capture
from machines import Lines, Machine, need_namespaces
from robot import PROGRAM, RobotTest, wait_for

PEER = os.environ["NACELLE_CYCLONE_PEER"]
RECORDED = pathlib.Path(os.environ["NACELLE_ROS2_WIRE"])
# The identity of an endpoint, of a service's two ends. That a writer is a writer is compared apart.
ITS_OWN = ("ENDPOINT_GUID",)
SERVICE_ID = re.compile(r"serviceid= ([0-9a-f.]+);")


def recorded(run, node):
    """Endpoints of the participant that held the node: (kind, topic) -> parameters."""
    rows = [json.loads(line) for line in (RECORDED / f"discovery_{run}.jsonl").read_text().splitlines()]
    participant = next(row["prefix"] for row in rows if f"/{node}/get_parametersReply" in row["pids"].get("TOPIC_NAME", ""))
    endpoints = {(row["kind"], row["pids"]["TOPIC_NAME"]): row["pids"] for row in rows
                 if row["prefix"] == participant and row["kind"] != "SPDP"}  # fmt: skip
    return endpoints, next(row["pids"] for row in rows if row["prefix"] == participant and row["kind"] == "SPDP")


def impersonal(pids):
    return {name: SERVICE_ID.sub("serviceid= ITS_OWN;", value) for name, value in pids.items() if name not in ITS_OWN}


def service_ids(endpoints):
    """Service -> the ids that its ends say."""
    found = {}
    for (_, topic), pids in endpoints.items():
        if said := SERVICE_ID.search(pids["USER_DATA"]):
            found.setdefault(re.sub("^/?r[qr]|(Request|Reply)$", "", topic), set()).add(said[1])
    return found


def properties(text):
    """Names of a participant's properties: a count, then pairs of CDR strings."""
    data, at, names = bytes.fromhex(text), 4, []
    for i in range(2 * int.from_bytes(data[:4], "little")):
        length = int.from_bytes(data[at : at + 4], "little")
        if i % 2 == 0:
            names.append(data[at + 4 : at + 3 + length].decode())
        at += 4 + (length + 3) // 4 * 4
    return names


class DiscoveryTest(RobotTest):
    maxDiff = None
    has_own_network = True

    @classmethod
    def setUpClass(cls):
        need_namespaces()
        super().setUpClass()
        cls.environment = {name: value for name, value in cls.environment.items() if not name.startswith(("ROS_", "RMW_", "CYCLONEDDS_"))}

    def setUp(self):
        self.machine = Machine()
        self.addCleanup(self.machine.close)
        self.capture = Capture(self.machine, "lo")
        self.addCleanup(self.capture.close)
        self.endpoints, self.participants = {}, {}
        container = self.container = Lines(self.machine.within(PROGRAM, "container"), self.environment)
        self.addCleanup(container.interrupt)
        container.wait_for("the container is up", lambda line: line.startswith("network: "))
        # Endpoints are announced to present participants: as in the recording, a plain Cyclone program listens.
        peer = Lines(self.machine.within(PEER, "echo", "--topic", "rt/nothing"), self.environment)
        self.addCleanup(peer.close)
        peer.wait_for("the peer is ready", lambda line: line == "ready")

    def load(self, *words):
        self.expect_exit(self.run_program("component", "load", *words), 0)

    def has_announced(self, keys):
        for kind, prefix, pids in self.capture.announcements():
            if kind == "SPDP" and "USER_DATA" in pids:
                self.participants[prefix] = pids
            elif "TOPIC_NAME" in pids and prefix in self.participants:
                self.endpoints[kind, pids["TOPIC_NAME"]] = pids
        return keys <= self.endpoints.keys()

    def expect_equal(self, run, node, only_recorded=()):
        expected, participant = recorded(run, node)
        for key in only_recorded:
            del expected[key]
        try:
            wait_for("all endpoints are announced", lambda: self.has_announced(expected.keys()), 10)
        except AssertionError:
            self.fail(f"not announced: {sorted(expected.keys() - self.endpoints.keys())}")
        for key, pids in expected.items():
            with self.subTest(key):
                ours = self.endpoints[key]
                self.assertEqual(impersonal(ours), impersonal(pids))
                self.assertEqual(ours["ENDPOINT_GUID"][-2:], pids["ENDPOINT_GUID"][-2:])
        for ids in service_ids(self.endpoints).values():
            self.assertEqual(len(ids), 1)
        self.assertEqual(len(self.participants), 1, f"{self.participants} {self.container.read()}")
        ((prefix, ours),) = self.participants.items()
        for name in ("USER_DATA", "VENDORID", "PROTOCOL_VERSION", "BUILTIN_ENDPOINT_SET", "PARTICIPANT_LEASE_DURATION"):
            self.assertEqual(ours[name], participant[name], name)
        self.assertEqual(properties(ours["PROPERTY_LIST"]), properties(participant["PROPERTY_LIST"]))
        self.assertEqual({pids["ENDPOINT_GUID"][:24] for pids in self.endpoints.values()}, {prefix})

    def test_a_lifecycle_node(self):
        """lifecycle_talker of ROS 2's demos. What it says is not of its kind of node: any component stands for it."""
        self.load("nacelle::test::Chaos", "--name", "lc_talker")
        # rclcpp gets use_sim_time that way, also a node's own; here nodes get it within the process.
        self.expect_equal("lc", "lc_talker", only_recorded=[("SEDP-pub", "rt/lifecycle_chatter"), ("SEDP-sub", "rt/parameter_events")])

    def test_an_action_server(self):
        self.load("nacelle::test::Series", "--name", "act_server", "-r", "~/series:=/fib")
        self.expect_equal("act", "act_server", only_recorded=[("SEDP-pub", "rt/tf_static")])


if __name__ == "__main__":
    unittest.main()
