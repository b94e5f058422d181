#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""Breaks one rule of the in-process transport after the other and expects a named case of the conformance suite to fail.

usage: mutants.py BUILD_DIR [-k WORD]

BUILD_DIR holds a built transport_conformance_test. The sources of the checkout stay as they are: a copy is broken, compiled and
linked beside it. Exit code 1: a rule was broken and no case, or not the named one, said so; or the text to break is gone.
"""
import argparse
import json
import re
import shlex
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
SOURCES = ROOT / "containers/runtime/src"
TEST = "test/transport_conformance_test"

# What the broken rule says, its file, the text that holds it, what takes its place, and the case that must fail.
MUTANTS = [
    ("an expired message is not delivered", "reader_queue.cpp", r"clock_\.now\(\) <= block->expires", "true", "older_than_its_lifespan"),
    ("an expired message makes room", "reader_queue.cpp", r"(?<=stale = )[^;]*->expires < [^;]*", "false", "makes_room_in_a_full_keep_all"),
    ("KEEP_LAST holds depth messages", "reader_queue.cpp", r"limit_\(std::max<std::size_t>\(1,", "limit_(1 + std::max<std::size_t>(1,", "QosMatrix"),
    ("KEEP_ALL refuses when it is full", "reader_queue.cpp", r"if \(keep_all_ && !stale\)", "if (false)", "keep_all_refuses"),
    ("a closed gate drops what comes", "reader_queue.cpp", r"if \(!enabled_ \|\| closed_\)", "if (closed_)", "disabled_reader_drops"),
    ("publish() waits for room", "reader_queue.cpp", r"if \(!keep_all_\) return;", "if (deadline.nanoseconds() != 0) return;", "waits_for_room"),
    ("history is given once", "broker_writer.cpp", r"block->info\.sequence <= reader\.seen\(id_\) \|\| ", "", "nothing_twice"),
    ("history holds depth messages", "broker_writer.cpp", r"history_\.size\(\) <= history_limit_\)", "history_.size() <= history_limit_ + 1)", "QosMatrix"),
    ("a volatile reader gets no history", "reader_queue.cpp", r"(?<=wants_history_\()[^\n]*(?=\),\n)", "true", "QosMatrix"),
    ("a refusal is reported to a reliable writer", "broker_writer.cpp", r"return PublishResult::WouldBlock;", "return PublishResult::Published;", "keep_all_refuses"),
    ("a closed gate lets nothing out", "broker_writer.cpp", r"if \(!is_open\(\)\) \[\[unlikely\]\] \{", "if (false) {", "closed_gate_lets_nothing_out"),
    ("a closed gate stops the deadline", "broker_writer.cpp", r"if \(!is_open\(\)\) deadline_\.stop\(\);", "", "closed_gate_stops_the_deadline"),
    ("an assertion shows life", "broker_writer.cpp", r"!lease_\.show_life\(broker_\.clock_\.now\(\)\)", "true", "manual_liveliness"),
    ("exactly one period is kept", "contract.hpp", r"- Duration\{1\}\) / period_", ") / period_", "missed_once_for_each_whole_period"),
    ("a lease ends with the lease", "contract.hpp", r"> lease_ &&", "> lease_ * 2 &&", "manual_liveliness"),
    ("automatic liveliness has no lease of its own", "broker_writer.cpp", r"qos\.liveliness\(\) == Liveliness::ManualByTopic \?", "true ?", "automatic_liveliness"),
    ("an error is no match", "broker_topic.hpp", r"!= Verdict::Error;", "!= Verdict::Error || true;", "incompatible_pair_exchanges_nothing"),
    ("a clash is reported to the writer", "broker_writer.cpp", r"\+\+\(policy == kTypePolicy[^;]*;", "", "reports_an_incompatible_pair"),
    ("a message carries its source stamp", "broker_writer.cpp", r"block\.info = \{id_, sequence, now, now\};", "block.info = {id_, sequence, MonotonicTime{}, now};", "stamps_each_message"),
]  # fmt: skip


def compile_commands(build):
    entries = json.loads((build / "compile_commands.json").read_text(encoding="utf-8"))
    found = {}
    for entry in entries:  # the product's own comes first; a test may compile a source once more, for itself
        found.setdefault(Path(entry["file"]).resolve(), entry)
    return found


def users_of(name, folder):
    """The .cpp files of the folder that include `name`, also through other headers."""
    if name.endswith(".cpp"):
        return [folder / name]
    found, headers = set(), {name}
    grown = True
    while grown:
        grown = False
        for path in folder.glob("*.?pp"):
            included = set(re.findall(r'#include "([^"]+)"', path.read_text(encoding="utf-8")))
            if not included & headers:
                continue
            if path.suffix == ".hpp" and path.name not in headers:
                headers.add(path.name)
                grown = True
            elif path.suffix == ".cpp":
                found.add(path)
    return sorted(found)


def build_mutant(build, commands, folder, name, link):
    objects = []
    for source in users_of(name, folder):
        entry = commands[SOURCES / source.name]
        words = shlex.split(entry["command"])
        output = folder / (source.name + ".o")
        words = ["-O0" if word == "-O2" else word for word in words]
        words[words.index("-o") + 1] = str(output)
        words[-1] = str(source)
        words = [word for i, word in enumerate(words) if not (word in ("-MD", "-MT", "-MF") or words[i - 1] in ("-MT", "-MF"))]
        done = subprocess.run(words, cwd=entry["directory"], capture_output=True, text=True, check=False)
        if done.returncode != 0:
            return None, done.stderr
        objects.append(str(output))
    words = list(link)
    program = folder / "mutant"
    at = words.index("-o")
    words[at + 1] = str(program)
    words[at + 2 : at + 2] = objects  # before the library that has the unbroken ones
    done = subprocess.run(words, cwd=build, capture_output=True, text=True, check=False)
    return (program, "") if done.returncode == 0 else (None, done.stderr)


def link_command(build):
    text = subprocess.run(["ninja", "-C", str(build), "-t", "commands", "-s", TEST], capture_output=True, text=True, check=True).stdout
    words = shlex.split(text.strip().splitlines()[-1])
    inner = [word for word in words if word not in (":", "&&")]
    if "-o" not in inner:
        sys.exit(f"mutants.py: {build}: no link command of {TEST} found; build it first")
    return inner


def failing_cases(program):
    try:
        # The in-process transport's cases only: a broken one may leave links to other processes waiting for ever.
        done = subprocess.run([str(program), "--gtest_brief=1", "--gtest_filter=*/0.*:*Broker*"], capture_output=True, text=True, timeout=60, check=False)
    except subprocess.TimeoutExpired:
        return ["(it hangs)"]
    cases = re.findall(r"\[  FAILED  \] (\S+?),? (?:where|\()", done.stdout)
    return cases or (["(it crashes)"] if done.returncode not in (0, 1) else [])


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("build", type=Path)
    parser.add_argument("-k", default="", help="only rules that contain this")
    options = parser.parse_args()
    build = options.build.resolve()
    commands, link = compile_commands(build), link_command(build)
    bad = run = 0
    for rule, name, pattern, instead, expected in MUTANTS:
        if options.k not in rule:
            continue
        run += 1
        with tempfile.TemporaryDirectory() as scratch:
            folder = Path(scratch) / "src"
            shutil.copytree(SOURCES, folder)
            text = (folder / name).read_text(encoding="utf-8")
            broken, hits = re.subn(pattern, lambda _, new=instead: new, text)
            if hits != 1:
                bad += 1
                print(f"BAD   {rule}: {name} has {hits} places like {pattern!r}, not one")
                continue
            (folder / name).write_text(broken, encoding="utf-8")
            program, why = build_mutant(build, commands, folder, name, link)
            if program is None:
                bad += 1
                print(f"BAD   {rule}: the mutant does not build: {why[:400]}")
                continue
            cases = failing_cases(program)
            good = any(expected in case for case in cases)
            bad += not good
            print(f"{'ok   ' if good else 'BAD  '} {rule}: {len(cases)} cases fail, {'among them' if good else 'but none is'} {expected}", flush=True)
    print(f"{run} rules broken one at a time, {bad} not found out")
    return 1 if bad or not run else 0


if __name__ == "__main__":
    sys.exit(main())
