# SPDX-License-Identifier: Apache-2.0
"""The stop: whichever part dies, the motor side sees zero in time, and nothing moves before the input was neutral and a new command came.

The world is a process of its own here, so that the container can be killed under it. Times are those of the simulated motor board:
CLOCK_MONOTONIC of the instant at which its aim became zero.
"""
import json
import mmap
import os
import pathlib
import signal
import struct
import subprocess
import time
import unittest

from control import BOOL, NAN, STAMPED, TWIST, Control, Sender, boolean, stamped, twist
from machines import Lines
from robot import LAUNCH_FILE, PROGRAM, SLOW, RobotTest, interrupt, nightly, wait_for

TIMEOUT_S, CYCLE_S, WATCHDOG_S, LEASE_S = 0.5, 0.02, 0.5, 0.5
MACHINE_S = 0.03  # for being scheduled on a busy machine; not part of the promise
SPEED = 0.2
TABLE = []


class Truth:
    """The world's truth file: magic, version, sequence (u32), padding, then one 64-bit word per field."""

    DOUBLES = "time_s x_m y_m yaw_rad speed_mps yaw_rate_rps left_command_mps right_command_mps".split()
    INTEGERS = "seed motion_commands last_motion_command_ns last_start_ns last_stop_ns starts stops watchdog_stops contacts".split()

    def __init__(self, path):
        with open(path, "rb") as file:
            self.map = mmap.mmap(file.fileno(), 0, access=mmap.ACCESS_READ)
        self.words_at = len(self.map) - 8 * (len(self.DOUBLES) + len(self.INTEGERS))
        self.words_at -= self.words_at % 8
        assert self.words_at == 16, self.words_at

    def __getattr__(self, name):
        form, index = ("<d", self.DOUBLES.index(name)) if name in self.DOUBLES else ("<q", len(self.DOUBLES) + self.INTEGERS.index(name))
        return struct.unpack_from(form, self.map, self.words_at + 8 * index)[0]  # an aligned word: never half of it

    def moves(self):
        return self.left_command_mps != 0 or self.right_command_mps != 0


