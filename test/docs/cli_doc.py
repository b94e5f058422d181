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
import shutil
import signal
import subprocess
import sys
import textwrap
import threading
import unittest

ROOT = pathlib.Path(__file__).resolve().parents[2]
os.environ.setdefault("NACELLE_PROGRAM", str(ROOT / "build" / "bin" / "nacelle"))
os.environ.setdefault("NACELLE_LAUNCH_FILE", str(ROOT / "launch" / "robot.launch.yaml"))
sys.path.insert(0, str(ROOT / "test" / "system"))
from machines import enter_own_network  # noqa: E402
from robot import PROGRAM, SLOW, RunningRobotTest, wait_for  # noqa: E402

DOCUMENT = ROOT / "docs" / "cli.md"
# outside_doc.py runs packages_outside_the_tree.md.
PAGES = (ROOT / "README.md", ROOT / "CONTRIBUTING.md", *sorted(set((ROOT / "docs").glob("*.md")) - {ROOT / "docs" / "packages_outside_the_tree.md"}))
LONGEST_LINE, MOST_LINES = 150, 24
IS_UP = " active in "  # of a launch


@dataclasses.dataclass
class Example:
    """One command line behind `nacelle`, in the words of a shell."""

    line: str
    first: tuple = ()  # lines before it in the same block: what it needs
    then: tuple = ()  # lines that follow in the same block: what puts it back, or what later examples need
    ends: float | None = None  # Ctrl-C after so many seconds; None: it ends by itself
    until: str = ""  # Ctrl-C before, as soon as it prints this
    keys: str | None = None  # typed on a terminal, one each tenth of a second; then Ctrl-C
    stdin: str = ""
    exit_codes: tuple = (0,)
    lines: int = MOST_LINES  # that are shown
    silent: bool = False  # it prints nothing when all is well
    prints: str = ""  # what must be in its output
    network: bool = False  # it needs a network of its own, which root only can make


