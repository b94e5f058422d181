# SPDX-License-Identifier: Apache-2.0
"""Clocks: the wall clock is set, and simulated time.

The wall clock is set while the robot drives: no control cycle is missed, one event tells of it, stamps keep their order.

The container's clock is set through its --test-clock; the machine's own stays as it is.
"""
import json
import os
import pathlib
import re
import signal
import time
import unittest

from control import CLOCK, TWIST, Sender, clock, twist
from robot import LAUNCH_FILE, SLOW, RunningRobotTest, wait_for
from stop_test import SPEED, Truth

STREAMS = {"/odom": "header", "/odometry/filtered": "header", "/imu/data_raw": "header", "/joint_states": "header"}


class Listening(RunningRobotTest):
    """Writes down what is said on topics."""

    def echo(self, topic, kind=()):
        path = self.folder / f"echo{topic.replace('/', '_')}"
        with open(path, "w") as file:
            return path, self.start_program("topic", "echo", topic, *kind, "--json", stdout=file)

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
        echoes = {topic: self.echo(topic) for topic in (*STREAMS, "/tf", "/diagnostics")}
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

        for topic, key in STREAMS.items():
            with self.subTest(stream=topic):
                self.check_order([message[key]["stamp"] for message in self.lines(echoes[topic][0])])
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
        said = re.search(r"\[diff_drive\] (\d+) cycles \((\d+) skipped, (\d+) not written\)", (self.folder / "log").read_text())
        self.assertGreater(int(said[1]), 50)
        self.assertEqual((said[2], said[3]), ("0", "0"))

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
        echoes = {topic: self.echo(topic) for topic in (*self.STAMPED, "/tf")}
        for topic in echoes:
            wait_for(f"{topic} is heard", lambda: len(self.lines(echoes[topic][0])) > 2, 20)
        end_s = now_s()
        for _, process in echoes.values():
            process.send_signal(signal.SIGINT)
            process.wait(10 * SLOW)
        sender.stop()
        wait_for("the timeout does not wait for /clock", lambda: not truth.moves(), 5)
        ticks.stop()

        stamps = {topic: [message["header"]["stamp"] for message in self.lines(echoes[topic][0])] for topic in self.STAMPED}
        stamps["/tf"] = [t["header"]["stamp"] for message in self.lines(echoes["/tf"][0]) for t in message["transforms"]]
        for topic, of_topic in stamps.items():
            with self.subTest(stream=topic):
                times = [stamp["sec"] + stamp["nanosec"] * 1e-9 for stamp in of_topic]
                self.assertGreater(min(times), 999)
                self.assertLess(max(times), end_s + 10)


if __name__ == "__main__":
    unittest.main()
