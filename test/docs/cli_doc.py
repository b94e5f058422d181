#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""docs/cli.md: every command once, with what it really printed on the simulated robot.

usage: cli_doc.py --write    runs all examples on a simulated robot and writes docs/cli.md anew
       cli_doc.py [-v]       the tests: each command has an example, and each example runs

Of the program in build/, unless NACELLE_PROGRAM and NACELLE_LAUNCH_FILE name another one, as in the system tests.
"""
import dataclasses
import json
import os
import pathlib
import pty
import re
import shlex
import signal
import subprocess
import sys
import threading
import unittest

ROOT = pathlib.Path(__file__).resolve().parents[2]
os.environ.setdefault("NACELLE_PROGRAM", str(ROOT / "build" / "bin" / "nacelle"))
os.environ.setdefault("NACELLE_LAUNCH_FILE", str(ROOT / "launch" / "robot.launch.yaml"))
sys.path.insert(0, str(ROOT / "test" / "system"))
from machines import enter_own_network  # noqa: E402
from robot import PROGRAM, SLOW, RunningRobotTest, wait_for  # noqa: E402

DOCUMENT = ROOT / "docs" / "cli.md"
LONGEST_LINE, MOST_LINES = 150, 24


@dataclasses.dataclass
class Example:
    """One command line behind `nacelle`, in the words of a shell."""

    line: str
    before: tuple = ()  # lines that are run first and not shown
    after: tuple = ()  # lines that put back what it has changed
    ends: float | None = None  # Ctrl-C after so many seconds; None: it ends by itself
    keys: str | None = None  # typed on a terminal, one each tenth of a second; then Ctrl-C
    stdin: str = ""
    exit_codes: tuple = (0,)
    lines: int = MOST_LINES  # that are shown
    silent: bool = False  # it prints nothing when all is well


# In the order of the document; the command's path is what stands in front of options and names. A command that this program
# does not have is left out, so that the table may run ahead of it. One line is one example.
# Where the robot itself has none of its kind: components of the tests.
CHAOS, NO_CHAOS = ("component load nacelle::test::Chaos --name chaos",), ("component unload chaos",)
SERIES = ("component load nacelle::test::Series --name series",)
EXAMPLES = (
    Example("launch launch/robot.launch.yaml sim:=true sim_dir:=launch-sim --name second -v", ends=4, lines=14),
    Example("container --name empty -v", ends=1),
    Example("drive --for 3 --seed 1"),
    Example("component list"),
    Example("component info lidar", lines=40),
    Example("component types"),
    Example("component unload camera", after=("component load camera",)),
    Example("component load camera", before=("component unload camera",)),
    Example("lifecycle nodes"),
    Example("lifecycle get lidar"),
    Example("lifecycle list lidar"),
    Example("lifecycle set monitor_2 deactivate", after=("lifecycle set monitor_2 activate",)),
    Example("node list"),
    Example("node info /lidar", lines=40),
    Example("topic list -t"),
    Example("topic info /scan -v", lines=40),
    Example("topic type /scan"),
    Example("topic find sensor_msgs/msg/Imu"),
    Example("topic echo /odom --once", lines=40),
    Example("topic hz /imu/data_raw --once"),
    Example("topic bw /camera/image_raw --once"),
    Example("topic delay /scan --once"),
    Example("topic pub --once /cmd_vel geometry_msgs/msg/Twist '{\"linear\": {\"x\": 0.1}}'"),
    Example("service list -t"),
    Example("service type /robot/_container/list_nodes"),
    Example("service find std_srvs/srv/Empty"),
    Example("service call /robot/_container/list_nodes composition_interfaces/srv/ListNodes"),
    Example("action list -t", before=SERIES, after=("component unload series",)),
    Example("action info /series/series -t", before=SERIES, after=("component unload series",)),
    Example("action type /series/series", before=SERIES, after=("component unload series",)),
    Example("action find example_interfaces/action/Fibonacci", before=SERIES, after=("component unload series",)),
    Example("action send_goal /series/series example_interfaces/action/Fibonacci '{order: 5}' --feedback", before=SERIES,
            after=("component unload series",), lines=40),
    Example("param list lidar"),
    Example("param get lidar frame_id"),
    Example("param describe lidar frame_id range_max"),
    Example("param set chaos share 0.75", before=CHAOS, after=NO_CHAOS),
    Example("param dump lidar"),
    Example("param load chaos chaos.yaml", before=CHAOS, after=NO_CHAOS),
    Example("param delete chaos loose", before=CHAOS, after=NO_CHAOS),
    Example("tf tree"),
    Example("tf echo odom lidar_link --once"),
    Example("tf monitor odom lidar_link --once --interval 2"),
    Example("streams --once", lines=30),
    Example("top --once --interval 2"),
    Example("faults", lines=40),
    Example("check launch/robot.launch.yaml"),
    Example("params --explain lidar launch/robot.launch.yaml"),
    Example("import driver.yaml"),
    Example("qos check launch/robot.launch.yaml"),
    Example("qos explain --offered reliability=best_effort --requested reliability=reliable"),
    Example("doctor", exit_codes=(0, 1), lines=40),  # what is wrong with the machine that wrote this page is its own affair
    Example("doctor net", lines=40),
    Example("export on", after=("export off",)),
    Example("export off"),
    Example("security create-keystore keys"),
    Example("security create-enclave keys /robot"),
    Example("security list-enclaves keys"),
    Example("security generate-policy policy.xml --enclave /robot"),
    Example("security create-permission keys /robot policy.xml"),
    Example("estop set", after=("estop release",)),
    Example("estop release", before=("estop set",)),
    Example("teleop", keys="iik", lines=20),
    Example("sim world --dir world -v", ends=2),
    Example("sim truth --dir sim"),
    Example("sim unplug --dir sim imu", after=("sim plug --dir sim imu",), silent=True),
    Example("sim plug --dir sim imu", before=("sim unplug --dir sim imu",), silent=True),
    Example("interface list --package std_srvs"),
    Example("interface show std_srvs/srv/SetBool"),
    Example("interface hash sensor_msgs/msg/Imu"),
    Example("interface encode std_msgs/msg/Bool", stdin='{"data": true}'),
    Example("interface decode std_msgs/msg/Bool", stdin="0001000001"),
    Example("xacro robot.xacro width:=0.3"),
    Example("completion bash", lines=8),
)

HEADINGS = {
    "launch": "Start", "component": "Components", "node": "Graph", "param": "Parameters", "tf": "Frames", "streams": "What it costs",
    "faults": "What is wrong", "security": "Security", "estop": "Stop and drive", "sim": "The simulated robot", "interface": "Messages and files",
}  # fmt: skip

INTRODUCTION = """# Every command

