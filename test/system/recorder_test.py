# SPDX-License-Identifier: Apache-2.0
"""`nacelle bag record` and the recorder in a launch file, with a simulated robot."""
import fcntl
import json
import os
import pathlib
import pty
import re
import signal
import struct
import subprocess
import termios
import time
import unittest

from robot import LAUNCH_FILE, SLOW, RobotTest, RunningRobotTest, interrupt, of_words, wait_for

RECORDER = """
    - pkg: nacelle_record
      plugin: nacelle::record::RecordComponent
      name: rosbag2_recorder
      param: [{name: record.all_topics, value: true}, {name: storage.uri, value: FOLDER/bag}]
"""
# On a machine that is busy with other tests the recorder may come too late. Then it says so.
LOST = re.compile(r"lost in queue: (\d+) messages of (\S+)")
SECONDS = int(os.environ.get("NACELLE_RECORD_SECONDS", "0"))  # at night: half an hour
KILLS = int(os.environ.get("NACELLE_KILLS", "2"))  # at night: 100


class Recorder:
    """What the classes share."""

    def info(self, bag):
        return json.loads(self.expect_exit(self.run_program("bag", "info", bag, "--json"), 0).stdout)

    def counts(self, bag):
        return {topic["name"]: topic["messages"] for topic in self.info(bag)["topics"]}

    def attachments(self, file):
        """Of an MCAP file: the texts by their names."""
        data, at, found = file.read_bytes(), 8, {}
        while at + 9 <= len(data) - 8:
            opcode, length = struct.unpack_from("<BQ", data, at)
            if opcode == 9:
                fields, place = [], at + 9 + 16  # after the times
                for size in ("<I", "<I", "<Q"):
                    (count,) = struct.unpack_from(size, data, place)
                    place += struct.calcsize(size)
                    fields.append(data[place : place + count].decode())
                    place += count
                found[fields[0]] = fields[2]
            at += 9 + length
        return found

    def start_recording(self, bag, *words):
        self.said_before = (self.folder / "log").stat().st_size
        recorder = self.start_program("bag", "record", "-o", bag, *words)
        self.assertIn("Recording into", recorder.stdout.readline())
        return recorder

    def end(self, recorder):
        interrupt(recorder)
        words = recorder.stdout.read()
        recorder.stdout.close()
        self.assertEqual(recorder.returncode, 0, words)
        self.assertIn("is complete", words)
        said = (self.folder / "log").read_text()[self.said_before:]
        return {topic: int(count) for count, topic in LOST.findall(said)}


