#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""Every block of commands of docs/raspberry_pi.md says how it is tested, and test/docs/run_guide.py reads pages as it says."""
import contextlib
import io
import pathlib
import signal
import tempfile
import unittest

import run_guide
from run_guide import PageError, blocks_of, is_shown

ROOT = pathlib.Path(__file__).resolve().parents[2]
GUIDE = ROOT / "docs" / "raspberry_pi.md"


def page(mark, language="sh", text="true\n"):
    return f"Words.\n\n{mark}\n```{language}\n{text}```\n"


class Guide(unittest.TestCase):
    def test_every_block_has_a_mark(self):
        blocks = blocks_of(GUIDE, GUIDE.read_text())
        self.assertGreater(sum(block.in_chroot for block in blocks), 5)

    def test_the_tests_that_it_names_exist(self):
        declared = "\n".join(file.read_text() for file in (ROOT / "test").rglob("CMakeLists.txt"))
        for block in blocks_of(GUIDE, GUIDE.read_text()):
            if name := block.mark["test"]:
                with self.subTest(name=name, place=block.place):
                    self.assertRegex(declared, rf"\b{name}\b")

    def test_the_readme_installs_what_the_guide_installs(self):
        (commands,) = blocks_of("README.md", (ROOT / "README.md").read_text(), every=False)
        self.assertTrue(commands.in_chroot)
        self.assertEqual(len(commands.text.splitlines()), 2, "two commands")


class Pages(unittest.TestCase):
    def test_a_block_without_a_mark_is_an_error_that_names_its_line(self):
        with self.assertRaisesRegex(PageError, r"^p\.md:4: "):
            blocks_of("p.md", page(""))

    def test_a_mark_that_says_nothing_is_an_error(self):
        for mark in ("<!-- tested -->", "<!-- tested: chroot and more -->", "<!-- not run: -->", "<!-- note -->"):
            for every in (True, False):
                with self.subTest(mark=mark, every=every), self.assertRaises(PageError):
                    blocks_of("p.md", page(mark), every)

    def test_marks_are_read(self):
        chroot, stays, other, none = (blocks_of("p.md", page(f"<!-- {mark} -->"))[0]
                                      for mark in ("tested: chroot, exit 3", "tested: chroot, stays", "tested: vm_service", "not run: it needs a Pi: boots"))  # fmt: skip
        self.assertEqual((chroot.in_chroot, chroot.mark["stays"], chroot.mark["exit"]), (True, None, "3"))
        self.assertTrue(stays.in_chroot and stays.mark["stays"])
        self.assertEqual((other.in_chroot, other.mark["test"]), (False, "vm_service"))
        self.assertEqual((none.in_chroot, none.mark["reason"]), (False, "it needs a Pi: boots"))

    def test_an_output_belongs_to_the_block_before_it(self):
        run, shown = page("<!-- tested: chroot -->"), page("<!-- output -->", "text", "yes\n")
        (block,) = blocks_of("p.md", run + shown)
        self.assertEqual(block.output, "yes\n")
        for text in (shown, run + shown + shown, page("<!-- not run: why -->") + shown):
            with self.subTest(text=text), self.assertRaises(PageError):
                blocks_of("p.md", text)

    def test_dots_stand_for_anything(self):
        for shown, printed in (("a\n", "a\n"), ("a ... c", "a b c\n"), ("a\n...\nd", "a\nb\nc\nd\n"), ("a\n...\nd", "a\nd\n"), ("...\nd", "a\nd")):
            with self.subTest(shown=shown, printed=printed):
                self.assertTrue(is_shown(shown, printed))
        for shown, printed in (("a\n", "a\nb\n"), ("a.c", "abc"), ("a ... c", "a b\nc\n"), ("a\n...", "b\na\n"), ("a", "")):
            with self.subTest(shown=shown, printed=printed):
                self.assertFalse(is_shown(shown, printed))