class StopTest(RobotTest):
    PLUGIN = None

    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        cls.sim = cls.folder / "sim"
        cls.world = cls.start_program("sim", "world", "--dir", cls.sim)
        wait_for("the world is ready", lambda: (cls.sim / "ready").exists())
        cls.truth = Truth(cls.sim / "truth")
        cls.log = open(cls.folder / "log", "w+")
        cls.start_robot()

    @classmethod
    def start_robot(cls, *more):
        source = pathlib.Path(LAUNCH_FILE)
        text = source.read_text()
        text = text.replace("      name: diff_drive\n", "      name: diff_drive\n      resume: active\n")
        assert "resume: active" in text
        if cls.PLUGIN:
            text = text.replace("plugin: nacelle::diff_drive::DiffDriveComponent", f"plugin: {cls.PLUGIN}")
        file = cls.folder / "stop.launch.yaml"
        file.write_text(cls.plan(text))
        ports = [f"{name}_port:={cls.sim}/{name}" for name in ("lidar", "imu", "base")]
        cls.robot = cls.start_program(
            "launch", file, "sim:=false", "camera_device:=pattern", *ports, f"config:={source.parent}/config/robot.yaml",
            f"description:={source.parent}/robot.urdf", "--name", "robot", *more, stdout=cls.log)
        wait_for("the base is active", lambda: cls.state_of_the_base() == "active", 60)
        wait_for("the robot is running", lambda: "components active" in (cls.folder / "log").read_text().split("-- ")[-1], 60)
        cls.socket = cls.folder / "nacelle" / "robot.sock"

    @classmethod
    def plan(cls, text):
        return text

    @classmethod
    def state_of_the_base(cls):
        if cls.robot.poll() is not None:
            raise AssertionError("the robot ended: " + (cls.folder / "log").read_text())
        listed = cls.run_program("component", "list", "--json")
        rows = json.loads(listed.stdout)["components"] if listed.returncode == 0 else []
        return next((row["state"] for row in rows if row["node"] == "/diff_drive"), None)

    @classmethod
    def tearDownClass(cls):
        for process, how in ((cls.robot, signal.SIGINT if cls.PLUGIN is None else signal.SIGKILL), (cls.world, signal.SIGTERM)):
            if process.poll() is None:
                process.send_signal(how)
                process.communicate(timeout=30 * SLOW)
        cls.log.close()
        super().tearDownClass()

    def setUp(self):
        self.senders = []

    def tearDown(self):
        for sender in self.senders:
            sender.stop()

    def sender(self, make=lambda: twist(SPEED), type_name=TWIST, topic="/cmd_vel"):
        self.senders.append(Sender(self.socket, topic, type_name, make))
        return self.senders[-1]

    def moving(self):
        wait_for("the wheels are driven", self.truth.moves, 5)

    def zero_after(self, cause_ns, limit_s, case):
        """Asserts that the motor side is at zero within this time after the cause, and adds the time to the table."""
        wait_for("the wheels get zero", lambda: not self.truth.moves(), limit_s + 5)
        took_s = (self.truth.last_stop_ns - cause_ns) * 1e-9
        TABLE.append((case, took_s, limit_s))
        self.assertLessEqual(took_s, limit_s * SLOW + MACHINE_S * SLOW, case)

    def told(self, *words):
        """When a command began that has ended, in ns: its start is part of the time, its waits for a CPU of a busy machine are not."""
        begin = time.monotonic_ns()
        command = subprocess.Popen([PROGRAM, *words], env=self.environment, stdout=subprocess.DEVNULL)
        os.waitid(os.P_PID, command.pid, os.WEXITED | os.WNOWAIT)
        waited_ns = int(pathlib.Path(f"/proc/{command.pid}/schedstat").read_text().split()[1])
        self.assertEqual(command.wait(), 0)
        return begin + waited_ns

    def nothing_moves(self, for_s):
        """The board's aim stays at zero all the time: it counts its starts, so that no look is missed."""
        starts = self.truth.starts
        self.assertFalse(self.truth.moves())
        deadline = time.monotonic() + for_s
        wait_for("the time is over", lambda: time.monotonic() > deadline, for_s + 5)
        self.assertEqual(self.truth.starts, starts)
        self.assertFalse(self.truth.moves())

    def rests_and_moves_again(self, sender, make):
        """A sender that goes on is not followed; one that rests for a timeout and commands anew is."""
        self.nothing_moves(2 * TIMEOUT_S)
        sender.pause()
        self.nothing_moves(TIMEOUT_S + 0.1)
        sender.say(make)
        self.moving()


