# SPDX-License-Identifier: Apache-2.0
"""Whole runs: figures, order, the drive, broken parts, interruptions."""
import json
import os
import pathlib
import pty
import re
import signal
import subprocess
import time
import unittest
import xml.etree.ElementTree

from cpu_waits import BUSY_S, CpuWatch
from robot import COUNTER, LAUNCH_FILE, MAY_ALLOCATE, SLOW, STREAMS_HZ, RobotTest, counting, nightly, wait_for

# The detector keeps one image, at 30 Hz: its queue overflows sooner than those that BUSY_S is about. A tenth is its own work.
OVERFLOWS_AFTER_S = dict.fromkeys(("/camera/image_raw", "/camera/camera_info"), 0.9 / 30)


class Page:
    """A page of --report-html."""

    def __init__(self, file):
        self.text = file.read_text(encoding="utf-8")
        root = xml.etree.ElementTree.fromstring(self.text)
        self.tiles = {tile.find("dt").text: tile.find("dd").text for tile in root.iter("div") if tile.find("dt") is not None}
        self.rows = [[cell.text for cell in row.iter("td")] for row in root.find(".//tbody").iter("tr")]
        self.lines = [
            (line.find("title").text, [tuple(map(float, point.split(","))) for point in line.get("points").split()])
            for line in root.iter("polyline")
        ]


