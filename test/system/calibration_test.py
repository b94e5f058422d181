# SPDX-License-Identifier: Apache-2.0
"""`nacelle base calibrate` and `nacelle imu calibrate` with a robot whose errors are known: the file that they write mends them."""
import json
import math
import os
import pathlib
import pty
import random
import re
import signal
import struct
import subprocess
import threading
import time
import unittest

from robot import LAUNCH_FILE, PROGRAM, SLOW, RobotTest, RunningRobotTest, interrupt, wait_for

CONFIG = os.path.join(os.path.dirname(LAUNCH_FILE), "config", "robot.yaml")
DESCRIPTION = os.path.join(os.path.dirname(LAUNCH_FILE), "robot.urdf")


class Talk:
    """A calibration that asks, and the user who answers."""

    def __init__(self, words, environment):
        self.process = subprocess.Popen([PROGRAM, *words], env=environment, stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=subprocess.PIPE,
                                        start_new_session=True)  # fmt: skip
        self.said, self.read_to = "", 0
        self.reader = threading.Thread(target=self._read)
        self.reader.start()

    def _read(self):
        while piece := os.read(self.process.stderr.fileno(), 4096):
            self.said += piece.decode()

    def expect(self, pattern, limit_s=120.0):
        """Waits until it says so, behind what was expected before; returns the match."""

        def found():
            return re.search(pattern, self.said[self.read_to :]) or self.process.poll() is not None

        try:
            match = wait_for(f"'{pattern}'", found, limit_s)
        except AssertionError as late:
            raise AssertionError(f"{late}: {self.said}") from None
        if match is True:
            self.reader.join()
            match = re.search(pattern, self.said[self.read_to :])
        if not match:
            raise AssertionError(f"it ended without '{pattern}': {self.said}")
        self.read_to += match.end()
        return match

    def answer(self, text=""):
        self.process.stdin.write((text + "\n").encode())
        self.process.stdin.flush()

    def end(self, limit_s=60.0):
        """Returns its exit code."""
        code = self.process.wait(limit_s * SLOW)
        self.reader.join()
        return code

    def close(self):
        if self.process.poll() is None:
            self.process.kill()
        self.process.wait()
        self.reader.join()
        for pipe in (self.process.stdin, self.process.stdout, self.process.stderr):
            pipe.close()


class BaseRobot(RunningRobotTest):
    """The simulated robot; its base has the parameters of self.base beside those of the default configuration."""

    base = ""

    @classmethod
    def make_launch_file(cls):
        """The default one with one more file for the base, as its user would add it."""
        extra = cls.folder / "base.yaml"
        extra.write_text(cls.base)
        text = pathlib.Path(LAUNCH_FILE).read_text(encoding="utf-8")
        before = "param: [{from: $(var config)}, {name: serial_port"
        assert text.count(before) == 1
        file = cls.folder / "robot.launch.yaml"
        file.write_text(text.replace(before, f"param: [{{from: $(var config)}}, {{from: {extra}}}, {{name: serial_port"))
        cls.arguments = (f"config:={CONFIG}", f"description:={DESCRIPTION}")
        return file

    def truth(self):
        return json.loads(self.expect_exit(self.run_program("sim", "truth", "--dir", f"{self.folder}/sim"), 0).stdout)

    def talk(self, *words, wait_s=60, output="out.yaml"):
        # Patient: another test may have the processor.
        talk = Talk(("base", "calibrate", "--wait", str(wait_s), "--output", str(self.folder / output), *words), self.environment)
        self.addCleanup(talk.close)
        return talk

    def calibrate(self):
        """Answers with what the world says. Returns the errors that the base had: believed over real, of distance and turn."""
        talk = self.talk("--distance", "1.0", "--turns", "1", "--speed", "0.3", "--turn", "1.2")
        talk.expect("drive 1.00 m ahead.*then press Enter")
        before = self.truth()
        talk.answer()
        drove = float(talk.expect(r"by its wheels it drove ([0-9.]+) m").group(1))
        talk.expect("how many metres")
        after = self.truth()
        self.assertEqual((after["left_command_mps"], after["right_command_mps"]), (0, 0))
        real_m = math.hypot(after["x_m"] - before["x_m"], after["y_m"] - before["y_m"])
        talk.answer("a metre")  # no number: it asks again
        talk.expect("'a metre' is no number above zero")
        talk.expect("how many metres")
        talk.answer(f"{real_m:.4f}")
        talk.expect("turn 1.00 times.*then press Enter")
        before = self.truth()
        talk.answer()
        turned = float(talk.expect(r"by its wheels it turned ([0-9.]+) times").group(1))
        talk.expect("how many turns")
        real_turns = (self.truth()["yaw_rad"] - before["yaw_rad"]) / (2 * math.pi)
        talk.answer(f"{real_turns:.5f}")
        self.assertEqual(talk.end(), 0, talk.said)
        self.assertIn(b"param: [{from: ", talk.process.stdout.read())
        # The second figure was believed with the corrected radius, so it shows the separation's error alone.
        return drove / real_m, turned / real_turns