One example of each, with what it printed on the simulated robot of `./dev nacelle launch launch/robot.launch.yaml`. This page is
written by `test/docs/cli_doc.py --write`; the tests run every line of it. Words, options and output follow `ros2`'s.

Every command has `--help`, and a word that is wrong is told with the nearest that is right. Those that ask a container have `--json`
and `--container NAME`; `topic`, `node`, `service`, `param`, `lifecycle`, `component` and `action` ask ROS 2 nodes of the network with `--remote`
([network.md](network.md#asking-other-machines)). The same is in the manual page (`man nacelle`, once installed). Completion of commands, options and names of
the running robot: `source <(nacelle completion bash)`, also `zsh` and `fish`; an installation has it in place.

Exit codes: 0 done; 1 failed: what is named is not there, a file cannot be read, the robot refused; 2 wrong usage: a word, an option or
a value that cannot be, which shows without asking anybody; 3 no container is running.
"""


def leaves(tree, path=()):
    """The commands that run, as words: ("topic", "echo")."""
    found = {path: tree["what"]} if tree["runs"] else {}
    for below in tree["subcommands"]:
        found.update(leaves(below, (*path, below["name"])))
    return found


def command_of(line, known):
    """The command that an example is of; None: this program does not have it."""
    words = tuple(shlex.split(line))
    return next((words[:n] for n in (3, 2, 1) if words[:n] in known), None)


class Robot(RunningRobotTest):
    """A robot with a folder to work in, in which the examples' files lie."""

    @classmethod
    def setUpClass(cls):
        cls.has_own_network = enter_own_network()
        super().setUpClass()
        cls.home = cls.folder / "home"
        cls.home.mkdir()
        (cls.home / "launch").symlink_to(ROOT / "launch")
        (cls.home / "sim").symlink_to(cls.folder / "sim")
        (cls.home / "driver.yaml").write_text("ekf_filter_node:\n  ros__parameters:\n    frequency: 30.0\n    two_d_mode: true\n")
        (cls.home / "chaos.yaml").write_text("/chaos:\n  ros__parameters:\n    share: 0.25\n")
        (cls.home / "robot.xacro").write_text(
            '<robot name="r" xmlns:xacro="http://www.ros.org/wiki/xacro">\n  <xacro:arg name="width" default="0.2"/>\n'
            '  <link name="base"/>\n  <!-- ${2 * 0.1} -->\n  <link name="wheel_${1 + 1}_$(arg width)"/>\n</robot>\n'
        )
        tree = json.loads(cls.run_program("command-tree").stdout)
        cls.known = leaves(tree)
        cls.examples = [example for example in EXAMPLES if command_of(example.line, cls.known)]

    @classmethod
    def run_line(cls, line, **options):
        return cls.run_program(*shlex.split(line), cwd=cls.home, limit_s=90, env=cls.environment_of(line), **options)

    @classmethod
    def environment_of(cls, line):
        """A second robot on the domain of the first would be heard by it, and hear it."""
        starts_one = shlex.split(line)[0] in ("launch", "drive", "container")
        return {**cls.environment, "ROS_DOMAIN_ID": "1"} if starts_one else cls.environment

    def run_example(self, example):
        """What it printed. Fails if it did not exit as it should."""
        for line in example.before:
            self.expect_exit(self.run_line(line), 0)
        try:
            if example.keys is not None:
                return self.run_on_terminal(example)
            if example.ends is not None:
                return self.run_until_interrupted(example)
            outcome = self.run_line(example.line, input=example.stdin)
            self.assertIn(outcome.returncode, example.exit_codes, f"{example.line}\n{outcome.stdout}\n{outcome.stderr}")
            return outcome.stdout + outcome.stderr
        finally:
            for line in example.after:
                self.expect_exit(self.run_line(line), 0)

    def run_until_interrupted(self, example):
        program = self.start_program(*shlex.split(example.line), cwd=self.home, env=self.environment_of(example.line))
        # A person's patience, not a synchronisation: the command has no end of its own.
        timer = threading.Timer(example.ends, program.send_signal, [signal.SIGINT])
        timer.start()
        said, _ = program.communicate(timeout=60 * SLOW)
        timer.cancel()
        self.assertIn(program.returncode, example.exit_codes, said)
        return said

    def run_on_terminal(self, example):
        master, slave = pty.openpty()
        program = subprocess.Popen([PROGRAM, *shlex.split(example.line)], stdin=slave, stdout=slave, stderr=slave, cwd=self.home,
                                   env=self.environment, start_new_session=True)  # fmt: skip
        os.close(slave)
        said = bytearray()

        def read():
            try:
                while piece := os.read(master, 4096):
                    said.extend(piece)
            except OSError:
                pass  # the terminal's other end is closed

        reader = threading.Thread(target=read)
        reader.start()
        wait_for("it is ready for keys", lambda: said)
        for key in example.keys:
            before = len(said)
            os.write(master, key.encode())
            wait_for("the key is answered", lambda before=before: len(said) > before)
        program.send_signal(signal.SIGINT)
        program.wait(20 * SLOW)
        reader.join()
        os.close(master)
        self.assertIn(program.returncode, example.exit_codes, said)
        return re.sub(r"\x1b\[[0-9;?]*[A-Za-z]", "", said.decode(errors="replace")).replace("\r\n", "\n").replace("\r", "\n")

    def shown(self, example, text):
        """Without the places of the machine that wrote it."""
        build = pathlib.Path(PROGRAM).resolve().parents[1]
        for place, name in ((self.home, "."), (self.folder, "/run/user/1000"), (build, "build"), (ROOT, ".")):
            text = text.replace(str(place), name)
        text = re.sub(r"(Linux \d+\.\d+\.\d+)\S*", r"\1", text)
        text = re.sub(r"(?m)^warning +\S.* can log in on this machine.*\n", "", text)  # people of the machine that wrote this page
        lines = [line.rstrip() for line in text.rstrip("\n").split("\n")]
        lines = [line if len(line) <= LONGEST_LINE else line[: LONGEST_LINE - 3] + "..." for line in lines]
        if len(lines) > example.lines:
            lines = [*lines[: example.lines - 1], "..."]
        return "\n".join(lines)


class Document(Robot):
    def test_every_command_has_an_example(self):
        shown = {command_of(line, self.known) for line in lines_of(DOCUMENT.read_text())}
        missing = [" ".join(command) for command in self.known if command not in shown]
        self.assertEqual(missing, [], "give each a line in EXAMPLES, then run cli_doc.py --write")

    def test_the_document_is_that_of_the_table(self):
        self.assertEqual(lines_of(DOCUMENT.read_text()), [example.line for example in self.examples], "run cli_doc.py --write")

    def test_every_example_runs(self):
        for example in self.examples:
            with self.subTest(line=example.line):
                self.assertEqual(self.run_example(example).strip() == "", example.silent, "what it prints")


def lines_of(document):
    return re.findall(r"^\$ (?:echo '.*' \| )?nacelle (.*)$", document, re.MULTILINE)


class Writer(Robot):
    """Not a test: uses what the tests use."""

    def runTest(self):
        parts, seen = [INTRODUCTION], set()
        for example in self.examples:
            command = command_of(example.line, self.known)
            if command[0] in HEADINGS and command[0] not in seen:
                parts.append(f"\n## {HEADINGS[command[0]]}\n")
            seen.add(command[0])
            line = (f"$ echo '{example.stdin}' | nacelle " if example.stdin else "$ nacelle ") + example.line
            print(line, file=sys.stderr)
            said = "\n".join(filter(None, (line, self.shown(example, self.run_example(example)))))
            what = self.known[command][:1].upper() + self.known[command][1:]
            parts.append(f"\n### {' '.join(command)}\n\n{what}.\n\n```console\n{said}\n```\n")
        DOCUMENT.write_text("".join(parts))


if __name__ == "__main__":
    if "--write" in sys.argv:
        outcome = unittest.TextTestRunner().run(unittest.TestSuite([Writer()]))
        sys.exit(0 if outcome.wasSuccessful() else 1)
    unittest.main()