class Record(Recorder, RunningRobotTest):
    def test_of_a_whole_robot_no_message_is_lost_in_silence(self):
        bag = self.folder / "all"
        first = self.streams()["/odom"]["published"]
        recorder = self.start_recording(bag, "-a", "--compression", "lz4")
        before = self.streams()["/odom"]["published"]
        wait_for("two seconds of odometry", lambda: self.streams()["/odom"]["published"] > before + 100)
        after = self.streams()["/odom"]["published"]
        lost = self.end(recorder)
        last = self.streams()["/odom"]["published"]
        self.expect_exit(self.run_program("bag", "check", bag), 0)
        found = self.info(bag)
        self.assertEqual(found["compression"], "lz4")
        counts = self.counts(bag)
        for topic in ("/camera/image_raw", "/scan", "/imu/data_raw", "/odom", "/odometry/filtered", "/tf", "/diagnostics"):
            self.assertGreater(counts.get(topic, 0), 1, topic)
        for topic in ("/tf_static", "/robot_description"):  # published long before
            self.assertEqual(counts.get(topic), 1, topic)
        seen = counts["/odom"] + lost.get("/odom", 0)
        self.assertTrue(after - before <= seen <= last - first, (seen, first, before, after, last))
        metadata = (bag / "metadata.yaml").read_text()
        self.assertIn(f"  message_count: {found['messages']}\n", metadata)
        self.assertNotIn("rosbag2_recorder", self.run_program("component", "list").stdout)
        said = found["notes"]["nacelle.recorder"]
        self.assertGreaterEqual(int(said["lost"]), sum(lost.values()), said)
        self.assertGreaterEqual(int(said["camera copies"]), counts["/camera/image_raw"], said)
        self.assertRegex(self.run_program("bag", "info", bag).stdout, r"Camera copies: +[1-9]")

    @unittest.skipUnless(SECONDS, "NACELLE_RECORD_SECONDS is not set: on a machine with other work the recorder may come too late")
    def test_a_whole_robot_is_recorded_without_a_loss(self):
        bag = self.folder / "whole"
        messages = {}
        seconds = 0.0

        def files():
            return sorted(bag.glob("*.mcap"), key=lambda file: int(file.stem.split("_")[1]))

        def take(file):  # half an hour takes 50 GB: minutes that were checked go
            nonlocal seconds
            self.expect_exit(self.run_program("bag", "check", file, limit_s=300), 0)
            found = self.info(file)
            seconds += (found["end_ns"] - found["start_ns"]) * 1e-9
            for topic in found["topics"]:
                messages[topic["name"]] = messages.get(topic["name"], 0) + topic["messages"]
            file.unlink()

        recorder = self.start_recording(bag, "-a", "-d", "60", "--for", SECONDS)
        while recorder.poll() is None:
            for file in files()[:-2]:  # the disk may still wait for the end of the one before the last
                take(file)
            try:
                recorder.wait(timeout=2)
            except subprocess.TimeoutExpired:
                pass
        words = recorder.stdout.read()
        recorder.stdout.close()
        self.assertEqual(recorder.returncode, 0, words)
        self.assertIn("is complete", words)
        for file in files():
            take(file)
        said = (self.folder / "log").read_text()[self.said_before:]
        self.assertEqual(re.findall(r"lost (?:in queue|to disk): \d+ messages of \S+", said), [])
        self.assertGreater(seconds, 0.99 * SECONDS - 1.0)
        self.assertGreater(messages["/odom"], 45 * SECONDS)  # of 50 a second

    def test_it_has_what_the_run_was_started_with(self):
        bag = self.folder / "attached"
        self.expect_exit(self.run_program("bag", "record", "/odom", "--for", "2", "-o", bag), 0)
        expected = {"robot.launch.yaml", "config/robot.yaml", "parameters.yaml", "robot_description.urdf"}
        self.assertEqual({one["name"] for one in self.info(bag)["attachments"]} & expected, expected)
        self.assertIn("parameters.yaml (application/yaml", self.run_program("bag", "info", bag).stdout)
        texts = self.attachments(bag / "attached_0.mcap")
        self.assertEqual(texts["robot.launch.yaml"], pathlib.Path(LAUNCH_FILE).read_text())
        self.assertIn("<robot", texts["robot_description.urdf"])
        dumped = self.expect_exit(self.run_program("param", "dump", "/lidar"), 0).stdout
        self.assertIn(dumped, texts["parameters.yaml"])
        for words in (("cut", "--duration", "1"), ("filter", "--topics", "/odom"), ("convert", "--compression", "zstd"), ("recover",)):
            copy = self.folder / f"{words[0]}.mcap"
            self.expect_exit(self.run_program("bag", words[0], bag / "attached_0.mcap", *words[1:], "-o", copy), 0)
            self.assertEqual(self.attachments(copy), texts, words)
        both = self.folder / "both.mcap"
        self.expect_exit(self.run_program("bag", "merge", bag, self.folder / "cut.mcap", "-o", both), 0)
        self.assertEqual(len(self.info(both)["attachments"]), 2 * len(texts))

    def test_it_ends_by_itself_and_splits_files(self):
        bag = self.folder / "split"
        done = self.expect_exit(self.run_program("bag", "record", "/odom", "/tf_static", "/never", "-e", "^/im", "-x", "raw$", "-d", "1", "--for", "3", "-o", bag), 0)
        self.assertIn(f"{bag} is complete\n", done.stdout)
        self.assertIn("never published: /never", done.stderr)
        self.assertEqual(set(self.counts(bag)), {"/odom", "/tf_static", "/imu/data", "/imu/mag", "/imu/temperature"})
        files = self.info(bag)["files"]
        self.assertGreaterEqual(len(files), 3)
        for file in files:
            self.assertEqual(self.counts(file).get("/tf_static"), 1, "each file stands alone")
        refused = self.run_program("bag", "record", "-a", "-o", bag)
        self.assertEqual(refused.returncode, 1)
        self.assertIn("exists already", refused.stderr)
        self.assertNotIn("rosbag2_recorder", self.run_program("component", "list").stdout, "nothing of it stays")

    def test_its_services_are_those_of_rosbag2(self):
        def call(service, kind):
            return self.expect_exit(self.run_program("service", "call", f"/rosbag2_recorder/{service}", f"rosbag2_interfaces/srv/{kind}"), 0).stdout

        bag = self.folder / "paused"
        recorder = self.start_recording(bag, "/odom", "/tf_static", "--start-paused")
        self.assertIn("true", call("is_paused", "IsPaused").lower())
        call("split_bagfile", "SplitBagfile")
        wait_for("a second file", (bag / "paused_1.mcap").exists)
        call("resume", "Resume")
        self.assertIn("false", call("is_paused", "IsPaused").lower())
        before = self.streams()["/odom"]["published"]
        wait_for("odometry", lambda: self.streams()["/odom"]["published"] > before + 20)
        call("pause", "Pause")
        self.end(recorder)
        found = self.info(bag)
        first, second = (self.counts(bag / f"paused_{number}.mcap") for number in (0, 1))
        self.assertEqual(first, {"/tf_static": 1}, "what stays is not lost in a pause")
        self.assertGreater(second["/odom"], 15)
        self.assertEqual(second["/tf_static"], 1, "each file stands alone")
        self.assertEqual(found["messages"], sum(first.values()) + sum(second.values()))

    def test_wrong_words_are_refused(self):
        for words, code, what in ((("record",), 2, "no topic is chosen"), (("record", "-e", "("), 2, "no regular expression"),
                                  (("record", "a b"), 2, "a b")):  # fmt: skip
            with self.subTest(words=words):
                refused = self.run_program("bag", *words)
                self.assertEqual(refused.returncode, code, refused.stderr)
                self.assertIn(what, refused.stderr)


