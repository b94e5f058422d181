# SPDX-License-Identifier: Apache-2.0
"""The program without a container: usage, exit codes, messages."""
import contextlib
import json
import os
import pathlib
import shutil
import signal
import subprocess
import unittest

from robot import LAUNCH_FILE, PROGRAM, SLOW, RobotTest, interrupt, of_words, wait_for

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


# Listens on a socket in the folder, and prints what is sent to it.
STRANGER = """
import os, socket, sys
os.mkdir(sys.argv[1], 0o755)
listener = socket.socket(socket.AF_UNIX)
listener.bind(sys.argv[1] + "/other.sock")
os.chmod(sys.argv[1] + "/other.sock", 0o666)
listener.listen()
print("ready", flush=True)
while True:
    print("asked", listener.accept()[0].recv(100), flush=True)
"""


class OfAnotherUser(RobotTest):
    USER, VICTIM = 64999, 64998  # ids that no account has

    def words_of(self, user):
        """What runs a program as that user."""
        them = ["setpriv", f"--reuid={user}", f"--regid={user}", "--clear-groups"]
        if subprocess.run([*them, "test", "-x", PROGRAM], check=False).returncode != 0:
            self.skipTest(f"another user cannot run {PROGRAM}: a folder above it is closed to them")
        return them

    @contextlib.contextmanager
    def stranger_in(self, folder):
        """A listener of USER in a folder that is named for another user. It must not be asked anything."""
        stranger = subprocess.Popen([*self.words_of(self.USER), "/usr/bin/python3", "-c", STRANGER, folder], cwd="/", stdout=subprocess.PIPE, text=True)
        try:
            self.assertEqual(stranger.stdout.readline(), "ready\n")
            yield
        finally:
            stranger.kill()
            said = stranger.communicate()[0]
            shutil.rmtree(folder, ignore_errors=True)
        self.assertEqual(said, "", "the stranger's socket was used")

    @unittest.skipUnless(os.geteuid() == 0 and shutil.which("setpriv"), "two users need root")
    def test_the_socket_of_a_stranger_in_this_users_folder_takes_no_stop(self):
        victim = self.words_of(self.VICTIM)
        folder = f"/dev/shm/nacelle-{self.VICTIM}"
        ignored = f"nacelle: {folder}: ignored: owned by user {self.USER}; another user may have created it; remove it"
        without_runtime_dir = {key: value for key, value in self.environment.items() if key != "XDG_RUNTIME_DIR"}
        home = self.folder / "victim"
        home.mkdir()
        os.chown(home, self.VICTIM, self.VICTIM)
        os.chmod(self.folder, 0o711)
        at_home = self.environment | {"XDG_RUNTIME_DIR": str(home)}
        with self.stranger_in(folder):
            alone = subprocess.run([*victim, PROGRAM, "estop", "set"], env=without_runtime_dir, capture_output=True, text=True, check=False)
            self.assertEqual((alone.returncode, alone.stdout), (3, ""), alone.stderr)
            self.assertEqual([line for line in alone.stderr.splitlines() if folder in line], [ignored])

            robot = subprocess.Popen(
                [*victim, PROGRAM, "container", "--name", "robot", "network:=off"], env=at_home, cwd=home,
                stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL,
            )  # fmt: skip
            self.addCleanup(interrupt, robot)
            wait_for("the victim's own container runs", lambda: (home / "nacelle" / "robot.sock").exists())
            words = [*victim, PROGRAM, "estop", "set", "--topic", "/emergency_stop"]
            beside = subprocess.run(words, env=at_home, capture_output=True, text=True, check=False)
            self.assertEqual((beside.returncode, beside.stdout), (0, "/emergency_stop set, heard by 0 readers\n"), beside.stderr)
            self.assertEqual(beside.stderr.splitlines(), [ignored])

    @unittest.skipUnless(os.geteuid() == 0 and shutil.which("setpriv"), "two users need root")
    def test_is_named_with_the_way_to_ask_it(self):
        environment = {key: value for key, value in self.environment.items() if key != "XDG_RUNTIME_DIR"}
        folder = pathlib.Path(f"/dev/shm/nacelle-{self.USER}")
        them = self.words_of(self.USER)
        theirs = subprocess.Popen([*them, PROGRAM, "container", "--name", "theirs"], env=environment, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)  # fmt: skip
        try:
            wait_for("their container runs", lambda: (folder / "theirs.sock").exists())
            outcome = self.expect_exit(self.run_program("component", "list"), 3)
            self.assertIn(f"no container of yours is running; user #{self.USER} runs 'theirs'; ask as its user: sudo -u '#{self.USER}'", outcome.stderr)
            ours = self.start_program("container", "--name", "ours", stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
            self.addCleanup(interrupt, ours)
            wait_for("a container of one's own runs", lambda: self.run_program("component", "list").returncode == 0)
            outcome = self.expect_exit(self.run_program("component", "list", "--container", "wrong"), 3)
            self.assertEqual(outcome.stderr, "nacelle: container 'wrong': not running; running: ours\n")
        finally:
            theirs.send_signal(signal.SIGINT)
            theirs.wait(30 * SLOW)
            shutil.rmtree(folder, ignore_errors=True)

    @unittest.skipUnless(os.geteuid() == 0, "two users need root")
    def test_a_world_of_another_user_is_not_taken(self):
        folder = self.folder / "nacelle-drive-1"
        world = self.start_program("sim", "world", "--dir", folder)
        try:
            wait_for("the world runs", lambda: (folder / "ready").exists())
            self.expect_exit(self.run_program("sim", "truth"), 0)
            os.chown(folder, self.USER, self.USER)
            self.assertIn("no simulated world runs there", self.expect_exit(self.run_program("sim", "truth"), 1).stderr)
        finally:
            world.send_signal(signal.SIGINT)
            world.communicate(timeout=30 * SLOW)


@of_words
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
        said = self.expect_exit(self.run_program("--version"), 0).stdout
        self.assertRegex(said, r"^nacelle \d+\.\d+\.\d+( \([0-9a-f]{12}(-dirty)?\))?\n$")
        git = ["git", "-c", "safe.directory=*", "-C", str(pathlib.Path(__file__).parent), "rev-parse", "HEAD"]
        commit = subprocess.run(git, capture_output=True, text=True, check=False).stdout[:12]
        if commit:
            self.assertIn(f" ({commit}", said)

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
            self.assertIn("/no/such/robot.launch.yaml: the launch file cannot be read: No such file or directory; is the path right?", outcome.stderr)

    def launch_text(self, text, *arguments):
        file = self.folder / "a.launch.yaml"
        file.write_text(text)
        return self.run_program("launch", file, *arguments)

    def test_a_limit_is_reported_briefly(self):
        self.assertLess(len(self.run_program("drive", "--seed", "-1").stderr), 200)
        wrong = self.expect_exit(self.run_program("topic", "pub", "/x", "std_msgs/msg/String", "{data"), 2)
        self.assertNotIn("[json", wrong.stderr)
        self.assertRegex(wrong.stderr, r"the message:1: this is not YAML: .* \(column \d+\); write {data: \.\.\.}")
        self.assertEqual(len(wrong.stderr.splitlines()), 1)

    def test_a_slip_of_the_fingers_is_named_with_what_was_meant(self):
        for words, parts in ((["topci", "list"], ("nacelle: unknown command 'topci'", "did you mean `nacelle topic`")),
                             (["topic", "lst"], ("nacelle: topic: unknown command 'lst'", "did you mean `nacelle topic list`")),
                             (["echo", "/scan"], ("unknown command 'echo'", "`nacelle topic echo` or `nacelle tf echo`")),
                             (["frobnicate"], ("unknown command 'frobnicate'", "see `nacelle --help`")),
                             (["lifecycle", "frobnicate"], ("unknown command 'frobnicate'", "one of get, list, nodes, set")),
                             ([], ("a command is missing", "see `nacelle --help`")), (["topic"], ("a command is missing", "one of list, info,")),
                             (["topic", "echo", "/scan", "--onec"], ("nacelle: topic echo: unknown option '--onec'", "did you mean '--once'")),
                             (["param", "get", "camera", "a", "b"], ("unexpected argument 'b'", "see `nacelle param get --help`")),
                             (["topic", "info"], ("nacelle: topic info: topic is required", "see `nacelle topic info --help`")),
                             (["lifecycle", "set", "camera", "actvate"], ("invalid value 'actvate'", "did you mean 'activate'")),
                             (["sim", "world", "--dri", "x"], ("sim world: unknown option '--dri'", "did you mean '--dir'")),
                             (["--json", "topic", "list"], ("option --json: must follow the command",)),
                             (["--container", "x", "topic", "list"], ("option --container: must follow the command",)),
                             (["topic", "hz", "sensor_msgs/msg/Imu"], ("is a type, and no topic",))):  # fmt: skip
            with self.subTest(words=words):
                said = self.expect_exit(self.run_program(*words), 2).stderr
                self.assertEqual(len(said.splitlines()), 1, said)
                for part in parts:
                    self.assertIn(part, said)

    def test_an_invalid_value_is_reported_in_plain_words(self):
        for words, part in ((["topic", "pub", "/x", "std_msgs/msg/String", "-t", "-1"], "'-1' is not a whole number of at least 0"),
                            (["topic", "pub", "/x", "std_msgs/msg/String", "--once", "-t", "4"], "excludes"),
                            (["topic", "hz", "/scan", "-w", "1"], "'1' is not a number from 2 to 100000"),
                            (["top", "--interval", "soon"], "'soon' is not a number from 0.1 to 3600"),
                            (["param", "set", "camera", "x", "[1"], "this is not YAML: end of sequence flow not found (column 1)"),
                            (["param", "set", "camera", "x", "[1, a]"], "the list mixes int and string"),
                            (["component", "load", "a::B", "-p", "rate:='1"], "this is not YAML"),
                            (["component", "load", "a::B", "-p", ":=1"], "the parameter's name is empty"),
                            (["component", "load", "a::B", "-r", "scan"], "write from:=to"),
                            (["component", "info"], "component is required"),
                            (["component", "info", "a::B"], "add --doc"),
                            (["component", "info", "--doc", "--remote"], "excludes"),
                            (["container", "--name", "a b"], "container name 'a b': not a name; use 1 to 48 letters"),
                            (["launch", "a.launch.yaml", "--name", "../b"], "container name '../b': not a name")):  # fmt: skip
            with self.subTest(words=words):
                said = self.expect_exit(self.run_program(*words), 2).stderr
                self.assertEqual(len(said.splitlines()), 1, said)
                self.assertIn(part, said)
                self.assertNotIn("UINT", said)
        # A file that is not there is no wrong usage.
        for words in (["component", "load", "a::B", "--params-file", "/no/such"],):
            self.assertIn("/no/such: cannot be read: No such file or directory", self.expect_exit(self.run_program(*words), 1).stderr)

    def test_help_speaks_to_people(self):
        rate = self.expect_exit(self.run_program("topic", "hz", "--help"), 0).stdout
        self.assertIn("NUMBER (2 to 100000)", rate)
        for command in ("launch", "container", "drive"):
            self.assertIn(", use: kill", self.expect_exit(self.run_program(command, "--help"), 0).stdout)
        load = self.expect_exit(self.run_program("component", "load", "--help"), 0).stdout
        self.assertIn("--parameter NAME:=VALUE", load)
        every = self.expect_exit(self.run_program("--help"), 0).stdout
        self.assertIn("source <(nacelle completion bash)", every)
        self.assertIn("completion ", every)
        for text in (rate, load, every):
            self.assertNotRegex(text, r"UINT|FLOAT")

    def test_a_short_name_of_a_type_will_do(self):
        for short, whole in (("std_msgs/Bool", "std_msgs/msg/Bool"), ("std_srvs/SetBool", "std_srvs/srv/SetBool")):
            self.assertEqual(self.expect_exit(self.run_program("interface", "show", short), 0).stdout,
                             self.expect_exit(self.run_program("interface", "show", whole), 0).stdout)  # fmt: skip
        self.assertIn("did you mean 'std_msgs/msg/Bool'", self.expect_exit(self.run_program("interface", "show", "std_msgs/Bol"), 1).stderr)

    def test_a_report_that_cannot_be_written_is_reported_at_once(self):
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
