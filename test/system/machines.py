# SPDX-License-Identifier: Apache-2.0
"""Machines on a LAN of their own, made of network namespaces and veth pairs: their packets stay there."""
import contextlib
import ctypes
import os
import pathlib
import subprocess
import sys
import threading
import time
import unittest

from robot import interrupt, wait_for


def ip(*words):
    subprocess.run(["ip", *map(str, words)], check=True, capture_output=True, text=True)


def need_namespaces():
    """Skips the tests of a class where the kernel does not let us make networks."""
    tried = subprocess.run(["unshare", "-n", "true"], capture_output=True, text=True)
    if tried.returncode != 0 or os.geteuid() != 0:
        raise unittest.SkipTest("network namespaces need root: " + tried.stderr.strip())


def enter_own_network():
    """Takes this process, and what it starts, to a machine with an empty LAN. False if that is not permitted."""
    clone_newnet, clone_newns = 0x40000000, 0x20000  # sched.h; os.unshare() came with Python 3.12
    libc = ctypes.CDLL(None)
    if os.geteuid() != 0 or libc.unshare(clone_newnet) != 0:
        return False
    # A /dev/shm that ends with this process: Fast DDS leaves its shared memory behind when it is killed.
    if libc.unshare(clone_newns) == 0:
        private = (["mount", "--make-rprivate", "/"], ["mount", "--make-private", "/dev/shm"])  # in a chroot, / is no mount
        if any(subprocess.run(words, capture_output=True).returncode == 0 for words in private):
            subprocess.run(["mount", "-t", "tmpfs", "-o", "mode=1777,nosuid,nodev", "tmpfs", "/dev/shm"], check=True)
    ip("link", "set", "lo", "up")
    with contextlib.suppress(subprocess.CalledProcessError):  # a kernel without such links
        ip("link", "add", "lan0", "type", "dummy")
        ip("addr", "add", "192.168.1.20/24", "dev", "lan0")
        ip("link", "set", "lan0", "up")
    return True


class Machine:
    """A network namespace with a loopback interface. It ends with close(), and what runs in it then has no network."""

    def __init__(self):
        self.holder = subprocess.Popen(["unshare", "-n", "cat"], stdin=subprocess.PIPE, stdout=subprocess.DEVNULL)
        ours = os.readlink("/proc/self/ns/net")

        def is_apart():
            with contextlib.suppress(OSError):
                return os.readlink(f"/proc/{self.holder.pid}/ns/net") != ours
            return False

        wait_for("a network namespace", is_apart, 60)  # the kernel first takes those apart that were left: one after the other
        self.ip("link", "set", "lo", "up")

    def close(self):
        self.holder.stdin.close()
        self.holder.wait()

    def within(self, *words):
        """The command line that runs in this network."""
        return ["nsenter", "-t", str(self.holder.pid), "-n", *map(str, words)]

    def ip(self, *words):
        self.run("ip", *words)

    def run(self, *words):
        return subprocess.run(self.within(*words), check=True, capture_output=True, text=True)

    def sent(self, link):
        """Packets that have left by a link."""
        with open(f"/proc/{self.holder.pid}/net/dev", encoding="ascii") as file:
            for line in file:
                name, _, rest = line.partition(":")
                if name.strip() == link:
                    return int(rest.split()[9])
        raise AssertionError(f"no link {link}")

    def udp_sockets(self):
        """Bound addresses as (hex of the address, port)."""
        with open(f"/proc/{self.holder.pid}/net/udp", encoding="ascii") as file:
            return [tuple(line.split()[1].split(":")) for line in list(file)[1:]]


def named(host):
    """What a command line begins with that runs where the host's name is this."""
    return ["unshare", "--uts", "sh", "-c", f'hostname {host}; exec "$@"', "sh"]


