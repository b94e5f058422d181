# SPDX-License-Identifier: Apache-2.0
"""Clocks: the wall clock is set, simulated time, and simulated time that jumps.

The wall clock is set while the robot drives: no control cycle is missed, one event reports it, stamps keep their order.

The container's clock is set through its --test-clock; the machine's own stays as it is.
"""
import json
import os
import pathlib
import re
import signal
import threading
import time
import unittest

from control import CLOCK, TWIST, Sender, clock, twist
from robot import LAUNCH_FILE, SLOW, RunningRobotTest, wait_for
from stop_test import Truth

STREAMS = ("/odom", "/odometry/filtered", "/imu/data_raw", "/joint_states")


class Listening(RunningRobotTest):
    """Records the messages of topics, or only their stamps."""

    def echo(self, topic, *field):
        path = self.folder / f"echo{topic.replace('/', '_')}"
        with open(path, "w") as file:
            return path, self.start_program("topic", "echo", topic, *field, "--json", stdout=file)

    def echo_stamps(self, topic):
        """An image as JSON has a megabyte and more: a test that reads whole ones may never catch up with the camera."""
        return self.echo(topic, "--field", "header.stamp")

    def lines(self, path):
        """Whole lines only: the last one may be half written."""
        return [json.loads(line) for line in path.read_text().split("\n")[:-1]]


class ClockSteps(Listening):
    @classmethod
    def start_program(cls, *arguments, **options):
        if arguments[0] == "launch":
            os.mkfifo(cls.folder / "clock")
            arguments = (*arguments, "--test-clock", cls.folder / "clock")
        return super().start_program(*arguments, **options)

    def test_steps_of_the_wall_clock_while_it_drives(self):
        truth = Truth(self.folder / "sim" / "truth")
        sender = Sender(self.folder / "nacelle" / "robot.sock", "/cmd_vel", TWIST, lambda: twist(0.05, 0.3))
        wait_for("it drives", truth.moves, 5)
        echoes = {topic: self.echo_stamps(topic) for topic in STREAMS} | {topic: self.echo(topic) for topic in ("/tf", "/diagnostics")}
        heard = lambda topic: len(self.lines(echoes[topic][0]))
        for topic in (*STREAMS, "/tf"):
            wait_for(f"{topic} is heard", lambda: heard(topic) > 10)
        starts = truth.starts

        for steps, step_s in enumerate((-5, 3600), 1):
            before = {topic: heard(topic) for topic in echoes}
            with open(self.folder / "clock", "w") as fifo:
                fifo.write(f"{step_s}\n")
            wait_for("the event", lambda: (self.folder / "log").read_text().count("clock_jump") == steps)
            for topic in (*STREAMS, "/tf"):
                wait_for(f"{topic} goes on after a step of {step_s} s", lambda: heard(topic) > before[topic] + 50)
        sender.pause()
        self.assertEqual(truth.starts, starts, "the wheels never stopped")
        for _, process in echoes.values():
            process.send_signal(signal.SIGINT)
            process.wait(10 * SLOW)

        for topic in STREAMS:
            with self.subTest(stream=topic):
                self.check_order(self.lines(echoes[topic][0]))
        for child in ("base_footprint", "left_wheel_link"):
            with self.subTest(frame=child):
                transforms = [t for message in self.lines(echoes["/tf"][0]) for t in message["transforms"] if t["child_frame_id"] == child]
                self.assertGreater(len(transforms), 50)
                self.check_order([t["header"]["stamp"] for t in transforms])

        told = [status for message in self.lines(echoes["/diagnostics"][0]) for status in message["status"] if "clock_jump" in status["name"]]
        self.assertEqual([status["message"] for status in told], ["the wall clock was set by -5.000 s", "the wall clock was set by +3600.000 s"])
        self.assertEqual((self.folder / "log").read_text().count("clock_jump"), 2)
        sender.stop()

        self.robot.send_signal(signal.SIGINT)
        self.assertEqual(self.robot.wait(30 * SLOW), 0)
        cycles, skipped, not_written = map(int, re.search(
            r"\[diff_drive\] (\d+) cycles \((\d+) skipped, (\d+) not written\)", (self.folder / "log").read_text()).groups())  # fmt: skip
        self.assertGreater(cycles, 50)
        # A loop that followed the wall clock would skip 250 cycles for the step back, and more for the other. A busy machine skips a few.
        self.assertLess(skipped, 25)
        self.assertEqual(not_written, 0)

    def check_order(self, stamps):
        """Stamps grow but for the two steps, each of the size of its step."""
        times = [stamp["sec"] + stamp["nanosec"] * 1e-9 for stamp in stamps]
        gaps = [b - a for a, b in zip(times, times[1:])]
        odd = [round(gap) for gap in gaps if gap < 0 or gap > 1 * SLOW]
        self.assertEqual(odd, [-5, 3600])