WRONG_BASE = """/diff_drive:
  ros__parameters:
    left_wheel_radius_multiplier: 1.15
    right_wheel_radius_multiplier: 1.15
    wheel_separation_multiplier: 0.85
"""


class Base(BaseRobot):
    base = WRONG_BASE

    def test_the_written_file_mends_the_wheels(self):
        distance, turn = self.calibrate()
        self.assertAlmostEqual(distance, 1.15, delta=0.03)
        self.assertAlmostEqual(turn, 1 / 0.85, delta=0.05)
        written = (self.folder / "out.yaml").read_text()
        values = {name: float(value) for name, value in re.findall(r"^    (\w+): ([0-9.]+)$", written, re.MULTILINE)}
        # The world's wheels are within 0.3 % of the description, its separation within a few.
        self.assertAlmostEqual(values.pop("left_wheel_radius_multiplier"), 1.0, delta=0.02)
        self.assertAlmostEqual(values.pop("right_wheel_radius_multiplier"), 1.0, delta=0.02)
        self.assertAlmostEqual(values.pop("wheel_separation_multiplier"), 1.0, delta=0.05)
        self.assertEqual(values, {})

        class Mended(BaseRobot):
            base = written

        Mended.setUpClass()
        try:
            mended = Mended()
            distance, turn = mended.calibrate()
            mended.doCleanups()
        finally:
            Mended.tearDownClass()
        self.assertAlmostEqual(distance, 1.0, delta=0.02)
        self.assertAlmostEqual(turn, 1.0, delta=0.02)

    def test_a_gyro_measures_the_turns(self):
        # Readings that are lost on a busy machine make it no measurement: then once more.
        for _ in range(5):
            before = self.truth()["yaw_rad"]
            talk = self.talk("--distance", "0", "--turns", "1", "--turn", "1.2", "--turns-by", "imu/data_raw", "--yes", output="by_gyro.yaml")
            code = talk.end(180)
            if "readings are missing" not in talk.said:
                break
        self.assertEqual(code, 0, talk.said)
        turns = float(re.search(r"by the gyro it turned ([0-9.]+) times", talk.said).group(1))
        self.assertAlmostEqual(turns, (self.truth()["yaw_rad"] - before) / (2 * math.pi), delta=0.01)
        (separation,) = re.findall(r"^    wheel_separation_multiplier: ([0-9.]+)$", (self.folder / "by_gyro.yaml").read_text(), re.MULTILINE)
        # The radius is 15 % too large still, and so becomes the separation.
        self.assertAlmostEqual(float(separation), 1.15, delta=0.05)

    def test_ctrl_c_stops_the_wheels_and_writes_nothing(self):
        out = self.folder / "interrupted.yaml"
        talk = self.talk("--distance", "0", "--turns", "20", "--yes", output=out.name)
        wait_for("the robot turns", lambda: self.truth()["yaw_rate_rps"] > 0.1, 60)
        talk.process.send_signal(signal.SIGINT)
        self.assertEqual(talk.end(), 130, talk.said)
        wait_for("the wheels stand", lambda: self.truth()["left_command_mps"] == 0)
        self.assertIn("nothing was written", talk.said)
        self.assertFalse(out.exists())
        # While it waits for an answer as well.
        talk = self.talk("--distance", "0", output=out.name)
        talk.expect("then press Enter")
        talk.process.send_signal(signal.SIGINT)
        self.assertEqual(talk.end(), 130, talk.said)
        self.assertFalse(out.exists())

    def test_lost_wheels_stop_the_robot_and_end_it(self):
        out = self.folder / "lost.yaml"
        talk = self.talk("--distance", "0", "--turns", "20", "--yes", wait_s=5, output=out.name)
        wait_for("the robot turns", lambda: self.truth()["yaw_rate_rps"] > 0.1, 60)
        self.expect_exit(self.run_program("sim", "unplug", "base", "--dir", f"{self.folder}/sim"), 0)
        try:
            self.assertEqual(talk.end(), 1, talk.said)
        finally:
            self.expect_exit(self.run_program("sim", "plug", "base", "--dir", f"{self.folder}/sim"), 0)
        self.assertIn("topic /joint_states: no position of the wheels came any more", talk.said)
        self.assertFalse(out.exists())
        wait_for("the wheels stand", lambda: self.truth()["left_command_mps"] == 0)
        # They do not turn by themselves when the board is back.
        wait_for("the base is back", lambda: "left_wheel_joint" in self.run_program("topic", "echo", "/joint_states", "--once", limit_s=30).stdout)
        self.assertEqual(self.truth()["left_command_mps"], 0)

    def test_what_is_no_calibration_is_refused(self):
        out = self.folder / "refused.yaml"
        talk = self.talk("--distance", "0", "--turns", "0.25", "--measured-turns", "90", "--yes", output=out.name)
        self.assertEqual(talk.end(120), 1, talk.said)
        self.assertIn("more than a factor of two is no calibration; check the unit", talk.said)
        self.assertFalse(out.exists())
        for words, code, said in ((("--distance", "0", "--turns", "0"), 2, "neither a distance nor turns"),
                                  (("--node", "imu"), 1, "is not a nacelle::diff_drive::DiffDriveComponent"),
                                  (("--node", "odometry"), 1, "is not a nacelle::diff_drive::DiffDriveComponent"),
                                  (("--node", "diff_drvie"), 1, "did you mean"),
                                  (("--output", "/nowhere/out.yaml"), 1, "cannot be written"),
                                  (("--output", str(self.folder)), 1, "it is a folder"),
                                  (("--container", "none"), 3, "none")):  # fmt: skip
            outcome = self.expect_exit(self.run_program("base", "calibrate", *words, stdin=subprocess.DEVNULL), code)
            self.assertIn(said, outcome.stderr)
        outcome = self.expect_exit(self.run_program("base", "calibrate", stdin=subprocess.DEVNULL), 1)
        self.assertIn("stdin: ended before the answer", outcome.stderr)