class Play(Recorder, RunningRobotTest):
    def test_a_recorded_drive_is_played_beside_the_robot(self):
        bag = self.folder / "drive"
        self.expect_exit(self.run_program("bag", "record", "/odom", "/tf_static", "--for", "2", "-o", bag), 0)
        again = self.start_recording(self.folder / "again", "/recorded/odom")
        played = self.expect_exit(self.run_program("bag", "play", bag, "--topics", "/odom", "--remap", "/odom:=/recorded/odom", "-r", "2"), 0)
        lost = self.end(again)
        first, second = self.info(bag), self.info(self.folder / "again")
        counts = self.counts(bag)
        published, unread = map(int, re.search(r"^(\d+) messages were published; (\d+) had no reader$", played.stdout, re.MULTILINE).groups())
        self.assertEqual(published + unread, counts["/odom"])
        self.assertGreater(published, unread, "the recorder has found the topic")
        self.assertEqual([topic["name"] for topic in second["topics"]], ["/recorded/odom"])
        self.assertEqual(second["messages"] + lost.get("/recorded/odom", 0), published)
        length = (first["end_ns"] - first["start_ns"]) * 1e-9
        self.assertAlmostEqual((second["end_ns"] - second["start_ns"]) * 1e-9, length / 2, delta=0.5 * SLOW)
        self.assertNotIn("rosbag2_player", self.run_program("component", "list").stdout)

    def test_what_cannot_be_played_is_refused(self):
        self.assertIn("No such file", self.run_program("bag", "play", self.folder / "none").stderr)
        self.assertEqual(self.run_program("bag", "play").returncode, 2)


