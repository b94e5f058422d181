#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""docs/packages_outside_the_tree.md: its files are written, and its commands run in their order, against an installation of this build.

usage: outside_doc.py BUILD [-v]    BUILD is a folder of CMake in which everything is built
"""
import os
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile
import unittest

ROOT = pathlib.Path(__file__).resolve().parents[2]
PAGE = ROOT / "docs" / "packages_outside_the_tree.md"
BUILD = None  # of main
BLOCK = re.compile(r"^(?P<before>[^\n]*)\n\n```(?P<language>\w+)\n(?P<text>.*?)^```$", re.MULTILINE | re.DOTALL)
FILE = re.compile(r"^`(my_robot/[\w./]+)`")
# The self-description of a library of an older Nacelle (nacelle/node/component.hpp).
OLD_LIBRARY = """
#include <stddef.h>
#include <stdint.h>
struct { uint32_t abi; size_t count; const void* classes; } table = {ABI, 0, 0};
const void* nacelle_component_table(void) { return &table; }
"""


class OutsideTheTree(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.home = pathlib.Path(tempfile.mkdtemp(prefix="nacelle-outside-"))
        cls.addClassCleanup(shutil.rmtree, cls.home)
        cls.blocks = [(match["before"], match["language"], match["text"]) for match in BLOCK.finditer(PAGE.read_text())]
        cls.variables = {name: value for name, value in os.environ.items() if not name.startswith(("NACELLE_", "COLCON_", "CMAKE_"))}
        cls.variables.update(HOME=str(cls.home), COLCON_HOME=str(cls.home / "colcon"), CMAKE_GENERATOR="Ninja", CMAKE_BUILD_PARALLEL_LEVEL="2")  # fmt: skip
        if ccache := shutil.which("ccache"):
            cls.variables.update(CMAKE_CXX_COMPILER_LAUNCHER=ccache, CCACHE_BASEDIR=str(cls.home), CCACHE_NOHASHDIR="1", LC_ALL="C.UTF-8", LANG="C.UTF-8")
            cls.variables.setdefault("CCACHE_DIR", str(pathlib.Path.home() / ".cache" / "ccache"))

    def run_shell(self, text):
        return subprocess.run(["bash", "-euc", text], cwd=self.home, env=self.variables, capture_output=True, text=True, check=False)

    def test_the_files_are_built_and_the_commands_run(self):
        commands = []
        for before, language, text in self.blocks:
            if named := FILE.match(before):
                file = self.home / named[1]
                file.parent.mkdir(parents=True, exist_ok=True)
                file.write_text(text)
            elif language == "sh":
                commands.append(text)
        script = "".join(commands).replace("cmake --install build", f"cmake --install {BUILD}")
        if shutil.which("colcon") is None:
            script = re.sub(r"^colcon .*\n.*\n", "", script, flags=re.MULTILINE)
        self.assertGreater(script.count("nacelle check"), 1)
        outcome = self.run_shell("set -x\n" + script)
        said = outcome.stdout + outcome.stderr
        self.assertEqual(outcome.returncode, 0, said)
        self.assertIn("100% tests passed", outcome.stdout, said)
        self.assertIn("## my_robot::Counter\n\nCounts up.", outcome.stdout)
        self.assertEqual(outcome.stdout.count("my_robot/counter.launch.yaml: 1 component, 1 stream: sound"), 2, said)

        for example in sorted((ROOT / "docs" / "examples" / "packages").iterdir()):
            if (example / "test").is_dir():
                continue  # a template of `nacelle new component`: new_component_test.py builds it
            with self.subTest(example=example.name):
                built = self.run_shell(f"cmake -S {example} -B {example.name} -DCMAKE_PREFIX_PATH=$HOME/nacelle -DCMAKE_BUILD_TYPE=Debug "
                                       f"&& cmake --build {example.name} && ls {example.name}/lib/nacelle/nacelle_example_{example.name}.so")  # fmt: skip
                self.assertEqual(built.returncode, 0, built.stdout + built.stderr)

    def test_the_message_of_another_abi_is_the_programs(self):
        (shown,) = [text for before, language, text in self.blocks if "component ABI" in text]
        old, new = re.search(r"component ABI (\d+), this container has (\d+)", shown).groups()
        index = self.home / "old" / "index"
        index.mkdir(parents=True)
        (index / "nacelle_my_robot").write_text("my_robot::Counter;nacelle_my_robot.so\n")
        library = self.home / "old" / "nacelle_my_robot.so"
        subprocess.run(["cc", "-shared", "-fPIC", f"-DABI={old}", "-x", "c", "-", "-o", library], input=OLD_LIBRARY, text=True, check=True)
        outcome = self.run_shell(f"NACELLE_COMPONENT_PATH=$HOME/old {BUILD}/bin/nacelle component info --doc my_robot::Counter")
        self.assertEqual(outcome.returncode, 1)
        self.assertEqual(outcome.stderr.strip(), "nacelle: " + shown.strip().replace("...", f"{self.home}/old"), f"is the ABI {new} no more?")

    def test_every_block_is_a_file_or_is_run(self):
        for before, language, text in self.blocks:
            with self.subTest(block=text):
                self.assertTrue(FILE.match(before) or language == "sh" or "component ABI" in text)
        self.assertEqual(len(self.blocks), PAGE.read_text().count("\n```") // 2)


if __name__ == "__main__":
    BUILD = pathlib.Path(sys.argv.pop(1)).resolve()
    unittest.main()
