#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""docs/components.md: the reference of the components in components/, as `nacelle component info --doc` prints it.

usage: components_doc.py --write    writes docs/components.md anew
       components_doc.py [-v]       the tests: the page is what the command prints, and nothing in it lacks a description

Of the program in build/, unless NACELLE_PROGRAM names another one.
"""
import difflib
import json
import os
import pathlib
import re
import subprocess
import sys
import unittest

ROOT = pathlib.Path(__file__).resolve().parents[2]
PROGRAM = os.environ.get("NACELLE_PROGRAM", str(ROOT / "build" / "bin" / "nacelle"))
DOCUMENT = ROOT / "docs" / "components.md"

INTRODUCTION = """# Components

What each component of this repository declares: topics, services, actions, transforms, parameters and devices. `nacelle component info --doc` prints
this page from the declarations in the components' constructors, and a test compares the two. For your own components, run
`nacelle component info --doc pkg::Class`; `--json` gives the same as JSON.

Names are relative to the node's namespace, `~` is the node's name; a launch file remaps them. The first tables of a component
show what it has without parameters, those below them what it also has with the parameters named there. Read-only parameters are set by the
launch file only, the others also with `nacelle param set`. All nodes also have the services and topics of [node_interfaces.md](node_interfaces.md). On a running robot
`nacelle node info` and `nacelle param describe` show the same of a node. `nacelle params --explain` says where the values of a launch come from.

"""


def classes():
    """The component classes that the packages in components/ register, by folder."""
    found = []
    for cmake in sorted((ROOT / "components").glob("*/CMakeLists.txt")):
        for names in re.findall(r"nacelle_component\(\s*\w+\s+CLASSES\s+(.*?)\s+SOURCES", cmake.read_text(), re.DOTALL):
            found += names.split()
    return found


def told_of(name, *options):
    return subprocess.run([PROGRAM, "component", "info", "--doc", name, *options], capture_output=True, text=True, check=True).stdout


def page():
    index = "".join(f"- [{name}](#{name.lower().replace(':', '')})\n" for name in classes())
    return INTRODUCTION + index + "\n" + "\n".join(told_of(name) for name in classes())


class Reference(unittest.TestCase):
    def test_the_page_is_what_the_command_prints(self):
        self.assertGreater(len(classes()), 5)
        difference = list(difflib.unified_diff(DOCUMENT.read_text().splitlines(), page().splitlines(), n=0, lineterm=""))
        self.assertEqual(difference, [], "run test/docs/components_doc.py --write")

    def test_every_class_and_parameter_is_described(self):
        for name in classes():
            (told,) = json.loads(told_of(name, "--json"))
            parameters = told["parameters"] + told.get("also", {}).get("parameters", [])
            with self.subTest(component=name):
                self.assertTrue(told["purpose"])
                self.assertEqual([row["name"] for row in parameters if not row["description"]], [])
                self.assertEqual(bool(told["devices_text"]), any(row["name"] == "device_lost" for row in parameters), "every driver names its devices")


if __name__ == "__main__":
    if "--write" in sys.argv:
        DOCUMENT.write_text(page())
    else:
        unittest.main()