# In the order of the document, in which the tests run them, so that each finds what those above it have left. The command's path is
# what stands in front of options and names. A command that this program does not have is left out, so that the table may run ahead
# of it.
EXAMPLES = (
    Example("launch launch/robot.launch.yaml sim_dir:=second-sim namespace:=second --name second -v", ends=4, until=IS_UP, lines=14),
    Example("container --name empty -v", ends=1),
    Example("drive --for 3 --seed 1 --report-html drive.html"),
    Example("component list"),
    Example("component info lidar", then=("component info --doc nacelle::examples::Series",), lines=40),
    Example("component types"),
    Example("component unload camera"),
    Example("component load camera", then=("component load nacelle::examples::Series",)),
    Example("lifecycle nodes"),
    Example("lifecycle get lidar"),
    Example("lifecycle list lidar"),
    Example("lifecycle set monitor_2 deactivate", then=("lifecycle set monitor_2 activate",)),
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
    # Of an image, which needs systemctl. The other two show what this machine's systemd says, if it has one.
    Example("service install launch/robot.launch.yaml sim:=true --root image", exit_codes=(0, 1)),
    Example("service status", exit_codes=(0, 1, 3, 4)),
    Example("service logs", exit_codes=(0, 1)),
    Example("service remove --root image --purge", exit_codes=(0, 1)),
    Example("action list -t"),
    Example("action info /series/series -t"),
    Example("action type /series/series"),
    Example("action find example_interfaces/action/Fibonacci"),
    Example("action send_goal /series/series example_interfaces/action/Fibonacci '{order: 5}' --feedback",
            lines=40),
    Example("param list lidar"),
    Example("param get lidar frame_id"),
    Example("param describe lidar frame_id range_max"),
    Example("param set series share 0.75"),
    Example("param dump lidar"),
    Example("param load series docs/examples/series.yaml"),
    Example("param delete series note"),
    Example("tf tree"),
    Example("tf echo odom lidar_link --once"),
    Example("tf monitor odom lidar_link --once --interval 2"),
    Example("streams --once", lines=30),
    Example("top --once --interval 2"),
    Example("ekf --once"),
    Example("faults", lines=40),
    Example("check launch/robot.launch.yaml"),
    Example("params --explain lidar launch/robot.launch.yaml"),
    Example("import docs/examples/ros2_drivers.yaml", lines=40),
    Example("new component wheel_counter", then=("new component sonar --driver",)),
    Example("qos check launch/robot.launch.yaml"),
    Example("qos explain --offered reliability=best_effort --requested reliability=reliable"),
    Example("device list", lines=40),
    Example("doctor", exit_codes=(0, 1), lines=40),  # faults of the machine that wrote this page do not matter
    Example("doctor net", lines=40),
    Example("export on"),
    Example("export off"),
    Example("security create-keystore keys"),
    Example("security create-enclave keys /robot"),
    Example("security list-enclaves keys"),
    Example("security generate-policy policy.xml --enclave /robot"),
    Example("security create-permission keys /robot policy.xml"),
    Example("estop set"),
    Example("estop release"),
    Example("look --port 8089", ends=2, prints="/#token="),
    Example("bag record -a --for 2 -o drive"),
    Example("replay launch/robot.launch.yaml --from drive --nodes transforms --nodes ekf --record replayed.mcap"),
    Example("bag snapshot --node black_box",
            first=("component load nacelle::record::RecordComponent -n black_box -p record.all_topics:=true -p storage.ring:=30 -p storage.uri:=$PWD/black_box",),
            then=("component unload black_box",)),
    Example("bag play docs/examples/recordings/talker.mcap --topics /chatter -r 10"),
    Example("bag info docs/examples/recordings/talker.mcap"),
    Example("bag check docs/examples/recordings/talker.mcap"),
    Example("bag recover docs/examples/recordings/talker.mcap -o talker.recovered.mcap --compression zstd"),
    Example("bag cut docs/examples/recordings/talker.mcap --start-offset 1 --duration 1 -o second.mcap"),
    Example("bag filter docs/examples/recordings/talker.mcap -x rosout -o chatter.mcap"),
    Example("bag convert docs/examples/recordings/talker.mcap -o small.mcap --compression lz4"),
    Example("bag diff small.mcap second.mcap", exit_codes=(1,)),
    Example("bag plot docs/examples/recordings/lap.mcap /path.x /path.y -o lap.svg"),
    Example("bag merge second.mcap chatter.mcap -o merged.mcap"),
    Example("teleop", keys="iik", lines=20),
    # A robot that stands still shows a magnetometer one direction only.
    Example("imu calibrate --mag --turn 2", stdin="ready", exit_codes=(1,)),
    Example("base calibrate --distance 0.3 --turns 0.5 --measured-distance 0.297 --measured-turns 0.49 --yes"),
    Example("sim world --dir world -v", ends=2),
    Example("sim device rplidar_a1 --pty rplidar", ends=2),
    Example("sim truth"),
    Example("sim unplug imu", silent=True),
    Example("sim plug imu", silent=True),
    Example("interface list --package std_srvs"),
    Example("interface show std_srvs/srv/SetBool"),
    Example("interface hash sensor_msgs/msg/Imu"),
    Example("interface encode std_msgs/msg/Bool", stdin='{"data": true}'),
    Example("interface decode std_msgs/msg/Bool", stdin="0001000001"),
    Example("xacro docs/examples/robot.xacro width:=0.3"),
    Example("completion bash", lines=8),
)

HEADINGS = {
    "launch": "Start", "component": "Components", "node": "Graph", "param": "Parameters", "tf": "Frames", "streams": "What it costs",
    "faults": "What is wrong", "security": "Security", "estop": "Stop and drive", "imu": "Calibration", "sim": "The simulated robot",
    "interface": "Messages and files",
}  # fmt: skip

