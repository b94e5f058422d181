# SPDX-License-Identifier: Apache-2.0
"""The simulated robot in a namespace, with its transforms apart by topics and by frames."""
import json
import os
import unittest

from robot import LAUNCH_FILE, SLOW, RobotTest, RunningRobotTest, nightly, wait_for

# As in ROS 2, these are absolute names: all robots' are on one topic each.
SHARED = {"/diagnostics", "/rosout", "/parameter_events"}
FRAMES = {"odom", "base_footprint", "base_link", "lidar_link", "imu_link", "left_wheel_link", "right_wheel_link", "camera_link",
          "camera_optical_frame"}


class NamespaceTest(RunningRobotTest):
    @classmethod
    def setUpClass(cls):
        if not cls.arguments:
            raise unittest.SkipTest("the class above those with tests")
        super().setUpClass()

    @classmethod
    def make_launch_file(cls):
        """With a component in a process of its own."""
        with open(LAUNCH_FILE, encoding="utf-8") as file:
            text = file.read()
        folder = os.path.dirname(os.path.realpath(LAUNCH_FILE))
        text = text.replace("$(dirname)", folder).replace("      name: lidar\n", "      name: lidar\n      isolate: process\n")
        launch_file = cls.folder / "robot.launch.yaml"
        launch_file.write_text(text)
        return launch_file

    def nacelle(self, *words, code=0):
        return self.expect_exit(self.run_program(*words), code).stdout

    def frames(self):
        rows = json.loads(self.nacelle("tf", "tree", "--json"))["frames"]
        return {name for row in rows for name in (row["child"], row["parent"])}

    def echoes(self, topic):
        message = json.loads(self.nacelle("topic", "echo", topic, "--once", "--json"))
        return message.get("message", message)

    def topics(self):
        return {row["name"] for row in json.loads(self.nacelle("topic", "list", "--json"))}

    def check_nodes(self):
        rows = json.loads(self.nacelle("component", "list", "--json"))["components"]
        self.assertEqual({row["node"] for row in rows if not row["node"].startswith("/robot1/")}, set())
        services = self.nacelle("service", "list", "--all")
        self.assertIn("/robot1/robot/_container/load_node", services)
        # All of them are fused: topics, frames and stamps fit.
        filtered = self.echoes("/robot1/odometry/filtered")
        self.assertIn(filtered["child_frame_id"], ("base_footprint", "robot1/base_footprint"))
        self.assertNotIn("not fused", (self.folder / "log").read_text())

    def check_other_plugins(self, frame):
        """One that the launch file does not name is put beside the others."""
        self.nacelle("component", "load", "nacelle::imu::ImuComponent", "--name", "imu2", "-p", f"port:={self.folder}/none",
                     "-p", "required_device:=true", code=1)  # there is no such device
        shown = self.nacelle("component", "load", "nacelle::transforms::TransformsComponent", "--name", "more", "-p",
                             "static_transforms:=[0 0 1 0 0 0 base_link mast]")
        self.assertIn("/robot1/more", shown)
        wait_for("the mast is in the tree", lambda: frame in self.frames(), 10)


    def compose(self, service, **request):
        kind = "LoadNode" if service == "load_node" else "UnloadNode"
        return json.loads(self.nacelle("service", "call", f"/robot1/robot/_container/{service}", f"composition_interfaces/srv/{kind}",
                                       json.dumps(request), "--timeout", "30", "--json"))["response"]

    def load_node(self, plugin, name, remaps=(), **parameters):
        rows = [{"name": key, "value": {"type": 9, "string_array_value": values}} for key, values in parameters.items()]
        return self.compose("load_node", package_name="any", plugin_name=plugin, node_name=name, parameters=rows, remap_rules=list(remaps))

    def names(self):
        return {row["node"]: row["id"] for row in json.loads(self.nacelle("component", "list", "--json"))["components"]}

    def check_load_node(self, frame):
        """ROS 2's service puts a component where `component load` does, with the same checks."""
        loaded = self.load_node("nacelle::transforms::TransformsComponent", "composed", static_transforms=["0 0 2 0 0 0 base_link flag"])
        self.assertEqual((loaded["error_message"], loaded["full_node_name"]), ("", "/robot1/composed"))
        # As rclcpp's container leaves it.
        self.assertEqual(self.nacelle("lifecycle", "get", "composed"), "unconfigured [1]\n")
        for transition in ("configure", "activate"):
            self.nacelle("lifecycle", "set", "composed", transition)
        wait_for("the flag is in the tree", lambda: frame in self.frames(), 10)

        taken = self.load_node("nacelle::transforms::TransformsComponent", "composed")
        self.assertFalse(taken["success"])
        self.assertIn("/robot1/composed", taken["error_message"])

        self.assertEqual(self.load_node("nacelle::test::Chaos", "calm")["error_message"], "")
        # It asks for the last message, which a volatile publisher does not keep.
        clash = self.load_node("nacelle::monitor::MonitorComponent", "late", ["/x/robot_description:=/robot1/calm/alive"],
                               streams=["/x/robot_description std_msgs/msg/String"])  # fmt: skip
        self.assertFalse(clash["success"])
        self.assertIn("durability", clash["error_message"])
        self.assertIn("it was unloaded again", clash["error_message"])
        self.assertNotIn("/robot1/late", self.names())

        state = self.folder / "nacelle/robot.composition"
        for name in ("calm", "composed"):
            node = "/robot1/" + name
            wait_for("it is in the state file that a restart restores", lambda: f'"{name}"' in state.read_text())
            self.assertEqual(self.compose("unload_node", unique_id=self.names()[node]), {"success": True, "error_message": ""})
            self.assertNotIn(node, self.names())
        self.assertEqual(self.compose("unload_node", unique_id=4711)["error_message"], "No node found with unique_id: 4711")


