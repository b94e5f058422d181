#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""What a group of tests in a virtual machine leaves behind, and the table that is made of it."""
import sys
import tempfile
import unittest
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "test/vm"))
import groups  # noqa: E402

# As GoogleTest 1.12 writes it.
RESULTS = """<?xml version="1.0" encoding="UTF-8"?>
<testsuites tests="4" failures="1" disabled="1"><testsuite name="Line">
<testcase name="carries" classname="Line" status="run" result="completed" time="0.1" />
<testcase name="breaks" classname="Line" status="run" result="completed" time="0.2"><failure message="a.cpp:3&#x0A;no bytes" type=""/></testcase>
<testcase name="waits" classname="Line" status="run" result="skipped"><skipped message="a.cpp:9&#x0A;no device"/></testcase>
<testcase name="later" classname="Line" status="notrun" result="suppressed" />
</testsuite></testsuites>
"""


class Groups(unittest.TestCase):
    def test_the_table_counts_cases_and_gives_the_reason_of_those_that_did_not_pass(self):
        with tempfile.TemporaryDirectory() as name:
            folder = Path(name)
            for group in ("serial", "camera", "i2c"):
                (folder / group).mkdir()
            (folder / "serial/results.xml").write_text(RESULTS)
            (folder / "serial/seconds.txt").write_text("12\n")
            (folder / "camera/output.txt").write_text("Segmentation fault\n")
            (folder / "i2c/skipped.txt").write_text("skipped: i2c-regsim could not be compiled\n")
            lines = groups.table(folder, ["serial", "camera", "gpio", "i2c"]).splitlines()
        self.assertEqual(lines[0].split(), ["group", "passed", "failed", "skipped", "seconds"])
        self.assertEqual(lines[1].split(), ["serial", "1", "1", "1", "12"])
        self.assertEqual(lines[2:4], ["    FAILED Line.breaks: a.cpp:3 no bytes", "    skipped Line.waits: a.cpp:9 no device"])
        self.assertEqual([line.split(": ")[-1] for line in lines[4:]], ["the program ended early", "it did not run", "i2c-regsim could not be compiled"])

    def test_modules_that_the_kernel_has_neither_as_a_file_nor_in_itself_are_missing(self):
        with tempfile.TemporaryDirectory() as name:
            modules = Path(name) / "lib/modules/6.12"
            (modules / "kernel/drivers").mkdir(parents=True)
            (modules / "kernel/drivers/cdc-acm.ko.xz").touch()
            (modules / "modules.builtin").write_text("kernel/fs/configfs/configfs.ko\n")
            self.assertEqual(groups.not_built(Path(name), "configfs cdc_acm gpio-sim vivid:n_devs=1"), ["gpio-sim", "vivid"])
            self.assertEqual(groups.not_built(Path(name), ""), [])

    def test_the_machine_runs_the_program_with_its_filter_and_keeps_its_exit_code(self):
        script = groups.script_of(Path("/b/vm_x_test"), "Line.*")
        self.assertIn("/b/vm_x_test --gtest_output=xml:/out/results.xml '--gtest_filter=Line.*' >/out/output.txt", script)
        self.assertTrue(script.rstrip().endswith("exit $status"))


if __name__ == "__main__":
    unittest.main()
