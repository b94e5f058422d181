#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""Runs the tests of the page's modules with `node --test`; exits with 77, which ctest takes for a skip, where node is missing.

usage: run.py
"""
import pathlib
import re
import shutil
import subprocess
import sys

FOLDER = pathlib.Path(__file__).resolve().parent
OLDEST = 18  # Debian 12's


def main() -> int:
    node = shutil.which("node") or shutil.which("nodejs")
    if node is None:
        print("skipped: Debian's nodejs is not installed: ./dev setup browser")
        return 77
    version = subprocess.run([node, "--version"], capture_output=True, text=True, check=True).stdout
    if int(re.search(r"\d+", version)[0]) < OLDEST:
        print(f"skipped: nodejs {version.strip()} is older than {OLDEST}")
        return 77
    files = sorted(FOLDER.glob("*.test.mjs"))
    assert files, "no test was found"
    return subprocess.run([node, "--test", *files], check=False).returncode


if __name__ == "__main__":
    sys.exit(main())