INTRODUCTION = """# Every command

This page shows one example of each command with its output, run in the source folder beside the simulated robot of
`./dev nacelle launch launch/robot.launch.yaml`. `test/docs/cli_doc.py --write` generates the page; the tests run every line of it
in order. `nacelle` stands for `./dev nacelle`, or `build/bin/nacelle`. Commands, options and output follow `ros2`'s.

Every command has `--help`, and names the nearest valid word for a misspelt one. Commands that query a container have `--json` and
`--container NAME`. With `--remote`, commands query the network, as in `nacelle topic echo /scan --remote`: `topic`, `node`, `service`,
`param`, `lifecycle`, `component` and `action` query any ROS 2 node; `tf`, `streams`, `top`, `faults` and `estop release` need a Nacelle
container there; `estop set` stops every base that it finds ([network.md](network.md#asking-other-machines)).

The manual page has the same content (`man nacelle`, once installed). For completion of commands, options and names of the running robot,
use `source <(nacelle completion bash)`, also `zsh` and `fish`; an installation sets it up.

Exit codes: 0 success; 1 failure: a name does not exist, a file cannot be read, or the robot refused; 2 wrong usage: an invalid word,
option or value, detected without querying a container; 3 no container is running; 130 a signal ended a drive or a calibration.
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
    """A robot, and a folder to work in that looks like the sources."""

    @classmethod
    def setUpClass(cls):
        cls.has_own_network = enter_own_network()
        super().setUpClass()
        cls.home = cls.folder / "home"
        cls.home.mkdir()
        for part in ("launch", "docs", "test"):
            (cls.home / part).symlink_to(ROOT / part)
        units = cls.home / "image/usr/lib/systemd/system"
        units.mkdir(parents=True)
        shutil.copy(pathlib.Path(PROGRAM).resolve().parents[1] / "launch/systemd/nacelle@.service", units)
        (units / "multi-user.target").write_text("[Unit]\n")
        # Where a launch file puts it that is given no sim_dir.
        (cls.folder / "nacelle-sim").symlink_to(cls.folder / "sim")
        tree = json.loads(cls.run_program("command-tree").stdout)
        cls.known = leaves(tree)
        cls.examples = [example for example in EXAMPLES if command_of(example.line, cls.known)]

    @classmethod
    def run_line(cls, line, **options):
        return cls.run_program(*shlex.split(line.replace("$PWD", str(cls.home)), comments=True), cwd=cls.home, limit_s=90, **options)

    def run_example(self, example):
        """What it printed. Fails if it did not exit as it should."""
        said = self.output_of(example)
        self.assertIn(example.prints, said, example.line)
        return said

    def output_of(self, example):
        if example.keys is not None:
            return self.run_on_terminal(example)
        if example.ends is not None:
            return self.run_until_interrupted(example)
        outcome = self.run_line(example.line, input=example.stdin)
        self.assertIn(outcome.returncode, example.exit_codes, f"{example.line}\n{outcome.stdout}\n{outcome.stderr}")
        return outcome.stdout + outcome.stderr

    def run_until_interrupted(self, example):
        # The command does not end by itself. This is a user's patience, not a synchronisation: on a busy machine a user sees that the
        # robot is not up yet, and waits longer.
        for patience_s in (example.ends, 4 * example.ends, 16 * example.ends):
            program = self.start_program(*shlex.split(example.line, comments=True), cwd=self.home)
            timers = (threading.Timer(patience_s, program.send_signal, [signal.SIGINT]), threading.Timer(patience_s + 60 * SLOW, program.kill))
            for timer in timers:
                timer.start()
            said = ""
            while line := program.stdout.readline():
                said += line
                if example.until and example.until in line:
                    program.send_signal(signal.SIGINT)
            program.wait()
            program.stdout.close()
            for timer in timers:
                timer.cancel()
            if "bring-up: interrupted by SIGINT" not in said:
                break
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
        lines = [line for example in self.examples for line in (*example.first, example.line, *example.then)]
        self.assertEqual(lines_of(DOCUMENT.read_text()), lines, "run cli_doc.py --write")

    def test_every_line_of_the_page_runs_from_the_first_to_the_last(self):
        how = {example.line: example for example in self.examples}
        for line in lines_of(DOCUMENT.read_text()):
            with self.subTest(line=line):
                example = how.get(line, Example(line))
                self.assertEqual(self.run_example(example).strip() == "", example.silent, "what it prints")


# Lines of other pages that do not simply run and end: how they are tried here.
ELSEWHERE = {
    # No serial lines are here: the plan is proved.
    "launch launch/robot.launch.yaml sim:=false lidar_port:=/dev/ttyUSB0 imu_port:=/dev/ttyUSB1 base_port:=/dev/ttyACM0":
        Example("check launch/robot.launch.yaml sim:=false lidar_port:=/dev/ttyUSB0 imu_port:=/dev/ttyUSB1 base_port:=/dev/ttyACM0"),
    "launch launch/robot.launch.yaml lidar_port:=/dev/ttyUSB1": Example("check launch/robot.launch.yaml lidar_port:=/dev/ttyUSB1"),
    # No gamepad is here: the robot waits for one.
    "launch launch/teleop.launch.yaml":
        Example("launch launch/teleop.launch.yaml sim_dir:=stick-sim namespace:=stick --name stick", ends=6, until=IS_UP),
    "launch launch/teleop.launch.yaml joy_name:=8BitDo Pro 2":
        Example("launch launch/teleop.launch.yaml joy_name:='8BitDo Pro 2' sim_dir:=pad-sim namespace:=pad --name pad", ends=6, until=IS_UP),
    # The default robot has no GPS; that of test/system/gps_test.py has.
    "launch launch/gps.launch.yaml": Example("launch launch/gps.launch.yaml sim_dir:=gps-sim namespace:=outdoors --name outdoors", ends=6, until=IS_UP),
    "launch launch/gps.launch.yaml sim:=false gps_port:=/dev/ttyACM0": Example("check launch/gps.launch.yaml sim:=false gps_port:=/dev/ttyACM0"),
    "service call /fromLL robot_localization/srv/FromLL {ll_point: {latitude: 49.87285, longitude: 8.65125, altitude: 191.6}}":
        Example("service call /fromLL robot_localization/srv/FromLL '{ll_point: {latitude: 49.87285, longitude: 8.65125, altitude: 191.6}}'",
                exit_codes=(1,)),
    "topic hz /scan": Example("topic hz /scan", ends=3),
    "teleop": Example("teleop", keys="k"),
    # A drive of half a minute is in test/system/run_test.py.
    "drive --report-html drive.html": Example("drive --for 1 --report-html drive.html"),
    # The component that README shows is built from there (CMakeLists.txt), and loaded by the line above this one.
    "topic echo /blocked": Example("topic echo /blocked", ends=3, prints="data: "),
    # A second robot is put apart from the one that runs.
    "launch launch/robot.launch.yaml --resume":
        Example("launch launch/robot.launch.yaml --resume sim_dir:=resumed-sim namespace:=resumed --name resumed", ends=6, until=IS_UP),
    "container --name lab": Example("container --name lab", ends=2),
    "container --name lab --resume": Example("container --name lab --resume", ends=2),
    "launch launch/robot.launch.yaml sim:=true network:=local --report report.json":
        Example("launch launch/robot.launch.yaml sim_dir:=local-sim namespace:=local network:=local --report report.json --name local",
                ends=6, until=IS_UP),
    # The robot here has no such node; that of test/system/controllers_test.py has.
    "service call /controller_manager/switch_controller controller_manager_msgs/srv/SwitchController "
    "{activate_controllers: [diff_drive_controller], strictness: 2}":
        Example("service call /controller_manager/switch_controller controller_manager_msgs/srv/SwitchController "
                "'{activate_controllers: [diff_drive_controller], strictness: 2}'", exit_codes=(1,)),
    # Of a machine that may have no systemd, and no such service.
    "service status": Example("service status", exit_codes=(0, 1, 3, 4)),
    "service logs --follow --component /lidar": Example("service logs --component /lidar", exit_codes=(0, 1)),
    # Asked over the network; the robot is in domain 0 here, and has no keystore (test/system/security_test.py has).
    "launch launch/robot.launch.yaml network:=export":
        Example("launch launch/robot.launch.yaml network:=export sim_dir:=shown-sim namespace:=shown --name shown",
                ends=6, until=IS_UP, network=True),
    "topic echo /scan --remote": Example("topic echo /scan --remote", ends=4, network=True),
    "param get /ekf frequency --remote --domain 7": Example("param get /ekf frequency --remote", network=True),
    "topic hz /odom --remote --network local": Example("topic hz /odom --remote --network local", ends=4, network=True),
    "topic hz /camera/image_raw --remote --network local":
        Example("topic hz /camera/image_raw --remote --network local", ends=4, network=True),
}  # fmt: skip


class OtherPages(Robot):
    def test_every_command_of_every_page_runs(self):
        tried = set()
        for page in PAGES:
            if page == DOCUMENT:
                continue
            for line in commands_of(page.read_text()):
                words = shlex.split(line, comments=True)
                with self.subTest(page=page.name, line=line):
                    example = ELSEWHERE.get(" ".join(words), Example(line))
                    tried.add(" ".join(words))
                    if example.network and not self.has_own_network:
                        self.skipTest("it needs a network of its own, which only root can make")
                    self.run_example(example)
        self.assertEqual(set(ELSEWHERE) - tried, set(), "these stand in no page any more")

    def test_the_yaml_and_xml_of_every_page_is_sound(self):
        (wheels,) = [block for page in PAGES for block in blocks_of(page.read_text(), "xml")]
        urdf = (ROOT / "launch" / "robot.urdf").read_text()
        (self.home / "robot.urdf").write_text(re.sub(r"(?s)<ros2_control.*</ros2_control>\n", lambda _: wheels, urdf))
        for page in PAGES:
            if page.name == "launch_files.md":  # names what is not here; test/unit/launch/documentation_test.cpp loads it
                continue
            for block in blocks_of(page.read_text(), "yaml"):
                with self.subTest(page=page.name, block=block):
                    (self.home / "block.yaml").write_text(block)
                    (self.home / "block.launch.yaml").write_text(launch_file_of(block))
                    self.run_example(Example("check block.launch.yaml"))

    def test_nothing_escapes(self):
        built = (ROOT / "test" / "docs" / "CMakeLists.txt").read_text()
        for page in PAGES:
            languages = re.findall(r"^ *```(\S+)$", page.read_text(), re.MULTILINE)
            with self.subTest(page=page.name):
                self.assertLessEqual(set(languages), {"sh", "console", "text", "yaml", "xml", "toml", "cpp", "cmake", "ini"})
                self.assertEqual(languages.count("cpp") + languages.count("cmake"), built.count(f"write_block({page.relative_to(ROOT)} "))


def lines_of(document):
    return re.findall(r"^\$ (?:echo '.*' \| )?nacelle (.*)$", document, re.MULTILINE)


def blocks_of(page, language, before=""):
    return re.findall(rf"{before}^```(?:{language})\n(.*?)^```", page, re.MULTILINE | re.DOTALL)


def launch_file_of(block):
    """Where a page's YAML belongs: a launch file, the default robot's parameter file (block.yaml), or a container's components."""
    if block.startswith("launch:"):
        return block + "- include: {file: launch/robot.launch.yaml}\n"
    if "ros__parameters:" in block:
        return "launch:\n- include: {file: launch/robot.launch.yaml, arg: [{name: config, value: $(dirname)/block.yaml}]}\n"
    return "launch:\n- node_container:\n    name: robot\n    composable_node:\n" + textwrap.indent(textwrap.dedent(block), "    ")