class PlayAlone(RobotTest):
    TALKER = pathlib.Path(LAUNCH_FILE).parents[1] / "docs/examples/recordings/talker.mcap"

    def test_without_a_container_it_starts_one_that_ends_with_it(self):
        played = self.expect_exit(self.run_program("bag", "play", self.TALKER, "-r", "10"), 0)
        self.assertIn("messages were published", played.stdout)
        self.assertEqual(self.run_program("component", "list").returncode, 3, "no container is left")

    @of_words
    def test_on_a_terminal_keys_pause_step_and_change_the_rate(self):
        def asked(service, kind):
            return json.loads(self.expect_exit(self.run_program("service", "call", f"/rosbag2_player/{service}", f"rosbag2_interfaces/srv/{kind}", "--json"), 0).stdout)["response"]

        def rate():
            return asked("get_rate", "GetRate")["rate"]

        keys, terminal = pty.openpty()
        player = self.start_program("bag", "play", self.TALKER, "--loop", stdin=terminal, stderr=subprocess.PIPE,
                                    preexec_fn=lambda: fcntl.ioctl(terminal, termios.TIOCSCTTY, 0))  # fmt: skip
        os.close(terminal)
        try:
            words = ""
            while "space pauses" not in words:
                said = player.stdout.readline()
                self.assertTrue(said, f"it has ended: {words}")
                words += said
            os.write(keys, b" ")
            wait_for("it pauses", lambda: asked("is_paused", "IsPaused")["paused"])
            os.write(keys, b"x\x1b[C\x1b[A")
            wait_for("it is faster", lambda: abs(rate() - 1.1) < 1e-9)
            os.write(keys, b"\x1b[B ")
            wait_for("it is as before", lambda: abs(rate() - 1.0) < 1e-9 and not asked("is_paused", "IsPaused")["paused"])
        finally:
            interrupt(player)
            os.close(keys)
            for stream in (player.stdout, player.stderr):
                stream.close()
        self.assertEqual(player.returncode, 0)


class Killed(Recorder, RobotTest):
    def test_a_killed_robot_leaves_all_but_the_last_two_seconds(self):
        source = pathlib.Path(os.environ["NACELLE_LAUNCH_FILE"])
        for number in range(KILLS):
            with self.subTest(number=number):
                folder = self.folder / str(number)
                folder.mkdir()
                file = folder / "recorded.launch.yaml"
                file.write_text(source.read_text() + RECORDER.replace("FOLDER", str(folder)))
                robot = self.start_program("launch", file, "sim:=true", f"sim_dir:={folder}/sim", "--name", f"robot{number}",
                                           f"config:={source.parent}/config/robot.yaml", f"description:={source.parent}/robot.urdf")  # fmt: skip
                self.addCleanup(robot.stdout.close)
                self.addCleanup(interrupt, robot)
                bag = folder / "bag" / "bag_0.mcap"
                wait_for("some megabytes", lambda: bag.exists() and bag.stat().st_size > 3e6 * (1 + number % 7))  # noqa: B023
                os.killpg(robot.pid, signal.SIGKILL)
                killed = time.time()
                robot.wait()
                self.assertEqual(self.run_program("bag", "info", bag).returncode, 1, "it has no end")
                whole = folder / "whole.mcap"
                self.expect_exit(self.run_program("bag", "recover", bag, "-o", whole), 0)
                self.expect_exit(self.run_program("bag", "check", whole), 0)
                self.assertLess(killed - self.info(whole)["end_ns"] * 1e-9, 2.0)
                whole.unlink()
                bag.unlink()


