# SPDX-License-Identifier: Apache-2.0
"""What a robot writes: nothing outside RAM, so that it runs on a read-only root and on a full disk."""
import os
import pathlib
import shutil
import signal
import subprocess
import sys
import tempfile
import time
import unittest

from disk_writes import RAM, STRACE, FileSystems, changed_by, on_disk
from machines import Machine, need_namespaces
from robot import LAUNCH_FILE, PROGRAM, SLOW, RobotTest, needs_no_sanitizer, wait_for

SECONDS = float(os.environ.get("NACELLE_FRUGAL_SECONDS", "8"))  # the nightly run traces ten minutes
COMPONENTS = "10 components active"
# $1: where the root is bound anew. $2: a folder in RAM for this run. The rest: the command.
ON_A_FULL_DISK = r"""
set -e
root=$1 run=$2
shift 2
mount --rbind / "$root"
mount --make-rprivate "$root"
awk -v root="$root" 'index($5, root) == 1 {type = ""; for (i = 7; i <= NF; ++i) if ($i == "-") type = $(i + 1); print $5, type}' /proc/self/mountinfo |
  while read -r point type; do
    case " $RAM " in
      *" $type "*) ;;
      *) mount -o remount,bind,ro "$(printf '%b' "$point")" ;;
    esac
  done
mount -t tmpfs -o size=64k,mode=1777 tmpfs "$root/tmp"
dd if=/dev/zero of="$root/tmp/full" bs=4k 2>/dev/null || true
if touch "$root/written" 2>/dev/null || echo more >>"$root/tmp/full" 2>/dev/null; then
  echo "the root can be written, or the disk is not full" >&2
  exit 99
fi
cd "$root"
exec env HOME=/tmp TMPDIR=/tmp chroot "$root" "$@"
"""

OWN_RAM = "NACELLE_TEST_HAS_OWN_RAM"


class InRam(RobotTest):
    """Its folder is in RAM, as XDG_RUNTIME_DIR is on a robot."""

    has_own_network = True

    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        cls.folder.rmdir()
        if not FileSystems().are_in_ram("/dev/shm/folder"):
            raise unittest.SkipTest("/dev/shm is not in RAM here")
        cls.folder = pathlib.Path(tempfile.mkdtemp(prefix="nacelle-frugal-", dir="/dev/shm"))
        cls.environment["XDG_RUNTIME_DIR"] = str(cls.folder)
        cls.without_runtime_dir = {name: text for name, text in cls.environment.items() if name != "XDG_RUNTIME_DIR"}