class Wt901:
    """A WT901 on a pty, as its data sheet describes the frames; sends 100 samples/s of what the test sets, with noise."""

    GYRO_BIAS_DPS = (1.5, -2.0, 0.8)
    ACCEL_BIAS_G, ACCEL_SCALE = (0.03, -0.02, 0.05), (1.02, 0.98, 1.01)
    HARD_IRON, FIELD = (120.0, -80.0, 60.0), 300.0  # counts
    SOFT_IRON = ((1.1, 0.05, 0.0), (0.05, 0.95, 0.02), (0.0, 0.02, 1.0))

    def __init__(self, link):
        self.master, slave = pty.openpty()
        os.set_blocking(self.master, False)
        os.symlink(os.ttyname(slave), link)
        self.slave = slave  # kept open: a line without a reader must not hang up
        self.up, self.shake_g, self.turns, self.speaks = (0.0, 0.0, 1.0), 0.0, None, True
        self.draws = random.Random(17)
        self.samples = 0
        self.ends = False
        self.thread = threading.Thread(target=self._run)
        self.thread.start()

    def close(self):
        self.ends = True
        self.thread.join()
        os.close(self.master)
        os.close(self.slave)

    @staticmethod
    def _frame(kind, values):
        body = struct.pack("<BB4h", 0x55, kind, *(max(-32768, min(32767, round(v))) for v in values))
        return body + bytes([sum(body) & 0xFF])

    def _field(self):
        """Of a sensor that is turned through the directions that `turns` names: one after another, each far from the last."""
        angle = self.samples * 2.399963
        z = ((self.samples * 0.618034) % 2.0) - 1.0 if self.turns == "all" else 0.0
        if self.turns == "half":
            angle %= math.pi / 2
        if self.turns is None:
            angle = 0.0
        r = math.sqrt(1.0 - z * z)
        return (self.FIELD * r * math.cos(angle), self.FIELD * r * math.sin(angle), self.FIELD * z)

    def _sample(self):
        noise = self.draws.gauss
        g = [s * u + b + noise(0, 0.002) + noise(0, 1) * self.shake_g for s, u, b in zip(self.ACCEL_SCALE, self.up, self.ACCEL_BIAS_G)]
        dps = [b + noise(0, 0.1) for b in self.GYRO_BIAS_DPS]
        field = self._field()
        counts = [sum(m * f for m, f in zip(row, field)) + b for row, b in zip(self.SOFT_IRON, self.HARD_IRON)]
        return b"".join(
            self._frame(kind, values)
            for kind, values in (
                (0x51, [v / 16 * 32768 for v in g] + [2500]),
                (0x52, [v / 2000 * 32768 for v in dps] + [2500]),
                (0x53, [0, 0, 0, 0]),
                (0x54, counts + [2500]),
                (0x59, [32767, 0, 0, 0]),
            )
        )

    def _run(self):
        due = time.monotonic()
        while not self.ends:
            due = max(due + 0.01, time.monotonic())
            if self.speaks:
                try:
                    os.write(self.master, self._sample())
                except BlockingIOError:
                    pass  # nobody reads yet
                self.samples += 1
            try:
                os.read(self.master, 4096)  # commands: this one needs none
            except BlockingIOError:
                pass
            time.sleep(max(0.0, due - time.monotonic()))  # the device's rate, not a synchronisation


