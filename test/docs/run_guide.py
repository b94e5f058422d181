#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""Runs the commands of a page as its reader would: in a Debian of its own, as a user with sudo, one login for each block.

usage: run_guide.py PAGE... --chroot DIR [--deb FILE]... [--timeout SECONDS]
       run_guide.py PAGE... --list

DIR holds a clean Debian of any architecture that this machine runs; it is changed. What Raspberry Pi OS Lite has and a small Debian
lacks is made first: sudo, systemd, the user `pi`, and files in /boot/firmware. The packages of --deb are put into the
user's home. Needs root.

A comment above a block of shell commands says how it is tested:

    <!-- tested: chroot -->           run here, in the order of the page; a failed command ends its block
    <!-- tested: chroot, exit 1 -->   as well; its exit code is 1
    <!-- tested: chroot, native -->   as well, but not where a chroot's programs are emulated: DDS has no multicast there
    <!-- tested: chroot, stays -->    as well, and it runs until the next such block or the end of the page: what a second terminal
                                      needs. The next block waits for its components to be active
    <!-- tested: NAME -->             another test, NAME, runs it
    <!-- not run: REASON -->          nothing runs it

A block of text below the comment `<!-- output -->` is what the block before it prints. There, `...` stands for anything: in a line for
a part of it, alone in a line for any number of lines.

systemd does not run: its tools write files, and start nothing.

