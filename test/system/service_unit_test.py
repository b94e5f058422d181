# SPDX-License-Identifier: Apache-2.0
"""nacelle@.service as systemd reads it, and `nacelle service` on the root folder of an image."""
import os
import pathlib
import re
import shutil
import subprocess
import unittest

from robot import LAUNCH_FILE, PROGRAM, RobotTest

UNIT = pathlib.Path(os.environ["NACELLE_UNIT"])
MOST_EXPOSED = "25"  # 2.5


@unittest.skipUnless(shutil.which("systemd-analyze"), "systemd-analyze is not installed")
class Unit(RobotTest):
    def setUp(self):
        # The same, of the program that is built here: systemd-analyze looks for it.
        self.unit = self.folder / "nacelle@.service"
        text, count = re.subn(r"(?m)^ExecStart=\S+/nacelle ", f"ExecStart={PROGRAM} ", UNIT.read_text())
        self.assertEqual(count, 1)
        self.unit.write_text(text)

    def analyze(self, *words):
        return subprocess.run(["systemd-analyze", *words, str(self.unit)], capture_output=True, text=True)

    def test_systemd_finds_no_mistake_in_it(self):
        told = self.analyze("verify", "--man=no")
        self.assertEqual((told.returncode, told.stdout + told.stderr), (0, ""))

    def test_it_is_exposed_to_no_more_than_the_robot_needs(self):
        told = self.analyze("security", "--offline=true", f"--threshold={MOST_EXPOSED}", "--no-pager")
        self.assertEqual(told.returncode, 0, told.stdout + told.stderr)
        print(told.stdout.splitlines()[-1])

    def test_it_shuts_out_no_device_that_is_plugged_in_later(self):
        """A list of devices holds the drivers that are loaded when the service starts. These settings imply one."""
        for setting in ("DeviceAllow", "DevicePolicy", "ProtectClock", "PrivateDevices"):
            self.assertIsNone(re.search(rf"(?m)^{setting}=", self.unit.read_text()), setting)


class Install(RobotTest):
    def setUp(self):
        self.root = self.folder / "image"
        (self.root / "usr/lib/systemd/system").mkdir(parents=True)
        shutil.copy(UNIT, self.root / "usr/lib/systemd/system/nacelle@.service")
        self.addCleanup(shutil.rmtree, self.root)
        self.etc = self.root / "etc/nacelle/robot"
        self.wants = self.root / "etc/systemd/system/multi-user.target.wants/nacelle@robot.service"

    def service(self, *words, code=0):
        return self.expect_exit(self.run_program("service", *words, "--root", self.root), code)

    def need_systemctl(self):
        if not shutil.which("systemctl"):
            self.skipTest("systemctl is not installed")

    def own_file(self, text):
        file = self.folder / "own.launch.yaml"
        file.write_text(text)
        return file

    def test_install_writes_the_files_and_enables_the_service(self):
        self.need_systemctl()
        file = self.own_file("launch:\n- executable: {cmd: 'true'}\n")
        self.service("install", file)
        self.assertEqual((self.etc / "robot.launch.yaml").read_text(), file.read_text())
        self.assertIn("# ROS_DOMAIN_ID=", (self.etc / "environment").read_text())
        self.assertTrue(self.wants.is_symlink())
        self.service("remove")
        self.assertFalse(self.wants.is_symlink())
        self.assertTrue(self.etc.exists())
        self.service("remove", "--purge")
        self.assertFalse(self.etc.exists())

    def test_the_robot_that_is_installed_is_included_so_that_an_update_reaches_it(self):
        self.need_systemctl()
        self.service("install", LAUNCH_FILE, "sim:=true")
        self.assertIn(f"- include: {{file: {LAUNCH_FILE}}}", (self.etc / "robot.launch.yaml").read_text())
        self.assertFalse((self.etc / "robot.launch.yaml").is_symlink())
        self.assertIn('\nNACELLE_ARGUMENTS="sim:=true"\n', (self.etc / "environment").read_text())

    def test_another_install_keeps_the_variables_that_a_user_has_written(self):
        self.need_systemctl()
        file = self.own_file("launch:\n- arg: {name: speed, default: '1'}\n- executable: {cmd: 'true'}\n")
        self.service("install", file, "speed:=2")
        environment = self.etc / "environment"
        environment.write_text(environment.read_text() + "ROS_DOMAIN_ID=7")
        self.service("install", "--name", "robot", file, "speed:=3")
        text = environment.read_text()
        self.assertIn("\nROS_DOMAIN_ID=7\n", text)
        self.assertEqual(text.count("\nNACELLE_ARGUMENTS="), 1)
        self.assertIn('\nNACELLE_ARGUMENTS="speed:=3"\n', text)
        self.service("install", file)
        self.assertEqual(environment.read_text(), text)

    def test_a_file_that_does_not_work_where_it_is_copied_to_is_not_enabled(self):
        (self.folder / "part.yaml").write_text("launch: []\n")
        file = self.own_file("launch:\n- include: {file: $(dirname)/part.yaml}\n")
        told = self.service("install", file, code=1).stderr
        self.assertIn("is not usable as it is, so the service is not enabled; copy the files that it names to ", told)
        self.assertFalse(self.wants.is_symlink())

    def test_arguments_that_systemd_would_take_apart_are_refused(self):
        for word in ("a:=b c", "a:=$HOME", 'a:="b"', "a:=%n"):
            self.assertIn("the arguments of a service have no spaces", self.service("install", LAUNCH_FILE, word, code=2).stderr)
        self.assertFalse(self.etc.exists())

    @unittest.skipIf(os.path.isdir("/run/systemd/system"), "systemd runs here")
    def test_without_systemd_nothing_is_changed_and_the_way_out_is_named(self):
        told = self.expect_exit(self.run_program("service", "install", LAUNCH_FILE), 1)
        self.assertIn("systemd does not run on this system; use `nacelle launch FILE --resume`", told.stderr)
        self.assertFalse(pathlib.Path("/etc/nacelle/robot").exists())


if __name__ == "__main__":
    unittest.main()
