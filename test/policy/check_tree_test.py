#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""The test of check_tree.py: breaks each promise once in a small tree and expects exactly that complaint."""
import sys
import tempfile
import unittest
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parent))
import check_tree  # noqa: E402

SPDX = "SPDX-License-Identifier: Apache-2.0\n"
MANIFEST = """<package format="3"><name>{name}</name><license>Apache-2.0</license>{depends}
<export><build_type>cmake</build_type></export></package>
"""


def manifest(name, *depends):
    return MANIFEST.format(name=name, depends="".join(f"<depend>{entry}</depend>" for entry in depends))


SOUND = {
    "CHANGELOG.md": "# Changelog\n\n## Unreleased\n",
    "dev": "#!/usr/bin/env bash\n# " + SPDX,
    ".ci/packages.txt": "# the list\nbuild: cmake\ninterfaces/base: libfmt-dev\n",
    "interfaces/base/CMakeLists.txt": "# " + SPDX + "project(nacelle_base CXX)\nnacelle_package(EXTERNAL fmt)\n",
    "interfaces/base/package.xml": manifest("nacelle_base", "libfmt-dev"),
    "debian/control": "Source: a\nBuild-Depends:\n debhelper-compat (= 13),\n cmake,\n libfmt-dev,\nPackage: a\n",
    "components/lidar/CMakeLists.txt": "# " + SPDX + "project(nacelle_lidar CXX)\nnacelle_package(DEPENDS nacelle_base)\n",
    "components/lidar/package.xml": manifest("nacelle_lidar", "nacelle_base"),
    "components/lidar/protocol/a.cpp": "// " + SPDX + "  Mutex m_;\n  int a NACELLE_GUARDED_BY(m_) = 0;\n",
    "test/unit/lidar/CMakeLists.txt": "# " + SPDX + "nacelle_test(a_test SOURCES a_test.cpp)\n",
    "test/unit/lidar/a_test.cpp": "// " + SPDX + "TEST(A, b) { EXPECT_TRUE(true); }\n",
}