class Topics(NamespaceTest):
    arguments = ("namespace:=robot1",)

    def test_everything_is_below_it_and_frames_keep_their_names(self):
        self.check_nodes()
        self.assertEqual({name for name in self.topics() if not name.startswith("/robot1/")} - SHARED, set())
        self.assertGreaterEqual(self.topics(), {"/robot1/tf", "/robot1/tf_static", "/robot1/robot_description", "/robot1/scan"})
        self.assertEqual(self.frames(), FRAMES)
        self.assertEqual(self.echoes("/robot1/scan")["header"]["frame_id"], "lidar_link")
        self.assertEqual(self.echoes("/robot1/odometry/filtered")["header"]["frame_id"], "odom")
        self.nacelle("tf", "echo", "odom", "camera_optical_frame", "--once")
        monitored = json.loads(self.nacelle("tf", "monitor", "--once", "--json"))
        self.assertIn("base_footprint", json.dumps(monitored))
        self.check_other_plugins("mast")
        self.check_load_node("flag")

    def test_the_check_passes(self):
        self.nacelle("check", self.launch_file, f"sim_dir:={self.folder}/sim", *self.arguments)


class Frames(NamespaceTest):
    arguments = ("namespace:=robot1", "tf:=frames")

    def test_transforms_stay_where_they_are_and_every_frame_has_the_prefix(self):
        self.check_nodes()
        self.assertEqual({name for name in self.topics() if not name.startswith("/robot1/")} - SHARED, {"/tf", "/tf_static"})
        self.assertEqual(self.frames(), {"robot1/" + name for name in FRAMES})
        for topic, frame in (("scan", "lidar_link"), ("imu/data", "imu_link"), ("camera/camera_info", "camera_optical_frame"),
                             ("odom", "odom"), ("odometry/filtered", "odom")):
            with self.subTest(topic=topic):
                self.assertEqual(self.echoes("/robot1/" + topic)["header"]["frame_id"], "robot1/" + frame)
        self.nacelle("tf", "echo", "robot1/odom", "robot1/camera_optical_frame", "--once")
        self.check_other_plugins("robot1/mast")
        self.check_load_node("robot1/flag")

    def test_the_check_passes(self):
        self.nacelle("check", self.launch_file, f"sim_dir:={self.folder}/sim", *self.arguments)


class Drive(RobotTest):
    # Whose filter fuses nothing would know nothing of the way.
    @nightly
    def test_follows_where_frames_have_a_prefix(self):
        file = self.folder / "report.json"
        self.expect_exit(self.run_program("drive", "--report", file, "namespace:=robot1", "tf:=frames", limit_s=120), 0)
        drive = json.loads(file.read_text())["drive"]
        self.assertLess(drive["ekf_error_m"], 0.05 * SLOW)
        self.assertLess(drive["odometry_error_m"], 0.2 * SLOW)


if __name__ == "__main__":
    unittest.main()
