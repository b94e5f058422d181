# SPDX-License-Identifier: Apache-2.0
"""The services of `ros2 control`, asked from another machine over ROS 2's network, while the robot there drives."""
import json
import subprocess
import unittest

from remote import RemoteTest
from robot import PROGRAM, interrupt, wait_for

SERVICES = {
    "cleanup_controller": "CleanupController", "configure_controller": "ConfigureController", "list_controller_types": "ListControllerTypes",
    "list_controllers": "ListControllers", "list_hardware_components": "ListHardwareComponents",
    "list_hardware_interfaces": "ListHardwareInterfaces", "load_controller": "LoadController",
    "reload_controller_libraries": "ReloadControllerLibraries", "set_hardware_component_state": "SetHardwareComponentState",
    "switch_controller": "SwitchController", "unload_controller": "UnloadController",
}  # fmt: skip
FILE = """
launch:
- node_container:
    name: robot
    composable_node:
    - pkg: nacelle_diff_drive
      plugin: nacelle::diff_drive::DiffDriveComponent
      name: diff_drive
      namespace: /robot1
      param: [{name: hardware, value: loopback}, {name: controller_manager, value: true}]
"""
STRICT = 2


class Controllers(RemoteTest):
    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        file = cls.folder / "base.launch.yaml"
        file.write_text(FILE)
        cls.start_far(lambda line: line.startswith("network: shown"), PROGRAM, "launch", file, "--name", "robot", "network:=export")

    def call(self, verb, **request):
        return self.rows("service", "call", f"/robot1/controller_manager/{verb}", f"controller_manager_msgs/srv/{SERVICES[verb]}",
                         json.dumps(request))["response"]  # fmt: skip

    def switch(self, **request):
        return self.call("switch_controller", strictness=STRICT, timeout={"sec": 5, "nanosec": 0}, **request)

    def states(self):
        return {controller["name"]: controller["state"] for controller in self.call("list_controllers")["controller"]}

    def drive(self, rate_hz):
        sender = self.start_program("topic", "pub", "/robot1/cmd_vel", "geometry_msgs/msg/TwistStamped", "{twist: {linear: {x: 0.2}}}", "-r", rate_hz,
                                    stdout=subprocess.DEVNULL)  # fmt: skip
        self.addCleanup(interrupt, sender)
        return sender

    def wheels(self):
        return json.loads(self.ask("topic", "echo", "/robot1/joint_states", "--once", "--json").stdout)["velocity"]

    def test_the_node_and_its_services_are_listed(self):
        self.assertIn("/robot1/controller_manager\n", self.ask("node", "list").stdout)
        listed = self.ask("service", "list", "-t").stdout.splitlines()
        for verb, kind in SERVICES.items():
            self.assertIn(f"/robot1/controller_manager/{verb} [controller_manager_msgs/srv/{kind}]", listed)

    def test_a_driving_robot_is_listed_stopped_and_driven_again(self):
        self.assertEqual(self.states(), {"diff_drive_controller": "active", "joint_state_broadcaster": "active"})
        component = self.call("list_hardware_components")["component"][0]
        self.assertEqual((component["name"], component["plugin_name"]), ("diff_drive", "nacelle_diff_drive/loopback"))
        interfaces = self.call("list_hardware_interfaces")["command_interfaces"]
        self.assertEqual([row["name"] for row in interfaces], ["left_wheel_joint/velocity", "right_wheel_joint/velocity"])
        self.assertTrue(all(row["is_claimed"] and row["is_available"] for row in interfaces))

        sender = self.drive("20")
        wait_for("it drives", lambda: self.wheels()[0] > 1.0)
        refused = self.switch(deactivate_controllers=["diff_drive_controller", "arm_controller"])
        self.assertFalse(refused["ok"])
        self.assertIn("arm_controller", refused["message"])
        self.assertGreater(self.wheels()[0], 1.0)

        self.assertTrue(self.switch(deactivate_controllers=["diff_drive_controller"])["ok"])
        self.assertEqual(self.wheels(), [0, 0])
        self.assertEqual(self.states()["diff_drive_controller"], "inactive")
        said = json.loads(self.ask("topic", "echo", "/diagnostics", "--once", "--json").stdout)["status"][0]
        self.assertIn("diff_drive_controller is not active", said["message"])
        self.assertTrue(self.switch(activate_controllers=["diff_drive_controller"])["ok"])
        self.assertEqual(self.wheels(), [0, 0], "the sender was never at rest")
        interrupt(sender)
        # Each of its commands comes after a rest of more than the input's timeout.
        self.drive("1")
        wait_for("it drives again", lambda: self.wheels()[0] > 1.0)


if __name__ == "__main__":
    unittest.main()
