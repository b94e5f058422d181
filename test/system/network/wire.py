# SPDX-License-Identifier: Apache-2.0
"""A robot and a laptop, each in a network of its own, with one wire between them: slow, lossy or cut at will."""
import json
import os
import shutil
import signal
import subprocess
import sys
import time
import unittest

ROBOT = os.environ["NACELLE_NETWORK_ROBOT"]
METER = os.environ["NACELLE_CYCLONE_METER"]
TOOLS = ("ip", "nft", "nsenter", "tc", "unshare")
STREAMS_HZ = {"image": 30, "scan": 10, "odom": 50, "tf": 100}
SMALL = ("scan", "odom", "tf")
INTERFACE = '<General><Interfaces><NetworkInterface name="wire0"/></Interfaces></General>'
# As cyclone_config() writes it for a network: a datagram in a frame.
ROBOT_CONFIG = INTERFACE.replace("</General>", "<MaxMessageSize>1452B</MaxMessageSize></General>")
PATH = os.environ.get("PATH", "") + ":/usr/sbin:/sbin"


def missing():
    """Why networks of one's own cannot be had here; empty: they can."""
    lacking = [tool for tool in TOOLS if shutil.which(tool, path=PATH) is None]
    if lacking:
        return "not installed: " + ", ".join(lacking)
    tried = subprocess.run(["unshare", "--net", "tc", "qdisc", "add", "dev", "lo", "root", "tbf", "rate", "1mbit", "burst", "4kb",
                            "limit", "64kb"], capture_output=True, text=True, env={**os.environ, "PATH": PATH}, check=False)
    return tried.stderr.strip()


def become_root_of_an_own_world():
    """Who is not root may be it in a user namespace: the program is started once more."""
    if os.geteuid() != 0 and "NACELLE_OWN_WORLD" not in os.environ and shutil.which("unshare"):
        os.environ["NACELLE_OWN_WORLD"] = "1"
        os.execvp("unshare", ["unshare", "--user", "--map-root-user", sys.executable, "-B", *sys.argv])


class Host:
    """A network namespace that lives as long as this."""

    def __init__(self):
        self.holder = subprocess.Popen(["unshare", "--net", "sh", "-c", "echo; exec cat"], stdin=subprocess.PIPE,
                                       stdout=subprocess.PIPE, env={**os.environ, "PATH": PATH})
        self.holder.stdout.readline()
        self.inside = ["nsenter", f"--net=/proc/{self.holder.pid}/ns/net"]

    def run(self, *words, text=None):
        subprocess.run([*self.inside, *map(str, words)], check=True, input=text, text=True,
                       env={**os.environ, "PATH": PATH}, stdout=subprocess.DEVNULL)

    def close(self):
        self.holder.stdin.close()
        self.holder.wait()
        self.holder.stdout.close()


class Program:
    """One that answers `measure SECONDS` with a line of JSON."""

    def __init__(self, host, *words, **environment):
        self.process = subprocess.Popen([*host.inside, *map(str, words)], stdin=subprocess.PIPE, stdout=subprocess.PIPE,
                                        text=True, env={**os.environ, "PATH": PATH, **environment})
        assert self.process.stdout.readline() == "ready\n", f"{words[0]} did not start"

    def ask(self, seconds):
        self.process.stdin.write(f"measure {seconds}\n")
        self.process.stdin.flush()

    def answer(self):
        return json.loads(self.process.stdout.readline())

    def signal(self, number):
        self.process.send_signal(number)

    def close(self):
        """Its exit code and how many seconds its end took."""
        began = time.monotonic()
        self.process.send_signal(signal.SIGCONT)
        self.process.stdin.close()
        try:
            code = self.process.wait(60)
        except subprocess.TimeoutExpired:
            self.process.kill()
            code = self.process.wait()
        self.process.stdout.close()
        return code, time.monotonic() - began


