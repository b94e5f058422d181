#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""The list of tests that qemu-user cannot run: what it divides, and that each mistake in it is found."""
import re
import sys
import unittest
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "vm"))
import arm64  # noqa: E402


def a_test(emulated=True, in_machine=False):
    return arm64.Test(["program"], "/", [], emulated, in_machine)


TESTS = {
    "base_test": a_test(), "dds_test": a_test(), "runtime_test": a_test(), "system_run": a_test(emulated=False),
    "policy_binaries": a_test(emulated=False), "vm_arm64": a_test(emulated=False, in_machine=True),
}  # fmt: skip


def read(text):
    return arm64.read_list(text, TESTS, lambda _, cases: cases.startswith("Crash"))


class List(unittest.TestCase):
    def test_tests_and_cases_are_divided_between_emulator_and_machine(self):
        listed = read("# why\n\ndds_test: multicast\nruntime_test Crash.*: signals\nruntime_test CrashToo.x: signals\nsystem_run: signals\n")
        self.assertEqual(listed, {"dds_test": [], "runtime_test": ["Crash.*", "CrashToo.x"], "system_run": []})
        names, cases = arm64.left_out(TESTS, listed)
        self.assertEqual([name for name in TESTS if re.search(names, name)], ["dds_test", "system_run"])
        self.assertEqual(cases, "-Crash.*:CrashToo.x")
        script = arm64.script_of(listed, TESTS)
        self.assertIn("program '--gtest_filter=Crash.*:CrashToo.x' >/out/runtime_test.log", script)
        self.assertNotIn("base_test", script)

    def test_only_the_programs_that_are_selected_are_built(self):
        chosen = {name: TESTS[name] for name in ("base_test", "dds_test", "system_run")}
        self.assertEqual(arm64.targets_of(chosen), ["base_test", "dds_test"])
        self.assertEqual(arm64.targets_of(TESTS), ["test/all"])

    def test_an_empty_list_leaves_only_out_what_is_no_program(self):
        names, cases = arm64.left_out(TESTS, read("# nothing\n"))
        self.assertEqual([name for name in TESTS if re.search(names, name)], ["system_run"])
        self.assertEqual(cases, "*")

    def test_a_line_that_names_nothing_is_an_error(self):
        for text, said in (
            ("dds_tset: multicast\n", "arm64.txt:1: there is no test 'dds_tset'"),
            ("dds_test: multicast\nruntime_test Crush.*: signals\n", "arm64.txt:2: 'runtime_test' has no case 'Crush.*'"),
            ("dds_test\n", "arm64.txt:1: 'dds_test' is not"),
            ("dds_test: \n", "arm64.txt:1: 'dds_test: ' is not"),
            ("dds_test: a\ndds_test: b\n", "arm64.txt:2: 'dds_test' is listed already"),
            ("runtime_test: a\nruntime_test Crash.*: b\n", "arm64.txt:2: 'runtime_test' is listed already"),
        ):
            with self.subTest(text=text), self.assertRaisesRegex(ValueError, re.escape(said)):
                read(text)


if __name__ == "__main__":
    unittest.main()
