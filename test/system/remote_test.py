# SPDX-License-Identifier: Apache-2.0
"""--remote: what a laptop on which no container runs may ask of ROS 2 nodes on another machine of its network."""
import json
import pathlib
import shutil
import signal
import socket
import subprocess
import time
import unittest

from machines import Lines
from on_the_network import PEERS
from remote import ACTIONS, RemoteRobotTest, RemoteTest
from robot import PROGRAM, SLOW, expect_rate, nightly, wait_for

SERIES, FIBONACCI = "/series/series", "example_interfaces/action/Fibonacci"


def text_of(outcome):
    return outcome.stdout, outcome.stderr


class Robot(RemoteRobotTest):
    """Questions to a simulated robot that is shown to the LAN."""

    def test_nodes_and_topics_are_listed_as_on_the_robot(self):
        self.assertEqual(self.ask("node", "list").stdout, self.run_program("node", "list").stdout)
        typed = self.ask("topic", "list", "-t").stdout.splitlines()
        self.assertIn("/scan [sensor_msgs/msg/LaserScan]", typed)
        self.assertIn("/cmd_vel [geometry_msgs/msg/TwistStamped]", typed, "a topic without publishers has the type that use_stamped_vel selects")
        # The odometry's topic is as the robot has it, but for what tools there read.
        self.assertEqual(self.ask("topic", "type", "/odom").stdout, "nav_msgs/msg/Odometry\n")
        self.assertIn("/odom\n", self.ask("topic", "find", "nav_msgs/msg/Odometry").stdout)
        self.assertIn("Published topics:\n", self.ask("topic", "list", "-v").stdout)

    def test_an_answer_comes_within_three_seconds(self):
        began = time.monotonic()
        self.ask("topic", "list")
        self.assertLess(time.monotonic() - began, 3 * SLOW)

    def test_topic_info_shows_node_qos_hash_and_gid_of_an_endpoint(self):
        answer = self.rows("topic", "info", "/scan")
        here = self.local("topic", "info", "/scan")
        self.assertEqual([end["node"] for end in answer["publishers"]], ["/lidar"])
        for key in ("type", "hash"):
            self.assertEqual(answer["publishers"][0][key], here["publishers"][0][key])
        self.assertEqual(answer["publishers"][0]["qos"]["reliability"], here["publishers"][0]["qos"]["reliability"])
        self.assertEqual({end["node"] for end in answer["subscriptions"]}, {end["node"] for end in here["subscriptions"]})
        text = self.ask("topic", "info", "-v", "/scan").stdout
        self.assertIn("Node name: lidar\nNode namespace: /\nTopic type: sensor_msgs/msg/LaserScan\n", text)
        self.assertRegex(text, r"GID: ([0-9a-f]{2}\.){15}[0-9a-f]{2}\n")

    def test_node_info_shows_topics_and_services(self):
        self.assertEqual(self.ask("node", "info", "/lidar").stdout, self.run_program("node", "info", "/lidar").stdout)

    def test_messages_are_shown_in_the_same_form(self):
        self.assertIn("frame_id: odom\n", self.ask("topic", "echo", "/odom", "--once").stdout)
        self.assertEqual(json.loads(self.ask("topic", "echo", "scan", "--once", "--json").stdout)["header"]["frame_id"], "lidar_link")
        # Latched: sent long ago.
        self.assertIn("<robot", self.ask("topic", "echo", "/robot_description", "--once", "--full").stdout)
        self.assertIn("- '...'", self.ask("topic", "echo", "/camera/image_raw", "--once").stdout)
        self.assertRegex(self.ask("topic", "echo", "/odom", "--once", "--raw").stdout, r"^0001000[0-3]([0-9a-f]{2})+\n---\n$")

    def test_a_type_that_is_not_installed_is_listed_measured_and_shown_as_bytes(self):
        program = self.folder / "bare" / "bin" / "nacelle"  # beside which there are no message packages
        program.parent.mkdir(parents=True)
        shutil.copy(PROGRAM, program)
        libraries = {"LD_LIBRARY_PATH": str(pathlib.Path(PROGRAM).parents[1] / "lib")}  # those that the program itself is linked with

        def bare(*words):
            return subprocess.run(self.laptop.within(program, *words, "--remote"), capture_output=True, text=True, timeout=60 * SLOW,
                                  env=self.laptop_environment() | libraries)  # fmt: skip

        self.assertIn("/odom [nav_msgs/msg/Odometry]", self.expect_exit(bare("topic", "list", "-t"), 0).stdout.splitlines())
        self.assertIn("--raw shows its bytes", self.expect_exit(bare("topic", "echo", "/odom", "--once"), 1).stderr)
        self.assertRegex(self.expect_exit(bare("topic", "echo", "/odom", "--once", "--raw"), 0).stdout, r"^0001000[0-3]([0-9a-f]{2})+\n---\n$")
        expect_rate(lambda: json.loads(self.expect_exit(bare("topic", "hz", "/odom", "--once", "--json"), 0).stdout)["rate_hz"], 50, 15)

    def test_rates_bytes_and_delays_are_measured(self):
        expect_rate(lambda: self.rows("topic", "hz", "/odom", "--once")["rate_hz"], 50, 15)
        both = self.rows("topic", "hz", "/odom", "/scan", "--once")
        self.assertEqual([row["topic"] for row in both], ["/odom", "/scan"])
        self.assertGreater(self.rows("topic", "bw", "/scan", "--once")["mean_bytes"], 1000)
        self.assertLess(self.rows("topic", "delay", "/scan", "--once")["delay_s"], 5 * SLOW)

    def test_a_stamp_is_of_the_moment_of_sending(self):
        began = time.time()
        sent = self.ask("topic", "pub", "/stamped", "geometry_msgs/msg/TwistStamped", "{header: auto}", "--once", "--json",
                        "--spin-time", "3").stdout  # fmt: skip
        self.assertGreater(json.loads(sent)["header"]["stamp"]["sec"] + 1 - began, 3)

    def test_what_was_sent_at_the_robots_socket_is_no_node_that_is_listed(self):
        self.addCleanup(self.run_program, "estop", "release")
        self.expect_exit(self.run_program("estop", "set"), 0)
        self.assertIn("/_control_socket", [end["node"] for end in self.rows("topic", "info", "/emergency_stop")["publishers"]])
        self.assertEqual(self.ask("node", "list").stdout, self.run_program("node", "list").stdout)
        self.assertIn("/_control_socket", self.rows("node", "list", "--all"))

    def test_services_are_listed_found_and_called(self):
        self.assertEqual(self.ask("service", "list", "-t").stdout, self.run_program("service", "list", "-t").stdout)
        self.assertEqual(self.ask("service", "type", "/lidar/get_parameters").stdout, "rcl_interfaces/srv/GetParameters\n")
        self.assertIn("/lidar/get_state\n", self.ask("service", "find", "lifecycle_msgs/srv/GetState").stdout)
        answer = self.rows("service", "call", "/lidar/get_state", "lifecycle_msgs/srv/GetState", "{}")
        self.assertEqual(answer["response"]["current_state"], {"id": 3, "label": "active"})

    def expect_agreement(self, there, here):
        """Asks both until they agree, five times at most: a fault may open or close between the two questions."""
        for _ in range(5):
            answers = there(), here()
            if answers[0] == answers[1]:
                return
        self.assertEqual(*answers)

    def test_a_verb_gives_the_same_json_from_the_robot_and_from_the_network(self):
        for words in (
            ("component", "list"),
            ("faults",),
            ("tf", "echo", "base_link", "lidar_link", "--once"),
            ("lifecycle", "get", "lidar"),
            ("lifecycle", "list", "lidar"),
            ("lifecycle", "list", "lidar", "--all"),
            ("param", "list", "lidar"),
            ("param", "get", "lidar", "frame_id"),
            ("param", "describe", "lidar", "frame_id"),
            ("service", "call", "/lidar/get_state", "lifecycle_msgs/srv/GetState"),
            ("service", "call", "/robot/_container/get_components", "nacelle_interfaces/srv/GetComponents"),
        ):
            with self.subTest(words=words):
                self.expect_agreement(lambda: self.rows(*words), lambda: self.local(*words))
        for words in (("lifecycle", "set", "lidar", "configure"), ("lifecycle", "get", "robot"), ("component", "list", "--container", "robot"),
                      ("faults",), ("tf", "echo", "base_link", "lidar_lnk", "--once")):  # fmt: skip
            with self.subTest(words=words):
                code = self.run_program(*words).returncode
                self.expect_agreement(lambda: text_of(self.ask(*words, code=code)), lambda: text_of(self.run_program(*words)))

    @nightly
    def test_figures_that_change_have_the_same_rows_from_the_robot_and_from_the_network(self):
        def shape(words):
            tables = [asked(*words) for asked in (self.rows, self.local)]
            lists = [{key: value for key, value in table.items() if isinstance(value, list)} for table in tables]
            self.assertEqual(tables[0].keys(), tables[1].keys())
            return [{key: [row.keys() for row in rows] for key, rows in lists[i].items()} for i in (0, 1)], lists

        (there, here), lists = shape(("tf", "tree"))
        self.assertEqual(there, here)
        same = ("child", "parent", "owner", "static")
        self.assertEqual(*([[row[key] for key in same] for row in tree["frames"]] for tree in lists))
        _, lists = shape(("streams", "--interval", "0.5"))
        self.assertEqual(*({(row["name"], row["type"]): row.keys() for row in table["streams"]} for table in lists))
        _, lists = shape(("top", "--interval", "0.5"))
        self.assertEqual(*({row["node"]: row.keys() for row in table["components"]} for table in lists))
        self.assertRegex(self.ask("top", "--once").stdout, r"^robot: [\d.]+ % of a core, [\d.]+ MB, \d+ threads\n")
        monitored = self.rows("tf", "monitor", "odom", "lidar_link", "--once")
        self.assertEqual(monitored["chain"], self.local("tf", "monitor", "odom", "lidar_link", "--once")["chain"])
        self.assertTrue(any(row["rate_hz"] > 10 for row in monitored["frames"]))
        self.assertIn("/robot", self.ask("top", "--container", "robbot", code=1).stderr)

    def test_a_component_is_described_as_on_the_robot(self):
        here, there = self.local("component", "info", "lidar"), self.rows("component", "info", "/lidar")
        counters = [[(row["kind"], row["name"]) for row in info.pop("callbacks")] for info in (here, there)]
        self.assertEqual(there, here)
        self.assertEqual(*counters)
        self.assertEqual((there["container"], there["host"]), ("robot", socket.gethostname()))
        self.assertEqual(there["parameters"]["frame_id"], "lidar_link")
        self.assertEqual(self.rows("component", "info", str(here["id"]), "--container", "/robot")["node"], "/lidar")
        self.assertEqual(self.ask("component", "info", "lidar").stdout, self.run_program("component", "info", "lidar").stdout)
        self.assertIn("did you mean '/lidar'", self.ask("component", "info", "lidor", code=1).stderr)

    @nightly
    def test_what_is_not_there_is_1_with_the_nearest_name(self):
        for words, name in (
            (("topic", "echo", "/scam", "--once"), "/scan"),
            (("topic", "info", "/scam"), "/scan"),
            (("node", "info", "/lidor"), "/lidar"),
            (("param", "list", "/lidor"), "/lidar"),
            (("service", "call", "/lidar/get_stat", "lifecycle_msgs/srv/GetState"), "/lidar/get_state"),
        ):
            with self.subTest(words=words):
                self.assertIn(f"did you mean '{name}'", self.ask(*words, code=1).stderr)
        wrong = self.ask("topic", "echo", "/scan", "sensor_msgs/msg/Image", code=1)
        self.assertIn("/scan: has the type sensor_msgs/msg/LaserScan, not sensor_msgs/msg/Image", wrong.stderr)
        wrong = self.ask("service", "call", "/lidar/get_state", "std_srvs/srv/Trigger", code=1)
        self.assertIn("has the type lifecycle_msgs/srv/GetState, not std_srvs/srv/Trigger", wrong.stderr)

    def test_a_name_that_no_topic_can_have_is_refused_before_anything_is_looked_for(self):
        for words in (("echo", "bad name"), ("hz", "/9"), ("pub", "bad name", "std_msgs/msg/String", "--once")):
            with self.subTest(words=words):
                refused = self.ask("topic", *words, "--spin-time", "60", code=2, limit_s=30).stderr
                self.assertRegex(refused, r"^nacelle: the topic or service name '/(bad name|9)' ")
                self.assertEqual(self.expect_exit(self.run_program("topic", *words), 2).stderr, refused)

    @nightly
    def test_ways_out_are_commands_that_ask_the_same_nodes(self):
        for words, way_out in (
            (("topic", "pub", "/quiet", "std_msgs/msg/String", "-w", "1", "--max-wait-time-secs", "1"), "topic info /quiet"),
            (("service", "call", "/quiet", "std_msgs/msg/String"), "service list -t"),
            (("action", "send_goal", "/quiet", "std_msgs/msg/String", "{}"), "action list -t"),
            (("action", "send_goal", "/quiet", FIBONACCI, "{}", "--timeout", "3"), "component list"),
            (("action", "send_goal", "/quiet", FIBONACCI, "{}", "--timeout", "3"), "action list"),
        ):
            with self.subTest(words=words):
                self.assertIn(f"see `nacelle {way_out} --remote`", self.ask(*words, code=1).stderr)

    def test_another_domain_is_empty(self):
        self.assertEqual(self.ask("node", "list", "--domain", "9").stdout, "")
        self.assertEqual(self.ask("node", "list", ROS_DOMAIN_ID="9").stdout, "")
        self.assertIn("domain 9", self.ask("topic", "echo", "/odom", "--domain", "9", code=1).stderr)
        self.assertEqual(self.ask("node", "list", "--network", "local").stdout, "")
        self.assertIn("the network is off", self.ask("node", "list", code=1, ROS_AUTOMATIC_DISCOVERY_RANGE="OFF").stderr)
        self.ask("node", "list", "--domain", "233", code=2)
        alone = self.run_program("node", "list", "--domain", "9")
        self.assertEqual(self.expect_exit(alone, 2).stderr, "nacelle: --domain: has an effect only with --remote; give --remote too\n")

    def test_ctrl_c_ends_it_and_leaves_the_network(self):
        reader = self.listen("topic", "echo", "/odom")
        reader.wait_for("odometry", lambda line: line == "---")

        def ends():
            found = self.rows("topic", "info", "/odom")["subscriptions"]
            return [end for end in found if end["node"].startswith("/_nacelle_cli_")]

        self.assertEqual(len(ends()), 1)
        reader.process.send_signal(signal.SIGINT)
        self.assertEqual(reader.process.wait(10 * SLOW), 0)
        self.assertEqual(ends(), [])
        for words in (("node", "list"), ("service", "call", "/nobody", "std_srvs/srv/Empty")):
            waiting = self.listen(*words, "--spin-time", "50")
            wait_for("it has its socket", self.laptop.udp_sockets)
            waiting.process.send_signal(signal.SIGINT)
            self.assertEqual(waiting.process.wait(10 * SLOW), -signal.SIGINT)


