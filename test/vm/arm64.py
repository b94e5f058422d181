#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""Divides the tests of a cross build between qemu-user and a virtual machine, and runs those of the machine.

Under qemu-user, ctest runs the programs that are tests: unit, conformance and model tests, and fuzz corpora. What qemu-user cannot do
is listed in arm64.txt, a line each: "TEST: reason", or "TEST CASES: reason" with a pattern of GoogleTest's --gtest_filter. The same lines
are what the machine runs, which has a kernel of its own. System tests in Python may be listed, too.

usage: arm64.py targets BUILD -- ARGS   what to build for the tests that ctest with these arguments would run
       arm64.py left-out BUILD          what ctest leaves out under qemu-user: a regular expression of tests, a pattern of cases
       arm64.py run BUILD [--pages 4|16] [--only TEST]... [--all]
  --pages  the kernel's page size in KiB (default 4): with 16, Debian 13's kernel and the processor of a Pi 5
  --only   these tests alone, all their cases, listed or not;  --all   every test that is a program
The list is checked: a test or a case that does not exist is an error.
"""
import argparse
import json
import re
import shlex
import subprocess
import sys
import tempfile
import time
from pathlib import Path
from typing import NamedTuple

HERE = Path(__file__).resolve().parent
ROOT = HERE.parents[1]
LINE = re.compile(r"(?P<test>\w+)(?: (?P<cases>[\w.*?/]+))?: (?P<reason>\S.*)")
TEST_LIMIT_S, BOOT_LIMIT_S = 900, 300
OF_FILES = ("policy_binaries",)  # reads what was built, and runs none of it
SLOWNESS = 10  # how much longer than on this machine a test may wait


class Test(NamedTuple):
    command: list
    folder: str
    environment: list
    emulated: bool  # a program that ctest runs under qemu-user
    in_machine: bool  # runs a machine itself


def tests_of(build: Path, *selection) -> dict:
    """Name -> Test, of everything that ctest knows, or selects with these arguments; the emulator is left out of commands."""
    said = subprocess.run(["ctest", "--test-dir", build, "--show-only=json-v1", *selection], capture_output=True, text=True, check=True)
    tests = {}
    for entry in json.loads(said.stdout)["tests"]:
        properties = {item["name"]: item["value"] for item in entry.get("properties", [])}
        command = entry.get("command", [])
        emulated = bool(command) and Path(command[0]).name.startswith("qemu-")
        if emulated:
            command = command[command.index("-L") + 2 :]
        tests[entry["name"]] = Test(
            command, properties.get("WORKING_DIRECTORY", str(build)), properties.get("ENVIRONMENT", []), emulated, "vm" in properties.get("LABELS", [])
        )
    return tests


def targets_of(tests: dict) -> list:
    """A program that is a test is a target of its name; a test in a virtual machine may need any of them, and policies read them all."""
    names = [name for name, test in tests.items() if test.emulated]
    return ["test/all"] if any(test.in_machine or name in OF_FILES for name, test in tests.items()) else names


def cases_of(build: Path, command: list, pattern: str) -> bool:
    """Whether a GoogleTest program has cases of that pattern; one that was not built may have any."""
    if not Path(command[0]).exists():
        return True
    words = ["qemu-aarch64-static", "-L", str(build / "sysroot"), *command, "--gtest_list_tests", f"--gtest_filter={pattern}"]
    return bool(subprocess.run(words, capture_output=True, text=True, check=True).stdout.strip())


def read_list(text: str, tests: dict, has_cases) -> dict:
    """Name -> patterns of cases (none: all of them). Raises ValueError at a line that names nothing."""
    listed = {}
    for number, line in enumerate(text.splitlines(), 1):
        if not line.strip() or line.startswith("#"):
            continue
        match = LINE.fullmatch(line)
        if match is None:
            raise ValueError(f"arm64.txt:{number}: '{line}' is not 'TEST: reason' or 'TEST CASES: reason'")
        name, cases = match["test"], match["cases"]
        if name not in tests:
            raise ValueError(f"arm64.txt:{number}: there is no test '{name}'; remove the line or correct the name (ctest -N lists them)")
        if name in listed and not (cases and listed[name]):
            raise ValueError(f"arm64.txt:{number}: '{name}' is listed already, all of it; remove one of the lines")
        if cases and not has_cases(tests[name].command, cases):
            raise ValueError(f"arm64.txt:{number}: '{name}' has no case '{cases}'; remove the line or correct the pattern")
        listed.setdefault(name, []).extend([cases] if cases else [])
    return listed


def left_out(tests: dict, listed: dict) -> tuple:
    """A regular expression of the tests that ctest leaves out under qemu-user, and the patterns of cases."""
    names = [
        name
        for name, test in tests.items()
        if not test.in_machine and name not in OF_FILES and (not test.emulated or listed.get(name) == [])
    ]
    patterns = [pattern for name, cases in listed.items() if tests[name].emulated for pattern in cases]
    return "^(" + "|".join(names) + ")$", "-" + ":".join(patterns) if patterns else "*"


def script_of(wanted: dict, tests: dict) -> str:
    """What the machine runs: every test, its output and its exit code below /out."""
    lines = ["grep -qs localhost /etc/hosts || echo 127.0.0.1 localhost >>/etc/hosts"]  # the sysroot has no such file
    for name, cases in wanted.items():
        test = tests[name]
        words = list(test.command) + ([f"--gtest_filter={':'.join(cases)}"] if cases else [])
        environment = [*test.environment, f"NACELLE_TEST_SLOWNESS={SLOWNESS}"]
        command = ["env", *environment, "timeout", "-k", "5", str(TEST_LIMIT_S), *words]
        lines += [
            f"cd {shlex.quote(test.folder)}; read -r begin rest </proc/uptime",
            f"{shlex.join(command)} >/out/{name}.log 2>&1; status=$?; read -r end rest </proc/uptime",
            f'echo "$status $begin $end" >/out/{name}.status; echo "vmrun: {name}: exit $status"',
        ]
    return "\n".join(lines) + "\n"


def machine(build: Path, pages: int, script: str, out: Path, limit_s: int) -> int:
    flavour = ["--release", "trixie", "--flavour", "arm64-16k"] if pages == 16 else []
    made = subprocess.run([ROOT / ".ci/kernel", *flavour], stdout=subprocess.PIPE, text=True, check=False)
    if made.returncode != 0:
        print(made.stdout.strip())
        return made.returncode
    (out / "tests.sh").write_text(script)
    # ROOT is an ancestor of the build, or else a folder of its own.
    shares = [ROOT] + ([] if build.is_relative_to(ROOT) else [build])
    words = [HERE / "vmrun.sh", "-k", made.stdout.strip(), "-r", (build / "sysroot").resolve(), "-p", "cortex-a76" if pages == 16 else "cortex-a72"]
    for share in shares:
        words += ["-s", share]
    return subprocess.run([*words, "-M", "3072", "-t", str(limit_s), "-o", out, "--", "bash", "/out/tests.sh"], check=False).returncode


def report(out: Path, wanted: dict) -> int:
    """Prints a line for each test, and the output of those that failed; how many did."""
    failed = 0
    for name in wanted:
        log, status = out / f"{name}.log", out / f"{name}.status"
        text = log.read_text(errors="replace") if log.is_file() else ""
        code, seconds = "none", ""
        if status.is_file():
            code, begin, end = status.read_text().split()
            seconds = f", {float(end) - float(begin):.0f} s of the machine"
        sums = re.findall(r"^(?:\[  PASSED  \] |Ran )(\d+ tests?)", text, re.MULTILINE) or ["1 test"]
        skipped = len(re.findall(r"^\[  SKIPPED \] \w+\.\w+ \(", text, re.MULTILINE))
        good = code == "0" and not sums[-1].startswith("0 ")  # where all was skipped, nothing was tested
        print(f"{name}: {'passed' if good else 'FAILED, exit code ' + code} ({sums[-1]}, {skipped} skipped{seconds})")
        if not good:
            failed += 1
            print("".join(f"    {line}\n" for line in text.splitlines()[-60:]))
    return failed


def main() -> int:
    parser = argparse.ArgumentParser()
    parser.add_argument("what", choices=("targets", "left-out", "run"))
    parser.add_argument("build", type=Path)
    parser.add_argument("selection", nargs="*")
    parser.add_argument("--pages", type=int, choices=(4, 16), default=4)
    parser.add_argument("--only", action="append")
    parser.add_argument("--all", action="store_true")
    wish = parser.parse_args()
    build = wish.build.resolve()
    if wish.what == "targets":
        print(*targets_of(tests_of(build, *wish.selection)), sep="\n")
        return 0
    tests = tests_of(build)
    try:
        listed = read_list((HERE / "arm64.txt").read_text(), tests, lambda command, cases: cases_of(build, command, cases))
    except ValueError as error:
        print(error, file=sys.stderr)
        return 1
    if wish.what == "left-out":
        print(*left_out(tests, listed), sep="\n")
        return 0
    wanted = listed
    if wish.only:
        wanted = {name: [] for name in wish.only}
    elif wish.all:
        wanted = {name: [] for name, test in tests.items() if test.emulated}
    unknown = [name for name in wanted if name not in tests]
    if unknown:
        print(f"there is no test '{unknown[0]}' (ctest --test-dir {build} -N lists them)", file=sys.stderr)
        return 1
    with tempfile.TemporaryDirectory() as folder:
        begin = time.monotonic()
        code = machine(build, wish.pages, script_of(wanted, tests), Path(folder), BOOT_LIMIT_S + TEST_LIMIT_S * len(wanted))
        if code == 77:
            return 77
        failed = report(Path(folder), wanted)
        print(f"{len(wanted) - failed} of {len(wanted)} tests passed in the machine, {time.monotonic() - begin:.0f} s")
        return 1 if failed or code != 0 else 0


if __name__ == "__main__":
    sys.exit(main())