class WholeRun(RobotTest):
    def run_and_report(self, *arguments, limit_s=120, **options):
        file = self.folder / "report.json"
        with CpuWatch() as self.watch:
            outcome = self.expect_exit(self.run_program("drive", "-v", "--report", file, *arguments, limit_s=limit_s, **options), 0)
        self.log = outcome.stderr
        return json.loads(file.read_text()), outcome.stdout

    def check_streams(self, report, summary):
        streams = {stream["name"]: stream for stream in report["streams"]}
        for name, hz in STREAMS_HZ.items():
            with self.subTest(stream=name):
                self.assertAlmostEqual(streams[name]["hz"], hz, delta=0.02 * hz * SLOW)
                self.assertIn(name, summary)
        for name in ("/camera/image_raw", "/scan", "/imu/data_raw", "/odometry/filtered"):
            self.assertGreaterEqual(streams[name]["readers"], 2, name)
        for name, stream in streams.items():
            with self.subTest(stream=name):
                # transient_local history is delivered to late readers too, once each.
                lost = stream["dropped"].get("overwritten", 0)
                in_flight = stream["published"] * stream["readers"] - stream["delivered"] - lost
                self.assertGreaterEqual(in_flight, 0)
                self.assertLessEqual(in_flight, 2 * stream["readers"], stream)
                if lost != 0:
                    self.assertGreater(self.watch.longest_s, OVERFLOWS_AFTER_S.get(name, BUSY_S), stream)
                self.assertEqual((stream["copies"], stream["bytes_copied"]), (0, 0))
                self.assertLessEqual(stream["latency_us"]["p50"], stream["latency_us"]["p99"])
                self.assertLessEqual(stream["latency_us"]["p99"], stream["latency_us"]["max"] * 1.13 + 1)

    def check_process(self, report, summary, counted=False):
        process = report["process"]
        self.assertGreater(process["rss_mb"], 1)
        self.assertGreaterEqual(process["threads"], 3)
        self.assertEqual(process["allocations_per_second"] is not None, counted)
        self.assertEqual("\nheap " in summary, counted)
        # A warning, as of measurements that were lost when the machine paused the robot, is a new message on /rosout.
        may_allocate = (*MAY_ALLOCATE, "services") if " warning [" in self.log else MAY_ALLOCATE
        for thread, rate in (process["allocations_per_second"] or {}).items():
            if not thread.startswith(may_allocate):
                self.assertEqual(rate, 0, f"thread {thread} allocates")

    def test_a_run_without_a_drive_gives_true_figures(self):
        report, summary = self.run_and_report("--for", "8", "--seed", "3", env=counting(self.environment))
        self.check_streams(report, summary)
        self.check_process(report, summary, counted=COUNTER is not None)
        self.assertIsNone(report["drive"])
        self.assertEqual(report["seed"], 3)
        self.assertGreater(report["bringup"]["ms"], 0)
        self.assertEqual(report["shutdown"]["order"], report["bringup"]["order"][::-1])
        self.assertEqual(
            sorted(report["bringup"]["order"]),
            sorted(["camera", "detector", "lidar", "imu", "diff_drive", "odometry", "ekf", "transforms", "monitor", "monitor_2"]),
        )
        self.assertEqual(self.our_processes(), [])

    def check_page(self, page, report, summary):
        """Compares the page with what the run printed."""
        tiles = page.tiles
        self.assertIn(f"drive      {tiles['Distance driven']}; error at the end:", summary)
        for name, label in (("odometry", "Odometry error at the end"), ("EKF", "EKF error at the end")):
            metres, degrees = re.search(rf"{name} ([\d.]+) mm and ([\d.]+) deg", summary).groups()
            shown_m, shown_deg = re.fullmatch(r"([\d.]+) m, ([\d.]+) deg", tiles[label]).groups()
            self.assertAlmostEqual(float(shown_m) * 1000, float(metres), delta=0.1001, msg=name)
            self.assertEqual(shown_deg, degrees, name)
        self.assertIn(f"{tiles['CPU, of one core']} of one core, {tiles['Memory']}, ", summary)
        self.assertEqual(tiles["Faults"], "0")
        self.assertGreater(float(tiles["Time"].split()[0]), 10)
        for key, label in (("published", "Messages"), ("copies", "Copied")):
            self.assertEqual(int(tiles[label]), sum(stream[key] for stream in report["streams"]), label)
        self.assertEqual(int(tiles["Dropped"]), sum(sum(stream["dropped"].values()) for stream in report["streams"]))
        # The same rows as the table that was printed, with its rates and counts.
        printed = {m[1]: (m[2], m[3]) for m in re.finditer(r"^(/\S+(?: \w+)?) +(\d+\.\d\d) +(\d+) ", summary, re.MULTILINE)}
        self.assertEqual({row[0]: (row[2], row[5]) for row in page.rows}, printed)
        rates = {row[0]: row for row in page.rows}
        self.assertEqual((rates["/scan"][1], rates["/imu/data"][1], rates["/cmd_vel"][1]), ("10", "100", "-"))
        for name, hz in STREAMS_HZ.items():
            self.assertLessEqual(float(rates[name][3]), hz * 1.05 * SLOW, name)
            self.assertGreater(float(rates[name][3]), 0, name)
        # A square of one metre, as large across as up, in one picture.
        self.assertEqual([title for title, _ in page.lines[:3]], ["truth", "odometry", "EKF"])
        for title, points in page.lines[:3]:
            across, up = (max(values) - min(values) for values in zip(*points))
            self.assertAlmostEqual(across / up, 1, delta=0.15, msg=title)
            self.assertGreater(len(points), 100, title)
        self.assertGreater(len(dict(page.lines)["CPU"]), 30)

    def test_the_drive_ends_where_it_began(self):
        file = self.folder / "run.html"
        report, summary = self.run_and_report("--seed", "4", "--report-html", file)
        self.check_page(Page(file), report, summary)
        self.check_streams(report, summary)
        self.check_process(report, summary)
        drive = report["drive"]
        self.assertAlmostEqual(drive["distance_m"], 4.0, delta=0.3)
        self.assertLess(drive["ekf_error_m"], 0.04)
        self.assertLess(drive["odometry_error_m"], 0.25)
        self.assertGreater(drive["odometry_error_m"], 0)
        self.assertLess(report["command_to_wheel_ms"]["p99"], 40 * SLOW)
        cmd_vel = next(s for s in report["streams"] if s["name"] == "/cmd_vel" and s["published"])
        self.assertAlmostEqual(cmd_vel["hz"], 50, delta=3)

    @nightly  # many_runs.py has twenty
    def test_one_seed_gives_one_order(self):
        orders = set()
        for _ in range(4):
            report, _ = self.run_and_report("--for", "0.2", "--seed", "9")
            orders.add((tuple(report["bringup"]["order"]), tuple(report["shutdown"]["order"])))
        self.assertEqual(len(orders), 1, orders)


class Report(RobotTest):
    def test_a_page_that_cannot_be_written_is_refused_before_the_robot_starts(self):
        for file, reason in (("/nosuch/run.html", "No such file or directory"), (self.folder, "it is a folder")):
            outcome = self.expect_exit(self.run_program("drive", "--report-html", file), 1)
            self.assertIn(f"nacelle: {file}: the report cannot be written: {reason}", outcome.stderr)
            self.assertEqual(outcome.stdout, "", "nothing was started")

    def test_a_page_of_a_run_without_a_drive(self):
        file = self.folder / "idle.html"
        self.expect_exit(self.run_program("drive", "--for", "3", "--report-html", file, "detector:=false"), 0)
        page = Page(file)
        self.assertEqual(page.tiles["Distance driven"], "not driven")
        self.assertIn("Arguments detector:=false", page.text)
        self.assertEqual([title for title, _ in page.lines[:3]], ["truth", "odometry", "EKF"])


