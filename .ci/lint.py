#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""Format, clang-tidy and the house rules. Called by ./dev lint, which has installed and built what this needs.

usage: ./dev lint [--all] [--fix] [--since COMMIT] [--minutes N] [--processor-minutes N]

Looks at the files that differ from the branch this one will be merged into (origin/main) or are not committed; with --all at
every file; with --since at what changed after COMMIT. --fix lets clang-format write the files. --minutes bounds clang-tidy, the slow
part, --processor-minutes does so where other work may take the processors: it begins with the newest files (with --all: another part
each day), and says how many it did not come to.
"""
import argparse
import concurrent.futures
import json
import os
import random
import re
import resource
import subprocess
import sys
import time
from datetime import date
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
TREES = ("interfaces/", "qos_profiles/", "components/", "containers/", "launch/", "test/")
# What clang has no use for: a launcher before the compiler, precompiled headers, and options of g++ only.
FOREIGN_WORDS = re.compile(r"^(\S*env\s+(\w+=\S+\s+)*)?\S*ccache\s+|\s(-fno-gnu-unique|--param=ggc-\S+|-include \S+/cmake_pch\.hxx)")


def git(*arguments):
    command = ["git", "-c", "safe.directory=*", "-C", str(ROOT), *arguments]
    result = subprocess.run(command, capture_output=True, text=True, check=False)
    return result.stdout.strip() if result.returncode == 0 else ""


def every_file():
    return [line for line in git("ls-files", "--cached", "--others", "--exclude-standard").splitlines() if (ROOT / line).is_file()]


def changed_files(since):
    base = since or git("merge-base", "HEAD", "origin/main") or "HEAD"
    names = git("diff", "--name-only", "--diff-filter=d", base).splitlines()
    names += git("ls-files", "--others", "--exclude-standard").splitlines()
    return sorted(set(names))


def is_ours(name):
    return name.startswith(TREES) and name.endswith((".cpp", ".hpp"))


def check_format(files, fix):
    if not files:
        return True
    command = ["clang-format", "--style=file", "-i"] if fix else ["clang-format", "--style=file", "--dry-run", "-Werror"]
    return subprocess.run([*command, *files], cwd=ROOT, check=False).returncode == 0


def units_to_read(files, commands):
    """The compiled files among `files`, and for each header one compiled file that includes it."""
    units = {name for name in files if name in commands}
    for header in (name for name in files if name.endswith(".hpp")):
        tail = re.compile(r'#\s*include\s*["<](?:[^">]*/)?' + re.escape(Path(header).name) + '[">]')
        readers = [unit for unit in commands if tail.search((ROOT / unit).read_text(encoding="utf-8"))]
        near = sorted(readers, key=lambda unit: (-len(os.path.commonpath([unit, header])), unit))
        if near and not units.intersection(readers):
            units.add(near[0])
    return sorted(units)


def newest_first(units):
    """Of a clone all files were written in one moment, so the commits tell. What is not committed comes first."""
    names = git("diff", "--name-only", "HEAD").splitlines() + git("ls-files", "--others", "--exclude-standard").splitlines()
    names += git("log", "--format=", "--name-only").splitlines()
    ranks = {name: rank for rank, name in reversed(list(enumerate(names)))}
    return sorted(units, key=lambda unit: ranks.get(unit, len(names)))


def entries_per_source(entry):
    """The entry, or one for each source of a file that includes several of them (NACELLE_UNITY)."""
    file = Path(entry["file"])
    if file.parent.name != "Unity":
        return [entry]
    sources = [os.path.normpath(file.parent / path) for path in re.findall(r'#include "([^"]+)"', file.read_text(encoding="utf-8"))]
    return [{**entry, "file": source, "command": entry["command"].replace(entry["file"], source)} for source in sources]


def processor_seconds():
    """Of all programs that were called and have ended."""
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    return used.ru_utime + used.ru_stime


def check_tidy(files, build, minutes, processor_minutes, every):
    database = json.loads((build / "compile_commands.json").read_text(encoding="utf-8"))
    commands = {}
    for entry in (each for one in database for each in entries_per_source(one)):
        name = os.path.relpath(entry["file"], ROOT)
        if is_ours(name):
            entry["command"] = FOREIGN_WORDS.sub("", entry["command"])
            commands.setdefault(name, entry)  # the product's own; a test may compile a source once more, for itself
    folder = build / "lint"
    folder.mkdir(exist_ok=True)
    (folder / "compile_commands.json").write_text(json.dumps(list(commands.values())), encoding="utf-8")
    units = newest_first(units_to_read(files, commands))
    if every and minutes:
        random.Random(date.today().isoformat()).shuffle(units)  # of all files, another part each day
    print(f"clang-tidy: {len(units)} files", flush=True)
    end = time.monotonic() + 60 * minutes if minutes else float("inf")
    most = processor_seconds() + 60 * processor_minutes if processor_minutes else float("inf")

    def read(unit):
        if time.monotonic() > end or processor_seconds() > most:
            return None
        # Not the generated headers, which lie in folders of the same names below build/.
        ours = f"--header-filter=^{re.escape(str(ROOT))}/({'|'.join(tree.rstrip('/') for tree in TREES)})/"
        command = ["clang-tidy", "-p", str(folder), "--quiet", ours, "--extra-arg=-Wno-unknown-warning-option", unit]
        return subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=False)

    good = True
    unread = 0
    with concurrent.futures.ThreadPoolExecutor(os.cpu_count()) as pool:
        for number, (unit, result) in enumerate(zip(units, pool.map(read, units)), 1):
            if result is None:
                unread += 1
            elif result.returncode != 0:
                good = False
                print(result.stdout.strip() or result.stderr.strip(), flush=True)
            elif number % 10 == 0:
                print(f"  {number} of {len(units)}", flush=True)
    if unread:
        print(f"clang-tidy: {unread} of {len(units)} files were not read: the {minutes or processor_minutes} minutes were over")
    return good


def main():
    parser = argparse.ArgumentParser(prog="./dev lint")
    parser.add_argument("--build", type=Path, required=True, help=argparse.SUPPRESS)
    parser.add_argument("--all", action="store_true", help="every file")
    parser.add_argument("--fix", action="store_true", help="let clang-format write the files")
    parser.add_argument("--since", default=os.environ.get("NACELLE_LINT_SINCE", ""), help="what changed after this commit")
    parser.add_argument("--minutes", type=float, default=0, help="begin no further file of clang-tidy after this time")
    parser.add_argument("--processor-minutes", type=float, default=0, help="begin none after so much time of processors")
    options = parser.parse_args()

    files = [name for name in (every_file() if options.all else changed_files(options.since)) if is_ours(name)]
    print(f"lint: {len(files)} C++ files{'' if options.all else ' that changed'}", flush=True)
    results = {
        "format": check_format(files, options.fix),
        "clang-tidy": check_tidy(files, options.build, options.minutes, options.processor_minutes, options.all),
    }
    for check in ("floors", "tree"):
        command = ["/usr/bin/python3", "-B", str(ROOT / f"test/policy/check_{check}.py")]
        results[check] = subprocess.run(command, check=False).returncode == 0
    for name, good in results.items():
        print(f"lint {name}: {'clean' if good else 'FAILED'}")
    if not results["format"]:
        print("mend the format with: ./dev lint --fix")
    return 0 if all(results.values()) else 1


if __name__ == "__main__":
    sys.exit(main())
