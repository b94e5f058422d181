#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""Packages that `nacelle new component` writes: built, tested, loaded by name and run, against an installation of this build.

usage: new_component_test.py BUILD [-v]    BUILD is a folder of CMake in which everything is built
"""
import os
import pathlib
import re
import shutil
import signal
import subprocess
import sys
import tempfile
import time
import unittest

BUILD = None  # of main
KINDS = {"wheel_counter": "", "sonar": "--driver", "smoother": "--filter"}
LIMIT_S = 60  # for what a robot does at once; a machine with much else to do takes longer


def class_of(name):
    return f"{name}::{name.title().replace('_', '')}"


class NewComponent(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.home = pathlib.Path(tempfile.mkdtemp(prefix="nacelle-new-"))
        cls.addClassCleanup(shutil.rmtree, cls.home)
        cls.variables = {name: value for name, value in os.environ.items() if not name.startswith(("NACELLE_", "COLCON_", "CMAKE_"))}
        cls.variables.update(HOME=str(cls.home), COLCON_HOME=str(cls.home / "colcon"), XDG_RUNTIME_DIR=str(cls.home / "run"),
                             CMAKE_GENERATOR="Ninja", CMAKE_BUILD_PARALLEL_LEVEL="2")  # fmt: skip
        (cls.home / "run").mkdir(mode=0o700)
        if ccache := shutil.which("ccache"):
            cls.variables.update(CMAKE_CXX_COMPILER_LAUNCHER=ccache, CCACHE_BASEDIR=str(cls.home), CCACHE_NOHASHDIR="1", LC_ALL="C.UTF-8", LANG="C.UTF-8")
            cls.variables.setdefault("CCACHE_DIR", str(pathlib.Path.home() / ".cache" / "ccache"))
        outcome = subprocess.run(["cmake", "--install", BUILD, "--prefix", cls.home / "nacelle"], capture_output=True, text=True, check=False)
        if outcome.returncode != 0:
            raise RuntimeError(outcome.stderr)
        # As the pages say: CMake finds Nacelle where the shell finds its program.
        cls.variables["PATH"] = f"{cls.home}/nacelle/bin:{os.environ['PATH']}"

    def shell(self, text, folder=None, **variables):
        return subprocess.run(["bash", "-euc", text], cwd=folder or self.home, env={**self.variables, **variables}, capture_output=True,
                              text=True, check=False)  # fmt: skip

    def succeed(self, text, folder=None, **variables):
        outcome = self.shell(text, folder, **variables)
        self.assertEqual(outcome.returncode, 0, f"{text}\n{outcome.stdout}{outcome.stderr}")
        return outcome.stdout

    def write_and_build(self, name):
        """The folder of a new package, built as its README.md says."""
        said = self.succeed(f"nacelle new component {name} {KINDS[name]}")
        self.assertIn(f"{name}/src/{name}.cpp\n", said)
        readme = (self.home / name / "README.md").read_text()
        self.assertIn(f"# {name}\n", readme)
        (commands,) = re.findall(r"(?s)```sh\n(.*?)^```", readme, re.MULTILINE)
        commands, launch = commands.rsplit("\n", 2)[:2]
        self.assertEqual(launch, f"nacelle launch launch/{name}.launch.yaml")
        begin = time.monotonic()
        said = self.succeed(commands, self.home / name)
        print(f"\n{name}: configured, built and tested in {time.monotonic() - begin:.1f} s", file=sys.stderr)
        self.assertIn("100% tests passed", said)
        return self.home / name

    def run_and_ask(self, package, variables):
        """Launches the package's file, and returns when its component is active."""
        name = package.name
        robot = subprocess.Popen(["nacelle", "launch", f"launch/{name}.launch.yaml", "--name", name, "network:=off"], cwd=package,
                                 env={**self.variables, **variables}, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)  # fmt: skip
        try:
            end = time.monotonic() + LIMIT_S
            while not re.search(r"\bactive\b", said := self.shell(f"nacelle component list --container {name}").stdout):
                self.assertIsNone(robot.poll(), robot.stdout.read() if robot.poll() is not None else "")
                self.assertLess(time.monotonic(), end, said)
            self.assertIn(f"/{name}", said)
            if name == "wheel_counter":
                said = self.succeed(f"nacelle topic echo /chatter --once --container {name}")
                self.assertIn("hello", said)
        finally:
            if robot.poll() is None:
                robot.send_signal(signal.SIGINT)
            said, _ = robot.communicate(timeout=LIMIT_S)
        self.assertEqual(robot.returncode, 0, said)

    def test_each_kind_is_built_tested_loaded_by_name_and_run(self):
        for name in KINDS:
            with self.subTest(name=name):
                package = self.write_and_build(name)
                in_build = {"NACELLE_COMPONENT_PATH": f"{package}/build/lib/nacelle"}
                page = self.succeed(f"nacelle component info --doc {class_of(name)}", **in_build)
                self.assertIn(f"## {class_of(name)}", page)
                self.succeed(f"nacelle check {name}/launch/{name}.launch.yaml", **in_build)
                self.run_and_ask(package, in_build)

                # In a prefix of its own it still finds Nacelle's libraries, and in Nacelle's no variable is needed.
                own = self.home / f"own_{name}"
                self.succeed(f"cmake --install {name}/build --prefix {own}")
                self.assertTrue((own / "share" / name / "launch" / f"{name}.launch.yaml").is_file())
                library = own / "lib" / "nacelle" / f"nacelle_{name}.so"
                self.assertNotIn("not found", self.succeed(f"ldd {library}"))
                self.succeed(f"nacelle component info --doc {class_of(name)}", NACELLE_COMPONENT_PATH=str(library.parent))
                self.succeed(f"cmake --install {name}/build --prefix $HOME/nacelle && nacelle component info --doc {class_of(name)}")
        with self.subTest("a package of that name is installed"):
            outcome = self.shell("mkdir elsewhere && cd elsewhere && nacelle new component sonar")
            self.assertEqual(outcome.returncode, 1)
            self.assertIn("there is a component 'sonar' already: ", outcome.stderr)

    def test_a_component_of_another_abi_is_refused_by_name(self):
        """Another Nacelle: its headers have the next ABI."""
        shutil.copytree(self.home / "nacelle", self.home / "later", symlinks=True)
        header = self.home / "later" / "include" / "nacelle" / "node" / "component.hpp"
        number = int(re.search(r"define NACELLE_COMPONENT_ABI (\d+)", header.read_text())[1])
        header.write_text(re.sub(r"(define NACELLE_COMPONENT_ABI) \d+", rf"\1 {number + 1}", header.read_text()))
        self.succeed("nacelle new component from_later && cmake -S from_later -B from_later/build -DCMAKE_PREFIX_PATH=$HOME/later && "
                     "cmake --build from_later/build --target nacelle_from_later")  # fmt: skip
        folder = self.home / "from_later" / "build" / "lib" / "nacelle"
        refusal = (f"{folder}/nacelle_from_later.so was built for component ABI {number + 1}, "
                   f"this container has {number}; build it again with the headers of this version")  # fmt: skip
        for command, code in (("component info --doc from_later::FromLater", 1), ("check from_later/launch/from_later.launch.yaml", 1),
                              ("launch from_later/launch/from_later.launch.yaml network:=off", 1)):  # fmt: skip
            with self.subTest(command=command):
                outcome = self.shell(f"nacelle {command}", NACELLE_COMPONENT_PATH=str(folder))
                self.assertEqual(outcome.returncode, code, outcome.stdout + outcome.stderr)
                self.assertRegex(outcome.stdout + outcome.stderr, r"from_later::FromLater\)?: " + re.escape(refusal))

    @unittest.skipUnless(shutil.which("colcon"), "colcon is not installed")
    def test_the_same_folders_are_colcon_packages_beside_each_other(self):
        workspace = self.home / "workspace" / "src"
        workspace.mkdir(parents=True)
        for name, kind in KINDS.items():
            self.succeed(f"nacelle new component colcon_{name} {kind}", workspace)
        self.succeed("colcon build --executor sequential && colcon test --executor sequential --return-code-on-test-failure", workspace.parent)
        said = self.succeed("colcon test-result --all", workspace.parent)
        self.assertRegex(said, r"Summary: [1-9]\d* tests, 0 errors, 0 failures, 0 skipped")
        for name in KINDS:
            one = f"colcon_{name}"
            self.succeed(f"nacelle component info --doc {class_of(one)}", NACELLE_COMPONENT_PATH=f"{workspace.parent}/install/{one}/lib/nacelle")

    def test_what_cannot_be_is_refused_with_the_way_out(self):
        (self.home / "taken").mkdir()
        for words, code, text in (
            ("Wheel-Counter", 2, "invalid name 'Wheel-Counter'; use lower-case letters, digits and single underscores, first a letter, such as wheel_counter"),
            ("time", 2, "'time' is a function or variable of a library; use another name, such as my_time"),
            ("state --driver", 2, "the class would be called State, as a type that its code uses; use another name, such as my_state"),
            ("mine --lang python", 2, "--lang: invalid value 'python'; "),
            ("mine --driver --filter", 2, "--driver"),
            ("", 2, "name"),
            ("taken", 1, "taken: already exists; use another name, or go to another folder"),
            ("lidar", 1, "use another name, such as my_lidar"),
        ):
            with self.subTest(words=words):
                outcome = self.shell(f"nacelle new component {words}")
                self.assertEqual(outcome.returncode, code, outcome.stderr)
                self.assertIn(text, outcome.stderr)
        self.assertEqual(list((self.home / "taken").iterdir()), [])
        self.assertFalse((self.home / "mine").exists())


if __name__ == "__main__":
    BUILD = pathlib.Path(sys.argv.pop(1)).resolve()
    unittest.main()
