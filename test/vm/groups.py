#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""Runs a group of tests in a virtual machine that has the kernel's test devices, and tells what came of it.

usage: groups.py run GROUP PROGRAM --out FOLDER [--modules "MODULE[:OPTION=VALUE]... ..."] [--filter PATTERN] [--disk]
       groups.py table FOLDER GROUP...

A group is one GoogleTest program, one boot. With --disk it has a disk, an image that stays, and two boots (NACELLE_VM_BOOT is 1 or 2): the
first machine is killed, as by a power loss, when the last time in its /out/recorded is five seconds after the first one.

Its output and results, and the kernel's messages, are in FOLDER/GROUP afterwards. The exit code of `run` is 77 with a reason where there is
no virtual machine. NACELLE_VM_RELEASE: whose kernel (bookworm, default, or trixie).
"""
import argparse
import os
import platform
import shlex
import shutil
import signal
import subprocess
import sys
import time
import xml.etree.ElementTree as xml
from pathlib import Path

HERE = Path(__file__).resolve().parent
ROOT = HERE.parents[1]
SLOWNESS = 10  # how much longer than on this machine a test may wait
LIMIT_S = 900
DISK_MB = 256
RECORDED_S = 5  # before the power fails


def no_machine():
    """Why this computer runs no group; nothing if it does."""
    if platform.machine() != "x86_64":
        return f"groups of tests run on amd64 machines, and this is {platform.machine()}"
    if shutil.which("qemu-system-x86_64") is None:
        return "qemu-system-x86_64 is not installed (./dev setup vm)"
    return None


def not_built(kernel: Path, modules: str) -> list:
    """Which of the modules this kernel does not have. Those that are not Debian's want a compiler like the kernel's own."""
    there = {file.name.split(".ko")[0].replace("-", "_") for file in kernel.glob("lib/modules/*/**/*.ko*")}
    for builtin in kernel.glob("lib/modules/*/modules.builtin"):
        there |= {Path(line).name.removesuffix(".ko").replace("-", "_") for line in builtin.read_text().split()}
    wanted = [module.split(":")[0] for module in modules.split()]
    return [name for name in wanted if name.replace("-", "_") not in there]


def make_disk(image: Path) -> Path:
    """An empty ext4 in a file."""
    with image.open("wb") as file:
        file.truncate(DISK_MB << 20)
    environment = {**os.environ, "PATH": f"{os.environ.get('PATH', '')}:/usr/sbin:/sbin"}
    subprocess.run(["mkfs.ext4", "-q", "-F", image], env=environment, check=True)
    return image


def kill_while_it_records(words: list, out: Path) -> bool:
    """Runs a machine and kills it without a warning when it has recorded long enough. False if it ended before."""
    machine = subprocess.Popen(words)
    recorded = out / "recorded"
    while machine.poll() is None:
        times = [int(line) for line in recorded.read_text().split("\n")[:-1]] if recorded.is_file() else []
        if times and times[-1] - times[0] >= RECORDED_S * 1_000_000_000:
            os.kill(int((out / ".pid").read_text()), signal.SIGKILL)
            machine.wait()
            print(f"the first machine was killed after it had recorded {(times[-1] - times[0]) / 1e9:.1f} s")
            return True
        time.sleep(0.05)  # the polling period
    return False


def script_of(program: Path, pattern: str) -> str:
    """What the machine runs: the program, its output and results below /out, and the kernel's last word."""
    words = ["timeout", "-k", "5", str(LIMIT_S), str(program), "--gtest_output=xml:/out/results.xml", *([f"--gtest_filter={pattern}"] if pattern else [])]
    return (
        "mount -t configfs none /sys/kernel/config 2>/dev/null\n"
        f"cd /tmp; {shlex.join(words)} >/out/output.txt 2>&1; status=$?\n"
        "dmesg >/out/kernel.txt; exit $status\n"
    )


def cases_of(out: Path) -> list:
    """(name, "passed", "FAILED" or "skipped", reason) of each case."""
    file = out / "results.xml"
    if not file.is_file():
        return []
    cases = []
    for case in xml.parse(file).iter("testcase"):
        name = f"{case.get('classname')}.{case.get('name')}"
        if (found := case.find("failure")) is not None:
            cases.append((name, "FAILED", found.get("message", "").strip()))
        elif (found := case.find("skipped")) is not None:
            cases.append((name, "skipped", found.get("message", "").strip()))
        elif case.get("status") == "run":
            cases.append((name, "passed", ""))
    return cases