class SimTime(Listening):
    """Every component takes its stamps from /clock, which here begins at 1000 s and runs at half the speed."""

    STAMPED = (*STREAMS, "/scan", "/camera/image_raw", "/imu/mag", "/battery/state")

    @classmethod
    def start_program(cls, *arguments, **options):
        if arguments[0] == "launch":
            source = pathlib.Path(LAUNCH_FILE)
            file = cls.folder / "sim_time.launch.yaml"
            file.write_text(source.read_text().replace("- node_container:", "- set_use_sim_time: {value: true}\n- node_container:"))
            arguments = ("launch", file, f"config:={source.parent}/config/robot.yaml", f"description:={source.parent}/robot.urdf", *arguments[2:])
        return super().start_program(*arguments, **options)

    def test_every_stamp_is_of_the_simulated_time(self):
        begin = time.monotonic()
        now_s = lambda: 1000 + (time.monotonic() - begin) / 2
        socket = self.folder / "nacelle" / "robot.sock"
        ticks = Sender(socket, "/clock", CLOCK, lambda: clock(now_s()), 100.0)
        sender = Sender(socket, "/cmd_vel", TWIST, lambda: twist(0.05))
        truth = Truth(self.folder / "sim" / "truth")
        wait_for("it drives", truth.moves, 5)
        echoes = {topic: self.echo_stamps(topic) for topic in self.STAMPED} | {"/tf": self.echo("/tf")}
        for topic in echoes:
            wait_for(f"{topic} is heard", lambda: len(self.lines(echoes[topic][0])) > 2, 20)
        end_s = now_s()
        for _, process in echoes.values():
            process.send_signal(signal.SIGINT)
            process.wait(10 * SLOW)
        sender.stop()
        wait_for("the timeout does not wait for /clock", lambda: not truth.moves(), 5)
        ticks.stop()

        stamps = {topic: self.lines(echoes[topic][0]) for topic in self.STAMPED}
        stamps["/tf"] = [t["header"]["stamp"] for message in self.lines(echoes["/tf"][0]) for t in message["transforms"]]
        for topic, of_topic in stamps.items():
            with self.subTest(stream=topic):
                times = [stamp["sec"] + stamp["nanosec"] * 1e-9 for stamp in of_topic]
                self.assertGreater(min(times), 999)
                self.assertLess(max(times), end_s + 10)


class SimulatedClock:
    """What /clock says: a time that runs at a pace, stands, or jumps; 100 times a second."""

    def __init__(self, start_s):
        self.lock = threading.Lock()
        self.pace, self.base_s, self.since = 1.0, start_s, time.monotonic()

    def now_s(self):
        with self.lock:
            return self.base_s + (time.monotonic() - self.since) * self.pace

    def go_on(self, pace, at_s=None):
        """Returns the time at which it goes on so."""
        now_s = self.now_s() if at_s is None else at_s
        with self.lock:
            self.pace, self.base_s, self.since = pace, now_s, time.monotonic()
        return now_s


