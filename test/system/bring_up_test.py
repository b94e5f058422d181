# SPDX-License-Identifier: Apache-2.0
"""The bring-up as a whole: order by readiness, one log for one plan, an end at any moment. NACELLE_COLD_BRING_UPS: how many."""
import json
import os
import pathlib
import re
import signal
import subprocess
import time
import unittest

from robot import LAUNCH_FILE, RobotTest, SLOW, wait_for

COUNT = int(os.environ.get("NACELLE_COLD_BRING_UPS", "3"))

LATE = """\
launch:
- include: {{file: {robot}}}
- load_composable_node:
    target: robot
    composable_node:
{extra}    - pkg: nacelle_monitor
      plugin: nacelle::monitor::MonitorComponent
      name: late
      after:
{conditions}
"""

# Publishes detections, but sees no image.
BLIND = """\
    - {pkg: nacelle_detector, plugin: nacelle::detector::DetectorComponent, name: blind, namespace: /blind}
"""
# Moves something, and fails for good once it is active.
CRANE = """\
    - {{pkg: nacelle_test, plugin: nacelle::test::Chaos, name: crane, param: [{{name: stop_file, value: {stop_file}}}, {{name: fail_in, value: activated}}]}}
"""
# The same, and well; one that is never configured.
CALM = """\
    - {{pkg: nacelle_test, plugin: nacelle::test::Chaos, name: crane, param: [{{name: stop_file, value: {stop_file}}}]}}
"""
HANGER = """\
    - {pkg: nacelle_test, plugin: nacelle::test::Chaos, name: hanger, param: [{name: fail_in, value: configure for ever}]}
"""


