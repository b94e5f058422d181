#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""Compares what a message costs, in counts, with what was recorded for this release, compiler and architecture.

usage: counts.py --programs FOLDER [--record]

Counts do not depend on how busy the machine is: instructions, mallocs, locked instructions and system calls of M1 to M3. The exit
code is 1 when one of them is more than 1 % above its record. --record writes counts.json anew for this release and compiler.
"""
import argparse
import json
import platform
import re
import subprocess
import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parent))
from measure import Programs  # noqa: E402  (python3 -I leaves this folder out of the path)

RECORDS = Path(__file__).resolve().parent / "counts.json"
TOLERANCE = 0.01
# The executor reads a thread's CPU clock at times that the clock chooses: a few system calls per thousand messages more or less.
SLACK = {"system calls": 0.005, "mallocs": 0.0005, "locked instructions": 0.005}
TRIES = 3


def place(compiler):
    """Names what the counts depend on: "debian 12, g++ 12.2.0, x86_64"."""
    release = dict(re.findall(r'^(\w+)="?([^"\n]*)"?$', Path("/etc/os-release").read_text(encoding="utf-8"), re.MULTILINE))
    version = subprocess.run([compiler, "-dumpfullversion"], capture_output=True, text=True, check=True).stdout.strip()
    return f"{release['ID']} {release['VERSION_ID']}, g++ {version}, {platform.machine()}"


def per_message(figure):
    return lambda programs, path: (run := programs.run("handover", path=path, messages=20000))[figure] / run["delivered"]


def system_calls(programs, path, few, many):
    # strace stops the threads at each call, so that it finds a reader awake that was to be found asleep.
    if path == "asleep" and programs.calls_are_counted_by != "perf":
        return None
    return programs.syscalls("handover", path=path, few=few, many=many)


def counts():
    """The name of each count, and what counts it."""
    for take, name in (("const_ref", "const T&"), ("loan", "Loan<T>"), ("shared", "shared_ptr<const T>")):
        yield f"M1 instructions, {name}", lambda programs, take=take: programs.instructions("handover", path="inline", take=take)
    yield "M1 instructions, four readers", lambda programs: programs.instructions("handover", path="inline", readers=4)
    yield "M1 locked instructions", lambda programs: (programs.steps(path="inline") or {}).get("locked")
    for goal, path, few, many in (("M1", "inline", 20000, 60000), ("M2", "asleep", 2000, 12000), ("M3", "busy", 5000, 15000)):
        if goal != "M1":
            yield f"{goal} instructions", lambda programs, path=path: programs.instructions("handover", path=path)
        yield f"{goal} mallocs", lambda programs, path=path: per_message("mallocs")(programs, path)
        yield f"{goal} system calls", lambda programs, path=path, few=few, many=many: system_calls(programs, path, few, many)


def limit_of(name, recorded):
    slack = next((value for word, value in SLACK.items() if word in name), 0)
    return recorded * (1 + TOLERANCE) + slack


def compare(programs, recorded, say=print):
    """Counts everything; a count that is above its limit is taken up to three times, since a scheduler may be in it."""
    measured, above = {}, []
    for name, count in counts():
        was = recorded.get(name)
        value = None
        for _ in range(TRIES):
            again = count(programs)
            if again is None:
                break
            value = again if value is None else min(value, again)
            if was is None or value <= limit_of(name, was):
                break
        measured[name] = None if value is None else round(value, 4)
        verdict = ""
        if value is None:
            verdict = "not measured: this kernel does not let it be counted here"
        elif was is not None and value > limit_of(name, was):
            verdict = f"ABOVE the limit of {limit_of(name, was):.4g}"
            above.append(name)
        say(f"{name:<36} {'-' if value is None else format(value, '.4g'):>9}   recorded {'-' if was is None else format(was, '.4g'):>9}   {verdict}".rstrip())
    return measured, above


def main():
    words = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    words.add_argument("--programs", required=True)
    words.add_argument("--compiler", default="c++")
    words.add_argument("--record", action="store_true")
    asked = words.parse_args()
    records = json.loads(RECORDS.read_text(encoding="utf-8")) if RECORDS.is_file() else {}
    here = place(asked.compiler)
    recorded = {} if asked.record else records.get(here, {})
    print(f"counts per message on {here}")
    measured, above = compare(Programs(asked.programs), recorded)
    if asked.record:
        records[here] = {name: value for name, value in measured.items() if value is not None}
        RECORDS.write_text(json.dumps(records, indent=1, sort_keys=True) + "\n", encoding="utf-8")
        print(f"recorded in {RECORDS.name}")
    elif not recorded:
        print(f"skipped: nothing is recorded for {here}; ./dev bench --counts --record does")
    return 1 if above else 0


if __name__ == "__main__":
    sys.exit(main())