class Input(StopTest):
    def test_the_sender_is_killed(self):
        process = self.start_program("topic", "pub", "-r", "20", "/cmd_vel", TWIST, json.dumps({"linear": {"x": SPEED}}))
        self.moving()
        process.kill()
        cause = time.monotonic_ns()
        process.communicate()
        self.zero_after(cause, TIMEOUT_S + CYCLE_S, "sender killed")
        self.nothing_moves(1)
        self.sender()
        self.moving()

    def test_the_sender_hangs(self):
        process = self.start_program("topic", "pub", "-r", "20", "/cmd_vel", TWIST, json.dumps({"linear": {"x": SPEED}}))
        try:
            self.moving()
            process.send_signal(signal.SIGSTOP)
            self.zero_after(time.monotonic_ns(), TIMEOUT_S + CYCLE_S, "sender hung")
            self.nothing_moves(1)
        finally:
            process.kill()
            process.communicate()

    def test_stale_stamps(self):
        sender = self.sender(lambda: stamped(SPEED), STAMPED)
        self.moving()
        cause = sender.say(lambda: stamped(SPEED, age_s=2.0))
        self.zero_after(cause, TIMEOUT_S + CYCLE_S, "stale stamps")
        self.nothing_moves(0.3)
        sender.say(lambda: stamped(SPEED))
        self.rests_and_moves_again(sender, lambda: stamped(SPEED))

    def test_commands_that_are_no_numbers(self):
        sender = self.sender()
        self.moving()
        cause = sender.say(lambda: twist(NAN))
        self.zero_after(cause, TIMEOUT_S + CYCLE_S, "NaN commands")
        sender.say(lambda: twist(SPEED))
        self.rests_and_moves_again(sender, lambda: twist(SPEED))

    def test_absurd_commands(self):
        sender = self.sender()
        self.moving()
        cause = sender.say(lambda: twist(1e6))
        self.zero_after(cause, TIMEOUT_S + CYCLE_S, "absurd commands")
        sender.say(lambda: twist(SPEED))
        self.rests_and_moves_again(sender, lambda: twist(SPEED))

    def test_a_rest_of_zeros_is_a_rest(self):
        sender = self.sender()
        self.moving()
        self.expect_exit(self.run_program("estop", "set"), 0)
        wait_for("it stands", lambda: not self.truth.moves())
        self.expect_exit(self.run_program("estop", "release"), 0)
        self.nothing_moves(0.3)
        sender.say(lambda: twist(0.0))
        self.nothing_moves(TIMEOUT_S + 0.1)
        sender.say(lambda: twist(SPEED))
        self.moving()

    def test_an_operator_takes_over_from_navigation_and_gives_back(self):
        self.sender()
        wait_for("navigation drives", lambda: self.truth.left_command_mps == SPEED, 5)
        before = time.monotonic_ns()
        operator = self.sender(lambda: twist(-0.1), topic="/cmd_vel_teleop")
        wait_for("the wheels get another command", lambda: self.truth.left_command_mps != SPEED, 5)
        took_s = (time.monotonic_ns() - before) * 1e-9
        TABLE.append(("operator takes over", took_s, 0.1))
        self.assertLess(took_s, 0.1 * SLOW)
        wait_for("the operator drives", lambda: self.truth.left_command_mps == -0.1, 5)
        operator.pause()
        wait_for("navigation drives again", lambda: self.truth.left_command_mps == SPEED, 5)


class EmergencyStop(StopTest):
    def stop_and_release(self, case, set_stop, release):
        sender = self.sender()
        self.moving()
        cause = set_stop()
        self.zero_after(cause, CYCLE_S, case)
        self.nothing_moves(0.3)
        release()
        self.rests_and_moves_again(sender, lambda: twist(SPEED))

    def test_from_the_command_line(self):
        sender = self.sender()
        self.moving()
        self.zero_after(self.told("estop", "set"), 0.1, "nacelle estop set (with its start)")
        self.expect_exit(self.run_program("estop", "release"), 0)
        self.rests_and_moves_again(sender, lambda: twist(SPEED))

    def test_by_the_topic(self):
        control = Control(self.socket)
        handle = control.open_writer("/emergency_stop", BOOL)
        self.stop_and_release("e-stop by topic", lambda: control.publish(handle, boolean(True)), lambda: control.publish(handle, boolean(False)))
        control.close()

    def test_outlives_its_publisher_and_reaches_a_base_that_is_loaded_later(self):
        sender = self.sender()
        self.moving()
        self.expect_exit(self.run_program("lifecycle", "set", "/diff_drive", "deactivate"), 0)
        # Sooner than the board's watchdog would; the frame is on its way through a pty to another process.
        wait_for("the deactivated base rests", lambda: not self.truth.moves(), 0.2)
        self.expect_exit(self.run_program("estop", "set"), 0)
        self.expect_exit(self.run_program("component", "unload", "diff_drive"), 0)
        self.expect_exit(self.run_program("component", "load", "diff_drive"), 0)
        sender.pause()
        self.nothing_moves(TIMEOUT_S + 0.1)
        sender.say(lambda: twist(SPEED))
        self.nothing_moves(1)
        released = self.expect_exit(self.run_program("estop", "release", "--json"), 0)
        self.assertEqual(json.loads(released.stdout), {"emergency_stop": False, "topics": [{"name": "/emergency_stop", "readers": 1}]})
        self.rests_and_moves_again(sender, lambda: twist(SPEED))


