# SPDX-License-Identifier: Apache-2.0
"""The command line's output about a running robot: nodes, topics, services, parameters; as ros2 prints it, and as JSON."""
import fcntl
import json
import pathlib
import signal
import subprocess
import time
import unittest

from control import Control
from robot import SLOW, RobotTest, RunningRobotTest, expect_rate, needs_no_thread_sanitizer, of_words, wait_for

NODES = ["/camera", "/detector", "/diff_drive", "/ekf", "/imu", "/lidar", "/monitor", "/monitor_2", "/odometry", "/transforms"]
TWIST = "geometry_msgs/msg/Twist"


@of_words
class WithoutContainer(RobotTest):
    COMMANDS = (
        ["component", "info", "camera"], ["lifecycle", "list", "camera"], ["lifecycle", "nodes"], ["node", "list"], ["node", "info", "camera"],
        ["topic", "info", "/scan"], ["topic", "type", "/scan"], ["topic", "find", "sensor_msgs/msg/LaserScan"], ["topic", "bw", "/scan"],
        ["topic", "delay", "/scan"], ["service", "list"], ["service", "type", "/reset"], ["service", "find", "std_srvs/srv/Empty"],
        ["service", "call", "/reset", "std_srvs/srv/Empty"], ["param", "list"], ["param", "get", "camera", "x"], ["param", "set", "camera", "x", "1"],
        ["param", "dump", "camera"], ["param", "load", "camera", "file"], ["param", "describe", "camera", "x"], ["param", "delete", "camera", "x"],
    )  # fmt: skip

    def test_every_command_explains_itself_and_needs_a_container(self):
        for words in self.COMMANDS:
            with self.subTest(words=words):
                self.assertIn("--json", self.expect_exit(self.run_program(*words, "--help"), 0).stdout)
                self.assertIn("nacelle launch", self.expect_exit(self.run_program(*words), 3).stderr)

    def test_wrong_usage_is_2(self):
        for words in (["node"], ["node", "info"], ["service"], ["service", "call", "/x"], ["service", "call", "/x", "t", "{}", "-r", "0"], ["param"],
                      ["param", "get", "camera"], ["param", "set", "camera", "x"], ["param", "describe", "camera"], ["topic", "info"],
                      ["topic", "find"], ["topic", "bw", "/scan", "-w", "1"], ["lifecycle", "list"], ["component", "info"],
                      ["topic", "pub", "/x", "t", "{}", "--rate", "0"]):  # fmt: skip
            with self.subTest(words=words):
                self.assertTrue(self.expect_exit(self.run_program(*words), 2).stderr)

    def test_the_installed_plugins_are_listed_by_package(self):
        lines = self.expect_exit(self.run_program("component", "types"), 0).stdout.splitlines()
        self.assertEqual(lines[lines.index("nacelle_lidar") + 1], "  nacelle::lidar::LidarComponent")
        rows = json.loads(self.expect_exit(self.run_program("component", "types", "--json"), 0).stdout)
        row = next(row for row in rows if row["plugin"] == "nacelle::camera::CameraComponent")
        self.assertEqual(row["package"], "nacelle_camera")
        self.assertTrue(pathlib.Path(row["library"]).is_file(), row)


class OnRobot(RunningRobotTest):
    def out(self, *words, code=0):
        return self.expect_exit(self.run_program(*words), code).stdout

    def json_of(self, *words):
        return json.loads(self.out(*words, "--json"))

    def socket_path(self):
        return self.folder / "nacelle" / "robot.sock"

    def time_of(self, control, request):
        """Seconds from a request to its answer over an open connection."""
        began = time.monotonic()
        control.send(b"j", json.dumps(request).encode())
        _, payload = control.receive()
        took = time.monotonic() - began
        self.assertTrue(json.loads(payload)["ok"], payload)
        return took


