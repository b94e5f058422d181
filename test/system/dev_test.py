#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""What ./dev promises before it builds anything: words, exit codes, completion, and the one list of packages."""
import os
import shutil
import subprocess
import tempfile
import unittest
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
VERBS = ("setup", "build", "run", "test", "vm", "bench", "lint", "nacelle", "deb", "test-deb", "release")


def dev(*arguments, cwd=ROOT, env=None, script=ROOT / "dev"):
    return subprocess.run(
        [str(script), *arguments], cwd=cwd, env=env, stdin=subprocess.DEVNULL, capture_output=True, text=True, check=False
    )


# Stands for ctest: two tests of which the second failed.
CTEST = """#!/bin/sh
while [ "$1" != --output-junit ]; do shift; done
echo '<testsuite name="x" tests="2" failures="1" disabled="0" skipped="0">
<testcase name="good" time="1" status="run"/>
<testcase name="bad" time="1" status="fail"/>
</testsuite>' >"$2"
exit 8
"""


class DevTest(unittest.TestCase):
    def test_alone_and_with_help_it_prints_every_verb(self):
        for arguments in ((), ("--help",), ("-h",), ("test", "--help"), ("lint", "-h"), ("bench", "--help")):
            answer = dev(*arguments)
            self.assertEqual(answer.returncode, 0)
            for verb in VERBS:
                self.assertRegex(answer.stdout, rf"(?m)^  {verb}\b")

    def test_help_of_what_runs_the_program_neither_installs_nor_builds(self):
        with tempfile.TemporaryDirectory() as folder:
            script = Path(folder) / "dev"
            script.write_bytes((ROOT / "dev").read_bytes())
            script.chmod(0o755)
            program = Path(folder) / "build/bin/nacelle"
            for arguments, passed in ((("run", "--help"), "drive --help"), (("run", "--for", "3", "-h"), "drive --help"),
                                      (("nacelle", "topic", "--help"), "topic --help")):  # fmt: skip
                with self.subTest(arguments=arguments):
                    program.unlink(missing_ok=True)
                    answer = dev(*arguments, script=script)
                    self.assertEqual((answer.returncode, answer.stderr), (0, ""))
                    self.assertRegex(answer.stdout, rf"(?m)^  {arguments[0]} ")
                    self.assertIn(f"build it first (./dev build), then ./dev nacelle {passed}", answer.stdout)
                    self.assertFalse(program.parent.exists(), "nothing was built")
                    program.parent.mkdir(parents=True)
                    program.write_text('#!/bin/sh\necho "the program: $*"\n')
                    program.chmod(0o755)
                    answer = dev(*arguments, script=script)
                    self.assertEqual(answer.stdout.splitlines()[-1], f"the program: {passed}")
                    self.assertNotIn("build it first", answer.stdout)
                    program.unlink()
                    program.parent.rmdir()

    def test_an_unknown_verb_is_a_usage_error(self):
        answer = dev("biuld")
        self.assertEqual(answer.returncode, 2)
        self.assertIn("biuld", answer.stderr)
        self.assertEqual(answer.stdout, "")

    def test_a_wrong_option_is_a_usage_error_before_anything_is_installed_or_built(self):
        for arguments in (
            ("test", "--sanitizer", "memory"),
            ("run", "--sanitizer="),
            ("build", "--jobs", "many"),
            ("build", "--jobs", "0"),
            ("run", "--sanitizer"),
            ("bench", "--jsn", "x"),
            ("test", "-L", "timing", "--busy", "2"),
            ("vm", "gpoi"),
            ("vm", "--release", "sid"),
            ("vm", "--release"),
            ("deb", "--release", "sid"),
            ("deb", "--arch"),
            ("test-deb", "--arch", "riscv64"),
            ("release",),
            ("release", "--key", ""),
            ("build", "--arch", "riscv64"),
            ("run", "--arch", "arm64"),
            ("test", "--arch", "arm64", "--sanitizer", "address"),
            ("test", "-L", "timing", "--arch", "arm64"),
        ):
            with self.subTest(arguments=arguments):
                answer = dev(*arguments)
                self.assertEqual(answer.returncode, 2, answer)
                self.assertNotIn("installs:", answer.stdout)

    def test_the_completion_is_bash_and_offers_the_verbs(self):
        script = dev("completion").stdout + 'COMP_WORDS=(./dev ""); COMP_CWORD=1; _nacelle_dev; echo "${COMPREPLY[@]}"'
        answer = subprocess.run(["bash", "-u", "-c", script], capture_output=True, text=True, check=True)
        self.assertTrue(set(VERBS) <= set(answer.stdout.split()), answer.stdout)

    def test_it_works_from_any_folder_through_a_link_and_without_a_locale(self):
        with tempfile.TemporaryDirectory() as folder:
            link = Path(folder) / "a link"
            link.symlink_to(ROOT / "dev")
            answer = dev("setup", "build", cwd=folder, env={"PATH": os.environ["PATH"]}, script=link)
            self.assertEqual(answer.returncode, 0, answer.stderr)
            self.assertIn("installs: nothing", answer.stdout)

    def test_what_a_line_of_the_list_needs_is_what_is_looked_for(self):
        answer = dev("setup", "no such line")
        self.assertEqual(answer.returncode, 2, answer)
        self.assertIn("no such line", answer.stderr)

    def test_a_run_of_the_tests_is_a_line_with_the_commit_and_the_outcome(self):
        with tempfile.TemporaryDirectory() as folder:
            tree, tools = Path(folder) / "tree", Path(folder) / "tools"
            (tree / ".ci").mkdir(parents=True)
            for name in ("dev", ".ci/last_run.py"):
                shutil.copy(ROOT / name, tree / name)
            (tree / ".ci/packages.txt").write_text("build: bash\ntest: bash\n")
            (tree / ".gitignore").write_text("build/\n")
            tools.mkdir()
            for name, text in (("cmake", "#!/bin/sh\n"), ("ninja", "#!/bin/sh\n"), ("ctest", CTEST)):
                (tools / name).write_text(text)
                (tools / name).chmod(0o755)
            env = {"PATH": f"{tools}:{os.environ['PATH']}", "HOME": folder}

            def git(*arguments):
                words = ("git", "-C", str(tree), "-c", "user.name=n", "-c", "user.email=e", *arguments)
                return subprocess.run(words, env=env, capture_output=True, text=True, check=True).stdout.strip()

            def last_line(*options):
                outcome = dev("test", *options, "-R", "x", cwd=folder, env=env, script=tree / "dev")
                self.assertEqual(outcome.returncode, 1, outcome.stdout + outcome.stderr)
                return (tree / "build/test-runs.log").read_text().splitlines()[-1]

            self.assertIn("  no-git  ", last_line())
            git("init", "-q")
            git("add", ".")
            git("commit", "-q", "-m", "x")
            commit = git("rev-parse", "--short=12", "HEAD")
            self.assertRegex(last_line(), rf"^\S+Z  {commit}  run 1 of 1  1 passed, 1 failed  \d+ s  ctest -R x  failed: bad *$")
            (tree / "new").touch()
            self.assertIn(f"  {commit}-dirty  run 1 of 1  ", last_line())
            self.assertEqual(len((tree / "build/test-runs.log").read_text().splitlines()), 3)
            self.assertRegex(last_line("--repeat", "2", "--busy", "1"), r"  run 2 of 2  .*  beside 1 busy loops  ctest -R x")
            self.assertRegex(last_line("--repeat", "2", "--chaos", "7"), r"  run 2 of 2  .*  chaos 8  ctest -R x")
            self.assertEqual(len((tree / "build/test-runs.log").read_text().splitlines()), 7)


if __name__ == "__main__":
    unittest.main()
