# SPDX-License-Identifier: Apache-2.0
"""What looks at a running robot and at its machine: tf, streams, top, doctor, completion, the manual page."""
import fcntl
import json
import os
import pty
import re
import select
import shutil
import signal
import struct
import subprocess
import termios
import time
import unittest

from control import Control, Sender
from robot import LAUNCH_FILE, PROGRAM, SLOW, RobotTest, RunningRobotTest, expect_rate, wait_for


STRING = "std_msgs/msg/String"


def string(text):
    return b"\0\1\0\0" + struct.pack("<I", len(text) + 1) + text.encode() + b"\0"


def read_terminal(master, limit_s, enough):
    """What a program writes to a terminal, until `enough` is satisfied with it."""
    text, deadline = "", time.monotonic() + limit_s * SLOW
    while not enough(text):
        ready, _, _ = select.select([master], [], [], max(0.0, deadline - time.monotonic()))
        if not ready:
            raise AssertionError(f"not within {limit_s} s: {text}")
        text += os.read(master, 65536).decode(errors="replace")
    return text


class Tools(RunningRobotTest):
    def json_of(self, *words):
        return json.loads(self.expect_exit(self.run_program(*words, "--json"), 0).stdout)

    # --- tf -----------------------------------------------------------------------------------------------------------

    def test_the_tree_of_frames_has_owner_rate_and_age(self):
        def frames_now():
            return {row["child"]: row for row in self.json_of("tf", "tree")["frames"]}

        frames = frames_now()
        base = frames["base_footprint"]
        self.assertEqual((base["parent"], base["owner"], base["static"]), ("odom", "/ekf", False))
        expect_rate(lambda: frames_now()["base_footprint"]["rate_hz"], 50, 10)
        self.assertLess(abs(base["age_s"]), SLOW)
        lidar = frames["lidar_link"]
        self.assertEqual((lidar["parent"], lidar["owner"], lidar["static"]), ("base_link", "/transforms", True))
        text = self.expect_exit(self.run_program("tf", "tree"), 0).stdout
        self.assertRegex(text, r"(?m)^odom\n└─ base_footprint +\d+\.\d Hz, -?\d+ ms old, /ekf\n   └─ base_link +static, /transforms$")

    def test_the_tree_is_drawn_as_svg_pdf_and_dot(self):
        files = {kind: self.folder / f"tree.{kind}" for kind in ("svg", "pdf", "dot")}
        outcome = self.run_program("tf", "tree", *(word for kind, file in files.items() for word in (f"--{kind}", file)))
        self.assertEqual(self.expect_exit(outcome, 0).stdout, "", "the files are what was asked for")
        self.assertRegex(files["svg"].read_text(), r"(?s)^<\?xml .*<svg .*>base_footprint<.*</svg>\n$")
        self.assertTrue(files["pdf"].read_bytes().startswith(b"%PDF-1."))
        self.assertIn('"odom" -> "base_footprint"', files["dot"].read_text())
        if shutil.which("pdftotext"):
            words = subprocess.run(["pdftotext", files["pdf"], "-"], capture_output=True, text=True, check=True).stdout
            self.assertIn("camera_optical_frame", words)
        undrawn = self.folder / "undrawn.svg"
        outcome = self.run_program("tf", "tree", "--svg", undrawn, env={**self.environment, "PATH": "/no/such/folder"})
        self.assertIn(f"dot -Tsvg {self.folder}/undrawn.dot -o {undrawn}", outcome.stderr)
        self.assertIn("digraph", (self.folder / "undrawn.dot").read_text())
        outcome = self.expect_exit(self.run_program("tf", "tree", "--svg", "/no/such/folder/x.svg"), 1)
        self.assertIn("/no/such/folder/x.svg", outcome.stderr)

    def test_echo_writes_as_tf2_echo_does(self):
        text = self.expect_exit(self.run_program("tf", "echo", "base_link", "lidar_link", "--once", "--matrix"), 0).stdout
        number = r"-?\d+\.\d{3}"
        self.assertRegex(text, rf"^At time \d+\.\d{{9}}\n- Translation: \[{number}, {number}, {number}\]\n"
                               rf"- Rotation: in Quaternion \(xyzw\) \[({number}, ){{3}}{number}\]\n"
                               rf"- Rotation: in RPY \(radian\) \[({number}, ){{2}}{number}\]\n"
                               rf"- Rotation: in RPY \(degree\) \[({number}, ){{2}}{number}\]\n- Matrix:\n( +{number}){{4}}\n")  # fmt: skip
        there = self.json_of("tf", "echo", "base_link", "lidar_link", "--once")
        back = self.json_of("tf", "echo", "lidar_link", "base_link", "--once")
        self.assertAlmostEqual(there["translation_m"][2], -back["translation_m"][2], places=9)
        self.assertGreater(there["translation_m"][2], 0, "the LiDAR stands above the base")

    def test_echo_of_a_frame_that_is_not_there_names_the_nearest(self):
        outcome = self.expect_exit(self.run_program("tf", "echo", "base_link", "lidar_lnk", "--once"), 1)
        self.assertIn("did you mean 'lidar_link'", outcome.stderr)

    def test_echo_goes_on_at_its_rate_until_it_is_ended(self):
        program = self.start_program("tf", "echo", "odom", "base_link", "--rate", "20", "--json")
        times = [json.loads(program.stdout.readline())["stamp_ns"] for _ in range(10)]
        program.send_signal(signal.SIGINT)
        self.assertEqual(program.wait(10 * SLOW), 0)
        program.stdout.close()
        self.assertGreater(times[-1], times[0])

    def test_monitor_shows_rate_delay_and_owner(self):
        def monitored():
            table = self.json_of("tf", "monitor", "--once", "--interval", "2")
            return table, next(row for row in table["frames"] if row["frame"] == "base_footprint")

        table, base = monitored()
        self.assertEqual(base["owner"], "/ekf")
        expect_rate(lambda: monitored()[1]["rate_hz"], 50, 10)
        self.assertGreater(base["max_delay_s"], 0)
        self.assertGreaterEqual(base["max_delay_s"], base["average_delay_s"])
        self.assertIn("/ekf", [row["node"] for row in table["broadcasters"]])
        text = self.expect_exit(self.run_program("tf", "monitor", "odom", "lidar_link", "--once"), 0).stdout
        self.assertIn("RESULTS: for odom to lidar_link\nChain is: odom -> base_footprint -> base_link -> lidar_link\n", text)
        self.assertRegex(text, r"Frame: base_footprint, published by /ekf, [\d.]+ Hz, Average Delay: [\d.]+, Max Delay: [\d.]+\n")
        self.assertNotIn("wheel", text)
        self.assertIn("did you mean 'odom'", self.expect_exit(self.run_program("tf", "monitor", "odmo"), 1).stderr)

    def test_a_topic_without_endpoints_is_not_suggested_for_itself(self):
        for topic in ("/gone_for_good", "/scam"):
            self.expect_exit(self.run_program("topic", "pub", "--once", topic, "std_msgs/msg/String", "{data: x}"), 0)
        said = self.expect_exit(self.run_program("topic", "echo", "/gone_for_good", "--once"), 1).stderr
        self.assertIn("topic /gone_for_good: no node publishes it or subscribes to it", said)
        self.assertNotIn("'/gone_for_good'", said)
        self.assertIn("did you mean '/scan'?", self.expect_exit(self.run_program("topic", "echo", "/scam", "--once"), 1).stderr)

    # --- streams and top ----------------------------------------------------------------------------------------------

    def test_streams_shows_rates_without_late_readers(self):
        table = self.json_of("streams")
        rows = {row["name"]: row for row in table["streams"]}
        self.assertLess(rows["/imu/data_raw"]["age_s"], 0.5 * SLOW)
        expect_rate(lambda: next(row["hz"] for row in self.json_of("streams")["streams"] if row["name"] == "/imu/data_raw"), 100, 10)
        self.assertEqual(rows["/camera/image_raw"]["copies"], 0)
        self.assertIn("overwritten", rows["/scan"]["dropped"])
        text = self.expect_exit(self.run_program("streams", "--once"), 0).stdout
        self.assertRegex(text, r"(?m)^STREAM +HZ +AGE +PUBLISHED +READERS +COPIES +P99 +DROPPED$")
        self.assertRegex(text, r"(?m)^/scan +\d+\.\d\d +\d")

    def test_streams_names_a_reader_that_is_stopped_and_started(self):
        # An inactive reader is not late: its lifecycle drops its messages, and they are reported as such.
        before = next(row for row in self.json_of("streams")["streams"] if row["name"] == "/scan")
        self.expect_exit(self.run_program("lifecycle", "set", "monitor_2", "deactivate"), 0)
        try:
            stream = wait_for("messages are dropped", lambda: next(
                (row for row in self.json_of("streams")["streams"]
                 if row["name"] == "/scan" and row["dropped"]["inactive"] > before["dropped"]["inactive"]), None))  # fmt: skip
            self.assertNotIn("/monitor_2", [late["node"] for late in stream["late"]])
        finally:
            self.expect_exit(self.run_program("lifecycle", "set", "monitor_2", "activate"), 0)

    def test_streams_names_the_reader_that_is_late_and_why(self):
        self.expect_exit(self.run_program("component", "load", "nacelle::test::Chaos", "--name", "chaos"), 0)
        orders = ["spin"]  # callbacks of 100 ms, one after the other, in the node that is to read twenty orders meanwhile
        sender = Sender(self.folder / "nacelle" / "robot.sock", "/chaos/do", STRING,
                        lambda: string(orders.pop() if orders else "nothing"), rate_hz=200)  # fmt: skip
        try:
            busy = re.compile(r"\d+ lost.*: (its thread 'executor' is busy|a callback on its thread runs too long|its callback )")
            # A slow machine may look after the spinning is over: then the cause is another one, and the chaos spins once more.
            late = wait_for("/chaos is late since it spins", lambda: orders.append("spin") or next(
                (late for row in self.json_of("streams")["streams"] if row["name"] == "/chaos/do" for late in row["late"] if busy.match(late["why"])), None))  # fmt: skip
            self.assertEqual(late["node"], "/chaos")
            orders.clear()
            text = self.expect_exit(self.run_program("streams", "--once"), 0).stdout
            self.assertRegex(text, r"(?m)^/chaos/do .* overwritten.*\n  /chaos is late: ")
        finally:
            sender.stop()
            self.expect_exit(self.run_program("component", "unload", "chaos"), 0)

    def test_top_sorts_components_and_shows_the_origin_of_figures(self):
        table = self.json_of("top", "--interval", "2")
        rows = {row["node"]: row for row in table["components"]}
        self.assertGreater(table["cpu_percent"], 0)
        self.assertEqual(rows["/detector"]["cpu_by"], "threads")
        self.assertEqual(rows["/ekf"]["cpu_by"], "callbacks")
        self.assertGreater(rows["/detector"]["cpu_percent"], 0)
        expect_rate(lambda: next(row["callbacks_per_s"] for row in self.json_of("top", "--interval", "2")["components"]
                                 if row["node"] == "/detector"), 60, 10)  # fmt: skip
        self.assertGreater(rows["/ekf"]["mean_us"], 0)
        self.assertGreaterEqual(rows["/ekf"]["max_us"], rows["/ekf"]["mean_us"])
        costs = [row["cpu_percent"] for row in table["components"]]
        self.assertEqual(costs, sorted(costs, reverse=True))
        self.assertIn("camera_rx", [row["name"] for row in table["other_threads"]], "a driver's own thread runs no callbacks")
        self.assertRegex(self.expect_exit(self.run_program("top", "--once"), 0).stdout, r"^robot: [\d.]+ % of a core, [\d.]+ MB, \d+ threads\n")

    def test_on_a_terminal_the_table_is_drawn_again_and_ctrl_c_ends_it(self):
        for command in ("streams", "top"):
            with self.subTest(command=command):
                master, slave = pty.openpty()
                fcntl.ioctl(slave, termios.TIOCSWINSZ, struct.pack("4H", 60, 150, 0, 0))
                program = subprocess.Popen([PROGRAM, command, "--interval", "0.2"], stdin=slave, stdout=slave, stderr=slave,
                                           env=self.environment, start_new_session=True)  # fmt: skip
                os.close(slave)
                text = read_terminal(master, 20, lambda text: text.count("\033[H") >= 3)
                program.send_signal(signal.SIGINT)
                self.assertEqual(program.wait(10 * SLOW), 0)
                os.close(master)
                self.assertIn("\033[K", text)
                self.assertIn("/ekf" if command == "top" else "/odom", text)

    def test_on_a_terminal_of_80_x_24_no_line_is_cut_and_q_ends_it(self):
        for command in ("streams", "top"):
            with self.subTest(command=command):
                master, slave = pty.openpty()
                fcntl.ioctl(slave, termios.TIOCSWINSZ, struct.pack("4H", 24, 80, 0, 0))
                before = termios.tcgetattr(slave)
                program = subprocess.Popen([PROGRAM, command, "--interval", "0.2"], stdin=slave, stdout=slave, stderr=slave,
                                           env=self.environment, start_new_session=True)  # fmt: skip
                text = read_terminal(master, 20, lambda text: text.count("\033[H") >= 3)
                os.write(master, b"xq")
                self.assertEqual(program.wait(10 * SLOW), 0)
                self.assertEqual(termios.tcgetattr(slave), before, "the terminal is as it was")
                os.close(slave)
                os.close(master)
                shown = re.sub(r"\033\[[0-9;?]*[A-Za-z]", "", text.split("\033[H")[2])
                lines = shown.replace("\r", "").split("\n")
                self.assertLessEqual(max(map(len, lines)), 80)
                for word in {"streams": ("AGE", "P99", "DROPPED"), "top": ("STATE", "MEAN", "MAX", "QUEUED")}[command]:
                    self.assertIn(word, shown)
                self.assertLessEqual(len(lines), 24)
                if command == "streams":
                    self.assertIn("(80 columns: without ", shown)
                    self.assertRegex(shown, r"\(\d+ more lines; --once shows all\)")

    def test_answers_come_within_a_tenth_of_a_second(self):
        best = {}
        for service, kind in (("get_statistics", "GetStatistics"), ("get_frames", "GetFrames")):
            # The socket itself, so that the program's start does not count.
            control = Control(self.folder / "nacelle" / "robot.sock")
            for _ in range(5):
                began = time.monotonic()
                control.send(b"j", json.dumps({"verb": "service.call", "service": f"/robot/_container/{service}",
                                               "type": f"nacelle_interfaces/srv/{kind}"}).encode())  # fmt: skip
                reply, payload = control.receive()
                self.assertEqual((reply, json.loads(payload)["ok"]), (b"r", True))
                best[service] = min(best.get(service, 9), time.monotonic() - began)
            control.close()
        for service, seconds in best.items():
            self.assertLess(seconds, 0.1 * SLOW, service)

    # --- doctor, completion ---------------------------------------------------------------------------------------------

    def test_doctor_reports_the_running_robot(self):
        outcome = self.run_program("doctor", "--json")
        findings = json.loads(outcome.stdout)["findings"]
        robot = next(row for row in findings if row["about"] == "robot")
        self.assertEqual(robot["where"], "container robot")
        self.assertRegex(robot["value"], r"^\d+ components run$")

    def completed(self, *words):
        lines = self.expect_exit(self.run_program("__complete", "--", *words), 0).stdout.splitlines()
        return [line.split("\t")[0] for line in lines]

    def test_names_are_completed_from_the_running_robot(self):
        self.assertIn("/scan", self.completed("topic", "echo", "/s"))
        self.assertIn("/lidar", self.completed("component", "unload", ""))
        self.assertIn("lidar_link", self.completed("tf", "echo", "base_link", "li"))
        self.assertEqual(self.completed("topic", "echo", "--container", "r"), ["robot"])

    def test_a_real_bash_completes_a_topic(self):
        self.assertIn("topic echo /odometry/filtered ", type_into_bash(self, "nacelle topic echo /odometry/f\t"))