Prints a line for each block, and the sum. The exit code is 0 if every block that was run succeeded and at least one was run.
"""
import argparse
import dataclasses
import os
import pathlib
import re
import shutil
import signal
import subprocess
import sys
import threading
import time

FENCE = re.compile(r"^(?:<!-- (?P<mark>[^\n]*?) -->\n)?```(?P<language>\w*)\n(?P<text>.*?)^```$", re.MULTILINE | re.DOTALL)
MARK = re.compile(r"tested: chroot(?:, exit (?P<exit>\d+)|(?P<native>, native)|(?P<stays>, stays))?$|tested: (?P<test>\w+)$|not run: (?P<reason>\S.*)$")
USER = "pi"
# Those of the first user of Raspberry Pi OS.
GROUPS = "adm,dialout,cdrom,sudo,audio,video,plugdev,games,users,input,render,netdev,gpio,i2c,spi"
# What the image has when it is new, in the parts that guides change. Source: pi-gen, stage1/00-boot-files and export-image.
BOOT_FILES = {
    "config.txt": "dtparam=audio=on\ncamera_auto_detect=1\nauto_initramfs=1\ndtoverlay=vc4-kms-v3d\narm_64bit=1\n[cm5]\ndtoverlay=dwc2,dr_mode=host\n\n[all]\n",
    "cmdline.txt": "console=serial0,115200 console=tty1 root=PARTUUID=4f2c1a9e-02 rootfstype=ext4 fsck.repair=yes rootwait\n",
}
ACTIVE = re.compile(r"\d+ components? active in ")


class PageError(Exception):
    """A page that cannot be run; says where and why."""


@dataclasses.dataclass
class Block:
    """A block of shell commands."""

    place: str  # page:line
    text: str
    mark: re.Match
    output: str | None = None  # what the page shows

    @property
    def in_chroot(self):
        return not self.mark["test"] and not self.mark["reason"]

    @property
    def title(self):
        lines = self.text.strip().splitlines()
        return lines[0][:80] + (f" (+{len(lines) - 1})" if len(lines) > 1 else "")


def blocks_of(page, text, every=True):
    """The blocks of shell commands of a page. Unless `every`, those without a comment are left out. Raises PageError."""
    blocks = []
    for fence in FENCE.finditer(text):
        place = f"{page}:{text.count(chr(10), 0, fence.start('text'))}"
        if fence["language"] == "sh":
            if not every and fence["mark"] is None:
                continue
            mark = MARK.match(fence["mark"] or "")
            if not mark:
                raise PageError(f"{place}: the comment above the block is '{fence['mark'] or ''}'; use 'tested: chroot', 'tested: NAME' or 'not run: REASON'")
            blocks.append(Block(place, fence["text"], mark))
        elif fence["mark"] == "output":
            if not blocks or not blocks[-1].in_chroot or blocks[-1].output is not None:
                raise PageError(f"{place}: this output belongs to no block that runs in a chroot")
            blocks[-1].output = fence["text"]
    return blocks


def is_shown(shown, printed):
    """Whether lines that a page shows are what was printed."""
    pattern = ""
    for line in shown.strip("\n").splitlines():
        pattern += r"(?:.*\n)*?" if line.strip() == "..." else "[^\n]*".join(re.escape(part) for part in line.rstrip().split("...")) + "\n"
    return re.fullmatch(pattern, "".join(line.rstrip() + "\n" for line in printed.strip("\n").splitlines())) is not None


class Debian:
    """The system in a folder, in namespaces of its own: nothing of it outlives this program."""

    def __init__(self, root, timeout):
        self.root, self.timeout = root, timeout
        self.staying = None
        self.staying_output = []

    def mount(self):
        for kind, place, options in (("proc", "proc", ""), ("devpts", "dev/pts", "newinstance,ptmxmode=0666,mode=0620"), ("tmpfs", "dev/shm", "mode=1777"), ("tmpfs", "run", "mode=755")):  # fmt: skip
            (self.root / place).mkdir(parents=True, exist_ok=True)
            subprocess.run(["mount", "-t", kind, *(["-o", options] if options else []), kind, self.root / place], check=True)
        (self.root / "run" / "systemd" / "system").mkdir(parents=True)  # sd_booted(3)
        ptmx = self.root / "dev" / "ptmx"
        ptmx.unlink(missing_ok=True)
        ptmx.symlink_to("pts/ptmx")
        subprocess.run(["hostname", "robot"], check=True)
        (self.root / "etc" / "hosts").write_text("127.0.0.1 localhost\n127.0.1.1 robot\n")
        shutil.copy("/etc/resolv.conf", self.root / "etc" / "resolv.conf")

    def is_emulated(self):
        """Whether its programs are of another processor than this one's: byte 18 of an ELF file names it."""
        here, there = (path.read_bytes()[18:20] for path in (pathlib.Path("/usr/bin/env"), self.root / "usr" / "bin" / "env"))
        return here != there

    def command(self, user, script):
        """A login of the user, who runs a script."""
        clean = ["env", "-i", "PATH=/usr/sbin:/usr/bin:/sbin:/bin", "LANG=C.UTF-8", "DEBIAN_FRONTEND=noninteractive"]
        return [*clean, "chroot", self.root, "runuser", "-l", user, "-w", "DEBIAN_FRONTEND", "--session-command", f"set -euo pipefail\n{script}"]

    def run(self, user, script):
        """The exit code (124: it took too long), and the output."""
        try:
            done = subprocess.run(self.command(user, script), stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.STDOUT,
                                  text=True, errors="replace", check=False, timeout=self.timeout)  # fmt: skip
        except subprocess.TimeoutExpired as late:
            return 124, (late.stdout or b"").decode(errors="replace") + f"\n(ended after {self.timeout} s)\n"
        return done.returncode, done.stdout

    def start(self, script):
        """Runs what stays until `stop`. Returns once its components are active: an exit code if it ended before, and the output."""
        self.staying_output = []
        self.staying = subprocess.Popen(self.command(USER, script), stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.STDOUT,
                                        text=True, errors="replace", start_new_session=True)  # fmt: skip
        active = threading.Event()

        def read(process):
            with process:
                for line in process.stdout:
                    self.staying_output.append(line)
                    if ACTIVE.search(line):
                        active.set()
            active.set()

        threading.Thread(target=read, args=(self.staying,), daemon=True).start()
        late = not active.wait(self.timeout)
        return 124 if late else self.staying.poll(), "".join(self.staying_output)

    def stop(self):
        """Ends what stays as Ctrl-C does."""
        if self.staying is None:
            return
        processes = subprocess.run(["pgrep", "-s", str(self.staying.pid)], capture_output=True, text=True, check=False).stdout.split()
        for process in processes:
            try:
                os.kill(int(process), signal.SIGINT)
            except ProcessLookupError:
                pass  # it ended with its parent
        try:
            self.staying.wait(60)
        except subprocess.TimeoutExpired:
            os.killpg(self.staying.pid, signal.SIGKILL)
        self.staying = None

    def prepare(self, debs):
        """Makes what Raspberry Pi OS Lite has."""
        script = f"""
            missing=""
            for name in sudo systemd udev; do dpkg-query -W -f='${{Status}}' $name 2>/dev/null | grep -q 'ok installed' || missing+=" $name"; done
            if [[ -n $missing ]]; then apt-get -q update; apt-get -q -y install --no-install-recommends $missing; fi
            for group in {GROUPS.replace(",", " ")}; do getent group $group >/dev/null || groupadd -r $group; done
            id -u {USER} >/dev/null 2>&1 || useradd -m -s /bin/bash {USER}
            usermod -aG {GROUPS} {USER}
            echo '{USER} ALL=(ALL) NOPASSWD: ALL' >/etc/sudoers.d/010_{USER}-nopasswd
            echo 'Defaults env_keep += "DEBIAN_FRONTEND"' >/etc/sudoers.d/011_frontend
            echo 'APT::Get::Assume-Yes "true";' >/etc/apt/apt.conf.d/90{USER}-says-yes
            """
        code, said = self.run("root", script)
        if code != 0:
            raise PageError(f"{self.root}: what Raspberry Pi OS Lite has could not be installed ({code}):\n{said}")
        firmware = self.root / "boot" / "firmware"
        firmware.mkdir(parents=True, exist_ok=True)
        for name, text in BOOT_FILES.items():
            (firmware / name).write_text(text)
        home = self.root / "home" / USER
        for old in home.glob("*.deb"):
            old.unlink()
        for deb in debs:
            shutil.copy(deb, home)


