#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""What .ci/last_run.py says of a run whose results are given."""
import pathlib
import subprocess
import sys
import tempfile
import unittest

PROGRAM = pathlib.Path(__file__).resolve().parents[2] / ".ci" / "last_run.py"
RESULTS = """<?xml version="1.0"?>
<testsuite name="all" tests="4">
<testcase name="gtest" time="1.5" status="fail"><system-out>before
some_test.cpp:3: Failure
Value of: speed
[  FAILED  ] Some.case (3 ms)
</system-out></testcase>
<testcase name="unittest" time="3" status="fail"><system-out>a \x01 b
FAIL: test_one (__main__.Cases)
AssertionError: 1 != 2
</system-out></testcase>
<testcase name="killed" time="2" status="fail"><system-out>the last words</system-out></testcase>
<testcase name="good" time="4" status="run"><system-out>x: Failure
</system-out></testcase>
<testcase name="rig" time="0" status="notrun"><system-out>no machine
</system-out></testcase>
</testsuite>
"""
LOG = """1/2 Testing: gtest
x_test.cpp:5: Skipped
no network

[  SKIPPED ] Links.are_up (3 ms)
[  SKIPPED ] 1 test, listed below:
[  SKIPPED ] Links.are_up
2/2 Testing: unittest
test_one (__main__.Cases.test_one) ... skipped "it's late"
test_two (__main__.Cases.test_two)
What it is about. ... skipped 'no fish'
test_three (__main__.Cases.test_three) ... ok
OK (skipped=3)
"""


class LastRun(unittest.TestCase):
    def run_it(self, what):
        with tempfile.TemporaryDirectory() as folder:
            (pathlib.Path(folder) / "test-results.xml").write_text(RESULTS, encoding="utf-8")
            log = pathlib.Path(folder) / "Testing" / "Temporary" / "LastTest.log"
            log.parent.mkdir(parents=True)
            log.write_text(LOG, encoding="utf-8")
            done = subprocess.run([sys.executable, "-B", PROGRAM, what, folder], capture_output=True, text=True, check=True)
        return done.stdout.split("\n\n")

    def test_a_failure_is_shown_from_where_it_begins(self):
        self.assertEqual([part.strip("\n") for part in self.run_it("failed") if part.strip()], [
            "failed gtest:\n  before\n  some_test.cpp:3: Failure\n  Value of: speed\n  [  FAILED  ] Some.case (3 ms)",
            "failed unittest:\n  a ? b\n  FAIL: test_one (__main__.Cases)\n  AssertionError: 1 != 2",
            "failed killed:\n  the last words"])

    def test_skipped_cases_of_tests_that_passed_are_named(self):
        self.assertEqual(self.run_it("skipped")[0].splitlines(), [
            "rig: no machine", "gtest, Links.are_up: no network",
            "unittest, test_one: it's late", "unittest, test_two: no fish", "unittest: a case"])

    def test_the_slowest_come_first(self):
        rows = self.run_it("slowest")[0].strip().splitlines()
        self.assertEqual(rows[0], "slowest tests:")
        self.assertEqual([row.split()[-1] for row in rows[1:]], ["good", "unittest", "killed", "gtest", "rig"])


if __name__ == "__main__":
    unittest.main()