class Actions(RemoteTest):
    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        cls.start_far(lambda line: line.startswith("network: shown"), PROGRAM, "launch", ACTIONS, "network:=export")

    def test_actions_are_listed_and_called(self):
        self.assertEqual(self.ask("action", "list", "-t").stdout, f"{SERIES} [{FIBONACCI}]\n")
        self.assertEqual(self.ask("action", "info", SERIES).stdout,
                         f"Action: {SERIES}\nAction clients: 1\n    /series_client\nAction servers: 1\n    /series\n")  # fmt: skip
        done = self.ask("action", "send_goal", SERIES, FIBONACCI, "{order: 5}", "--feedback").stdout
        self.assertIn("Goal finished with status: SUCCEEDED", done)
        self.assertIn("Feedback:\n", done)

    def test_ctrl_c_cancels_a_goal(self):
        goal = self.listen("action", "send_goal", SERIES, FIBONACCI, "{order: 2000}", "--feedback")
        goal.wait_for("feedback", lambda line: line.startswith("Feedback"))
        goal.process.send_signal(signal.SIGINT)
        goal.wait_for("the end", lambda line: line == "Goal canceled.")
        self.assertEqual(goal.process.wait(10 * SLOW), 1)


class Kept(RemoteTest):
    """Nodes that are not exported, queried on their own machine without the container's socket."""

    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        launch = cls.folder / "kept.launch.yaml"
        launch.write_text(f"launch:\n- network: {{mode: local, peers: [10.77.0.9]}}\n- include: {{file: {ACTIONS}}}\n")
        cls.said = []
        cls.start_far(lambda line: cls.said.append(line) or line.startswith("network: local only"), PROGRAM, "launch", launch,
                      "--name", "actions")  # fmt: skip

    @classmethod
    def command(cls, *words):
        return cls.far.within(PROGRAM, *words, "--remote", "--network", "local")

    def test_they_are_found_on_their_machine(self):
        self.assertEqual(self.ask("node", "list").stdout, "/actions\n/series\n/series_client\n")
        self.assertEqual(self.ask("lifecycle", "get", "series").stdout, "active [3]\n")

    def test_a_remark_names_what_it_is_of_once(self):
        remark = "nacelle: network: peers: peers are not asked in this mode; network:=export shows the robot to them"
        self.assertIn(remark, self.said)

    @nightly
    def test_a_list_may_take_longer_than_a_container_to_answer(self):
        self.assertEqual(self.ask("node", "list", "--spin-time", "11").stdout, "/actions\n/series\n/series_client\n")