def run_pages(blocks, debian):
    """Runs the blocks, prints a line for each. Returns how many passed, failed and were left out."""
    passed = failed = left_out = 0
    for block in blocks:
        if not block.in_chroot:
            left_out += bool(block.mark["reason"])
            print(f"{'tested by ' + block.mark['test'] if block.mark['test'] else 'not run'}  {block.place}  {block.title}"
                  + (f"  ({block.mark['reason']})" if block.mark["reason"] else ""), flush=True)  # fmt: skip
            continue
        if block.mark["native"] and debian.is_emulated():
            left_out += 1
            print(f"not run  {block.place}  {block.title}  (its programs are emulated)", flush=True)
            continue
        begin = time.monotonic()
        if block.mark["stays"]:
            debian.stop()
            code, said = debian.start(block.text)
            bad = None if code is None else f"it ended with {code}, and should stay"
        else:
            code, said = debian.run(USER, block.text)
            bad = f"exit code {code}" if code != int(block.mark["exit"] or 0) else None
        if bad is None and block.output is not None and not is_shown(block.output, said):
            bad = f"its output is not the one of the page, which is\n{block.output}\nIt printed"
        print(f"{'FAILED' if bad else 'ran'} {time.monotonic() - begin:6.1f} s  {block.place}  {block.title}", flush=True)
        if bad:
            failed += 1
            print(f"{block.place}: {bad}\n{said}", flush=True)
        else:
            passed += 1
    debian.stop()
    return passed, failed, left_out


def parse_arguments():
    parser = argparse.ArgumentParser(usage=__doc__.split("\n\n", maxsplit=2)[1].removeprefix("usage: "))
    parser.add_argument("pages", nargs="+", type=pathlib.Path, metavar="PAGE")
    parser.add_argument("--chroot", type=lambda text: pathlib.Path(text).resolve(), metavar="DIR")
    parser.add_argument("--deb", type=pathlib.Path, action="append", default=[], metavar="FILE")
    parser.add_argument("--timeout", type=float, default=900, metavar="SECONDS")
    parser.add_argument("--list", action="store_true")
    return parser.parse_args()


def main():
    arguments = parse_arguments()
    blocks = [block for page in arguments.pages for block in blocks_of(page, page.read_text(), every=page.name != "README.md")]
    if arguments.list:
        for block in blocks:
            print(f"{block.mark[0]}  {block.place}  {block.title}")
        return 0
    if arguments.chroot is None or not (arguments.chroot / "etc" / "debian_version").is_file():
        raise PageError(f"--chroot {arguments.chroot}: give the folder of a Debian, as debootstrap makes it")
    if os.geteuid() != 0:
        raise PageError("a chroot needs root")
    for deb in arguments.deb:
        if not deb.is_file():
            raise PageError(f"--deb {deb}: there is no such file")
    if os.getpid() != 1:  # once more, in namespaces of its own
        os.execvp("unshare", ["unshare", "--mount", "--uts", "--pid", "--fork", "--kill-child", "--mount-proc", sys.executable, "-B", *sys.argv])
    debian = Debian(arguments.chroot, arguments.timeout)
    debian.mount()
    debian.prepare(arguments.deb)
    passed, failed, left_out = run_pages(blocks, debian)
    print(f"{passed} passed, {failed} failed, {left_out} skipped")
    return 0 if failed == 0 and passed > 0 else 1


if __name__ == "__main__":
    try:
        sys.exit(main())
    except (PageError, OSError) as error:
        sys.exit(f"run_guide.py: {error}")
