#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""Runs the benchmarks and prints goal, figure and baseline. Called by ./dev bench, which has built what this needs.

usage: bench.py --programs FOLDER [--json FILE] [--record] [NAME]

NAME: only the benchmarks whose name contains it (m1-inline, m8, robot, ...). --record writes the figures of all benchmarks into the
table of docs/performance.md; those of `footprint`, which runs only when it is named (as `look` does), into docs/footprint.md. Being slow is no failure: the
exit code is 1 only when a program crashes.
"""
import argparse
import json
import os
import platform
import re
import subprocess
import sys
import time
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parent))
from footprint import footprint  # noqa: E402  (python3 -I leaves this folder out of the path)
from goals import BENCHMARKS, ON_REQUEST  # noqa: E402
from look import look  # noqa: E402
from measure import Crash, Programs  # noqa: E402

PAGE = Path(__file__).resolve().parents[2] / "docs/performance.md"
PAGES = {"": PAGE, "footprint": PAGE.with_name("footprint.md")}  # by the NAME that --record goes with
TABLE = re.compile(r"(?s)(?<=<!-- figures of ./dev bench: begin -->\n).*?(?=<!-- figures of ./dev bench: end -->)")


def judge(row):
    """True or False where there is a goal and a figure."""
    if row["goal"] is None or row["value"] is None:
        return None
    relation, limit = row["goal"]
    return {"<=": row["value"] <= limit, ">=": row["value"] >= limit, "==": row["value"] == limit}[relation]


def as_text(value):
    if value is None:
        return "-"
    if value == int(value) and abs(value) < 1e15:
        return f"{int(value):,}"
    return f"{value:,.0f}" if abs(value) >= 1000 else f"{value:.3g}" if abs(value) < 100 else f"{value:.1f}"


def cells(row):
    ok = {True: "yes", False: "NO", None: ""}[row["ok"]]
    return (row["id"], row["what"], as_text(row["value"]), row["unit"], row["goal"], row["baseline"], ok)


def table(rows):
    lines = [("id", "what", "value", "unit", "goal", "baseline", "ok"), *map(cells, rows)]
    widths = [max(len(line[i]) for line in lines) for i in range(7)]
    right = (2, 4)
    for number, line in enumerate(lines):
        print("  ".join(f"{c:>{w}}" if i in right else f"{c:<{w}}" for i, (c, w) in enumerate(zip(line, widths))).rstrip())
        if number == 0:
            print("  ".join("-" * w for w in widths))


def place():
    """Names what the figures were taken on: "Debian GNU/Linux 12, g++ 12.2.0, x86_64, 2 CPUs, load 0.10, tree 0123456789ab"."""
    release = dict(re.findall(r'^(\w+)="?([^"\n]*)"?$', Path("/etc/os-release").read_text(encoding="utf-8"), re.MULTILINE))

    def said(*command):
        return subprocess.run(command, capture_output=True, text=True, check=True, cwd=PAGE.parent).stdout.strip()

    tree = said("git", "-c", "safe.directory=*", "describe", "--always", "--abbrev=12", "--dirty")
    return (f"{release['NAME']} {release['VERSION_ID']}, g++ {said('c++', '-dumpfullversion')}, {platform.machine()}, "
            f"{os.cpu_count()} CPUs, load {os.getloadavg()[0]:.2f}, tree {tree}")


def record(rows, page, where):
    """Replaces the table of the page; a page without its marks is refused."""

    def line(row):
        value = "-" if row["value"] is None else f"{row['value']:.4g}" if abs(row["value"]) < 1e4 else f"{row['value']:.0f}"
        met = {True: "yes", False: "**no**", None: ""}[row["ok"]]
        return f"| {row['id']} | {row['what']} | {value} {row['unit']} | {row['goal']} | {row['baseline']} | {met} |\n"

    text = page.read_text(encoding="utf-8")
    if not TABLE.search(text):
        raise SystemExit(f"{page}: the marks of the table of figures are missing; put them back (git checkout {page})")
    table_text = (f"Taken on {where}.\n\n| id | what | figure | goal | baseline | met |\n| --- | --- | ---: | ---: | --- | --- |\n"
                  + "".join(map(line, rows)))
    page.write_text(TABLE.sub(lambda _: table_text, text), encoding="utf-8")


def main():
    words = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    words.add_argument("name", nargs="?", default="")
    words.add_argument("--programs", required=True)
    words.add_argument("--json")
    words.add_argument("--record", action="store_true")
    asked = words.parse_args()
    if asked.record and asked.name not in PAGES:
        words.error("--record takes all benchmarks (leave NAME out) or `footprint`")
    where = place() if asked.record else ""  # of the tree that runs, before this writes into it
    known = BENCHMARKS if not asked.name else BENCHMARKS | ON_REQUEST | {"footprint": footprint, "look": look}
    chosen = {name: run for name, run in known.items() if asked.name.lower() in name}
    if not chosen:
        print(f"no benchmark is named like '{asked.name}'; there are: {', '.join(known)}", file=sys.stderr)
        return 2
    programs, rows, crashes = Programs(asked.programs), [], []
    begin = time.monotonic()
    for name, run in chosen.items():

        def say(what, name=name):
            print(f"  [{time.monotonic() - begin:4.0f} s] {name}: {what}", flush=True)

        try:
            for row in run(programs, say):
                if "ok" not in row:
                    row["ok"] = judge(row)
                    row["goal"] = f"{row['goal'][0]} {as_text(row['goal'][1])}" if row["goal"] else ""
                elif not row["goal"]:
                    row["ok"] = None  # a program that judges itself, on a figure without a goal
                rows.append(row)
        except Crash as crash:
            crashes.append(f"{name}: {crash}")
            print(f"  {crashes[-1]}", file=sys.stderr, flush=True)
    print()
    table(rows)
    judged = [row["ok"] for row in rows if row["ok"] is not None]
    print(f"\n{sum(judged)} of {len(judged)} goals met; {sum(row['value'] is None for row in rows)} figures not measured")
    if asked.json:
        Path(asked.json).write_text(json.dumps(rows, indent=1) + "\n")
        print(f"written: {asked.json}")
    if asked.record and not crashes:
        record(rows, PAGES[asked.name], where)
        print(f"recorded in {PAGES[asked.name]}")
    for crash in crashes:
        print(f"crashed: {crash}", file=sys.stderr)
    return 1 if crashes else 0


if __name__ == "__main__":
    sys.exit(main())