def type_into_bash(test, keys):
    """The screen after those keys, in a bash that has sourced the completion."""
    bindir = os.path.dirname(PROGRAM)
    script = test.folder / "completion.bash"
    script.write_text(test.expect_exit(test.run_program("completion", "bash"), 0).stdout)
    master, slave = pty.openpty()
    environment = {**test.environment, "PATH": bindir + ":" + os.environ["PATH"], "PS1": "READY> ", "TERM": "dumb", "COLUMNS": "200"}
    bash = subprocess.Popen(["bash", "--norc", "--noprofile", "-i"], stdin=slave, stdout=slave, stderr=slave, env=environment, start_new_session=True)
    os.close(slave)
    try:
        read_terminal(master, 20, lambda text: "READY> " in text)
        os.write(master, f"source {script}; echo sour''ced\n".encode())
        # What is typed before bash reads is shown twice.
        read_terminal(master, 20, lambda text: "sourced\r\n" in text and text.endswith("READY> "))
        os.write(master, keys.encode())
        typed = keys.rstrip("\t")
        return read_terminal(master, 20, lambda text: text.partition(typed)[2].strip("\a") != "" and text.endswith(" "))
    finally:
        bash.kill()
        bash.wait()
        os.close(master)


class WithoutRobot(RobotTest):
    def test_doctor_needs_no_container_and_names_devices_that_are_missing(self):
        launch = self.folder / "robot.launch.yaml"
        outcome = self.run_program("doctor", LAUNCH_FILE, "sim:=false", "lidar_port:=/dev/no_such_lidar", "--json")
        self.expect_exit(outcome, 1)
        findings = json.loads(outcome.stdout)["findings"]
        lidar = next(row for row in findings if "/dev/no_such_lidar" in row["where"])
        self.assertEqual((lidar["severity"], lidar["what"]), ("wrong", "is not there"))
        self.assertIn("/lidar, parameter port_name", lidar["where"])
        self.assertTrue(lidar["way_out"])
        self.assertLessEqual({"clock", "memory", "kernel", "realtime", "versions", "ports"}, {row["about"] for row in findings})
        text = self.expect_exit(self.run_program("doctor", launch), 1).stdout
        self.assertRegex(text, r"(?m)^wrong +launch +.*robot\.launch\.yaml")
        self.assertRegex(text, r"\n\d+ wrong, \d+ advice, \d+ fine\n$")

    def test_the_exit_code_is_1_if_something_is_wrong(self):
        outcome = self.run_program("doctor")
        self.assertEqual(outcome.returncode, 1 if re.search(r"(?m)^wrong ", outcome.stdout) else 0, outcome.stdout)

    def test_without_a_container_names_are_silently_none(self):
        outcome = self.expect_exit(self.run_program("__complete", "--", "topic", "echo", ""), 0)
        self.assertEqual((outcome.stdout, outcome.stderr), ("", ""))

    def test_commands_options_types_and_plugins_need_no_container(self):
        def completed(*words):
            lines = self.expect_exit(self.run_program("__complete", "--", *words), 0).stdout.splitlines()
            return [line.split("\t")[0] for line in lines]

        self.assertLessEqual({"topic", "tf", "doctor", "launch"}, set(completed("")))
        self.assertNotIn("isolated", completed(""))
        self.assertIn("--once", completed("tf", "echo", "--o"))
        self.assertIn("geometry_msgs/msg/Twist", completed("topic", "pub", "/cmd_vel", "geometry_msgs/msg/T"))
        self.assertIn("nacelle::lidar::LidarComponent", completed("component", "load", "nacelle::l"))

    def test_a_real_bash_completes_commands_and_names_with_colons(self):
        self.assertIn("nacelle topic echo ", type_into_bash(self, "nacelle topic ec\t"))
        self.assertIn("load nacelle::lidar::LidarComponent ", type_into_bash(self, "nacelle component load nacelle::li\t"))

    def test_the_completion_of_each_shell_is_valid(self):
        for shell in ("bash", "zsh", "fish"):
            script = self.expect_exit(self.run_program("completion", shell), 0).stdout
            self.assertIn("__complete", script)
            if shutil.which(shell):
                with self.subTest(shell=shell):
                    self.assertEqual(subprocess.run([shell, "-n"], input=script, text=True).returncode, 0)

    def test_a_real_fish_completes_commands(self):
        if not shutil.which("fish"):
            self.skipTest("there is no fish")
        script = self.folder / "nacelle.fish"
        script.write_text(self.expect_exit(self.run_program("completion", "fish"), 0).stdout)
        asked = f"set -x PATH {os.path.dirname(PROGRAM)} $PATH; source {script}; complete -C 'nacelle tf e'"
        said = subprocess.run(["fish", "--no-config", "-c", asked], capture_output=True, text=True, env=self.environment, check=True)
        self.assertIn("echo\t", said.stdout)

    def test_the_manual_page_is_sound_and_whole(self):
        page = self.folder / "nacelle.1"
        self.expect_exit(self.run_program("man-page", "--output", page), 0)
        text = page.read_text()
        for path in leaves(json.loads(self.expect_exit(self.run_program("command-tree"), 0).stdout)):
            self.assertIn(".SS " + path.replace("-", "\\-") + "\n", text)
        checks = {
            "groff": ["groff", "-ww", "-man", "-Tutf8", "-z", page],
            "man": ["man", "-l", "--warnings", "-Z", page],
            "mandoc": ["mandoc", "-Tlint", "-Wwarning", page],
        }
        for tool, command in checks.items():
            if shutil.which(tool):
                with self.subTest(tool=tool):
                    said = subprocess.run(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, env={**os.environ, "LC_ALL": "C.UTF-8"})
                    # It has no date: the same source makes the same page.
                    remarks = [line for line in (said.stdout + said.stderr).splitlines() if "mandoc:" in line and "missing date" not in line]
                    self.assertEqual(remarks if tool == "mandoc" else said.stderr.splitlines(), [])


def leaves(tree, path=""):
    """The commands that run: "nacelle topic echo"."""
    path = f"{path} {tree['name']}".strip()
    below = [leaf for one in tree["subcommands"] for leaf in leaves(one, path)]
    return [path, *below] if tree["runs"] else below


if __name__ == "__main__":
    unittest.main()
