# SPDX-License-Identifier: Apache-2.0
"""The program without a container: usage, exit codes, messages."""
import json
import pathlib
import subprocess
import unittest

from robot import LAUNCH_FILE, PROGRAM, RobotTest

# Two LiDARs on one topic, one of which does not offer what the reader asks for; the ports are never opened.
CLASH = """launch:
- node_container:
    pkg: nacelle
    exec: container
    name: c
    namespace: ''
    composable_node:
    - pkg: nacelle_lidar
      plugin: nacelle::lidar::LidarComponent
      name: lidar
      param: [{name: port_name, value: /no/such/port}]
      qos: {/scan: {publisher: {reliability: best_effort}}}
    - pkg: nacelle_lidar
      plugin: nacelle::lidar::LidarComponent
      name: good_lidar
      param: [{name: port_name, value: /no/such/port}]
      qos: {/scan: {publisher: {reliability: reliable, deadline: 120ms}}}
    - pkg: nacelle_monitor
      plugin: nacelle::monitor::MonitorComponent
      name: monitor
      param: [{name: streams, value: [/scan]}]
      qos: {/scan: {subscription: {reliability: reliable, deadline: 150ms}}}
"""


class WithoutContainer(RobotTest):
    COMMANDS = (
        ["launch"], ["drive"], ["component"], ["component", "list"], ["component", "load"], ["component", "unload"], ["lifecycle"],
        ["lifecycle", "get"], ["lifecycle", "set"], ["topic"], ["topic", "list"], ["topic", "echo"], ["topic", "hz"], ["topic", "pub"],
        ["teleop"], ["sim"], ["sim", "world"], ["interface"], ["interface", "list"], ["qos"], ["qos", "check"],
        ["qos", "explain"], ["check"], ["params"], ["import"], [],
    )  # fmt: skip

    def test_every_command_explains_itself(self):
        for command in self.COMMANDS:
            with self.subTest(command=command):
                self.assertIn("--help", self.expect_exit(self.run_program(*command, "--help"), 0).stdout)

    def test_the_version_is_known(self):
        self.assertRegex(self.expect_exit(self.run_program("--version"), 0).stdout, r"^nacelle \d+\.\d+\.\d+\n$")

    def test_wrong_usage_is_2(self):
        for words in ([], ["no-such-command"], ["topic"], ["topic", "echo"], ["drive", "--no-such-option"], ["drive", "--for", "1", "--stay"],
                      ["drive", "--for", "-1"], ["lifecycle", "set", "camera", "explode"], ["drive", "a.yaml", "b.yaml"],
                      ["component", "load", "camera", "--name", "other"],
                      ["drive", "--seed", "-1"], ["component", "load", "a::B", "-p", "rate"], ["component", "load", "a::B", "-r", "scan"]):  # fmt: skip
            with self.subTest(words=words):
                self.assertTrue(self.expect_exit(self.run_program(*words), 2).stderr)

    def test_no_container_is_3_with_a_way_out(self):
        for words in (["topic", "list"], ["topic", "echo", "/scan"], ["topic", "hz", "/scan"], ["component", "list"], ["component", "load", "camera"],
                      ["component", "unload", "camera"], ["lifecycle", "get", "camera"], ["lifecycle", "set", "camera", "activate"], ["teleop"],
                      ["topic", "list", "--container", "other"], ["topic", "pub", "/x", "std_msgs/msg/String"]):  # fmt: skip
            with self.subTest(words=words):
                self.assertIn("nacelle launch", self.expect_exit(self.run_program(*words), 3).stderr)

    def test_a_launch_file_that_is_not_there_is_1_and_named(self):
        for command in ("launch", "drive"):
            outcome = self.expect_exit(self.run_program(command, "/no/such/robot.launch.yaml"), 1)
            self.assertIn("/no/such/robot.launch.yaml", outcome.stderr)

    def launch_text(self, text, *arguments):
        file = self.folder / "a.launch.yaml"
        file.write_text(text)
        return self.run_program("launch", file, *arguments)

    def test_a_limit_is_told_in_few_words(self):
        self.assertLess(len(self.run_program("drive", "--seed", "-1").stderr), 200)
        wrong = self.expect_exit(self.run_program("topic", "pub", "/x", "std_msgs/msg/String", "{data"), 1)
        self.assertNotIn("[json", wrong.stderr)
        self.assertIn("the message:1: ", wrong.stderr)

    def test_a_report_that_cannot_be_written_is_told_at_once(self):
        for command in ("launch", "drive"):
            outcome = self.expect_exit(self.run_program(command, LAUNCH_FILE, "--report", "/nosuch/x.json"), 1)
            self.assertEqual(len(outcome.stderr.splitlines()), 1, outcome.stderr)
            self.assertIn("/nosuch/x.json: the report cannot be written", outcome.stderr)
            self.assertEqual(outcome.stdout, "")

    def test_the_arguments_are_shown_with_those_that_are_required(self):
        outcome = self.expect_exit(self.launch_text("launch:\n- arg: {name: who}\n- arg: {name: port, default: p0}\n", "-s"), 0)
        self.assertRegex(outcome.stdout, r"'who':\n +\(required\)\n\n +'port':\n +\(default: 'p0'\)")

    def test_a_launch_file_with_nothing_to_start_is_1(self):
        for text in ("launch: []", "launch:\n- node: {exec: x, if: 'false'}"):
            self.assertIn("nothing to start", self.expect_exit(self.launch_text(text), 1).stderr)

    def test_a_launch_file_may_be_named_from_anywhere(self):
        file = pathlib.Path(LAUNCH_FILE)
        for folder in (file.parent, file.parent.parent, pathlib.Path("/")):
            with self.subTest(folder=folder):
                self.expect_exit(self.run_program("launch", file.relative_to(folder), "--show-args", cwd=folder), 0)

    def explained(self, offered, requested):
        outcome = self.expect_exit(self.run_program("qos", "explain", "--offered", offered, "--requested", requested, "--json"), 0)
        return json.loads(outcome.stdout)

    def test_qos_explain_answers_as_rmw_does(self):
        self.assertEqual(self.explained("deadline=100ms", "deadline=1s"), {"verdict": "ok", "reasons": []})
        answer = self.explained("reliability=best_effort,lease=2s", "reliability=reliable,lease=1s")
        self.assertEqual(answer["verdict"], "error")
        self.assertEqual([(r["policy"], r["offered"], r["requested"]) for r in answer["reasons"]],
                         [("reliability", "best_effort", "reliable"), ("lease", "2s", "1s")])  # fmt: skip
        self.assertTrue(all(reason["change"] for reason in answer["reasons"]))
        self.assertEqual(self.explained("reliability=system_default", "reliability=reliable")["verdict"], "warning")
        self.assertEqual(self.explained("", "deadline=1s")["verdict"], "error", "infinite is more than a second")

    def test_qos_explain_names_what_it_cannot_read(self):
        for offered, part in (("relability=reliable", "did you mean 'reliability'"), ("deadline=5", "5s"), ("durability", "key=value")):
            with self.subTest(offered=offered):
                outcome = self.expect_exit(self.run_program("qos", "explain", "--offered", offered, "--requested", ""), 2)
                self.assertIn(part, outcome.stderr)

    def test_qos_check_finds_a_clash_without_starting_anything(self):
        fits = self.expect_exit(self.run_program("qos", "check", LAUNCH_FILE), 0)
        self.assertIn("every publisher and subscription fits", fits.stdout)
        file = self.folder / "clash.launch.yaml"
        file.write_text(CLASH)
        outcome = self.expect_exit(self.run_program("qos", "check", file), 1)
        for part in ("/scan: /lidar publishes with reliability best_effort, /monitor asks for reliable", "deadline", "1 other publisher serves it"):
            self.assertIn(part, outcome.stdout)
        answer = json.loads(self.expect_exit(self.run_program("qos", "check", file, "--json"), 1).stdout)
        self.assertEqual({clash["policy"] for clash in answer["clashes"]}, {"reliability", "deadline"})

    def test_the_completion_is_valid_bash(self):
        script = self.expect_exit(self.run_program("completion", "bash"), 0).stdout
        self.assertEqual(subprocess.run(["bash", "-n"], input=script, text=True).returncode, 0)
        complete = script + f'\nCOMP_LINE="{PROGRAM} topic e"; COMP_POINT=${{#COMP_LINE}}; _nacelle; echo "${{COMPREPLY[@]}}"'
        self.assertEqual(subprocess.run(["bash", "-c", complete], capture_output=True, text=True).stdout, "echo\n")


if __name__ == "__main__":
    unittest.main()