class Guarded(StopTest):
    """emergency_stop_required: the base moves only while an emergency stop component is alive, which has its own process here."""

    @classmethod
    def plan(cls, text):
        port = "{name: serial_port, value: $(var base_port_used)}"
        assert text.count(port) == 1
        text = text.replace(port, port + ", {name: emergency_stop_required, value: true}")
        return text + "    - {pkg: nacelle_estop, plugin: nacelle::estop::EmergencyStopComponent, name: estop, isolate: process}\n"

    def process_of_the_stop(self):
        return wait_for("the process of the emergency stop", self.child_of_the_robot, 5)

    def child_of_the_robot(self):
        for entry in pathlib.Path("/proc").glob("[0-9]*"):
            try:
                words = (entry / "cmdline").read_bytes().split(b"\0")
                parent = int((entry / "stat").read_text().rsplit(")", 1)[1].split()[1])
            except (OSError, IndexError):
                continue
            if parent == self.robot.pid and b"/estop" in words:
                return int(entry.name)
        return None

    def load_it_anew(self):
        self.expect_exit(self.run_program("component", "unload", "estop"), 0)
        self.expect_exit(self.run_program("component", "load", "estop"), 0)

    def test_1_its_process_is_killed(self):
        sender = self.sender()
        self.moving()
        process, cause = self.process_of_the_stop(), time.monotonic_ns()
        os.kill(process, signal.SIGKILL)
        self.zero_after(cause, MACHINE_S + CYCLE_S, "required e-stop component killed")
        sender.pause()
        self.nothing_moves(TIMEOUT_S + 0.1)
        sender.say(lambda: twist(SPEED))
        self.nothing_moves(2 * TIMEOUT_S)
        self.assertIn("emergency_stop_required", (self.folder / "log").read_text())
        self.expect_exit(self.run_program("estop", "release"), 0)  # from a publisher without liveliness: not enough
        self.nothing_moves(TIMEOUT_S)
        self.load_it_anew()
        self.rests_and_moves_again(sender, lambda: twist(SPEED))

    def test_2_its_process_hangs_and_goes_on(self):
        sender = self.sender()
        self.moving()
        process = self.process_of_the_stop()
        os.kill(process, signal.SIGSTOP)
        try:
            self.zero_after(time.monotonic_ns(), LEASE_S + CYCLE_S, "required e-stop component hung")
            self.nothing_moves(0.3)
        finally:
            os.kill(process, signal.SIGCONT)
        self.rests_and_moves_again(sender, lambda: twist(SPEED))

    def test_3_it_is_deactivated(self):
        sender = self.sender()
        self.moving()
        cause = self.told("lifecycle", "set", "/estop", "deactivate")
        self.zero_after(cause, LEASE_S + CYCLE_S + 0.1, "e-stop component deactivated (with command)")
        self.nothing_moves(0.3)
        self.expect_exit(self.run_program("lifecycle", "set", "/estop", "activate"), 0)
        self.rests_and_moves_again(sender, lambda: twist(SPEED))