@needs_no_sanitizer
@unittest.skipUnless(shutil.which("strace"), "strace is not installed")
class Written(InRam):
    def traced(self, name, *words, seconds, environment, within=()):
        """Runs a robot under strace, gives orders to it, ends it. Returns the lines that changed a disk, how many changes there were, and the
        bytes that each process wrote to a disk before the end."""
        log = self.folder / f"{name}.log"
        with open(log, "w", encoding="utf-8") as output:
            strace = subprocess.Popen(
                [*within, *STRACE, "-o", self.folder / f"{name}.strace", PROGRAM, "launch", LAUNCH_FILE, "--name", name,
                 f"sim_dir:={self.folder}/sim-{name}", *words],
                stdout=output, stderr=subprocess.STDOUT, env=environment, cwd=self.folder, start_new_session=True)  # fmt: skip
        self.addCleanup(strace.wait)
        self.addCleanup(lambda: strace.poll() is None and os.killpg(strace.pid, signal.SIGKILL))  # the robot with it, which goes on without it
        wait_for("the robot is up", lambda: COMPONENTS in log.read_text() or strace.poll() is not None, 60)
        self.assertIsNone(strace.poll(), log.read_text())
        robot = self.robot_below(strace.pid)

        def order(*command):
            self.expect_exit(self.run_program(*command, "--container", name, env=environment, cwd=self.folder), 0)

        order("component", "unload", "camera")
        order("component", "load", "camera")
        order("param", "set", "/camera", "device_lost", "fault")
        order("estop", "set")
        order("estop", "release")
        time.sleep(seconds)  # the length of the run that is looked at
        written = {process: self.written_by(process) for process in (robot, *self.children_of(robot))}
        os.kill(robot, signal.SIGINT)
        self.assertEqual(strace.wait(60), 0, log.read_text())
        return *on_disk(sorted(self.folder.glob(f"{name}.strace.*")), self.folder), written

    @staticmethod
    def children_of(process):
        return [int(child) for task in pathlib.Path(f"/proc/{process}/task").iterdir() for child in (task / "children").read_text().split()]

    def robot_below(self, process):
        while os.readlink(f"/proc/{process}/exe") != os.path.realpath(PROGRAM):
            (process,) = self.children_of(process)
        return process

    @staticmethod
    def written_by(process):
        fields = dict(line.split(": ") for line in pathlib.Path(f"/proc/{process}/io").read_text().splitlines())
        return int(fields["write_bytes"])

    def test_a_robot_changes_nothing_outside_ram(self):
        found, changes, written = self.traced("still", "network:=off", seconds=SECONDS, environment=self.environment)
        self.assertEqual(found, [])
        self.assertEqual(set(written.values()), {0}, f"bytes written to a disk, by process: {written}")
        self.assertGreater(changes, 10)  # its socket, its state, the simulated devices: what strace must have seen

    def test_on_the_network_and_without_a_runtime_folder_neither(self):
        need_namespaces()
        machine = Machine()
        self.addCleanup(machine.close)
        found, changes, written = self.traced("networked", "network:=local", seconds=SECONDS, environment=self.without_runtime_dir, within=machine.within())
        self.assertEqual(found, [])
        self.assertEqual(set(written.values()), {0}, f"bytes written to a disk, by process: {written}")
        self.assertGreater(changes, 10)

    def test_a_file_on_disk_that_a_user_asks_for_is_seen(self):
        folder = pathlib.Path(tempfile.mkdtemp(prefix="frugal-", dir=pathlib.Path(PROGRAM).parent))
        self.addCleanup(shutil.rmtree, folder)
        if FileSystems().are_in_ram(str(folder / "state")):
            self.skipTest("the build is in RAM")
        found, _, written = self.traced("asked", "network:=off", "--report", folder / "report.json", seconds=0, environment=self.environment)
        self.assertTrue(found, written)
        self.assertTrue(all(f"{folder}/report.json" in line for line in found), found)


class Lines(unittest.TestCase):
    """The reader of strace's lines."""

    def test_names_what_a_call_changed(self):
        for line, changed in (
            ('openat(AT_FDCWD</home/pi>, "a", O_RDONLY|O_CLOEXEC) = 3</home/pi/a>', []),
            ('openat(AT_FDCWD</home/pi>, "a", O_RDWR|O_CREAT, 0600) = 3</home/pi/a>', ["/home/pi/a"]),
            ('openat(AT_FDCWD</home/pi>, "a", O_RDWR|O_CREAT, 0600) = -1 EROFS (Read-only file system)', []),
            ('openat(AT_FDCWD</home/pi>, "/tmp", O_RDWR|O_EXCL|O_TMPFILE, 0600) = 5</tmp/#12 (deleted)>', ["/tmp/#12"]),
            ('creat("/tmp/b", 0644)             = 4</tmp/b>', ["/tmp/b"]),
            ('rename("a", "/tmp/b") = 0', ["a", "/tmp/b"]),
            ('renameat2(AT_FDCWD</x>, "a", 7</y>, "b", RENAME_NOREPLACE) = 0', ["/x/a", "/y/b"]),
            ('symlink("/dev/pts/1", "/run/lidar") = 0', ["/run/lidar"]),
            ('fchmod(5</tmp/c>, 0600)           = 0', ["/tmp/c"]),
            ('fchmod(5<socket:[17]>, 0600)      = 0', []),
            ('setxattr("/tmp/c", "user.a", "/tmp/d", 6, 0) = 0', ["/tmp/c"]),
            ('bind(6<socket:[18]>, {sa_family=AF_UNIX, sun_path="/run/a.sock"}, 110) = 0', ["/run/a.sock"]),
            ('bind(6<socket:[18]>, {sa_family=AF_INET, sin_port=htons(0), sin_addr=inet_addr("0.0.0.0")}, 16) = 0', []),
        ):  # fmt: skip
            with self.subTest(line):
                self.assertEqual(changed_by(line), changed)

    def test_knows_which_mount_a_path_is_on(self):
        systems = FileSystems("21 1 8:1 / / rw - ext4 /dev/sda1 rw\n22 21 0:5 / /dev rw shared:2 - devtmpfs udev rw\n"
                              "23 22 0:6 / /dev/shm rw - tmpfs tmpfs rw\n24 21 8:2 / /mnt/a\\040b rw - vfat /dev/sdb1 rw")  # fmt: skip
        self.assertEqual([systems.type_of(path) for path in ("/etc/x", "/dev/shm/x/y", "/dev/null", "/mnt/a b/c")],
                         ["ext4", "tmpfs", "devtmpfs", "vfat"])
        self.assertFalse(systems.are_in_ram("/devices"))