def cable(one, other, name="lan0", network="10.77.0"):
    """Joins two machines: .1 and .2 on a link of the same name. IPv6 is off, so that the kernel itself says nothing."""
    ip("link", "add", name, "netns", one.holder.pid, "type", "veth", "peer", "name", name, "netns", other.holder.pid)
    for machine, address in ((one, 1), (other, 2)):
        plug_in(machine, name, f"{network}.{address}/24")


def plug_in(machine, name, address):
    machine.run("sh", "-c", f"echo 1 > /proc/sys/net/ipv6/conf/{name}/disable_ipv6")
    machine.ip("addr", "add", address, "dev", name)
    machine.ip("link", "set", name, "up")
    machine.ip("route", "add", "224.0.0.0/4", "dev", name)


@contextlib.contextmanager
def slow_cable(one, other, between, delay_s, name="lan0", network="10.77.0"):
    """The same with a third machine in the middle, which passes each frame on so much later; a kernel need not have netem."""
    for number, machine in enumerate((one, other), 1):
        ip("link", "add", name, "netns", machine.holder.pid, "type", "veth", "peer", "name", f"end{number}", "netns", between.holder.pid)
        plug_in(machine, name, f"{network}.{number}/24")
        between.ip("link", "set", f"end{number}", "up")
    program = pathlib.Path(__file__).with_name("slow_way.py")
    way = Lines(between.within(sys.executable, "-B", program, "end1", "end2", delay_s), os.environ)
    try:
        way.wait_for("the way is open", lambda line: line == "ready")
        yield
    finally:
        way.process.terminate()
        way.close()


REST_S = 1.0  # twice the timeout of the robot's inputs


def drive_until(moves, drive, robot=None):
    """Returns the program that drive() starts once moves(LIMIT_S) is content with the robot, which says what keeps it if it is given.

    On a busy machine the base may miss its cycles. It stops then, and ignores a sender until that has rested (rearm: neutral). So the
    driver ends, and after a rest a new one starts; one that starts at once is ignored as well.
    """
    for rounds_left in reversed(range(4)):
        driver = drive()
        try:
            moves(8)
            return driver
        except AssertionError as still:
            if rounds_left == 0:
                raise AssertionError(f"{still}; the robot said: {robot.read()[-20:] if robot else '?'}") from None
        driver.close()
        threading.Event().wait(REST_S)  # the rest


class Lines:
    """A program whose lines a test waits for."""

    def __init__(self, command, environment):
        self.process = subprocess.Popen(
            command, env=environment, stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, bufsize=0
        )
        os.set_blocking(self.process.stdout.fileno(), False)
        self.seen, self.rest = [], b""

    def read(self):
        with contextlib.suppress(BlockingIOError):
            while more := self.process.stdout.read(65536):
                *whole, self.rest = (self.rest + more).split(b"\n")
                self.seen += [line.decode(errors="replace") for line in whole]
        return self.seen

    def wait_for(self, what, fits, limit_s=30.0):
        """The first line that fits and has not been waited for yet."""

        def look():
            for number, line in enumerate(self.read()):
                if fits(line):
                    del self.seen[: number + 1]
                    return line
            if self.process.poll() is not None and not self.read():
                raise AssertionError(f"{what}: the program ended with {self.process.returncode}")
            return None

        try:
            return wait_for(what, look, limit_s)
        except AssertionError as failed:
            raise AssertionError(f"{failed}; it said: {self.seen[-20:]}") from None

    def within(self, seconds, fits):
        """Whether such a line comes in so long."""
        end = time.monotonic() + seconds
        while time.monotonic() < end:
            if any(fits(line) for line in self.read()):
                return True
            time.sleep(0.02)  # the polling period, not a synchronisation
        return False

    def go(self):
        self.process.stdin.write(b"\n")

    def interrupt(self):
        """Ends it as Ctrl-C does, and close()."""
        interrupt(self.process)
        self.close()

    def close(self):
        with contextlib.suppress(OSError):
            self.process.stdin.close()
        try:
            self.process.wait(5)
        except subprocess.TimeoutExpired:
            self.process.kill()
            self.process.wait()
        self.process.stdout.close()