def table(folder: Path, groups: list) -> str:
    """A line for each group, and one for each case that failed or was skipped."""
    lines = [f"{'group':10} {'passed':>7} {'failed':>7} {'skipped':>8} {'seconds':>8}"]
    for group in groups:
        out = folder / group
        cases = cases_of(out)
        if (skipped := out / "skipped.txt").is_file():
            lines.append(f"{group:10} {skipped.read_text().strip()}")
            continue
        if not cases:
            said = out / "output.txt"
            lines.append(f"{group:10} no results: {'the program ended early' if said.is_file() else 'it did not run'}")
            continue
        count = {state: sum(case[1] == state for case in cases) for state in ("passed", "FAILED", "skipped")}
        seconds = (out / "seconds.txt").read_text().strip()
        lines.append(f"{group:10} {count['passed']:7} {count['FAILED']:7} {count['skipped']:8} {seconds:>8}")
        for name, state, reason in cases:
            if state != "passed":
                lines.append(f"    {state} {name}: {' '.join(reason.split())[:300]}")
    return "\n".join(lines)


def run(wish) -> int:
    out = (wish.out / wish.group).resolve()
    shutil.rmtree(out, ignore_errors=True)
    why = no_machine()
    if why is None:
        release = os.environ.get("NACELLE_VM_RELEASE", "bookworm")
        words = [ROOT / ".ci/kernel", "--release", release, "--flavour", "amd64"]
        made = subprocess.run(words, stdout=subprocess.PIPE, text=True, check=False)
        if made.returncode not in (0, 77):
            return made.returncode
        if made.returncode == 77:
            why = made.stdout.strip().removeprefix("skipped: ")
        elif release != "bookworm" and (missing := not_built(Path(made.stdout.strip()), wish.modules)):
            why = f"{', '.join(missing)} could not be compiled here for {release}'s kernel"
    out.mkdir(parents=True)
    if why is not None:
        (out / "skipped.txt").write_text(f"skipped: {why}\n")
        print(f"skipped: {why}")
        return 77
    (out / "test.sh").write_text(script_of(wish.program.resolve(), wish.filter))
    begin = time.monotonic()
    shares = {ROOT, wish.program.resolve().parent}  # the machine has /tmp and /run of its own
    words = [HERE / "vmrun.sh", "-k", made.stdout.strip(), "-m", wish.modules, "-t", str(LIMIT_S + 100), "-o", out]
    for share in shares if any(str(share).startswith(("/tmp/", "/run/")) for share in shares) else ():
        words += ["-s", share]
    environment = [f"NACELLE_TEST_SLOWNESS={SLOWNESS}", f"NACELLE_VM_GROUP={wish.group}"]
    if "NACELLE_VM_CYCLES" in os.environ:
        environment.append(f"NACELLE_VM_CYCLES={os.environ['NACELLE_VM_CYCLES']}")
    command = ["bash", "/out/test.sh"]
    if wish.disk:
        words += ["-d", make_disk(out / "disk.img")]
        if not kill_while_it_records([*words, "--", "env", *environment, "NACELLE_VM_BOOT=1", *command], out):
            print("the first machine ended by itself")
        environment.append("NACELLE_VM_BOOT=2")
    code = subprocess.run([*words, "--", "env", *environment, *command], check=False).returncode
    if code == 0:
        (out / "disk.img").unlink(missing_ok=True)
    (out / "seconds.txt").write_text(f"{time.monotonic() - begin:.0f}\n")
    said = out / "output.txt"
    print(said.read_text(errors="replace") if said.is_file() else "the program did not start")
    cases = cases_of(out)
    states = {state for _, state, _ in cases}
    if code == 0 and states <= {"passed", "skipped"} and "passed" in states:
        return 0
    kernel = out / "kernel.txt"
    if kernel.is_file():
        print("the kernel's last messages:", *kernel.read_text(errors="replace").splitlines()[-30:], sep="\n    ")
    print(f"{wish.group}: exit code {code} of the machine" + ("" if "passed" in states else "; no case passed: nothing was tested"))
    return code or 1


def main() -> int:
    parser = argparse.ArgumentParser()
    verbs = parser.add_subparsers(dest="what", required=True)
    running = verbs.add_parser("run")
    running.add_argument("group")
    running.add_argument("program", type=Path)
    running.add_argument("--out", type=Path, required=True)
    running.add_argument("--modules", default="")
    running.add_argument("--filter", default=os.environ.get("NACELLE_VM_FILTER", ""))
    running.add_argument("--disk", action="store_true")
    showing = verbs.add_parser("table")
    showing.add_argument("folder", type=Path)
    showing.add_argument("groups", nargs="+")
    wish = parser.parse_args()
    if wish.what == "run":
        return run(wish)
    print(table(wish.folder, wish.groups))
    return 0


if __name__ == "__main__":
    sys.exit(main())
