# SPDX-License-Identifier: Apache-2.0
"""Composition that survives: kill -9, and the same graph again."""
import json
import os
import signal
import subprocess
import time
import unittest

from robot import LAUNCH_FILE, SHORT, SLOW, RobotTest, wait_for

# A hundred in the nightly run.
KILLS = int(os.environ.get("NACELLE_TEST_KILLS", "2" if SHORT and SLOW > 1 else "5"))
CHAOS = "nacelle::test::Chaos"


class Resume(RobotTest):
    def setUp(self):
        self.log_path = self.folder / "log"
        self.container = None

    def tearDown(self):
        if self.container and self.container.poll() is None:
            self.container.kill()
            self.container.wait()

    def start(self, *arguments):
        with open(self.log_path, "w") as log:
            self.container = self.start_program(*arguments, stdout=log, stderr=subprocess.STDOUT)
        begin = time.monotonic()
        wait_for("it is up", lambda: " active in " in self.said() or self.container.poll() is not None)
        self.assertIsNone(self.container.poll(), self.said())
        return time.monotonic() - begin

    def said(self):
        return self.log_path.read_text()

    def ask(self, *arguments):
        return self.expect_exit(self.run_program(*arguments), 0).stdout

    def graph(self):
        components = json.loads(self.ask("component", "list", "--json"))["components"]
        topics = json.loads(self.ask("topic", "list", "--json"))
        state = json.loads((self.folder / "nacelle/box.composition").read_text())
        return ([(row["node"], row["plugin"], row["state"]) for row in components],
                [(row["name"], row["type"], row["writers"], row["readers"]) for row in topics], state)  # fmt: skip

    def test_the_same_graph_comes_back_after_each_kill(self):
        self.start("container", "--name", "box")
        self.ask("component", "load", CHAOS, "--name", "one", "-p", "note:=hello", "-r", "~/alive:=/alive")
        self.ask("component", "load", CHAOS, "--name", "two", "--namespace", "/arm")
        self.ask("component", "load", CHAOS, "--name", "mover", "-p", f"stop_file:={self.folder}/stop")
        self.ask("component", "load", CHAOS, "--name", "gone")
        self.ask("lifecycle", "set", "two", "deactivate")
        self.ask("component", "unload", "gone")
        before = self.graph()
        self.assertEqual([(node, state) for node, _, state in before[0]], [("/one", "active"), ("/arm/two", "inactive"), ("/mover", "active")])
        first = None
        longest = 0.0
        for _ in range(KILLS):
            self.container.send_signal(signal.SIGKILL)
            self.container.wait()
            longest = max(longest, self.start("container", "--name", "box", "--resume"))
            now = self.graph()
            first = first or now
            self.assertEqual(now, first)
        print(f"{KILLS} kills, back within {longest:.2f} s")
        self.assertLess(longest, 3 * SLOW)
        # All as it was, but for what moves something.
        self.assertEqual([(n, p, "inactive" if n == "/mover" else s) for n, p, s in before[0]], first[0])
        self.assertEqual(before[1], first[1])
        self.assertIn("hello", self.ask("topic", "echo", "/alive", "--once"))

    def test_an_orderly_end_leaves_nothing_to_come_back_to(self):
        self.start("container", "--name", "box")
        self.ask("component", "load", CHAOS, "--name", "one")
        self.container.send_signal(signal.SIGINT)
        self.assertEqual(self.container.wait(20), 0)
        self.assertFalse((self.folder / "nacelle/box.composition").exists())
        self.start("container", "--name", "box", "--resume")
        self.assertIn("nothing to resume", self.said())

    def test_what_is_no_state_file_is_refused_with_the_reason(self):
        file = self.folder / "state"
        for text, why in (("", "not JSON, or cut off"), ("{", "cut off"), ("[]", "no nacelle_composition"),
                          ('{"nacelle_composition": 99}', "has the version 99"),
                          ('{"nacelle_composition": 1, "container": "other", "components": []}', "holds the container 'other'"),
                          ('{"nacelle_composition": 1, "container": "box", "components": [{"plugin": 3}]}', "is damaged")):  # fmt: skip
            file.write_text(text)
            outcome = self.expect_exit(self.run_program("container", "--name", "box", "--resume", "--state", file, limit_s=10), 1)
            self.assertIn(why, outcome.stderr)
            self.assertIn(str(file), outcome.stderr)
            self.assertEqual(file.read_text(), text, "it is left as it was")

    def test_a_launch_file_selects_components_that_come_back_active(self):
        launch = self.folder / "box.launch.yaml"
        launch.write_text(f"""
launch:
- node_container:
    name: box
    param: [{{name: hang_after, value: 0.5}}]
    composable_node:
    - {{pkg: t, plugin: {CHAOS}, name: still, param: [{{name: stop_file, value: {self.folder}/stop_1}}]}}
    - {{pkg: t, plugin: {CHAOS}, name: moving, resume: active, param: [{{name: stop_file, value: {self.folder}/stop_2}}]}}
    - {{pkg: t, plugin: {CHAOS}, name: extra}}
""")
        self.start("launch", launch)
        self.ask("component", "unload", "extra")
        self.ask("component", "load", CHAOS, "--name", "by_hand", "-p", "note:=seven")
        self.container.send_signal(signal.SIGKILL)
        self.container.wait()
        self.start("launch", launch, "--resume")
        rows = json.loads(self.ask("component", "list", "--json"))["components"]
        self.assertEqual({row["node"]: row["state"] for row in rows}, {"/still": "inactive", "/moving": "active", "/by_hand": "active"})
        # The container's own limit holds: a callback that hangs is found after half a second.
        self.ask("topic", "pub", "--once", "/by_hand/do", "std_msgs/msg/String", '{"data": "hang"}')
        event = wait_for("it hangs", lambda: json.loads(self.ask("faults", "--json"))["history"])[0]
        self.assertEqual(event["code"], "HUNG")
        self.assertRegex(event["text"], r"running for 0\.[5-9] s")