class BlackBox(Recorder, RobotTest):
    """A robot whose launch file has a recorder with a ring."""

    def start_robot(self, name):
        source = pathlib.Path(os.environ["NACELLE_LAUNCH_FILE"])
        file = self.folder / "box.launch.yaml"
        ring = "{name: storage.ring, value: 30}, {name: storage.ring_size, value: 16000000}, {name: storage.compression, value: lz4}, "
        file.write_text(source.read_text() + RECORDER.replace("FOLDER", str(self.folder)).replace("param: [", "param: [" + ring))
        robot = self.start_program("launch", file, "sim:=true", f"sim_dir:={self.folder}/sim", "--name", name,
                                   f"config:={source.parent}/config/robot.yaml", f"description:={source.parent}/robot.urdf")  # fmt: skip
        self.addCleanup(robot.stdout.close)
        self.addCleanup(interrupt, robot)
        wait_for("the robot", lambda: " active in " in robot.stdout.readline())
        return robot

    def snapshots(self):
        return sorted(path.name for path in self.folder.glob("bag*"))

    def check(self, bag):
        self.expect_exit(self.run_program("bag", "check", bag), 0)
        counts = self.counts(bag)
        for topic in ("/odom", "/tf_static", "/robot_description"):
            self.assertGreaterEqual(counts.get(topic, 0), 1, topic)

    def test_it_writes_the_last_seconds_when_asked_after_a_stop_and_after_a_kill(self):
        robot = self.start_robot(f"box{os.getpid()}")
        self.assertEqual(self.snapshots(), [], "nothing is written unless it is asked for")
        asked = self.expect_exit(self.run_program("bag", "snapshot"), 0)
        self.assertEqual(asked.stdout, f"{self.folder}/bag\n")
        self.check(self.folder / "bag")
        called = self.expect_exit(self.run_program("service", "call", "/rosbag2_recorder/snapshot", "rosbag2_interfaces/srv/Snapshot"), 0)
        self.assertIn("true", called.stdout.lower())
        self.check(self.folder / "bag_2")

        self.expect_exit(self.run_program("estop", "set"), 0)
        wait_for("the snapshot of the stop", (self.folder / "bag_3" / "metadata.yaml").exists)
        self.check(self.folder / "bag_3")

        os.killpg(robot.pid, signal.SIGKILL)
        killed = time.time()
        robot.wait()
        self.start_robot(f"box{os.getpid()}")
        left = self.folder / "bag_crashed"
        wait_for("what the killed robot left", (left / "metadata.yaml").exists)
        self.check(left)
        self.assertLess(killed - self.info(left)["end_ns"] * 1e-9, 2.0 * SLOW)

    def test_a_recorder_without_a_ring_has_no_snapshot(self):
        self.assertNotEqual(self.run_program("bag", "snapshot").returncode, 0)
        for words in (("--ring", "soon"), ("--ring", "0s"), ("--ring", "60s", "--ring-size", "64"), ("--ring", "60s", "-d", "5")):
            refused = self.run_program("bag", "record", "-a", *words)
            self.assertEqual(refused.returncode, 2, refused.stderr)


class Ring(Recorder, RunningRobotTest):
    def test_the_command_keeps_a_ring_until_it_ends(self):
        bag = self.folder / "ring"
        recorder = self.start_program("bag", "record", "-a", "--ring", "20s", "--ring-size", "8MB", "-o", bag)
        self.assertIn("Keeping the last 20s in memory", recorder.stdout.readline())
        self.expect_exit(self.run_program("bag", "snapshot"), 0)
        self.assertEqual(recorder.stdout.readline(), f"{bag} is written\n")
        self.expect_exit(self.run_program("bag", "check", bag), 0)
        self.assertEqual(self.counts(bag).get("/tf_static"), 1, "published long before")
        self.assertLess(self.info(bag)["bytes"], 12e6)
        interrupt(recorder)
        self.assertIn("1 snapshot of rosbag2_recorder", recorder.stdout.read())
        recorder.stdout.close()
        self.assertFalse(list(self.folder.glob("ring_*")))
        plain = self.start_recording(self.folder / "plain", "/odom")
        refused = self.run_program("bag", "snapshot")
        self.assertEqual(refused.returncode, 1)
        self.assertIn("keeps no ring", refused.stderr)
        self.end(plain)


class Absent(RobotTest):
    def test_without_a_robot_there_is_nothing_to_record(self):
        self.assertEqual(self.run_program("bag", "record", "-a").returncode, 3)


if __name__ == "__main__":
    unittest.main()