def commands_of(page):
    """The command lines in a page's blocks of shell text, behind `nacelle`. Below a comment, run_guide.py runs them."""
    return [line for block in blocks_of(page, "sh|console", "(?<!-->\n)") for line in re.findall(r"^(?:\$ )?(?:\./dev )?nacelle (.*)$", block, re.MULTILINE)]


class Writer(Robot):
    """Not a test: uses what the tests use."""

    def block(self, example):
        line = (f"$ echo '{example.stdin}' | nacelle " if example.stdin else "$ nacelle ") + example.line
        print(line, file=sys.stderr)
        return "\n".join(filter(None, (line, self.shown(example, self.run_example(example)))))

    def runTest(self):
        parts, seen = [INTRODUCTION], set()
        for example in self.examples:
            command = command_of(example.line, self.known)
            if command[0] in HEADINGS and command[0] not in seen:
                parts.append(f"\n## {HEADINGS[command[0]]}\n")
            seen.add(command[0])
            said = "\n".join(self.block(one) for one in (*map(Example, example.first), example, *map(Example, example.then)))
            what = self.known[command][:1].upper() + self.known[command][1:]
            parts.append(f"\n### {' '.join(command)}\n\n{what}.\n\n```console\n{said}\n```\n")
        DOCUMENT.write_text("".join(parts))


if __name__ == "__main__":
    if "--write" in sys.argv:
        outcome = unittest.TextTestRunner().run(unittest.TestSuite([Writer()]))
        sys.exit(0 if outcome.wasSuccessful() else 1)
    unittest.main()