@of_words
class Graph(OnRobot):
    def test_nodes_are_listed(self):
        nodes = self.out("node", "list").split()
        self.assertEqual([node for node in nodes if node != "/robot"], NODES)
        self.assertIn("/robot", nodes, "the container's own, as ros2 lists a component container")
        self.assertEqual(self.json_of("node", "list"), nodes)
        self.assertEqual(self.out("node", "list", "-c"), f"{len(nodes)}\n")
        self.assertEqual(self.out("lifecycle", "nodes").split(), NODES)
        self.assertEqual(self.out("lifecycle", "nodes", "-c"), "10\n")
        states = {row["node"]: row["state"] for row in self.json_of("lifecycle", "nodes")}
        self.assertEqual(set(states), set(NODES))
        self.assertEqual(set(states.values()), {"active"})

    def test_node_info_lists_topics_services_and_actions(self):
        text = self.out("node", "info", "/ekf")
        titles = ["  Subscribers:", "  Publishers:", "  Service Servers:", "  Service Clients:", "  Action Servers:", "  Action Clients:"]
        self.assertEqual([line for line in text.splitlines() if line.endswith(":")], titles)
        servers = text.split("  Service Servers:\n")[1].split("  Service Clients:")[0]
        self.assertIn("    /set_pose: robot_localization/srv/SetPose\n", servers)
        publishers = text.split("  Publishers:\n")[1].split("  Service Servers:")[0]
        self.assertIn("    /odometry/filtered: nav_msgs/msg/Odometry\n", publishers)
        info = self.json_of("node", "info", "diff_drive")
        self.assertEqual(info["node"], "/diff_drive")
        self.assertIn({"name": "/cmd_vel", "types": [TWIST, "geometry_msgs/msg/TwistStamped"]}, info["subscribers"])

    def test_topic_info_lists_endpoints_with_their_qos(self):
        self.assertRegex(self.out("topic", "info", "scan"), r"^Type: sensor_msgs/msg/LaserScan\nPublisher count: 1\nSubscription count: \d\n$")
        self.assertIn(f"Type: ['{TWIST}', 'geometry_msgs/msg/TwistStamped']\n", self.out("topic", "info", "/cmd_vel"))
        text = self.out("topic", "info", "-v", "/scan")
        self.assertIn("Node name: lidar\nNode namespace: /\nTopic type: sensor_msgs/msg/LaserScan\nTopic type hash: RIHS01_", text)
        end = text.split("Node name: lidar\n")[1].split("\n\n")[0]
        self.assertRegex(end, r"Endpoint type: PUBLISHER\nGID: ([0-9a-f]{2}\.)+[0-9a-f]{2}\nQoS profile:\n"
                              r"  Reliability: \w+\n  History \(Depth\): KEEP_LAST \(\d+\)\n  Durability: VOLATILE\n  Lifespan: Infinite\n"
                              r"  Deadline: .+\n  Liveliness: AUTOMATIC\n  Liveliness lease duration: Infinite$")  # fmt: skip
        info = self.json_of("topic", "info", "/robot_description")
        self.assertEqual([end["qos"]["durability"] for end in info["publishers"]], ["transient_local"])
        self.assertEqual(info["types"], ["std_msgs/msg/String"])

    def test_the_topics_can_be_searched_and_counted(self):
        self.assertEqual(self.out("topic", "find", "sensor_msgs/msg/LaserScan"), "/scan\n")
        self.assertEqual(self.json_of("topic", "find", "sensor_msgs/LaserScan"), ["/scan"])
        self.assertEqual(self.out("topic", "find", "std_msgs/msg/Empty"), "")
        self.assertEqual(self.out("topic", "type", "/odom"), "nav_msgs/msg/Odometry\n")
        names = self.out("topic", "list").split()
        self.assertEqual(self.out("topic", "list", "-c"), f"{len(names)}\n")
        both = self.out("topic", "list", "-v")
        self.assertRegex(both, r"^Published topics:\n(.*\n)+ \* /scan \[sensor_msgs/msg/LaserScan\] 1 publisher\n(.*\n)+\nSubscribed topics:\n")

    def test_component_info_shows_origin_and_execution(self):
        text = self.out("component", "info", "lidar")
        for part in ("/lidar\n  id: ", "\n  plugin: nacelle::lidar::LidarComponent\n", "nacelle_lidar.so\n", "\n  state: active [3]\n",
                     "\n  process: the container's\n", "\n  namespace: /\n", "    port_name: ", "\n  thread: ", "\n  on fault: ", "\n  faults so far: 0\n"):  # fmt: skip
            self.assertIn(part, text)
        info = self.json_of("component", "info", "diff_drive")
        self.assertTrue(info["actuator"])
        self.assertEqual(info["on_fault"]["policy"], "stop_robot")
        self.assertEqual(info["plugin"], "nacelle::diff_drive::DiffDriveComponent")
        self.assertIn("subscription", {callback["kind"] for callback in info["callbacks"]})
        by_id = self.json_of("component", "info", str(info["id"]))
        self.assertEqual(by_id["node"], "/diff_drive")

    def test_the_transitions_that_are_possible_are_listed(self):
        self.assertEqual(self.out("lifecycle", "list", "imu"),
                         "- deactivate [4]\n\tStart: active\n\tGoal: deactivating\n- shutdown [7]\n\tStart: active\n\tGoal: shuttingdown\n")  # fmt: skip
        every = self.json_of("lifecycle", "list", "imu", "-a")
        self.assertEqual(every["state"], "active")
        self.assertEqual(len(every["transitions"]), 25)
        self.assertIn({"label": "configure", "id": 1, "start": "unconfigured", "goal": "configuring"}, every["transitions"])

    def test_reports_that_a_finalized_node_has_no_transition(self):
        got = self.json_of("lifecycle", "get", "imu")
        self.assertEqual(set(got), {"id", "node", "state", "state_id"})
        self.assertEqual((got["state"], got["state_id"]), ("active", 3))
        self.assertEqual(got["id"], self.json_of("component", "info", "imu")["id"])
        self.out("lifecycle", "set", "monitor_2", "shutdown")
        try:
            self.assertEqual(self.out("lifecycle", "list", "monitor_2"),
                             "/monitor_2 is finalized: no transition leads on\nUnload it, and load it again: nacelle component unload monitor_2\n")
        finally:
            self.out("component", "unload", "monitor_2")
            self.out("component", "load", "monitor_2")

    def test_one_field_is_echoed_alone(self):
        self.assertRegex(self.out("topic", "echo", "/odom", "--field", "pose.pose.position", "--once"), r"^x: \S+\ny: \S+\nz: \S+\n---\n$")
        self.assertRegex(self.out("topic", "echo", "/odom", "--field", "pose.pose.position.x", "--once"), r"^-?\d+\.\S*\n---\n$")
        self.assertEqual(self.json_of("topic", "echo", "/odom", "--field", "header.frame_id", "--once"), "odom")
        urdf = self.out("topic", "echo", "/robot_description", "--field", "data", "--full-length", "--once")
        self.assertTrue(urdf.startswith("<"), urdf[:80])
        self.assertIn("</robot>\n---\n", urdf)
        self.assertRegex(self.out("topic", "echo", "/odom", "--csv", "--once"), r"^\d+,\d+,odom,base_footprint,(-?[\d.e-]+,){84}-?[\d.e-]+\n$")
        self.assertRegex(self.out("topic", "echo", "/scan", "--field", "ranges", "--csv", "--once", "-l", "2"), r"^[^,\n]+,[^,\n]+,\.\.\.\n$")
        wrong = self.expect_exit(self.run_program("topic", "echo", "/odom", "--field", "pose.psoe", "--once"), 1)
        self.assertIn("there is no 'psoe' in geometry_msgs/msg/PoseWithCovariance; did you mean 'pose'? its fields are pose, covariance", wrong.stderr)

    def test_several_rates_are_one_table(self):
        text = self.out("topic", "hz", "/odom", "/imu/data_raw", "--once")
        head, table = text.split("\n", 2)[:2], text.split("\n", 2)[2]
        self.assertEqual(head, ["Subscribed to [/odom]", "Subscribed to [/imu/data_raw]"])
        self.assertRegex(table, r"^ +topic +rate +min_delta +max_delta +std_dev +window\n=+\n/odom +[\d.]+ .*\n/imu/data_raw +[\d.]+ .*\n\n$")

        def rates():
            rows = self.json_of("topic", "hz", "/odom", "/imu/data_raw", "sensor_msgs/Imu", "--once")
            return {row["topic"]: row["rate_hz"] for row in rows}

        expect_rate(lambda: rates()["/odom"], 50, 5)
        expect_rate(lambda: rates()["/imu/data_raw"], 100, 10)
        wrong = self.expect_exit(self.run_program("topic", "hz", "/odom", "/scam", "--once"), 1)
        self.assertIn("did you mean '/scan'", wrong.stderr)

    def silence_of(self, *words):
        """Returns the line that a command prints on stderr for a silent topic, then ends the command with Ctrl-C."""
        listening = self.start_program("topic", *words, stderr=subprocess.PIPE)
        said = listening.stderr.readline()
        listening.send_signal(signal.SIGINT)
        _, more = listening.communicate(timeout=20 * SLOW)
        self.assertEqual((listening.returncode, more), (0, ""), said)
        return said

    def test_reports_silence_with_its_reason(self):
        for command in ("echo", "hz", "bw"):
            self.assertIn("topic /emergency_stop: it does not appear to be published yet", self.silence_of(command, "/emergency_stop"))
        self.assertIn("nothing has come since the first message", self.silence_of("hz", "/robot_description"))
        self.out("lifecycle", "set", "lidar", "deactivate")
        try:
            self.assertIn("topic /scan: nothing has come yet: /lidar is inactive; `nacelle lifecycle set /lidar activate`",
                          self.silence_of("delay", "/scan"))  # fmt: skip
        finally:
            self.out("lifecycle", "set", "lidar", "activate")

    def test_a_wrong_name_is_1_with_the_nearest(self):
        for words, hint in ((["node", "info", "lidr"], "'/lidar'"), (["topic", "info", "/scam"], "'/scan'"), (["topic", "type", "/scam"], "'/scan'"),
                            (["topic", "find", "sensor_msgs/msg/LaserScam"], "LaserScan"), (["service", "type", "/rest"], "'/reset'"),
                            (["service", "find", "std_srvs/srv/Emty"], "Empty"), (["service", "find", "std_msgs/msg/Bool"], "is not a service"),
                            (["component", "info", "camra"], "'/camera'"), (["lifecycle", "list", "camra"], "'/camera'"),
                            (["param", "list", "camra"], "'/camera'"), (["param", "get", "diff_drive", "wheel_radus"], "'wheel_radius'"),
                            (["param", "describe", "diff_drive", "wheel_radus"], "'wheel_radius'"),
                            (["param", "set", "diff_drive", "wheel_radus", "1.0"], "'wheel_radius'"), (["topic", "bw", "/scam"], "'/scan'"),
                            (["service", "call", "/rest", "std_srvs/srv/Empty"], "'/reset'"),
                            (["service", "call", "/reset", "std_srvs/srv/SetBool"], "has the type std_srvs/srv/Empty")):  # fmt: skip
            with self.subTest(words=words):
                self.assertIn(hint, self.expect_exit(self.run_program(*words), 1).stderr)
        self.assertIn("no fields", self.expect_exit(self.run_program("service", "call", "/reset", "std_srvs/srv/Empty", "{x: 1}"), 2).stderr)

    def test_reports_an_unknown_topic_before_any_output(self):
        for command in ("echo", "hz", "bw", "delay"):
            unknown = self.expect_exit(self.run_program("topic", command, "/nope"), 1)
            self.assertEqual(unknown.stdout, "")
            names = unknown.stderr.split("one of ")[1].strip().split(", ")
            self.assertEqual(len(names), len(set(names)), "each once")

    def test_bandwidth_and_delay_are_measured(self):
        text = self.out("topic", "bw", "/camera/image_raw", "--once")
        self.assertRegex(text, r"^Subscribed to \[/camera/image_raw\]\n[\d.]+ MB/s from \d+ messages\n\tMessage size mean: .+ min: .+ max: .+\n$")

        def images_per_s():
            figures = self.json_of("topic", "bw", "/camera/image_raw", "--once")
            return figures["bytes_per_s"] / figures["mean_bytes"]

        expect_rate(images_per_s, 30, 6)
        self.assertRegex(self.out("topic", "delay", "/odom", "--once"), r"^average delay: -?[\d.]+\n\tmin: .+s max: .+s std dev: .+s window: \d+\n$")
        age = self.json_of("topic", "delay", "/odom", "--once")
        self.assertLess(abs(age["delay_s"]), 0.1 * SLOW)
        self.assertIn("window", self.json_of("topic", "hz", "/odom", "--once"))
        refused = self.expect_exit(self.run_program("topic", "delay", "/tf", "--once"), 1)
        self.assertIn("tf2_msgs/msg/TFMessage has no header", refused.stderr)

    @needs_no_thread_sanitizer
    def test_ctrl_c_ends_an_echo_that_waits_for_room_in_its_output(self):
        echo = self.start_program("topic", "echo", "/odom", stdout=subprocess.PIPE)
        self.addCleanup(echo.stdout.close)
        fcntl.fcntl(echo.stdout, fcntl.F_SETPIPE_SZ, 4096)
        wait_for("echo is blocked by a full pipe", lambda: "pipe_write" in pathlib.Path(f"/proc/{echo.pid}/wchan").read_text())
        echo.send_signal(signal.SIGINT)
        self.assertEqual(echo.wait(10 * SLOW), 0)

    def test_an_open_connection_is_answered_within_100_ms(self):
        control = Control(self.socket_path())
        verbs = ({"verb": "graph"}, {"verb": "node.find", "name": "diff_drive"},
                 {"verb": "service.call", "service": "/robot/_container/get_component", "type": "nacelle_interfaces/srv/GetComponent",
                  "request": {"component": "diff_drive"}},
                 {"verb": "service.call", "service": "/robot/_container/list_nodes", "type": "composition_interfaces/srv/ListNodes"},
                 {"verb": "service.call", "service": "/robot/_container/get_components", "type": "nacelle_interfaces/srv/GetComponents"})  # fmt: skip
        for verb in verbs:
            with self.subTest(verb=verb):
                times = [self.time_of(control, verb) for _ in range(5)]
                # The first may load a message library; a busy machine makes single ones late.
                self.assertLess(sorted(times)[2], 0.1 * SLOW, times)
        control.close()