HOST = "deb." + "debian.org"
# name -> (path, text or None to remove it, words of the complaint)
BROKEN = {
    "a folder too many": ("utils/a.md", "x\n", "utils: not one of"),
    "no licence line": ("components/lidar/protocol/a.cpp", "#pragma once\n", "none of its first lines"),
    "a licence line that goes on": (
        "components/lidar/protocol/a.cpp",
        "// " + SPDX.strip() + " What is here.\n",
        "none of its first lines",
    ),
    "no licence line in a script": (".ci/run", "#!/usr/bin/env bash\n", "none of its first lines"),
    "a private path": ("docs/a.md", "see /ro" + "ot/x/y\n", "private machine"),
    "a scratch path": ("docs/a.md", "see /tmp" + "/w/notes\n", "private machine"),
    "a registry": ("docs/a.md", f"from http://{HOST}/x\n", "package registry"),
    "no place for changes": ("CHANGELOG.md", "# Changelog\n", "no heading"),
    "no package.xml": ("components/lidar/package.xml", None, "no package.xml"),
    "two names": ("components/lidar/package.xml", manifest("nacelle_radar", "nacelle_base"), "project() says"),
    "colcon does not know": ("components/lidar/package.xml", manifest("nacelle_lidar"), "nacelle_package() lists it"),
    "cmake does not know": (
        "components/lidar/package.xml",
        manifest("nacelle_lidar", "nacelle_base", "nacelle_io"),
        "does not list it",
    ),
    "an unlisted package": (
        "components/lidar/package.xml",
        manifest("nacelle_lidar", "nacelle_base", "libudev-dev"),
        "libudev-dev is not in",
    ),
    "a listed folder that is gone": (".ci/packages.txt", "interfaces/base: libfmt-dev\na/b: cmake\n", "no folder 'a/b'"),
    "a listed package without a dependency": (".ci/packages.txt", "interfaces/base: libfmt-dev cmake\n", "its package.xml does not"),
    "a build that Debian's builders cannot repeat": ("debian/control", "Build-Depends:\n cmake,\n", "no libfmt-dev in Build-Depends"),
    "a package that nothing needs": ("debian/control", "Build-Depends:\n cmake,\n libfmt-dev,\n libx-dev,\n", "libx-dev in Build-Depends"),
    "a link to nowhere": ("docs/a.md", "see [b](b.md#there)\n", "links to b.md"),
    "a test without assertion": ("test/unit/lidar/a_test.cpp", "// " + SPDX, "assertion"),
    "a check switched off without a reason": (".clang-tidy", "Checks: >\n  bugprone-*,\n  -bugprone-x-y,\n", "no heading"),
    "a NOLINT without a reason": (
        "components/lidar/protocol/a.cpp",
        "// " + SPDX + "int a;  // NOLINT(some-check)\n",
        "NOLINT(some-check)",
    ),
    "a NOLINT of everything": ("components/lidar/protocol/a.cpp", "// " + SPDX + "int a;  // NOLINT\n", "NOLINT()"),
    "JSON without a bound": ("components/lidar/protocol/a.cpp", "// " + SPDX + "using Json = nlohmann::ordered_json;\nauto a = Json::parse(t);\n", "reads JSON"),
    "XML without a bound": ("components/lidar/protocol/a.cpp", "// " + SPDX + "document.Parse(text);\n", "reads XML"),
    "YAML without a bound": ("components/lidar/protocol/a.cpp", "// " + SPDX + "YAML::LoadFile(path);\n", "reads YAML"),
    "a file that may be a FIFO": ("components/lidar/protocol/a.cpp", "// " + SPDX + "std::ifstream file{path};\n", "reads a file"),
    "a lock that is not checked": ("components/lidar/protocol/a.cpp", "// " + SPDX + "std::mutex m;\n", "std::mutex is not checked"),
    "a guard that is not checked": ("components/lidar/protocol/a.cpp", "// " + SPDX + "std::lock_guard l(m);\n", "std::lock_guard is not"),
    "a lock that guards nothing": ("components/lidar/protocol/a.cpp", "// " + SPDX + "  mutable Mutex m_;\n  int a;\n", "NACELLE_GUARDED_BY(m_)"),
    "a lock of another name": (
        "components/lidar/protocol/a.cpp",
        "// " + SPDX + "  Mutex m_;\n  int a NACELLE_GUARDED_BY(n_);\n",
        "NACELLE_GUARDED_BY(m_)",
    ),
    "an exception that is gone": ("components/transforms/model/robot_tree.cpp", "// " + SPDX, "has no lock lock any more"),
    "a test that is not built": ("test/unit/lidar/b_test.cpp", "// " + SPDX + "EXPECT_EQ(1, 1);\n", "no CMakeLists.txt builds it"),
}


class TreeTest(unittest.TestCase):
    def complaints(self, changes):
        with tempfile.TemporaryDirectory() as folder:
            root = Path(folder)
            for path, text in {**SOUND, **changes}.items():
                if text is not None:
                    (root / path).parent.mkdir(parents=True, exist_ok=True)
                    (root / path).write_text(text, encoding="utf-8")
            tree = check_tree.Tree(root)
            return [complaint for rule in check_tree.RULES for complaint in rule(tree)]

    def test_a_sound_tree_has_no_complaint(self):
        self.assertEqual(self.complaints({}), [])

    def test_each_broken_promise_is_found(self):
        for name, (path, text, words) in BROKEN.items():
            with self.subTest(name):
                complaints = self.complaints({path: text})
                self.assertTrue(any(words in complaint for complaint in complaints), complaints)

    def test_a_tree_without_files_is_not_called_sound(self):
        with tempfile.TemporaryDirectory() as folder:
            sys.argv = ["check_tree.py", folder]
            self.assertEqual(check_tree.main(), 1)


if __name__ == "__main__":
    unittest.main()