class Interrupted(RobotTest):
    def test_an_interruption_at_any_moment_leaves_nothing_behind(self):
        # The moments are events of the bring-up, seen in the container's own lines.
        for moment in (r"^", r"starting program", r"\[1/", r"\[9/", r"configure /ekf", r"activate /diff_drive", r"components active"):
            with self.subTest(moment=moment):
                sim = self.folder / "sim"
                robot = self.start_program("launch", LAUNCH_FILE, "sim:=true", f"sim_dir:={sim}", "--name", "robot", "-v")
                lines = []
                if moment != r"^":
                    for line in robot.stdout:
                        lines.append(line)
                        if re.search(moment, line):
                            break
                robot.send_signal(signal.SIGINT)
                rest, _ = robot.communicate(timeout=30 * SLOW)
                text = "".join(lines) + rest
                expected = 0 if moment == "components active" else 1
                if moment != r"^":  # before the handler stands, the kernel's own answer is right
                    self.assertEqual(robot.returncode, expected, text)
                wait_for("its processes are gone", lambda: not self.our_processes(), 5)
                self.assertFalse(sim.exists() and list(sim.iterdir()), "the world takes its links with it")
                self.assertEqual([p for p in (self.folder / "nacelle").glob("*.sock")], [])

    def turns(self):
        return abs(json.loads(self.expect_exit(self.run_program("sim", "truth"), 0).stdout)["yaw_rate_rps"]) > 0.3

    @nightly
    def test_a_drive_goes_on_after_its_robot_was_frozen(self):
        drive = self.start_program("drive", "--report", self.folder / "report.json")
        children = pathlib.Path(f"/proc/{drive.pid}/task/{drive.pid}/children")
        next(line for line in drive.stdout if "side 2 of 4" in line)
        # What it turns meanwhile would make a wrong direction for the rest of the way, if the IMU's samples, which wait in the line, got
        # the time at which they are read.
        wait_for("it turns", self.turns, 20)
        container = int(children.read_text().split()[0])
        os.kill(container, signal.SIGSTOP)
        # Longer than the base's inputs may be silent, shorter than the drive waits for a transform.
        until = time.monotonic() + 0.6
        wait_for("the base's inputs were silent", lambda: time.monotonic() > until)
        os.kill(container, signal.SIGCONT)
        text, _ = drive.communicate(timeout=90 * SLOW)
        self.assertEqual(drive.returncode, 0, text)
        drive_report = json.loads((self.folder / "report.json").read_text())["drive"]
        self.assertLess(drive_report["ekf_error_m"], 0.08)

    def test_ctrl_c_in_a_drive_stops_the_robot_in_order(self):
        page = self.folder / "early.html"
        drive = self.start_program("drive", LAUNCH_FILE, "--seed", "2", "--report-html", page)
        for line in drive.stdout:
            if re.search(r"side \d of 4", line):
                break
        drive.send_signal(signal.SIGINT)
        rest, _ = drive.communicate(timeout=30 * SLOW)
        self.assertEqual(drive.returncode, 130, rest)
        self.assertIn("interrupted by SIGINT; the robot was stopped and taken down (container exited with 0)", rest)
        self.assertIn("Ended early: interrupted", Page(page).text)

    def test_under_nohup_it_outlives_its_terminal(self):
        robot = self.start_program("launch", LAUNCH_FILE, "--name", "robot", preexec_fn=lambda: signal.signal(signal.SIGHUP, signal.SIG_IGN))
        wait_for("it runs", lambda: "active" in robot.stdout.readline(), 60)
        robot.send_signal(signal.SIGHUP)
        # A request after the signal: if the signal were obeyed, there would be no answer.
        self.expect_exit(self.run_program("topic", "hz", "/odom", "--once"), 0)
        robot.send_signal(signal.SIGTERM)
        said, _ = robot.communicate(timeout=30 * SLOW)
        self.assertEqual(robot.returncode, 0, said)

    def test_a_killed_drive_takes_the_container_and_the_world_with_it(self):
        drive = self.start_program("drive", LAUNCH_FILE, "--stay")
        for line in drive.stdout:
            if "running" in line:
                break
        self.assertGreaterEqual(len(self.our_processes()), 2)
        drive.kill()
        drive.communicate()
        wait_for("container and world are gone", lambda: not self.our_processes(), 20)


class Terminal(RobotTest):
    FILE = """
launch:
- node_container:
    name: one
    composable_node:
    - pkg: nacelle_monitor
      plugin: nacelle::monitor::MonitorComponent
      name: monitor
      param: [{name: no_such, value: 1}]
      qos: {/diagnostisc: {publisher: {depth: 2}}}
      required: false
"""

    def test_messages_during_the_bring_up_begin_on_a_new_line(self):
        file = self.folder / "one.launch.yaml"
        file.write_text(self.FILE)
        screen, terminal = pty.openpty()
        robot = self.start_program("launch", file, stdout=subprocess.DEVNULL, stderr=terminal)
        os.close(terminal)
        shown = b""
        while b"active in" not in shown:
            shown += os.read(screen, 4096)
        robot.send_signal(signal.SIGINT)
        self.assertEqual(robot.wait(30 * SLOW), 0)
        os.close(screen)
        text = shown.decode()
        self.assertRegex(text, r"\r\x1b\[Knacelle: warning: [^\r]*'no_such'")
        self.assertRegex(text, r"\r\x1b\[K[^\r]*one\.launch\.yaml:10: /monitor has no topic '/diagnostisc'[^\r]*did you mean '/diagnostics'")
        self.assertRegex(text, r"\r\x1b\[K1 component active")