class Publishing(OnRobot):
    def commands_heard(self):
        return sum(row["published"] for row in json.loads(self.out("streams", "--json", "--interval", "0.1"))["streams"] if row["name"] == "/cmd_vel")

    def test_yaml_is_published_as_ros2_does(self):
        before = self.commands_heard()
        text = self.out("topic", "pub", "--once", "/cmd_vel", "geometry_msgs/Twist", "{linear: {x: 0.0}, angular: {z: 0}}")
        self.assertIn("publisher: beginning loop\npublishing #1: geometry_msgs.msg.Twist(linear=geometry_msgs.msg.Vector3(x=0.0, y=0.0, z=0.0), ", text)
        self.assertEqual(self.commands_heard(), before + 1)
        for values, part in (("{linaer: {x: 1}}", "did you mean 'linear'"), ("{linear: 1}", "linear"), ("{linear: {", "the message:1")):
            self.assertIn(part, self.expect_exit(self.run_program("topic", "pub", "--once", "/cmd_vel", TWIST, values), 2).stderr)

    def test_a_topic_of_another_type_is_not_published(self):
        before = len(self.json_of("topic", "info", "/scan")["types"])
        for words in (["--once"], ["-t", "2"]):
            refused = self.expect_exit(self.run_program("topic", "pub", *words, "/scan", "std_msgs/msg/String"), 1)
            self.assertIn("topic /scan: has the type sensor_msgs/msg/LaserScan, not std_msgs/msg/String", refused.stderr)
            self.assertEqual(refused.stdout, "")
        self.assertEqual(len(self.json_of("topic", "info", "/scan")["types"]), before)
        # A topic with several types takes each of them.
        for name in (TWIST, "geometry_msgs/msg/TwistStamped"):
            self.expect_exit(self.run_program("topic", "pub", "--once", "/cmd_vel", name), 0)

    def test_a_stamp_can_be_now(self):
        rows = self.out("topic", "pub", "-t", "2", "-r", "20", "/x", "geometry_msgs/msg/TwistStamped", "header: auto", "--json").splitlines()
        stamps = [row["header"]["stamp"]["sec"] + row["header"]["stamp"]["nanosec"] * 1e-9 for row in map(json.loads, rows)]
        self.assertLess(abs(stamps[0] - time.time()), 30)
        self.assertGreater(stamps[1], stamps[0])

    def test_a_rate_below_the_base_s_timeout_is_warned_of(self):
        # A robot that does not answer within 0.2 s is published to all the same, without a warning.
        said = wait_for("the warning", lambda: self.expect_exit(self.run_program("topic", "pub", "-t", "2", "-r", "3", "/cmd_vel", TWIST), 0).stderr)
        self.assertIn("/cmd_vel: /diff_drive stops 0.5 s after the last message (its parameter", said)
        self.assertIn("timeout)", said)
        self.assertIn("publish with --rate 4 or more", said)
        self.assertIn("leaves no room for a late one", said)
        for words in (["-t", "2", "-r", "4"], ["--once"]):
            self.assertEqual(self.expect_exit(self.run_program("topic", "pub", *words, "/cmd_vel", TWIST), 0).stderr, "")
        # Without a reader that stops there is no warning.
        self.assertEqual(self.expect_exit(self.run_program("topic", "pub", "-t", "2", "-r", "3", "/x", TWIST), 0).stderr, "")

    def test_shows_the_timeout_with_the_topic(self):
        text = self.out("topic", "info", "-v", "/cmd_vel")
        self.assertRegex(text, r"Command timeout: 0.5 s \(parameter (cmd_vel_timeout|topics\.\w+\.timeout)\)\n")

    def test_it_can_wait_for_readers(self):
        self.expect_exit(self.run_program("topic", "pub", "--once", "-w", "1", "/cmd_vel", TWIST), 0)
        late = self.expect_exit(self.run_program("topic", "pub", "--once", "-w", "1", "--max-wait-time-secs", "1e-9", "/nobody", TWIST), 1)
        self.assertIn("Waiting for at least 1 matching subscription(s)...\n", late.stderr)
        self.assertIn("Expected 1 subscribers but only got 0 subscribers", late.stderr)