class JumpingSimTime(Listening):
    """Every type of component lives through a /clock that is slow, stands, and is set back; two of them in processes of their own."""

    # Who publishes what. The camera is the pattern, which needs no device; the stop has no stream of its own.
    STREAMS = {
        "/joint_states": "diff_drive", "/odom": "odometry", "/odometry/filtered": "ekf", "/scan": "lidar", "/imu/data_raw": "imu",
        "/camera/camera_info": "camera", "/detections": "detector", "/imu/filtered": "imu_filter",
        "/resize/camera_info": "resize", "/image_rect": "rectify", "/resize/image_raw/compressed": "compress",
    }
    # What the default robot does not have. Gamepad, receiver, ultrasonic sensor and battery monitor are waited for; what debayer makes has no
    # reader, since no camera here sends a Bayer mosaic.
    MORE = """
    - {pkg: nacelle_estop, plugin: nacelle::estop::EmergencyStopComponent, name: estop}
    - {pkg: nacelle_imu_filter, plugin: nacelle::imu_filter::MadgwickFilterComponent, name: imu_filter, remap: [{from: imu/data, to: imu/filtered}]}
    - {pkg: nacelle_joy, plugin: nacelle::joy::JoyComponent, name: joy_node, param: [{name: device_name, value: nobody's}]}
    - {pkg: nacelle_gps, plugin: nacelle::gps::GpsComponent, name: gps, param: [{name: port, value: /dev/no_receiver}, {name: frame_id, value: base_link}]}
    - pkg: nacelle_navsat
      plugin: nacelle::navsat::NavsatTransformComponent
      name: navsat_transform
      param: [{name: use_odometry_yaw, value: true}]
      remap: [{from: gps/fix, to: fix}]
    - {pkg: nacelle_range, plugin: nacelle::range::HcSr04Component, name: range, param: [{name: gpio_chip, value: /dev/no_chip}, {name: frame_id, value: base_link}]}
    - {pkg: nacelle_battery, plugin: nacelle::battery::Ina219Component, name: battery, param: [{name: port, value: /dev/no_i2c}]}
    - {pkg: nacelle_image_proc, plugin: nacelle::image_proc::DebayerComponent, name: debayer, remap: [{from: image_raw, to: camera/image_raw}]}
    - {pkg: nacelle_look, plugin: nacelle::look::LookComponent, name: look, param: [{name: port, value: 0}]}
    - {pkg: nacelle_record, plugin: nacelle::record::RecordComponent, name: recorder, param: [{name: record.all_topics, value: true}, {name: storage.uri, value: FOLDER/bag}]}
    - {pkg: nacelle_record, plugin: nacelle::record::PlayComponent, name: player, param: [{name: play.loop, value: true}, {name: storage.uri, value: TALKER}]}
    - pkg: nacelle_image_proc
      plugin: nacelle::image_proc::ResizeComponent
      name: resize
      param: [{name: scale_width, value: 0.25}, {name: scale_height, value: 0.25}]
      remap: [{from: image/image_raw, to: camera/image_raw}, {from: image/camera_info, to: camera/camera_info}]
    - pkg: nacelle_image_proc
      plugin: nacelle::image_proc::RectifyComponent
      name: rectify
      remap: [{from: image, to: resize/image_raw}, {from: camera_info, to: resize/camera_info}]
    - pkg: nacelle_image_proc
      plugin: nacelle::image_proc::CompressComponent
      name: compress
      remap: [{from: image_raw, to: resize/image_raw}]
"""
    FRAME_OF_THE_TRANSFORMS = "left_wheel_link"
    ISOLATED = ("lidar", "detector")
    BACK_TO_S = 500.0

    @classmethod
    def start_program(cls, *arguments, **options):
        if arguments[0] == "launch":
            source = pathlib.Path(LAUNCH_FILE)
            text = source.read_text().replace("- node_container:", "- set_use_sim_time: {value: true}\n- node_container:")
            for name in cls.ISOLATED:
                text, count = re.subn(rf"^( +)name: {name}$", rf"\1name: {name}\n\1isolate: process", text, flags=re.MULTILINE)
                assert count == 1, name
            text += cls.MORE.replace("FOLDER", str(cls.folder)).replace("TALKER", f"{source.parents[1]}/docs/examples/recordings/talker.mcap")
            file = cls.folder / "sim_time.launch.yaml"
            file.write_text(text)
            arguments = ("launch", file, f"config:={source.parent}/config/robot.yaml", f"description:={source.parent}/robot.urdf", *arguments[2:])
        return super().start_program(*arguments, **options)

    def components(self):
        rows = json.loads(self.expect_exit(self.run_program("component", "list", "--json"), 0).stdout)["components"]
        return {row["node"].removeprefix("/"): row for row in rows}

    def stamps(self, topic):
        return [self.seconds(stamp) for stamp in self.lines(self.echoes[topic][0])]

    def stamps_of_frame(self, child):
        return [
            self.seconds(t["header"]["stamp"]) for message in self.lines(self.echoes["/tf"][0]) for t in message["transforms"]
            if t["child_frame_id"] == child]  # fmt: skip

    @staticmethod
    def seconds(stamp):
        return stamp["sec"] + stamp["nanosec"] * 1e-9

    def all_stamps(self):
        every = {topic: self.stamps(topic) for topic in self.STREAMS}
        every["/tf of " + self.FRAME_OF_THE_TRANSFORMS] = self.stamps_of_frame(self.FRAME_OF_THE_TRANSFORMS)
        return every

    def wait_for_more(self, why, count, of=None):
        before = {name: len(stamps) for name, stamps in self.all_stamps().items()}
        for name in of or before:
            wait_for(f"{name} goes on {why}", lambda: len(self.all_stamps()[name]) >= before[name] + count)
        return {name: stamps[before[name]:] for name, stamps in self.all_stamps().items()}

    def test_every_component_lives_through_it(self):
        self.assertEqual(
            {row["plugin"].split("::")[1] for row in self.components().values()},
            {folder.name for folder in (pathlib.Path(LAUNCH_FILE).parents[1] / "components").iterdir()
             if folder.name != "examples" and "NACELLE_REGISTER_COMPONENT" in "".join(f.read_text() for f in (folder / "component").glob("*.cpp"))},
            "every type of component runs here")  # fmt: skip
        world = SimulatedClock(1000.0)
        socket = self.folder / "nacelle" / "robot.sock"
        ticks = Sender(socket, "/clock", CLOCK, lambda: clock(world.now_s()), 100.0)
        sender = Sender(socket, "/cmd_vel", TWIST, lambda: twist(0.05))
        truth = Truth(self.folder / "sim" / "truth")
        wait_for("it drives", truth.moves, 5)
        self.echoes = {topic: self.echo_stamps(topic) for topic in self.STREAMS} | {"/tf": self.echo("/tf")}
        self.wait_for_more("at full speed", 5)

        slow_from_s = world.go_on(0.5)
        begin = time.monotonic()
        filtered = len(self.stamps("/odometry/filtered"))
        self.check_range("slow", self.wait_for_more("at half speed", 20), slow_from_s - 1, slow_from_s + 60)
        wait_for("two seconds are over", lambda: time.monotonic() > begin + 2)
        rate_hz = (len(self.stamps("/odometry/filtered")) - filtered) / (time.monotonic() - begin)
        self.assertLess(rate_hz, 35 if SLOW == 1 else 50, "the filter's 50 Hz are those of /clock")
        self.assertGreater(rate_hz, 15 / SLOW)

        stands_at_s = world.go_on(0.0)
        wait_for("the filter has seen it", lambda: self.is_quiet("/odometry/filtered"))
        standing = [topic for topic in self.STREAMS if topic not in ("/odometry/filtered", "/imu/filtered")]  # no time passes for a filter
        self.check_range("standing", self.wait_for_more("while the clock stands", 5, standing), stands_at_s - 1, stands_at_s + 0.1)
        self.assertTrue(self.is_quiet("/odometry/filtered"))
        self.assertTrue(truth.moves(), "what drives real wheels does not wait for /clock")

        world.go_on(1.0, self.BACK_TO_S)
        jumped = self.wait_for_more("after the jump back", 20)
        for name, stamps in jumped.items():
            with self.subTest(stream=name):
                late = [s for s in stamps[5:] if not self.BACK_TO_S - 1 < s < self.BACK_TO_S + 60]
                self.assertEqual(late, [], "all stamps but those of messages in flight are of the new time")
                # Real devices' ages are taken from a time that moves in ticks: two samples of one tick may change places.
                back = [a - b for a, b in zip(stamps[5:], stamps[6:]) if a - b > 0.1 * SLOW]
                self.assertEqual(back, [], "they go on in order but for /clock's own ticks")

        self.assertTrue(truth.moves())
        for name, row in self.components().items():
            with self.subTest(component=name):
                self.assertEqual((row["state"], row.get("fault")), ("active", None))
        self.expect_exit(self.run_program("estop", "set"), 0)
        wait_for("the stop stops", lambda: not truth.moves(), 5)
        self.expect_exit(self.run_program("estop", "release"), 0)
        for _, process in self.echoes.values():
            process.send_signal(signal.SIGINT)
            process.wait(10 * SLOW)
        sender.stop()
        ticks.stop()

    def is_quiet(self, topic):
        before, until = len(self.stamps(topic)), time.monotonic() + 0.3 * SLOW
        wait_for("a while is over", lambda: time.monotonic() > until)
        return len(self.stamps(topic)) == before

    def check_range(self, when, every, from_s, to_s):
        for name, stamps in every.items():
            with self.subTest(stream=name, when=when):
                self.assertEqual([s for s in stamps if not from_s <= s <= to_s], [])


if __name__ == "__main__":
    unittest.main()