class Line(StopTest):
    def test_the_cable_is_pulled_and_put_back(self):
        sender = self.sender()
        self.moving()
        watchdog_stops = self.truth.watchdog_stops
        # As `nacelle sim unplug base` does, whose start would be part of the time.
        with open(self.sim / "control", "w", encoding="ascii") as control:
            cause = time.monotonic_ns()
            control.write("unplug base\n")
        self.zero_after(cause, WATCHDOG_S + CYCLE_S, "cable pulled (board's watchdog)")
        self.assertEqual(self.truth.watchdog_stops, watchdog_stops + 1, "nothing else can have stopped it")
        self.assertEqual(self.state_of_the_base(), "active")

        heard, back = self.truth.motion_commands, time.monotonic_ns()
        self.expect_exit(self.run_program("sim", "plug", "base", "--dir", self.sim), 0)
        wait_for("the board is commanded again", lambda: self.truth.motion_commands > heard, 5)
        took_s = (time.monotonic_ns() - back) * 1e-9
        TABLE.append(("cable put back: commands again", took_s, 2.0))
        self.assertLess(took_s, 2.0 * SLOW)
        self.rests_and_moves_again(sender, lambda: twist(SPEED))
        joints = self.streams()["/joint_states"]["published"]
        wait_for("joint states go on", lambda: self.streams()["/joint_states"]["published"] > joints)
        self.assertEqual(self.faults()["components"], [])
        last = self.faults()["history"][-1]
        self.assertEqual((last["node"], last["code"], last["open"]), ("/diff_drive", "DEVICE_LOST", False))

    @nightly
    def test_every_sensors_cable_comes_back_and_the_robot_stays_active(self):
        for device, node, topic in (("lidar", "/lidar", "/scan"), ("imu", "/imu", "/imu/data")):
            with self.subTest(device=device):
                self.expect_exit(self.run_program("sim", "unplug", device, "--dir", self.sim), 0)
                pulled = time.monotonic()
                wait_for("the open fault", lambda: self.open_fault(node), 5)
                TABLE.append((f"{device} unplugged: open fault (with command)", time.monotonic() - pulled, 0.5 + 0.5))
                self.assertLess(time.monotonic() - pulled, (0.5 + 0.5) * SLOW)
                self.assertTrue(self.open_fault(node).startswith("DEVICE_LOST"))
                self.assertEqual(self.state_of(node), "active")
                diagnostics = Lines([PROGRAM, "topic", "echo", "/diagnostics"], self.environment)
                try:
                    diagnostics.wait_for("/diagnostics says so", lambda line: "DEVICE_LOST" in line, 10)
                finally:
                    diagnostics.interrupt()
                time_to_lose = 3  # the time after which it was faulted for good
                wait_for("three seconds are over", lambda: time.monotonic() - pulled > time_to_lose)
                heard = self.streams()[topic]["published"]
                self.expect_exit(self.run_program("sim", "plug", device, "--dir", self.sim), 0)
                back = time.monotonic()
                wait_for("data flows", lambda: self.streams()[topic]["published"] > heard, 5)
                TABLE.append((f"{device} plugged: data (with command)", time.monotonic() - back, 2.0))
                self.assertLess(time.monotonic() - back, 2.0 * SLOW)
                wait_for("the fault is over", lambda: not self.open_fault(node), 5)
                self.assertEqual(self.state_of(node), "active")

    def faults(self):
        return json.loads(self.expect_exit(self.run_program("faults", "--json"), 0).stdout)

    def open_fault(self, node):
        rows = [row for row in self.faults()["components"] if row["node"] == node]
        return "".join(f"{fault['code']}: {fault['text']}" for row in rows for fault in row.get("open_faults", []))

    def state_of(self, node):
        rows = json.loads(self.expect_exit(self.run_program("component", "list", "--json"), 0).stdout)["components"]
        return next(row["state"] for row in rows if row["node"] == node)

    def streams(self):
        return {row["name"]: row for row in json.loads(self.expect_exit(self.run_program("streams", "--json", "--interval", "0.1"), 0).stdout)["streams"]}


class Absent(RobotTest):
    def test_a_robot_without_its_devices_comes_up_names_them_and_takes_them_when_they_are_there(self):
        sim, source = self.folder / "sim", pathlib.Path(LAUNCH_FILE)
        ports = [f"{name}_port:={sim}/{name}" for name in ("lidar", "imu", "base")]
        with open(self.folder / "log", "w+") as log:
            robot = self.start_program("launch", source, "sim:=false", f"camera_device:={sim}/camera", *ports, "--name", "robot", stdout=log)
        self.addCleanup(interrupt, robot)
        said = lambda: (self.folder / "log").read_text()
        wait_for("the last line of the launch", lambda: "absent devices" in said(), 60)
        last = said().splitlines()[-1]
        for node in ("/lidar", "/imu", "/diff_drive", "/camera"):
            self.assertIn(f"{node} (DEVICE_LOST: ", last)
        listed = json.loads(self.expect_exit(self.run_program("component", "list", "--json"), 0).stdout)["components"]
        self.assertEqual({row["state"] for row in listed}, {"active"})

        world = self.start_program("sim", "world", "--dir", sim, stdout=subprocess.DEVNULL)
        self.addCleanup(interrupt, world)
        # The world has no camera.
        wait_for("every device is there", lambda: [row["node"] for row in json.loads(self.run_program("faults", "--json").stdout)["components"]] == ["/camera"], 20)
        for topic in ("/scan", "/imu/data", "/joint_states"):
            self.expect_exit(self.run_program("topic", "echo", topic, "--once"), 0)


