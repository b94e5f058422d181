#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""What .ci/steps adds up: steps, their tests, and what was skipped."""
import pathlib
import subprocess
import unittest

STEPS = pathlib.Path(__file__).resolve().parents[2] / ".ci" / "steps"


class Steps(unittest.TestCase):
    def run_steps(self, *commands):
        """The exit code and the lines of a run with a step for each command."""
        script = f"set -uo pipefail; source {STEPS}; " + "; ".join(f"step 'step {i}' bash -c '{command}'" for i, command in enumerate(commands))
        done = subprocess.run(["bash", "-c", f"{script}; finish"], capture_output=True, text=True, check=False)
        return done.returncode, done.stdout.splitlines()

    def test_tests_and_skipped_tests_are_added_up(self):
        code, lines = self.run_steps("echo 3 passed, 0 failed, 2 skipped", "echo 4 passed, 0 failed")
        self.assertEqual((code, lines[-1]), (0, "7 passed, 0 failed, 2 skipped"))

    def test_a_step_that_ends_with_77_is_one_skipped_part_with_its_reason(self):
        code, lines = self.run_steps("echo 1 passed, 0 failed", "echo skipped: no root; exit 77")
        self.assertEqual((code, lines[-1]), (0, "1 passed, 0 failed, 1 skipped"))
        self.assertRegex(lines[-2], r"^step 1 .*  skipped  \(no root\)$")

    def test_parts_that_a_step_reports_as_skipped_count(self):
        code, lines = self.run_steps("echo 1 passed, 0 failed, 1 skipped; echo; echo skipped:; echo \"  a case\"",
                                     "echo skipped: M2 system calls: no perf; echo skipped: M3 mallocs: it has no record; echo done",
                                     "echo skipped: one thing")
        self.assertEqual((code, lines[-1]), (0, "1 passed, 0 failed, 4 skipped"))
        self.assertRegex(lines[-2], r"  ok  \(1 skipped: one thing\)$")
        self.assertRegex(lines[-3], r"^step 1 .*  ok  \(2 skipped: M2 system calls: no perf; M3 mallocs: it has no record\)$")

    def test_the_time_of_all_steps_is_printed_with_that_of_the_processors(self):
        _, lines = self.run_steps("for ((i = 0; i < 400000; i++)); do :; done; echo 1 passed, 0 failed")
        (line,) = [line for line in lines if line.startswith("===") and "in all" in line]
        self.assertRegex(line, r"^=== \d+ s in all, \d+ s of processors$")

    def test_a_failed_step_fails_the_run_and_the_others_run_all_the_same(self):
        code, lines = self.run_steps("exit 3", "echo 1 passed, 0 failed")
        self.assertEqual((code, lines[-1], lines[-2]), (1, "1 passed, 0 failed, 0 skipped", "1 steps failed"))


if __name__ == "__main__":
    unittest.main()