class WholeRobot(Resume):
    """The simulated robot: everything comes back as it was but the base, which waits to be activated."""

    longest_s = float("inf")

    # The cases of the small container are run once, above.
    test_the_same_graph_comes_back_after_each_kill = None
    test_an_orderly_end_leaves_nothing_to_come_back_to = None
    test_what_is_no_state_file_is_refused_with_the_reason = None
    test_a_launch_file_selects_components_that_come_back_active = None

    def test_the_robot_comes_back_after_each_kill(self):
        launch = ("launch", LAUNCH_FILE, f"sim_dir:={self.folder}/sim", "--name", "box")
        self.start(*launch)
        self.ask("component", "unload", "detector")
        before = self.graph()
        first = None
        longest = 0.0
        for _ in range(max(2, KILLS // 2)):
            self.container.send_signal(signal.SIGKILL)
            self.container.wait()
            longest = max(longest, self.start(*launch, "--resume"))
            now = self.graph()
            first = first or now
            self.assertEqual(now, first)
        print(f"{max(2, KILLS // 2)} kills, back within {longest:.2f} s")
        self.assertLess(longest, self.longest_s)
        self.assertEqual([(n, p, "inactive" if n == "/diff_drive" else s) for n, p, s in before[0]], first[0])
        said = ("nacelle: /diff_drive moves something, so it was restored as inactive on purpose; "
                "`nacelle lifecycle set /diff_drive activate` activates it")
        self.assertIn(said, self.said().splitlines())
        self.ask(*said.split("`")[1].split()[1:])
        self.assertEqual(self.graph()[0], before[0])


class WholeRobotInTime(WholeRobot):
    """Runs alone on the machine (CMakeLists.txt), so that the time can be held."""

    longest_s = 3 * SLOW


if __name__ == "__main__":
    unittest.main()