class Broken(RobotTest):
    def bring_up(self, text, *arguments):
        file = self.folder / "broken.launch.yaml"
        file.write_text(text)
        outcome = self.expect_exit(self.run_program("launch", file, *arguments), 1)
        complaints = [line for line in outcome.stderr.splitlines() if line.startswith("nacelle:")]
        # One finding and how many there are, or what failed later.
        self.assertIn(len(complaints), (1, 2), outcome.stderr)
        if len(complaints) == 2:
            self.assertIn("the plan is unsound: 1 error", complaints[1], outcome.stderr)
        self.assertEqual(self.our_processes(), [])
        return complaints[0]

    def robot_with(self, before, after):
        text = pathlib.Path(LAUNCH_FILE).read_text()
        self.assertIn(before, text)
        # The file has moved; the files that it names relative to itself have not.
        return text.replace(before, after).replace("$(dirname)", str(pathlib.Path(LAUNCH_FILE).parent))

    def test_a_port_that_does_not_exist(self):
        text = self.robot_with("value: $(var lidar_port_used)}", "value: /no/such/port}\n      - {name: required_device, value: true}")
        message = self.bring_up(text, f"sim_dir:={self.folder}/sim")
        for part in ("component lidar (nacelle::lidar::LidarComponent)", "/no/such/port", "broken.launch.yaml:", "could not configure"):
            self.assertIn(part, message)
        self.assertNotIn("sim:=", message, "many files have no such argument")

    def test_a_folder_of_a_world_that_runs_names_the_launch_files_argument(self):
        folder = self.folder / "taken"
        world = self.start_program("sim", "world", "--dir", folder)
        try:
            wait_for("the world runs", lambda: (folder / "ready").exists())
            outcome = self.expect_exit(self.run_program("launch", LAUNCH_FILE, f"sim_dir:={folder}", "--name", "second"), 1)
            self.assertIn("another world runs here; end it, or choose another folder: sim_dir:=FOLDER of a launch file", outcome.stderr)
        finally:
            world.send_signal(signal.SIGINT)
            world.communicate(timeout=30 * SLOW)

    def test_a_parameter_out_of_range(self):
        text = self.robot_with("name: serial_port, value: $(var base_port_used)}", "name: serial_port, value: $(var base_port_used)}, {name: wheel_radius, value: -1.0}")
        message = self.bring_up(text, f"sim_dir:={self.folder}/sim")
        for part in ("diff_drive", "wheel_radius", "-1"):
            self.assertIn(part, message)

    def test_a_library_that_is_missing(self):
        text = self.robot_with("plugin: nacelle::camera::CameraComponent", "plugin: nacelle::camera::CamraComponent")
        message = self.bring_up(text, f"sim_dir:={self.folder}/sim")
        for part in ("camera", "there is no plugin nacelle::camera::CamraComponent", "did you mean 'nacelle::camera::CameraComponent'"):
            self.assertIn(part, message)

    def test_a_drive_reports_errors_like_a_launch(self):
        for arguments in (["sim:=false", "base_port:=/no/such/port"], ["config:=/no/such/robot.yaml"]):
            with self.subTest(arguments=arguments):
                outcome = self.expect_exit(self.run_program("drive", "--for", "2", *arguments), 1)
                said = outcome.stderr.splitlines()
                self.assertRegex(said[-1], r"^nacelle: .*/no/such/")

    def test_a_component_that_is_not_required_is_left_out(self):
        text = self.robot_with("{name: port_name, value: $(var lidar_port_used)}",
                               "{name: port_name, value: /no/such/port}\n      - {name: required_device, value: true}")
        text = text.replace("      name: lidar\n", "      name: lidar\n      required: false\n")
        file = self.folder / "left_out.launch.yaml"
        file.write_text(text)
        robot = self.start_program("launch", file, f"sim_dir:={self.folder}/sim", "-v")
        lines = []
        for line in robot.stdout:
            lines.append(line)
            if "components active" in line:
                break
        robot.send_signal(signal.SIGTERM)
        robot.communicate(timeout=30 * SLOW)
        self.assertEqual(robot.returncode, 0, "".join(lines))
        self.assertTrue(any("left out, since it is not required" in line and "/no/such/port" in line for line in lines), lines)
        self.assertIn("9 components active", lines[-1])


if __name__ == "__main__":
    unittest.main()