class Services(OnRobot):
    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        loaded = cls.run_program("component", "load", "nacelle::test::Chaos", "--name", "chaos")
        assert loaded.returncode == 0, loaded.stderr

    def test_services_are_listed_with_their_types(self):
        names = self.out("service", "list").split()
        self.assertEqual(names, sorted(names))
        self.assertIn("/chaos/answer", names)
        self.assertFalse([name for name in names if "/_" in name])
        self.assertIn("/robot/_container/list_nodes", self.out("service", "list", "-a").split())
        self.assertIn("/chaos/answer [std_srvs/srv/SetBool]\n", self.out("service", "list", "-t"))
        self.assertEqual(self.out("service", "list", "-c"), f"{len(names)}\n")
        self.assertEqual(self.out("service", "type", "/chaos/answer"), "std_srvs/srv/SetBool\n")
        self.assertIn("/chaos/answer\n", self.out("service", "find", "std_srvs/SetBool"))
        row = next(row for row in self.json_of("service", "list") if row["name"] == "/chaos/answer")
        self.assertEqual(row, {"name": "/chaos/answer", "types": ["std_srvs/srv/SetBool"], "nodes": ["/chaos"]})

    def test_what_every_node_offers_is_left_out_and_counted(self):
        shown = self.expect_exit(self.run_program("service", "list"), 0)
        self.assertNotIn("/lidar/get_parameters", shown.stdout.split())
        every = self.out("service", "list", "--all").split()
        self.assertIn("/lidar/get_parameters", every)
        self.assertIn("/lidar/change_state", every)
        left_out = [row["name"] for row in self.json_of("service", "list") if row.get("standard")]
        self.assertEqual(shown.stderr, f"(and {len(left_out)} that nodes have by standard: --all shows them)\n")
        self.assertEqual(len(left_out), 12 * (len(NODES) + 1) + 7, "ten of the robot's, and /chaos; the container has no lifecycle")
        self.assertLessEqual(set(left_out), set(every))
        self.assertEqual(self.out("service", "type", "/lidar/get_state"), "lifecycle_msgs/srv/GetState\n")
        info = self.expect_exit(self.run_program("node", "info", "/lidar"), 0)
        self.assertNotIn("get_state", info.stdout)
        self.assertNotIn("/rosout", info.stdout)
        self.assertEqual(info.stderr, "(and 15 that nodes have by standard: --all shows them)\n")
        full = self.out("node", "info", "/lidar", "--all")
        self.assertIn("    /lidar/get_state: lifecycle_msgs/srv/GetState\n", full)
        self.assertIn("    /rosout: rcl_interfaces/msg/Log\n", full)
        rows = self.json_of("node", "info", "/lidar")["service_servers"]
        self.assertIn({"name": "/lidar/set_parameters", "types": ["rcl_interfaces/srv/SetParameters"], "standard": True}, rows)

    def test_what_every_node_offers_is_there(self):
        state = self.json_of("service", "call", "/chaos/get_state", "lifecycle_msgs/srv/GetState")
        self.assertEqual(state["response"], {"current_state": {"id": 3, "label": "active"}})
        values = self.json_of("service", "call", "/chaos/get_parameters", "rcl_interfaces/srv/GetParameters", "{names: [share]}")
        self.assertEqual(values["response"]["values"][0]["double_value"], 0.5)

    def test_what_is_logged_is_on_rosout(self):
        heard = self.folder / "rosout"
        with open(heard, "w") as file:
            listening = self.start_program("topic", "echo", "/rosout", "--json", stdout=file, stderr=subprocess.DEVNULL)

        def line():
            refused = self.json_of("service", "call", "/chaos/change_state", "lifecycle_msgs/srv/ChangeState", "{transition: {label: fly}}")
            self.assertEqual(refused["response"], {"success": False})
            logs = [json.loads(text) for text in heard.read_text().split("\n")[:-1]]
            return next((log for log in logs if "'fly'" in log["msg"]), None)

        try:
            log = wait_for("a line on /rosout", line)
        finally:
            listening.kill()
            listening.wait()
        self.assertIn("transition 0 'fly', which does not lead on from active", log["msg"])
        self.assertEqual((log["level"], log["name"]), (30, "container"))
        self.assertTrue(log["file"].endswith("lifecycle_services.cpp"), log)

    def test_a_service_is_called_as_ros2_does(self):
        self.assertEqual(self.out("service", "call", "/chaos/answer", "std_srvs/srv/SetBool", "{data: true}"),
                         "requester: making request: std_srvs.srv.SetBool_Request(data=True)\n\nresponse:\n"
                         "std_srvs.srv.SetBool_Response(success=True, message=\"it's told\")\n\n")  # fmt: skip
        answer = self.json_of("service", "call", "chaos/answer", "std_srvs/SetBool", "data: true")
        self.assertEqual(answer, {"request": {"data": True}, "response": {"success": True, "message": "it's told"}})
        nodes = self.json_of("service", "call", "/robot/_container/list_nodes", "composition_interfaces/srv/ListNodes")
        self.assertIn("/camera", nodes["response"]["full_node_names"])

    def test_a_service_is_called_again_and_again(self):
        caller = self.start_program("service", "call", "/chaos/answer", "std_srvs/srv/SetBool", "{data: true}", "-r", "50", "--json")
        for _ in range(5):
            self.assertTrue(json.loads(caller.stdout.readline())["response"]["success"])
        caller.send_signal(signal.SIGINT)
        self.assertEqual(caller.wait(10 * SLOW), 0)
        caller.stdout.close()

    def test_a_hanging_server_delays_only_its_caller(self):
        loaded = self.json_of("component", "load", "nacelle::test::Chaos", "--name", "hanging")
        waiting = self.start_program("service", "call", "/hanging/answer", "std_srvs/srv/SetBool", "{data: false}", "--timeout", "1", "--json")
        control, times = Control(self.socket_path()), []
        while waiting.poll() is None:
            times.append(self.time_of(control, {"verb": "service.call", "service": "/camera/get_state", "type": "lifecycle_msgs/srv/GetState"}))
            self.assertLess(sum(times), 20 * SLOW)
        control.close()
        self.assertGreater(len(times), 5)
        self.assertLess(sorted(times)[len(times) // 2], 0.1 * SLOW, "the container was held up")
        problem = json.loads(waiting.communicate()[0])["problem"]
        self.assertEqual((problem["where"], problem["code"]), ("service /hanging/answer", "service.no_answer"))
        self.assertEqual(waiting.returncode, 1)
        wait_for("its hang is found", lambda: "hanging" in self.run_program("faults").stdout)
        self.assertIn("  use_sim_time\n", self.out("param", "list", "hanging"), "what is read needs no callback of the node")
        for words in (["param", "set", "hanging", "share", "0.5"], ["service", "call", "/hanging/answer", "std_srvs/srv/SetBool", "{data: true}", "--timeout", "2"]):
            self.expect_exit(self.run_program(*words), 1)
        self.out("component", "unload", str(loaded["id"]))


class Parameters(OnRobot):
    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        loaded = cls.run_program("component", "load", "nacelle::test::Chaos", "--name", "chaos")
        assert loaded.returncode == 0, loaded.stderr

    def test_they_are_listed_got_and_described(self):
        self.assertIn("  note\n", self.out("param", "list", "/chaos"))
        self.assertIn("  share (type: double)\n", self.out("param", "list", "chaos", "--param-type"))
        everybody = self.out("param", "list")
        self.assertIn("/chaos:\n  fail_in\n", everybody)
        self.assertIn("/diff_drive:\n", everybody)
        self.assertEqual(self.out("param", "get", "chaos", "share"), "Double value is: 0.5\n")
        self.assertEqual(self.out("param", "get", "chaos", "use_sim_time"), "Boolean value is: False\n")
        self.assertEqual(self.out("param", "get", "chaos", "use_sim_time", "--hide-type"), "False\n")
        self.assertEqual(self.out("param", "get", "diff_drive", "left_wheel_names"),
                         f"String values are: {json.loads(self.out('param', 'get', 'diff_drive', 'left_wheel_names', '--json'))['value']}\n")  # fmt: skip
        self.assertEqual(self.out("param", "describe", "chaos", "share", "use_sim_time"),
                         "Parameter name: share\n  Type: double\n  Description: of nothing\n  Constraints:\n    Min value: 0.0\n    Max value: 1.0\n"
                         "Parameter name: use_sim_time\n  Type: boolean\n  Description: Take the time from /clock.\n"
                         "  Constraints:\n    Read only: true\n")  # fmt: skip
        rows = {row["name"]: row for row in self.json_of("param", "list", "chaos")}
        self.assertEqual((rows["share"]["from"], rows["share"]["to"]), (0.0, 1.0))
        self.assertEqual(self.json_of("param", "describe", "chaos", "share"), [rows["share"]])

    def test_they_are_set_as_the_node_allows(self):
        self.assertEqual(self.out("param", "set", "chaos", "share", "1"), "Set parameter successful\n")
        self.assertEqual(self.json_of("param", "get", "chaos", "share")["value"], 1.0)
        self.assertEqual(self.json_of("param", "set", "chaos", "share", "0.5"), {"node": "/chaos", "name": "share"})
        for name, value, part in (("share", "1.5", "1.5 is not in 0 to 1"), ("share", "a lot", "is of type {double}"),
                                  ("use_sim_time", "true", "read-only"), ("shar", "1.0", "did you mean 'share'"), ("share", "[]", "gives no value")):  # fmt: skip
            with self.subTest(name=name, value=value):
                self.assertIn(part, self.expect_exit(self.run_program("param", "set", "chaos", name, value), 1).stderr)
        self.assertEqual(self.json_of("param", "get", "chaos", "share")["value"], 0.5)

    def test_a_dump_loads(self):
        file = self.folder / "chaos.yaml"
        text = self.out("param", "dump", "chaos")
        self.assertIn("/chaos:\n  ros__parameters:\n", text)
        file.write_text(text.replace("share: 0.5", "share: 0.25"))
        loaded = self.out("param", "load", "chaos", str(file))
        self.assertIn("Set parameter share successful\n", loaded)
        self.assertEqual(self.json_of("param", "get", "chaos", "share")["value"], 0.25)
        values = self.json_of("param", "dump", "chaos")["/chaos"]["ros__parameters"]
        self.assertEqual(values["share"], 0.25)
        file.write_text("/chaos: {ros__parameters: {share: 7.0, note: from a file}}")
        half = self.expect_exit(self.run_program("param", "load", "chaos", file), 1)
        self.assertIn("Set parameter share failed", half.stderr)
        self.assertEqual(half.stdout, "Set parameter note successful\n")
        file.write_text("/other: {ros__parameters: {share: 7.0}}")
        self.assertIn("has no parameters for /chaos", self.expect_exit(self.run_program("param", "load", "chaos", file), 1).stderr)
        self.assertIn("/no/such", self.expect_exit(self.run_program("param", "load", "chaos", "/no/such"), 1).stderr)
        self.out("param", "set", "chaos", "share", "0.5")

    def test_only_what_was_declared_loosely_can_be_deleted(self):
        self.assertEqual(self.out("param", "delete", "chaos", "loose"), "Deleted parameter successfully\n")
        self.assertNotIn("loose", self.out("param", "list", "chaos"))
        self.assertIn("fixed type", self.expect_exit(self.run_program("param", "delete", "chaos", "share"), 1).stderr)
        self.assertIn("read-only", self.expect_exit(self.run_program("param", "delete", "chaos", "use_sim_time"), 1).stderr)
        self.assertIn("no such parameter", self.expect_exit(self.run_program("param", "delete", "chaos", "loose"), 1).stderr)

    def test_what_is_set_is_kept_for_a_resume(self):
        self.out("param", "set", "chaos", "note", "kept")
        state = next(self.folder.rglob("robot.composition"))
        wait_for("the state file holds it", lambda: "kept" in state.read_text())


if __name__ == "__main__":
    unittest.main()
