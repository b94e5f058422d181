# SPDX-License-Identifier: Apache-2.0
"""Actions through the program: what `nacelle action` says and does, with a server and a client in one container, or in two processes of it."""
import json
import os
import pathlib
import re
import signal
import subprocess
import unittest

from robot import SLOW, RobotTest, wait_for

LAUNCH = pathlib.Path(__file__).parent / "actions" / "actions.launch.yaml"
NAME, TYPE = "/series/series", "example_interfaces/action/Fibonacci"


class Actions(RobotTest):
    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        cls.log = open(cls.folder / "log", "w+")
        cls.container = cls.start_program("launch", cls.launch_file(), stdout=cls.log, stderr=subprocess.STDOUT)
        wait_for("the action is offered", lambda: cls.container.poll() is not None or cls.state("series") == "active")

    @classmethod
    def tearDownClass(cls):
        cls.container.send_signal(signal.SIGINT)
        cls.container.wait(30 * SLOW)
        cls.log.close()
        super().tearDownClass()

    @classmethod
    def launch_file(cls):
        return LAUNCH

    @classmethod
    def state(cls, node):
        return cls.run_program("lifecycle", "get", node).stdout.split(" ")[0]

    def action(self, *words, code=0, **options):
        return self.expect_exit(self.run_program("action", *words, **options), code)

    def send(self, goal, *words, code=0):
        return self.action("send_goal", NAME, TYPE, goal, *words, code=code)

    def test_the_list_has_the_actions_with_types_or_as_a_number(self):
        self.assertEqual(self.action("list").stdout, f"{NAME}\n")
        self.assertEqual(self.action("list", "-t").stdout, f"{NAME} [{TYPE}]\n")
        self.assertEqual(self.action("list", "-c").stdout, "1\n")
        self.assertEqual(json.loads(self.action("list", "--json").stdout), [{"name": NAME, "types": [TYPE]}])

    def test_info_names_the_nodes_of_both_sides(self):
        self.assertEqual(self.action("info", NAME).stdout,
                         f"Action: {NAME}\nAction clients: 1\n    /series_client\nAction servers: 1\n    /series\n")  # fmt: skip
        self.assertIn(f"    /series [{TYPE}]\n", self.action("info", NAME, "-t").stdout)
        self.assertEqual(self.action("info", NAME, "-c").stdout, f"Action: {NAME}\nAction clients: 1\nAction servers: 1\n")
        answer = json.loads(self.action("info", "series/series", "--json").stdout)
        self.assertEqual(answer["servers"], [{"node": "/series", "type": TYPE}])

    def test_type_and_find_are_each_others_inverse(self):
        self.assertEqual(self.action("type", NAME).stdout, f"{TYPE}\n")
        self.assertEqual(self.action("find", TYPE).stdout, f"{NAME}\n")
        self.assertEqual(self.action("find", "example_interfaces/Fibonacci", "-c").stdout, "1\n")
        self.assertEqual(self.action("find", "nav2_msgs/action/Spin").stdout, "")

    def test_wrong_names_are_1_with_the_nearest_wrong_usage_is_2_no_container_is_3(self):
        self.assertIn(f"did you mean '{NAME}'", self.action("info", "/series/serie", code=1).stderr)
        self.assertIn(f"did you mean '{NAME}'", self.action("type", "/series/serie", code=1).stderr)
        self.assertIn("Fibonacci", self.action("find", "example_interfaces/action/Fibonaci", code=1).stderr)
        self.assertIn("order", self.send("{ordr: 5}", code=2).stderr)
        self.assertIn(f"has the type {TYPE}, not nav2_msgs/action/Spin", self.action("send_goal", NAME, "nav2_msgs/action/Spin", code=1).stderr)
        self.assertIn("is not an action", self.action("send_goal", NAME, "std_msgs/msg/String", code=1).stderr)
        self.action("send_goal", NAME, code=2)
        self.action("list", "--container", "nobody", code=3)

    def test_a_goal_is_shown_as_ros2_shows_it(self):
        text = self.send("{order: 3}", "--feedback").stdout
        sequences = ["".join(f"- {n}\n" for n in (0, 1, 1, 2)[: i + 1]) for i in range(4)]
        pattern = ("Waiting for an action server to become available...\nSending goal:\n     order: 3\n\n"
                   "Goal accepted with ID: [0-9a-f]{32}\n\n"
                   + "".join(f"Feedback:\n    sequence:\n{sequence}\n" for sequence in sequences)
                   + f"Result:\n    sequence:\n{sequences[-1]}\nGoal finished with status: SUCCEEDED\n")  # fmt: skip
        self.assertRegex(text, re.compile(f"^{pattern}$"))
        self.assertNotIn("Feedback", self.send("{order: 3}").stdout)

    def test_json_is_one_event_a_line(self):
        events = [json.loads(line) for line in self.send('{"order": 2}', "-f", "--json").stdout.splitlines()]
        self.assertEqual([event["event"] for event in events], ["accepted", "feedback", "feedback", "feedback", "result"])
        self.assertEqual(events[-1], {"event": "result", "status": "SUCCEEDED", "result": {"sequence": [0, 1, 1]}})

    def test_the_goal_can_come_from_standard_input(self):
        text = self.action("send_goal", NAME, TYPE, "--stdin", input="order: 1\n").stdout
        self.assertIn("order: 1\n", text)

    def test_a_rejected_or_aborted_goal_is_1(self):
        self.assertIn("Goal was rejected.\n", self.send("{order: -1}", code=1).stdout)
        self.assertIn("Goal finished with status: ABORTED\n", self.send("{order: 13}", code=1).stdout)

    def begin(self, goal):
        """A `send_goal` whose goal executes."""
        process = self.start_program("action", "send_goal", NAME, TYPE, goal, "-f")
        read = []
        while not any(line.startswith("Feedback:") for line in read):
            line = process.stdout.readline()
            self.assertNotEqual(line, "", read)
            read.append(line)
        return process

    def test_the_first_ctrl_c_cancels_the_goal(self):
        process = self.begin("{order: 1000000}")
        process.send_signal(signal.SIGINT)
        rest = process.communicate(timeout=20 * SLOW)[0]
        self.assertTrue(rest.endswith("Canceling goal...\nGoal canceled.\n"), rest)
        self.assertEqual(process.returncode, 1)
        wait_for("the server counts no longer", lambda: self.feedback_stands_still())

    def feedback_stands_still(self):
        def published():
            rows = json.loads(self.run_program("streams", "--json", "--interval", "0.1").stdout)["streams"]
            return [row["published"] for row in rows if row["name"] == f"{NAME}/_action/feedback"]

        before = published()
        return before and before == published()

    def test_reports_a_goal_that_refuses_to_be_canceled(self):
        process = self.begin("{order: 170}")
        process.send_signal(signal.SIGINT)
        rest = process.communicate(timeout=20 * SLOW)[0]
        self.assertIn("Failed to cancel goal", rest)
        self.assertEqual(process.returncode, 1)

    def test_a_time_limit_cancels_too(self):
        outcome = self.send("{order: 1000000}", "--timeout", "0.3", code=1)
        self.assertIn("Goal canceled.", outcome.stdout)
        self.assertIn("has not ended in time", outcome.stderr)
        self.assertIn("has no active server", self.action("send_goal", "/nobody", TYPE, "--timeout", "0.2", code=1).stderr)

    def test_the_servers_deactivation_aborts_the_goal(self):
        process = self.begin("{order: 1000000}")
        self.expect_exit(self.run_program("lifecycle", "set", "series", "deactivate"), 0)
        text = process.communicate(timeout=20 * SLOW)[0]
        self.assertTrue(text.endswith("Goal finished with status: ABORTED\n"), text[-300:])
        self.assertEqual(process.returncode, 1)
        late = self.start_program("action", "send_goal", NAME, TYPE, "{order: 1}")
        self.assertEqual(late.stdout.readline(), "Waiting for an action server to become available...\n")
        self.expect_exit(self.run_program("lifecycle", "set", "series", "activate"), 0)
        self.assertIn("SUCCEEDED", late.communicate(timeout=20 * SLOW)[0])

    def test_a_component_sends_goals_too(self):
        text = self.expect_exit(self.run_program("topic", "echo", "/series_client/outcome", "--once"), 0).stdout
        self.assertEqual(text, "data: SUCCEEDED 6\n---\n")

    def test_parts_of_actions_are_hidden_from_lists_of_topics_and_services(self):
        for kind in ("topic", "service"):
            self.assertNotIn("_action", self.expect_exit(self.run_program(kind, "list"), 0).stdout)
            shown = self.expect_exit(self.run_program(kind, "list", f"--include-hidden-{kind}s"), 0).stdout
            self.assertIn(f"{NAME}/_action/", shown)

    def test_node_info_names_the_actions(self):
        text = self.expect_exit(self.run_program("node", "info", "series"), 0).stdout
        self.assertIn(f"  Action Servers:\n    {NAME}: {TYPE}\n", text)
        text = self.expect_exit(self.run_program("node", "info", "series_client"), 0).stdout
        self.assertIn(f"  Action Clients:\n    {NAME}: {TYPE}\n", text)

    def test_check_finds_nothing_to_complain_of(self):
        self.expect_exit(self.run_program("check", self.launch_file()), 0)


class Isolated(Actions):
    """The same with server and client in processes of their own."""

    @classmethod
    def launch_file(cls):
        copy = cls.folder / "isolated.launch.yaml"
        copy.write_text(re.sub(r"^( +)name: (series.*)$", r"\1name: \2\n\1isolate: process", LAUNCH.read_text(), flags=re.MULTILINE))
        return copy

    def process_of(self, node):
        for entry in pathlib.Path("/proc").glob("[0-9]*"):
            try:
                words = (entry / "cmdline").read_bytes().split(b"\0")
                parent = int((entry / "stat").read_text().rsplit(")", 1)[1].split()[1])
            except (OSError, IndexError):
                continue
            if parent == self.container.pid and b"isolated" in words and node.encode() in words:
                return int(entry.name)
        return self.fail(f"{node} has no process")

    def test_z_a_goal_fails_when_the_servers_process_ends(self):
        goal = self.begin("{order: 1000000}")
        os.kill(self.process_of("/series"), signal.SIGKILL)
        text = goal.communicate(timeout=20 * SLOW)[0]
        self.assertEqual(goal.returncode, 1, text)
        self.assertNotIn("finished with status", text)


if __name__ == "__main__":
    unittest.main()