class Recorder:
    """Takes the place of a Debian: notes what is run and answers what a case says."""

    def __init__(self, emulated=False, **answers):
        self.answers, self.noted, self.emulated = answers, [], emulated

    def is_emulated(self):
        return self.emulated

    def run(self, user, script):
        self.noted.append(script.strip())
        return self.answers.get(script.strip(), (0, ""))

    def start(self, script):
        self.noted.append("start " + script.strip())
        return self.answers.get(script.strip(), (None, ""))

    def stop(self):
        self.noted.append("stop")


class Here(run_guide.Debian):
    """Runs the scripts on this machine, as its user."""

    def command(self, user, script):
        return ["bash", "-c", f"set -euo pipefail\n{script}"]


class Logins(unittest.TestCase):
    def setUp(self):
        self.debian = Here(pathlib.Path("/"), timeout=60)
        self.addCleanup(self.debian.stop)

    def test_a_failed_command_ends_its_block(self):
        self.assertEqual(self.debian.run("pi", "echo a; false; echo b"), (1, "a\n"))

    def test_a_block_that_takes_too_long_is_ended(self):
        self.debian.timeout = 0.2
        code, said = self.debian.run("pi", "sleep 1000")
        self.assertEqual(code, 124)
        self.assertIn("ended after 0.2 s", said)

    def test_what_stays_is_waited_for_and_is_interrupted_at_the_end(self):
        code, said = self.debian.start("echo '10 components active in 5 ms: a'; exec sleep 1000")
        self.assertEqual((code, said), (None, "10 components active in 5 ms: a\n"))
        process = self.debian.staying
        self.debian.stop()
        self.assertEqual(process.returncode, -signal.SIGINT)

    def test_programs_of_another_processor_are_emulated(self):
        self.assertFalse(self.debian.is_emulated())
        with tempfile.TemporaryDirectory() as folder:
            program = pathlib.Path(folder) / "usr" / "bin" / "env"
            program.parent.mkdir(parents=True)
            here = bytearray(pathlib.Path("/usr/bin/env").read_bytes()[:64])
            here[18] ^= 1
            program.write_bytes(here)
            self.assertTrue(Here(pathlib.Path(folder), timeout=60).is_emulated())

    def test_an_end_that_is_early_is_noticed(self):
        self.assertEqual(self.debian.start("echo no; exit 7"), (7, "no\n"))


class Runs(unittest.TestCase):
    def run_marked(self, debian, *marked):
        text = "".join(page(f"<!-- {mark} -->", "text" if mark == "output" else "sh", command + "\n") for mark, command in marked)
        with contextlib.redirect_stdout(io.StringIO()):
            return run_guide.run_pages(blocks_of("p.md", text), debian)

    def test_blocks_run_in_their_order_and_what_stays_is_ended(self):
        debian = Recorder()
        sums = self.run_marked(debian, ("tested: chroot", "a"), ("not run: why", "b"), ("tested: chroot, stays", "c"), ("tested: other", "d"), ("tested: chroot", "e"))
        self.assertEqual((sums, debian.noted), ((3, 0, 1), ["a", "stop", "start c", "e", "stop"]))

    def test_what_needs_this_processor_is_left_out_under_emulation(self):
        for emulated, expected in ((False, ((2, 0, 0), ["a", "b", "stop"])), (True, ((1, 0, 1), ["b", "stop"]))):
            with self.subTest(emulated=emulated):
                debian = Recorder(emulated=emulated)
                sums = self.run_marked(debian, ("tested: chroot, native", "a"), ("tested: chroot", "b"))
                self.assertEqual((sums, debian.noted), expected)

    def test_a_failed_command_an_end_that_is_early_and_another_output_fail(self):
        debian = Recorder(a=(1, ""), b=(0, ""), c=(0, "no\n"), d=(3, "yes\n"))
        sums = self.run_marked(debian, ("tested: chroot", "a"), ("tested: chroot, stays", "b"), ("tested: chroot", "c"), ("output", "yes"),
                               ("tested: chroot, exit 3", "d"), ("output", "yes"), ("tested: chroot, exit 2", "d"))  # fmt: skip
        self.assertEqual(sums, (1, 4, 0))


if __name__ == "__main__":
    unittest.main()