class Frozen(StopTest):
    def test_a_suspended_container_follows_only_inputs_that_have_rested(self):
        sender = self.sender()
        self.moving()
        watchdog_stops = self.truth.watchdog_stops
        os.kill(self.robot.pid, signal.SIGSTOP)
        try:
            self.zero_after(time.monotonic_ns(), WATCHDOG_S + CYCLE_S, "container stopped (board's watchdog)")
        finally:
            os.kill(self.robot.pid, signal.SIGCONT)
        self.assertEqual(self.truth.watchdog_stops, watchdog_stops + 1)
        self.rests_and_moves_again(sender, lambda: twist(SPEED))


class Interrupted(StopTest):
    CHAOS = "nacelle::test::Chaos"

    def test_the_wheels_stop_before_the_container_waits_for_anything(self):
        self.expect_exit(self.run_program("component", "load", self.CHAOS, "--name", "slow"), 0)
        self.sender()
        self.moving()
        # It will not answer for as long as the container waits for it.
        self.expect_exit(self.run_program("topic", "pub", "--once", "/slow/do", "std_msgs/msg/String", '{"data": "hang"}'), 0)
        self.robot.send_signal(signal.SIGINT)
        self.zero_after(time.monotonic_ns(), CYCLE_S, "SIGINT while a component hangs")
        starts = self.truth.starts
        self.robot.wait(30 * SLOW)
        self.assertEqual(self.truth.starts, starts)


class Killed(StopTest):
    def test_the_container_is_killed_and_its_successor_moves_nothing_by_itself(self):
        self.sender()
        self.moving()
        watchdog_stops = self.truth.watchdog_stops
        os.kill(self.robot.pid, signal.SIGKILL)
        cause = time.monotonic_ns()
        self.robot.wait()
        self.zero_after(cause, CYCLE_S, "container SIGKILLed (its watcher process)")
        self.assertEqual(self.truth.watchdog_stops, watchdog_stops, "the board's own watchdog found the wheels at rest")
        starts = self.truth.starts
        self.log.write("-- \n")
        self.log.flush()
        type(self).start_robot()
        self.nothing_moves(1)
        self.assertEqual(self.truth.starts, starts)
        self.sender()
        self.moving()

    def test_an_emergency_stop_outlives_the_container(self):
        """The base comes back active by itself: `resume: active`."""
        self.sender()
        self.moving()
        self.expect_exit(self.run_program("estop", "set"), 0)
        wait_for("it stands", lambda: not self.truth.moves())
        state = self.folder / "nacelle" / "robot.composition"
        wait_for("it is kept", lambda: json.loads(state.read_text())["emergency_stops"] == ["/emergency_stop"])
        os.kill(self.robot.pid, signal.SIGKILL)
        self.robot.wait()
        for sender in self.senders:
            sender.stop()
        self.log.write("-- \n")
        self.log.flush()
        type(self).start_robot("--resume")
        sender = self.sender()
        self.nothing_moves(2 * TIMEOUT_S)
        self.assertIn("the emergency stop /emergency_stop was set and still is", (self.folder / "log").read_text())
        self.expect_exit(self.run_program("estop", "release"), 0)
        self.rests_and_moves_again(sender, lambda: twist(SPEED))


class Hung(StopTest):
    PLUGIN = "nacelle::test::HangingBase"

    def test_the_callback_of_the_base_hangs(self):
        self.sender()
        self.moving()
        control = Control(self.socket)
        handle = control.open_writer("/diff_drive/hang", BOOL)
        self.zero_after(control.publish(handle, boolean(True)), TIMEOUT_S + CYCLE_S, "base's callback hung")
        control.close()

        def fault():
            listed = json.loads(self.expect_exit(self.run_program("component", "list", "--json"), 0).stdout)
            return next((row.get("fault") for row in listed["components"] if row["node"] == "/diff_drive"), None)

        self.assertIn("diff_drive", json.dumps(wait_for("it is named", fault, 10)))
        self.nothing_moves(1)


def tearDownModule():
    print("\n  from the cause to zero at the motor board\n" + "\n".join(
        f"    {case:<42} {took * 1e3:7.1f} ms   (limit {limit * 1e3:.0f} ms)" for case, took, limit in TABLE))


if __name__ == "__main__":
    unittest.main()