class BringUp(RobotTest):
    def launch_file(self, name, *conditions, extra=""):
        path = self.folder / f"{name}.launch.yaml"
        lines = "\n".join(f"      - {{{condition}}}" for condition in conditions)
        path.write_text(LATE.format(robot=LAUNCH_FILE, extra=extra, conditions=lines))
        return path

    def devices(self):
        return self.folder / "nacelle-sim"

    def start(self, file, *arguments):
        return self.start_program("launch", file, *arguments, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE)

    def end(self, robot, number=signal.SIGINT):
        robot.send_signal(number)
        said = robot.communicate(timeout=30 * SLOW)[1]
        return said

    def test_waits_for_messages_transforms_and_services(self):
        log = self.folder / "waited.log"
        file = self.launch_file(
            "waited",
            "node: lidar, when: first_message(/scan)",
            'node: transforms, when: "tf(odom->base_link)", timeout: 8s',
            "node: odometry, when: service(reset_odom)",
        )
        robot = self.start(file, "--transitions", log)
        self.read_until_up(robot)
        lines = re.findall(r"([\d.]+) ms (.+) took ([\d.]+) ms", pathlib.Path(f"{log}.times").read_text())
        times = {step: (float(ended) - float(took), float(ended)) for ended, step, took in lines}
        began, lidar_ended = times["activate /late"][0], times["activate /lidar"][1]
        # The first scan may come at once, since a turn may be nearly complete. test_answers_while_it_waits shows the waiting.
        self.assertGreaterEqual(began, lidar_ended)
        self.end(robot)
        self.assertEqual(robot.returncode, 0)

    def read_until_up(self, robot):
        """Until the bring-up says that it is over: a signal right after its last step still undoes it."""
        said = []
        for line in robot.stderr:
            said.append(line)
            if " active in " in line:
                return
        self.fail("the robot ended before it was up: " + "".join(said))

    def listed_states(self):
        listed = self.run_program("component", "list", "--json")
        return {row["node"]: row["state"] for row in json.loads(listed.stdout)["components"] if row["state"] == "inactive"} if listed.returncode == 0 else {}

    def test_answers_while_it_waits(self):
        file = self.launch_file("patient", "node: /blind/blind, when: first_message(/blind/detections), timeout: 60s", extra=BLIND)
        robot = self.start(file)
        listed = wait_for("it answers while it waits", lambda: self.listed_states().get("/late"), 30)
        self.assertEqual(listed, "inactive")
        self.assertIsNone(robot.poll())
        said = self.end(robot)
        self.assertEqual(robot.returncode, 1, said)

    def test_reports_the_condition_and_rolls_back_on_timeout(self):
        file = self.launch_file("stuck", "node: /blind/blind, when: first_message(/blind/detections), timeout: 3s", extra=BLIND)
        robot = self.start(file)
        said = robot.communicate(timeout=60 * SLOW)[1]
        self.assertEqual(robot.returncode, 1, said)
        self.assertIn("/late waits for first_message(/blind/detections) of /blind/blind: no message yet (at most 3 s)", said)
        self.assertRegex(said, r"stuck\.launch\.yaml:\d+: component late .*: could not activate: .*stuck\.launch\.yaml:\d+: waited 3 s for")
        self.assertEqual(list(self.devices().glob("*")), [], "the devices of the simulated world are gone")

    def test_a_fault_that_stops_the_robot_ends_the_bring_up(self):
        stop_file = self.folder / "stop"
        file = self.launch_file(
            "stopped", "node: /blind/blind, when: first_message(/blind/detections), timeout: 60s", extra=BLIND + CRANE.format(stop_file=stop_file)
        )
        begin = time.monotonic()
        robot = self.start(file)
        said = robot.communicate(timeout=60 * SLOW)[1]
        self.assertLess(time.monotonic() - begin, 30 * SLOW, "it does not wait for the rest")
        self.assertEqual(robot.returncode, 1, said)
        self.assertIn("/crane is faulted (TOLD_TO: a fault on command)", said)
        self.assertIn("STOP\n", stop_file.read_text())

    def test_a_signal_beside_a_step_that_hangs_stops_what_moves_and_does_not_wait_for_it(self):
        stop_file = self.folder / "stop_beside"
        file = self.launch_file("hanging", "node: lidar, when: active", extra=HANGER + CALM.format(stop_file=stop_file))
        robot = self.start(file)
        said = []
        for line in robot.stderr:
            said.append(line)
            if "is still in on_configure" in line:
                break
        begin = time.monotonic()
        robot.send_signal(signal.SIGINT)
        wait_for("what moves is stopped", lambda: stop_file.exists() and "STOP\n" in stop_file.read_text(), 5)
        stopped = time.monotonic() - begin
        more = robot.communicate(timeout=60 * SLOW)[1]
        took = time.monotonic() - begin
        self.assertEqual(robot.returncode, 1, "".join(said) + more)
        print(f"SIGINT beside a hanging on_configure: stopped after {stopped * 1e3:.0f} ms, ended after {took:.1f} s")
        self.assertLess(stopped, 1 * SLOW)
        self.assertLess(took, 10 * SLOW)
        self.assertEqual(list(self.devices().glob("*")), [], "the devices of the simulated world are gone")

    def test_the_same_plan_gives_the_same_log(self):
        logs = set()
        for run in range(COUNT):
            log = self.folder / f"transitions_{run}"
            robot = self.start(LAUNCH_FILE, "--transitions", log)
            self.read_until_up(robot)
            said = self.end(robot, signal.SIGTERM if run % 2 else signal.SIGINT)
            self.assertEqual(robot.returncode, 0, said)
            logs.add(log.read_bytes())
        self.assertEqual(len(logs), 1, logs)
        lines = logs.pop().decode().splitlines()
        self.assertEqual(len(lines), 40)
        self.assertEqual(lines[10:20], [f"activate {line.split()[1]}" for line in lines[:10]])
        self.assertEqual(lines[20:30], [f"deactivate {line.split()[1]}" for line in reversed(lines[:10])])

    def test_a_signal_at_any_moment_leaves_nothing_behind(self):
        for i in range(max(COUNT * 2, 8)):
            robot = self.start(LAUNCH_FILE)
            time.sleep(0.004 * (1 << i % 9))  # the moment is what is tried: 4 ms to 1 s
            said = self.end(robot, signal.SIGTERM if i % 2 else signal.SIGINT)
            self.assertIn(robot.returncode, (0, 1, -signal.SIGTERM, -signal.SIGINT), said)
            self.assertNotIn("FAILED", said)
            self.assertEqual(list(self.devices().glob("*")), [], f"after {i}: {said}")
            self.assertEqual(list((self.folder / "nacelle").glob("*.sock")), [], said)


if __name__ == "__main__":
    unittest.main()