class OnAFullDisk(InRam):
    """The root and all other disks are read-only, and the home folder and /tmp are on a disk without a free byte."""

    has_own_network = False

    @classmethod
    def setUpClass(cls):
        if os.geteuid() != 0 or subprocess.run(["unshare", "--mount", "true"], capture_output=True, check=False).returncode != 0:
            raise unittest.SkipTest("a mount namespace needs root")
        if any(str(pathlib.Path(path).resolve()).startswith("/tmp/") for path in (PROGRAM, LAUNCH_FILE)):
            raise unittest.SkipTest("the program is in /tmp, which this test fills")
        super().setUpClass()
        cls.root = cls.folder / "root"
        cls.root.mkdir()

    def run_there(self, *words, environment=None):
        command = ["unshare", "--mount", "--propagation", "private", "sh", "-c", ON_A_FULL_DISK, "sh", self.root, self.folder, PROGRAM, *words]
        return subprocess.run(command, env={**(environment or self.environment), "RAM": " ".join(RAM)}, capture_output=True, text=True,
                              timeout=120 * SLOW, check=False)  # fmt: skip

    def test_a_robot_comes_up_and_goes_down(self):
        for environment in (self.environment, self.without_runtime_dir):
            outcome = self.expect_exit(self.run_there("drive", "--for", "2", environment=environment), 0)
            self.assertIn("bring-up", outcome.stdout)
            self.assertEqual(outcome.stderr, "")

    def test_a_file_that_cannot_be_written_is_named(self):
        refused = self.expect_exit(self.run_there("launch", LAUNCH_FILE, "network:=off", "--report", "/var/report.json"), 1)
        self.assertIn("/var/report.json: the report cannot be written: Read-only file system", refused.stderr)
        late = self.expect_exit(self.run_there("drive", "--for", "1", "--report", "/tmp/report.json"), 1)
        self.assertIn("/tmp/report.json", late.stderr)
        self.assertIn("No space left on device", late.stderr)

    def test_a_robot_without_a_place_for_its_state_or_log_is_refused(self):
        ended = self.run_there("launch", LAUNCH_FILE, "network:=off", "--state", "/tmp/state", "--transitions", "/var/steps")
        self.assertEqual(ended.returncode, 1)
        self.assertIn("/var/steps: the log of transitions cannot be written: Read-only file system", ended.stderr)


def with_own_ram():
    """Runs this file again, as root, with a /dev/shm and a /run of its own: the commands of all tests look into a folder in /dev/shm for containers
    without a runtime folder. A robot's /run is in RAM, which that of a chroot or of a container image need not be."""
    mount = 'mount -t tmpfs -o mode=1777 nacelle /dev/shm && mount -t tmpfs -o mode=755 nacelle /run && exec "$@"'
    os.environ[OWN_RAM] = "yes"
    os.execvp("unshare", ["unshare", "--mount", "--propagation", "private", "sh", "-c", mount, "sh", sys.executable, "-B", *sys.argv])


if __name__ == "__main__":
    if OWN_RAM not in os.environ and subprocess.run(["unshare", "--mount", "true"], capture_output=True, check=False).returncode == 0:
        with_own_ram()
    unittest.main()