class WireTest(unittest.TestCase):
    """Robot and laptop, and the wire between them, which tests can disturb."""

    @classmethod
    def setUpClass(cls):
        why_not = missing()
        if why_not:
            raise unittest.SkipTest(why_not)

    def setUp(self):
        self.here, self.there = Host(), Host()
        self.addCleanup(self.here.close)
        self.addCleanup(self.there.close)
        self.here.run("ip", "link", "add", "wire0", "type", "veth", "peer", "name", "wire0", "netns", self.there.holder.pid)
        for host, address in ((self.here, "10.77.0.1/24"), (self.there, "10.77.0.2/24")):
            host.run("ip", "address", "add", address, "dev", "wire0")
            host.run("ip", "link", "set", "lo", "up")
            host.run("ip", "link", "set", "wire0", "up")

    # --- the wire ----------------------------------------------------------------------------------------------------

    def lose(self, percent):
        """Of every hundred frames so many, both ways."""
        for host in (self.here, self.there):
            host.run("nft", "-f", "-", text=f"""table netdev wire {{
                chain lose {{
                    type filter hook ingress device wire0 priority 0
                    {"" if percent == 100 else f"numgen random mod 100 < {percent}"} drop
                }}
            }}
            """)

    def slow_down(self, rate, queue="1mb"):
        """What the robot sends; the queue in front of the wire holds so much."""
        self.here.run("tc", "qdisc", "add", "dev", "wire0", "root", "tbf", "rate", rate, "burst", "4kb", "limit", queue)

    def mend(self):
        for host in (self.here, self.there):
            subprocess.run([*host.inside, "nft", "flush", "ruleset"], check=False, capture_output=True)
        subprocess.run([*self.here.inside, "tc", "qdisc", "del", "dev", "wire0", "root"], check=False, capture_output=True)

    # --- participants ------------------------------------------------------------------------------------------------

    def start_robot(self, *words):
        robot = Program(self.here, ROBOT, "--domain", 7, "--config", ROBOT_CONFIG, *words)
        self.addCleanup(robot.close)
        return robot

    def start_meter(self, *words):
        meter = Program(self.there, METER, "--domain", 7, *words, CYCLONEDDS_URI=INTERFACE)
        self.addCleanup(meter.close)
        return meter

    def measure(self, seconds, robot, meter=None, what=""):
        """Both sides over the same time; prints the figures."""
        robot.ask(seconds)
        if meter:
            meter.ask(seconds)
        here = robot.answer()
        there = meter.answer() if meter else {}
        self.show(what, here, there)
        return here, there

    def show(self, what, here, there):
        print(f"\n{what}: rss {here['rss_kib']} KiB, cpu {here['cpu_percent']:.1f} %, wake-ups {here['network_wake_ups']}, "
              f"mirror {here['during']}")
        for name, near in here["streams"].items():
            far = there.get(name, {})
            print(f"  {name:5} here {near['hz']:6.2f} Hz p50 {near['p50_us']:6} p99 {near['p99_us']:6} us | there "
                  f"{far.get('hz', 0):6.2f} Hz p50 {far.get('p50_us', 0) / 1000:8.1f} p99 {far.get('p99_us', 0) / 1000:8.1f} ms | "
                  f"{near['remote_readers']} remote readers", flush=True)

    def wait_until_heard(self, robot, meter, names=tuple(STREAMS_HZ), limit_s=30):
        """Both programs have found each other and every stream arrives."""
        deadline = time.monotonic() + limit_s
        while True:
            robot.ask(0.5)
            meter.ask(0.5)
            here, there = robot.answer(), meter.answer()
            if all(there[name]["heard"] > 0 for name in names):
                return here
            self.assertLess(time.monotonic(), deadline, f"not heard: {[name for name in names if there[name]['heard'] == 0]}")

    # --- what must hold ----------------------------------------------------------------------------------------------

    def expect_local_rates(self, seconds, *measured):
        """Asserts rates within 1 % of those without a network, and two messages that the ends of the window may cut off. One of
        several windows suffices: a busy machine may spoil the others."""
        for name, hz in STREAMS_HZ.items():
            best = min((here["streams"][name]["heard"] for here in measured), key=lambda heard: abs(heard - hz * seconds))
            self.assertAlmostEqual(best, hz * seconds, delta=2 + 0.01 * hz * seconds, msg=f"{name} here")
