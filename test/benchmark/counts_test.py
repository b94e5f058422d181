#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""The test of what counts.py compares and reports; nothing is counted."""
import contextlib
import io
import json
import sys
import tempfile
import unittest
from pathlib import Path
from unittest import mock

sys.path.insert(0, str(Path(__file__).resolve().parent))
import counts  # noqa: E402


class Limits(unittest.TestCase):
    def test_one_percent_is_allowed_and_nothing_on_top_of_it(self):
        for name in ("M1 instructions, const T&", "M1 system calls", "M2 system calls", "M3 locked instructions", "M3 mallocs"):
            self.assertAlmostEqual(counts.limit_of(name, 2.0), 2.02)
            self.assertEqual(counts.limit_of(name, 0.0), 0.0)

    def test_only_what_depends_on_how_threads_meet_has_slack(self):
        self.assertAlmostEqual(counts.limit_of("M3 system calls", 0.03), 0.03 * 1.01 + 0.006)
        self.assertAlmostEqual(counts.limit_of("M2 locked instructions", 7.0), 7.07 + 0.1)
        self.assertLess(counts.limit_of("M2 locked instructions", 7.0), 8, "one more a message")
        self.assertEqual(len(counts.SLACK), 2)

    def test_every_count_of_every_goal_is_taken(self):
        names = [name for name, _ in counts.counts()]
        for goal in ("M1", "M2", "M3"):
            for what in ("instructions", "locked instructions", "mallocs", "system calls"):
                self.assertTrue(any(name.startswith(f"{goal} {what}") for name in names), f"{goal} {what}")


class Comparing(unittest.TestCase):
    def run_counts(self, taken, recorded, *words, here="a desk"):
        """Exit code, what was printed, and the records afterwards. taken: figures of each count, one after the other, or why there is none."""
        self.calls = dict.fromkeys(taken, 0)

        def count_of(name):
            def count(_):
                answer = taken[name]
                if isinstance(answer, str):
                    raise counts.NotCounted(answer)
                self.calls[name] += 1
                return answer[min(self.calls[name], len(answer)) - 1]
            return count

        with tempfile.TemporaryDirectory() as folder:
            file = Path(folder) / "counts.json"
            file.write_text(json.dumps({"a desk": recorded}))
            said = io.StringIO()
            with mock.patch.object(counts, "RECORDS", file), mock.patch.object(counts, "counts", lambda: [(name, count_of(name)) for name in taken]), \
                    mock.patch.object(counts, "place", lambda _: here), contextlib.redirect_stdout(said), \
                    mock.patch("sys.argv", ["counts.py", "--programs", folder, *words]):  # fmt: skip
                code = counts.main()
            return code, said.getvalue(), json.loads(file.read_text())

    def test_what_is_at_its_record_or_one_percent_above_passes(self):
        for value in (90.0, 100.0, 101.0):
            code, said, _ = self.run_counts({"M1 instructions": [value]}, {"M1 instructions": 100.0})
            self.assertEqual(code, 0, said)
            self.assertNotIn("skipped", said)
        self.assertEqual(self.calls["M1 instructions"], 1)

    def test_more_than_one_percent_above_fails_after_five_tries(self):
        for name, record in (("M1 instructions", 100.0), ("M1 system calls", 0.0156), ("M3 locked instructions", 5.0)):
            code, said, _ = self.run_counts({name: [record * 1.011]}, {name: record})
            self.assertEqual(code, 1)
            self.assertRegex(said, rf"(?m)^{name} .*ABOVE the limit of ")
            self.assertEqual(self.calls[name], 5)

    def test_a_malloc_where_none_is_recorded_fails(self):
        self.assertEqual(self.run_counts({"M1 mallocs": [0.00005]}, {"M1 mallocs": 0.0})[0], 1)

    def test_one_good_try_of_five_passes(self):
        code, _, _ = self.run_counts({"M2 system calls": [2.5, 2.2, 2.0]}, {"M2 system calls": 2.0})
        self.assertEqual((code, self.calls["M2 system calls"]), (0, 3))

    def test_what_cannot_be_counted_is_skipped_with_its_reason(self):
        code, said, _ = self.run_counts({"M1 mallocs": [0.0], "M2 system calls": "no perf"}, {"M1 mallocs": 0.0, "M2 system calls": 2.0})
        self.assertEqual(code, 0)
        self.assertIn("\nskipped: M2 system calls: no perf\n", said)

    def test_what_has_no_record_is_skipped(self):
        _, said, _ = self.run_counts({"M1 mallocs": [0.0], "M2 mallocs": [0.0]}, {"M1 mallocs": 0.0})
        self.assertIn("\nskipped: M2 mallocs: it has no record\n", said)
        code, said, _ = self.run_counts({"M1 mallocs": [0.0], "M2 mallocs": [0.0]}, {}, here="a boat")
        self.assertEqual((code, said.count("skipped: ")), (0, 1))
        self.assertIn("\nskipped: nothing is recorded for a boat; ./dev bench --counts --record does\n", said)

    def test_recording_replaces_the_record_of_this_place_only(self):
        taken = {"M1 instructions": [448.0, 447.12344, 449.0], "M2 system calls": "no perf"}
        _, said, records = self.run_counts(taken, {"M1 instructions": 1.0}, "--record", here="a boat")
        self.assertEqual(records, {"a desk": {"M1 instructions": 1.0}, "a boat": {"M1 instructions": 447.1234}})
        self.assertIn("\nskipped: M2 system calls: no perf\n", said)
        self.assertEqual(said.count("skipped: "), 1)


class Perf(unittest.TestCase):
    def test_system_calls_of_a_sleeping_reader_need_perf(self):
        programs = mock.Mock(calls_are_counted_by="strace")
        with self.assertRaisesRegex(counts.NotCounted, "perf may not count here"):
            counts.system_calls(programs, "asleep", 1, 2)
        counts.system_calls(programs, "inline", 1, 2)
        programs.syscalls.assert_called_once_with("handover", path="inline", few=1, many=2)


if __name__ == "__main__":
    unittest.main()