SIDES = {"+x": (1, 0, 0), "-x": (-1, 0, 0), "+y": (0, 1, 0), "-y": (0, -1, 0), "+z": (0, 0, 1), "-z": (0, 0, -1)}


class Imu(RobotTest):
    def setUp(self):
        self.place = self.folder / self.id().rpartition(".")[2]
        self.place.mkdir()
        self.device = Wt901(self.place / "imu")
        self.addCleanup(self.device.close)
        self.robot = None
        self.launch("")

    def launch(self, more):
        """Starts the robot anew, with more parameters for the IMU."""
        if self.robot:
            interrupt(self.robot)
        file = self.place / "imu.launch.yaml"
        # Mounted turned, so that the axes of sensor and frame differ.
        file.write_text(f"""launch:
- node_container:
    name: robot
    composable_node:
    - pkg: nacelle_imu
      plugin: nacelle::imu::ImuComponent
      name: imu
      param:
      - {{name: port, value: {self.place}/imu}}
      - {{name: calibrate_gyro, value: false}}
      - {{name: mounting_rpy, value: [0.0, 0.0, 1.5707963267948966]}}
{more}""")
        log = open(self.place / "log", "w", encoding="utf-8")
        self.addCleanup(log.close)
        self.robot = self.start_program("launch", file, "--name", "robot", stdout=log, stderr=subprocess.STDOUT)
        self.addCleanup(interrupt, self.robot)

        def is_up():
            if self.robot.poll() is not None:
                raise AssertionError("the robot ended: " + (self.place / "log").read_text())
            return "active [3]" in self.run_program("lifecycle", "get", "imu").stdout

        wait_for("the IMU is active", is_up, 60)

    def talk(self, *words, wait_s=60):
        talk = Talk(("imu", "calibrate", "--wait", str(wait_s), "--rest", "2", "--turn", "3", "--output", str(self.place / "out.yaml"), *words),
                    self.environment)  # fmt: skip
        self.addCleanup(talk.close)
        return talk

    def readings(self, topic, field, count=100):
        """The mean vector of some messages."""
        echo = self.start_program("topic", "echo", topic, "--json", stderr=subprocess.DEVNULL)
        try:
            vectors = [json.loads(echo.stdout.readline())[field] for _ in range(count)]
        finally:
            interrupt(echo)
            echo.stdout.close()
        return [[v["x"], v["y"], v["z"]] for v in vectors]

    @staticmethod
    def mean(vectors):
        return [sum(axis) / len(vectors) for axis in zip(*vectors)]

    def set_side(self, name):
        self.device.up = tuple(map(float, SIDES[name]))

    def test_the_written_file_mends_all_three_sensors(self):
        talk = self.talk()
        talk.expect("gyro: put the robot down.*then press Enter")
        talk.answer()
        talk.expect("gyro: bias")
        for number, side in enumerate(SIDES, 1):
            self.set_side(side)
            # A reading may still be on its way from the side before: then it is asked once more.
            while True:
                talk.expect(f"side {number} of 6.*then press Enter")
                talk.answer()
                if talk.expect("is up: |is up again; choose another side|it moved").group() == "is up: ":
                    break
            if number == 1:
                # What is held in the hand does not count.
                self.device.shake_g = 0.2
                talk.expect("side 2 of 6.*then press Enter")
                talk.answer()
                talk.expect("it moved")
                self.device.shake_g = 0.0
        self.device.turns = "all"
        talk.expect("magnetometer: turn the robot(.|\n)*then press Enter")
        talk.answer()
        self.assertEqual(talk.end(120), 0, talk.said)
        self.assertIn(b"param: [{from: ", talk.process.stdout.read())

        self.launch(f"      - {{from: {self.place / 'out.yaml'}}}\n")
        for axis in self.mean(self.readings("/imu/data_raw", "angular_velocity")):
            self.assertAlmostEqual(axis, 0.0, delta=0.002)
        for side, up in SIDES.items():
            self.set_side(side)
            # The frame is the sensor turned by a quarter about z.
            expected = [9.80665 * v for v in (-up[1], up[0], up[2])]

            def fits(expected=expected):
                seen = self.mean(self.readings("/imu/data_raw", "linear_acceleration", 50))
                return all(abs(s - e) < 0.03 for s, e in zip(seen, expected))

            wait_for(f"gravity on {side}", fits)
        lengths = [math.hypot(*v) for v in self.readings("/imu/mag", "magnetic_field", 200)]
        mean = sum(lengths) / len(lengths)
        self.assertLess(max(abs(length / mean - 1.0) for length in lengths), 0.02)

    def test_a_robot_that_cannot_be_tilted_gets_a_flat_calibration_beside_what_it_had(self):
        before = "      - {name: accel_bias, value: [0.1, 0.2, 0.3]}\n"
        self.launch(before)
        self.device.turns = "flat"
        talk = self.talk("--mag")
        talk.expect("magnetometer: turn the robot(.|\n)*then press Enter")
        talk.answer()
        self.assertEqual(talk.end(120), 0, talk.said)
        self.assertIn("x and y are calibrated", talk.said)
        self.assertIn("accel_bias: [0.100000000, 0.200000000, 0.300000000]", (self.place / "out.yaml").read_text())
        self.launch(f"      - {{from: {self.place / 'out.yaml'}}}\n")
        lengths = [math.hypot(*v[:2]) for v in self.readings("/imu/mag", "magnetic_field", 200)]
        mean = sum(lengths) / len(lengths)
        self.assertLess(max(abs(length / mean - 1.0) for length in lengths), 0.02)

    def test_bad_data_are_refused_and_nothing_is_written(self):
        out = self.place / "out.yaml"
        self.device.shake_g = 0.2
        talk = self.talk("--gyro")
        talk.answer()
        self.assertEqual(talk.end(), 1, talk.said)
        self.assertIn("/imu: gyro: it moved", talk.said)
        self.device.shake_g = 0.0
        self.device.turns = "half"
        talk = self.talk("--mag")
        talk.answer()
        self.assertEqual(talk.end(120), 1, talk.said)
        self.assertIn("/imu: magnetometer: ", talk.said)
        talk = self.talk("--accel")
        talk.expect("side 1 of 6.*then press Enter")
        talk.process.send_signal(signal.SIGINT)
        self.assertEqual(talk.end(), 130, talk.said)
        self.assertIn("nothing was written", talk.said)
        self.device.speaks = False
        talk = self.talk("--gyro", wait_s=1)
        talk.answer()
        self.assertEqual(talk.end(), 1, talk.said)
        self.assertIn("topic /imu/data_raw: no message came for 1 s; is its node active?", talk.said)
        self.assertFalse(out.exists())


if __name__ == "__main__":
    unittest.main()
