#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""Which rows .ci/matrix runs, and what it records of them. The commands of the rows are scripts of the test."""
import pathlib
import shutil
import subprocess
import tempfile
import unittest

ROOT = pathlib.Path(__file__).resolve().parents[2]
# Packages of bookworm pass 3 tests, those of trixie are skipped, and what runs in a clean Debian fails.
COMMAND = """#!/bin/bash
case "$* " in
  "deb "*"bookworm "*) echo "3 passed, 0 failed" ;;
  "deb "*) echo "skipped: no mirror | no root"; exit 77 ;;
  test-deb*) echo "1 passed, 2 failed"; exit 5 ;;
esac
"""


class Matrix(unittest.TestCase):
    def setUp(self):
        self.tree = pathlib.Path(tempfile.mkdtemp(prefix="nacelle-matrix-"))
        self.addCleanup(shutil.rmtree, self.tree)
        (self.tree / ".ci").mkdir()
        (self.tree / "docs").mkdir()
        for name in ("matrix", "steps", "debians"):
            shutil.copy(ROOT / ".ci" / name, self.tree / ".ci")
        for name in ("dev", ".ci/chroot"):
            (self.tree / name).write_text(COMMAND)
            (self.tree / name).chmod(0o755)

    def run_matrix(self, *arguments):
        done = subprocess.run([self.tree / ".ci" / "matrix", *arguments], capture_output=True, text=True, check=False)
        return done.returncode, done.stdout.splitlines(), done.stderr

    def recorded(self):
        rows = [line.split(" | ") for line in (self.tree / "docs" / "matrix.md").read_text().splitlines() if line.startswith(("| bookworm", "| trixie"))]
        return [(row[0].removeprefix("| "), row[1], row[2], row[3], row[5]) for row in rows]

    def test_every_release_and_architecture_has_a_row_for_its_tests_and_its_packages(self):
        _, lines, _ = self.run_matrix("--list")
        rows = {tuple(line.split()[:3]) for line in lines}
        self.assertEqual(len(rows), len(lines))
        for release in ("bookworm", "trixie"):
            for arch in ("amd64", "arm64"):
                for word in ("test", "deb", "installed"):
                    self.assertIn((release, arch, word), rows)
            self.assertIn((release, "arm64", "vm"), rows)

    def test_rows_may_be_chosen(self):
        _, lines, _ = self.run_matrix("--list", "--release", "trixie", "--arch", "arm64", "--row", "deb", "--row", "vm")
        self.assertEqual([line.split()[:3] for line in lines], [["trixie", "arm64", "vm"], ["trixie", "arm64", "deb"]])

    def test_what_does_not_exist_is_refused(self):
        for arguments in (("--release", "sid"), ("--arch", "armhf"), ("--row", "debs"), ("--row",), ("--all",)):
            with self.subTest(arguments=arguments):
                code, lines, said = self.run_matrix(*arguments)
                self.assertEqual((code, lines), (1, []))
                self.assertIn(arguments[-1], said)

    def test_a_failed_row_fails_the_run_and_a_skipped_one_does_not(self):
        code, lines, _ = self.run_matrix("--arch", "amd64", "--row", "deb")
        self.assertEqual((code, lines[-1]), (0, "3 passed, 0 failed, 1 skipped"))
        code, lines, _ = self.run_matrix("--arch", "amd64", "--release", "bookworm", "--row", "installed", "--row", "deb")
        self.assertEqual((code, lines[-1]), (1, "4 passed, 2 failed, 0 skipped"))

    def test_nothing_is_recorded_unasked(self):
        self.run_matrix("--row", "deb")
        self.assertFalse((self.tree / "docs" / "matrix.md").exists())

    def test_the_record_keeps_what_is_not_run_now(self):
        self.run_matrix("--record", "--arch", "amd64", "--row", "deb")
        first = self.recorded()
        self.assertEqual(first, [("bookworm", "amd64", "packages", "ok", "(3 passed, 0 failed)"), ("trixie", "amd64", "packages", "skipped", "(no mirror / no root)")])
        self.run_matrix("--record", "--release", "bookworm", "--arch", "amd64", "--row", "installed")
        failed = ("bookworm", "amd64", "packages in a clean Debian", "FAILED", "(5)  (1 passed, 2 failed)")
        self.assertEqual(self.recorded(), [first[0], failed, first[1]])


if __name__ == "__main__":
    unittest.main()
