#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""The test of what bench.py says and of the graphs that it runs; no benchmark is started."""
import contextlib
import io
import json
import os
import sys
import tempfile
import unittest
from pathlib import Path
from unittest import mock

sys.path.insert(0, str(Path(__file__).resolve().parent))
import bench  # noqa: E402
import goals  # noqa: E402
import graphs  # noqa: E402
from measure import Crash, Programs  # noqa: E402


def rates(lines):
    """Messages and deliveries per second that a graph's lines ask for."""
    words = [line.split() for line in lines]
    hz = {w[1]: 1e6 / int(w[3]) for w in words if w[0] == "pub"}
    return sum(hz.values()), sum(hz.get(w[1], 0) for w in words if w[0] == "sub")


class Graphs(unittest.TestCase):
    def test_topologies_have_the_rates_that_their_readme_names(self):
        for name, expected in (("sierra_nevada", (654, 1054)), ("mont_blanc", (781, 1263))):
            self.assertEqual(tuple(round(hz) for hz in rates(graphs.topology(name))), expected, name)

    def test_every_topology_can_be_written_and_each_reader_has_its_writers_type(self):
        for name in ("sierra_nevada", "mont_blanc", "white_mountain", "cedar"):
            words = [line.split() for line in graphs.topology(name)]
            types = {w[1]: w[2] for w in words if w[0] == "pub"}
            for w in words:
                if w[0] == "sub":
                    self.assertEqual(w[2], types[w[1]], f"{name}: {w[1]}")

    def test_saturation_offers_what_the_goal_names(self):
        published, delivered = rates(graphs.saturation(64))
        self.assertAlmostEqual(published, 51_575, delta=5)
        self.assertEqual(published, delivered)


class Judging(unittest.TestCase):
    def judged(self, value, goal):
        return bench.judge(goals.row("M0", "a", value, "x", goal))

    def test_a_figure_is_held_against_its_goal(self):
        self.assertIs(self.judged(250, goals.at_most(250)), True)
        self.assertIs(self.judged(251, goals.at_most(250)), False)
        self.assertIs(self.judged(1, goals.exactly(0)), False)
        self.assertIs(self.judged(99.8, (">=", 99.9)), False)

    def test_what_was_not_measured_is_neither_met_nor_missed(self):
        self.assertIsNone(self.judged(None, goals.at_most(1)))
        self.assertIsNone(self.judged(7, None))


class Running(unittest.TestCase):
    def run_bench(self, benchmarks, *words):
        """Exit code, what was printed, and the rows of the JSON file."""
        with tempfile.TemporaryDirectory() as folder:
            file = Path(folder) / "rows.json"
            said = io.StringIO()
            with mock.patch.dict(bench.BENCHMARKS, benchmarks, clear=True), contextlib.redirect_stdout(said), \
                    contextlib.redirect_stderr(said), mock.patch("sys.argv", ["bench.py", "--programs", folder, "--json", str(file), *words]):  # fmt: skip
                code = bench.main()
            return code, said.getvalue(), json.loads(file.read_text()) if file.exists() else None

    def test_reports_a_missed_goal_without_failing(self):
        code, said, rows = self.run_bench({"slow": lambda *_: [goals.row("M1", "snail", 9, "Ir", goals.at_most(8), "others 7")]})
        self.assertEqual(code, 0)
        self.assertEqual(rows[0],
                         {"id": "M1", "what": "snail", "value": 9, "unit": "Ir", "goal": "<= 8", "baseline": "others 7", "ok": False})  # fmt: skip
        self.assertRegex(said, r"(?m)^M1 +snail +9 +Ir +<= 8 +others 7 +NO$")

    def test_a_crash_fails_and_the_others_still_run(self):
        def crash(*_):
            raise Crash("handover: ended with -11")

        code, said, rows = self.run_bench({"bad": crash, "good": lambda *_: [goals.row("M1", "a", 1, "x")]})
        self.assertEqual(code, 1)
        self.assertIn("bad: handover: ended with -11", said)
        self.assertEqual([row["what"] for row in rows], ["a"])

    def test_a_name_chooses_and_an_unknown_one_is_refused(self):
        known = {name: lambda *_, name=name: [goals.row("M1", name, 1, "x")] for name in ("m1-inline", "m8-saturation")}
        self.assertEqual([row["what"] for row in self.run_bench(known, "M8")[2]], ["m8-saturation"])
        code, said, _ = self.run_bench(known, "nothing")
        self.assertEqual(code, 2)
        self.assertIn("there are: m1-inline, m8-saturation", said)


class Recording(unittest.TestCase):
    MARKS = ("before\n<!-- figures of ./dev bench: begin -->\n", "<!-- figures of ./dev bench: end -->\nafter\n")

    def test_the_table_of_the_page_is_replaced_and_the_rest_stays(self):
        rows = [{**goals.row("M1", "snail", 9.87654, "Ir", goals.at_most(8), "others 7"), "goal": "<= 8", "ok": False},
                {**goals.row("M2", "unseen", None, "us"), "goal": "", "ok": None}]  # fmt: skip
        with tempfile.TemporaryDirectory() as folder:
            page = Path(folder) / "page.md"
            page.write_text("old figures\n".join(self.MARKS))
            bench.record(rows, page, "a desk")
            self.assertEqual(page.read_text(), (
                "Taken on a desk.\n\n| id | what | figure | goal | baseline | met |\n| --- | --- | ---: | ---: | --- | --- |\n"
                "| M1 | snail | 9.877 Ir | <= 8 | others 7 | **no** |\n| M2 | unseen | - us |  |  |  |\n").join(self.MARKS))  # fmt: skip
            page.write_text("no marks")
            with self.assertRaisesRegex(SystemExit, "marks .* are missing"):
                bench.record(rows, page, "a desk")

    def test_readme_counts_the_goals_that_the_table_misses(self):
        met = [line.rsplit("|", 2)[1].strip() for line in bench.TABLE.search(bench.PAGE.read_text()).group().splitlines()
               if line.startswith("| M")]  # fmt: skip
        missed = f"{met.count('**no**')} of {met.count('**no**') + met.count('yes')} goals are missed"
        self.assertTrue(missed in (bench.PAGE.parents[1] / "README.md").read_text(), f"README.md does not say: {missed}")


class Starting(unittest.TestCase):
    def program(self, folder, text):
        file = Path(folder) / "program"
        file.write_text(f"#!/bin/sh\n{text}\n")
        os.chmod(file, 0o755)
        return Programs(folder)

    def test_figures_are_the_last_line_and_a_failure_carries_the_programs_words(self):
        with tempfile.TemporaryDirectory() as folder:
            self.assertEqual(self.program(folder, "echo hello; echo '{\"ns\": 5}'").run("program"), {"ns": 5})
            with self.assertRaisesRegex(Crash, "ended with 3: no such graph"):
                self.program(folder, "echo 'no such graph' >&2; exit 3").run("program")


if __name__ == "__main__":
    unittest.main()