class Peer(RemoteTest):
    """Programs that have nothing of Nacelle, and no node: topics and services with DDS alone."""

    def peer(self, vendor, *words):
        peer = Lines(self.far.within(PEERS[vendor], *words, "--as-delivered"), self.environment)
        self.addCleanup(peer.close)
        peer.wait_for(f"the {vendor} peer is ready", lambda line: line == "ready")
        return peer

    def test_topics_of_each_dds_are_listed_and_echoed(self):
        for vendor in PEERS:
            with self.subTest(vendor=vendor):
                peer = self.peer(vendor, "pub", "--topic", f"rt/{vendor}", "--type", "string", "--every", 50, "--count", 100000)
                peer.go()
                self.assertIn(f"/{vendor} [std_msgs/msg/String]", self.ask("topic", "list", "-t").stdout.splitlines())
                self.assertIn("Node name: _NODE_NAME_UNKNOWN_\n", self.ask("topic", "info", "-v", f"/{vendor}").stdout)
                self.assertRegex(self.ask("topic", "echo", f"/{vendor}", "--once").stdout, r"data: hello \d+\n---\n")

    def test_a_published_message_arrives_there(self):
        for vendor in PEERS:
            with self.subTest(vendor=vendor):
                peer = self.peer(vendor, "echo", "--topic", f"rt/{vendor}", "--type", "string")
                self.ask("topic", "pub", f"/{vendor}", "std_msgs/msg/String", "{data: good morning}", "--once")
                peer.wait_for("the message", lambda line: line == "text good morning")

    def test_reports_silence_with_its_reason(self):
        self.peer("cyclone", "pub", "--topic", "rt/quiet", "--type", "string")
        reader = self.listen("topic", "echo", "/quiet")
        told = reader.wait_for("the reason", lambda line: "warning" in line)
        self.assertIn("has published nothing meanwhile; see `nacelle topic info -v /quiet --remote`", told)

    def test_a_service_is_called(self):
        for vendor in PEERS:
            with self.subTest(vendor=vendor):
                self.peer(vendor, "serve", "--topic", f"{vendor}/add")
                answer = self.rows("service", "call", f"/{vendor}/add", "example_interfaces/srv/AddTwoInts", "{a: 40, b: 2}")
                self.assertEqual(answer["response"], {"sum": 42})

    # Fast DDS 2.9 answers at once or a second later, as it comes: without the waiting most of the six are missing.
    def test_waits_for_a_discovered_participant_without_endpoints(self):
        if "fastdds" not in PEERS:
            self.skipTest("needs Fast DDS")
        took, missed = [], []
        for i in range(6):
            self.peer("fastdds", "serve", "--topic", f"late{i}/add")
            begin = time.monotonic()
            if f"/late{i}/add" not in self.ask("service", "list", "--spin-time", "0.7").stdout.splitlines():
                missed.append(i)
            took.append(time.monotonic() - begin)
        print("a list with 0.7 s for discovery took " + ", ".join(f"{s:.1f}" for s in took) + " s")
        # On a busy machine, one node may stay undiscovered for that long. The command does not wait for an undiscovered node.
        self.assertLessEqual(len(missed), 1, missed)

    def test_without_a_container_a_component_is_refused_with_the_reason(self):
        for vendor in PEERS:
            with self.subTest(vendor=vendor):
                self.peer(vendor, "serve", "--topic", f"{vendor}/add")
                self.assertEqual(self.ask("component", "info", "adder", code=1).stderr,
                                 "nacelle: containers: none was found in domain 0; see `nacelle node list --remote`\n")


if __name__ == "__main__":
    unittest.main()
