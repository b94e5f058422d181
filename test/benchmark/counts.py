#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""Compares what a message costs, in counts, with what was recorded for this release, compiler and architecture.

usage: counts.py --programs FOLDER [--record]

Counts do not depend on how busy the machine is: instructions, mallocs, locked instructions and system calls of M1 to M3. The exit
code is 1 if one of them is more than 1 % above its record. A count that cannot be taken here, or has no record, is reported in a line
"skipped: ...", which .ci/steps counts. --record writes counts.json anew for this release and compiler, with the least of five counts.
"""
import argparse
import json
import math
import platform
import re
import subprocess
import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parent))
from measure import Programs  # noqa: E402  (python3 -I leaves this folder out of the path)

RECORDS = Path(__file__).resolve().parent / "counts.json"
TOLERANCE = 0.01
# What is not exact, since it depends on how threads meet. M3: of the six system calls of the benchmark itself in a burst of 500 messages
# three are waits, each of which is made or not. M2: under callgrind on a busy machine some readers are found before they sleep.
SLACK = {"M3 system calls": 3 / 500, "M2 locked instructions": 0.1}
TRIES = 5


def place(compiler):
    """Names what the counts depend on: "debian 12, g++ 12.2.0, x86_64"."""
    release = dict(re.findall(r'^(\w+)="?([^"\n]*)"?$', Path("/etc/os-release").read_text(encoding="utf-8"), re.MULTILINE))
    version = subprocess.run([compiler, "-dumpfullversion"], capture_output=True, text=True, check=True).stdout.strip()
    return f"{release['ID']} {release['VERSION_ID']}, g++ {version}, {platform.machine()}"


class NotCounted(Exception):
    """Why a count cannot be taken on this machine."""


def per_message(figure):
    return lambda programs, path: (run := programs.run("handover", path=path, messages=20000))[figure] / run["delivered"]


def system_calls(programs, path, few, many):
    if path == "asleep" and programs.calls_are_counted_by != "perf":
        raise NotCounted("perf may not count here, and strace wakes the reader that is to be found asleep")
    return programs.syscalls("handover", path=path, few=few, many=many)


def counts():
    """The name of each count, and what counts it."""
    for take, name in (("const_ref", "const T&"), ("loan", "Loan<T>"), ("shared", "shared_ptr<const T>")):
        yield f"M1 instructions, {name}", lambda programs, take=take: programs.instructions("handover", path="inline", take=take)
    yield "M1 instructions, four readers", lambda programs: programs.instructions("handover", path="inline", readers=4)
    # M1 makes so few system calls that those of start and end would show in fewer messages.
    for goal, path, few, many in (("M1", "inline", 20000, 1020000), ("M2", "asleep", 2000, 12000), ("M3", "busy", 5000, 15000)):
        if goal != "M1":
            yield f"{goal} instructions", lambda programs, path=path: programs.instructions("handover", path=path)
        yield f"{goal} locked instructions", lambda programs, path=path: programs.executed("handover", path=path)["Ge"]
        yield f"{goal} mallocs", lambda programs, path=path: per_message("mallocs")(programs, path)
        yield f"{goal} system calls", lambda programs, path=path, few=few, many=many: system_calls(programs, path, few, many)


def limit_of(name, recorded):
    return recorded * (1 + TOLERANCE) + SLACK.get(name, 0)


def least(count, programs, limit):
    """The count; one that is above the limit is taken up to five times, since a scheduler may be in it."""
    value = count(programs)
    for _ in range(TRIES - 1):
        if value <= limit:
            break
        value = min(value, count(programs))
    return value


def compare(programs, recorded, is_record=False, say=print):
    """Runs all counts; to make a record, as often as the limit allows. Returns the figures, the names of those above their limit, and
    the reasons why others were not compared."""
    measured, above, skipped = {}, [], []
    for name, count in counts():
        was = recorded.get(name)
        limit = limit_of(name, was) if was is not None else -math.inf if is_record else math.inf
        verdict = ""
        try:
            value = least(count, programs, limit)
            measured[name] = round(value, 4)
            if was is None:
                skipped.append(f"{name}: it has no record")
            elif value > limit:
                verdict = f"ABOVE the limit of {limit:.4g}"
                above.append(name)
        except NotCounted as reason:
            value = None
            skipped.append(f"{name}: {reason}")
        figures = ("-" if figure is None else format(figure, ".4g") for figure in (value, was))
        say("{:<36} {:>9}   recorded {:>9}   {}".format(name, *figures, verdict).rstrip())
    return measured, above, skipped


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
    measured, above, skipped = compare(Programs(asked.programs), recorded, asked.record)
    if asked.record:
        records[here] = measured
        RECORDS.write_text(json.dumps(records, indent=1, sort_keys=True) + "\n", encoding="utf-8")
        print(f"recorded in {RECORDS.name}")
        skipped = [reason for reason in skipped if not reason.endswith("it has no record")]
    elif not recorded:
        skipped = [f"nothing is recorded for {here}; ./dev bench --counts --record does"]
    for reason in skipped:
        print(f"skipped: {reason}")
    return 1 if above else 0


if __name__ == "__main__":
    sys.exit(main())
