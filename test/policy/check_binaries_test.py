#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""The test of check_binaries.py: plants each weakness once in a small ELF file and expects exactly that complaint."""
import struct
import sys
import tempfile
import unittest
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parent))
import check_binaries as check  # noqa: E402


def elf(kind=check.ET_DYN, program=True, relro=True, now=True, stack=6, pie=True, runpath="$ORIGIN/../lib", tag=check.DT_RUNPATH, machine=62, page=4096):
    """Returns the smallest file with all fields that the check reads. `stack` is the flags of PT_GNU_STACK, None for no such segment."""
    names = b"\0" + runpath.encode() + b"\0"
    types = [(check.PT_LOAD, 5), (check.PT_DYNAMIC, 6)]
    types += [(check.PT_INTERP, 4)] if program else []
    types += [(check.PT_GNU_RELRO, 4)] if relro else []
    types += [(check.PT_GNU_STACK, stack)] if stack is not None else []
    names_at = 64 + 56 * len(types)
    dynamic_at = names_at + len(names)
    flags_1 = (check.DF_1_NOW if now else 0) | (check.DF_1_PIE if pie else 0)
    dynamic = struct.pack("<qQqQqQqQ", check.DT_STRTAB, names_at, tag, 1, check.DT_FLAGS_1, flags_1, 0, 0)
    size = dynamic_at + len(dynamic)
    header = b"\x7fELF\x02\x01\x01" + bytes(9)
    header += struct.pack("<HHIQQQIHHHHHH", kind, machine, 1, 0, 64, 0, 0, 64, 56, len(types), 0, 0, 0)
    for what, flags in types:
        offset, length = (dynamic_at, len(dynamic)) if what == check.PT_DYNAMIC else (0, size)
        header += struct.pack("<IIQQQQQQ", what, flags, offset, offset, offset, length, length, page if what == check.PT_LOAD else 8)
    return header + names + dynamic


PLANTED = {
    "an empty element at the end": (elf(runpath="$ORIGIN/../lib:"), "empty element"),
    "an empty element at the begin": (elf(runpath=":/usr/lib"), "empty element"),
    "an empty element within": (elf(runpath="/a::/b"), "empty element"),
    "an empty path": (elf(runpath=""), "empty element"),
    "an empty element of the older kind": (elf(runpath="/a:", tag=check.DT_RPATH), "empty element"),
    "no RELRO": (elf(relro=False), "no RELRO"),
    "lazy binding": (elf(now=False), "bound lazily"),
    "an executable stack": (elf(stack=7), "stack is executable"),
    "nothing about the stack": (elf(stack=None), "stack is executable"),
    "a program at a fixed address": (elf(kind=check.ET_EXEC), "not position-independent"),
    "a program without -pie": (elf(pie=False), "not linked with -pie"),
    "small pages on arm64": (elf(machine=check.EM_AARCH64), "pages of 16 KiB"),
}

GOOD = "c++ -U_FORTIFY_SOURCE -fstack-protector-strong -fstack-clash-protection -D_FORTIFY_SOURCE=3 -c a.cpp"


class BinariesTest(unittest.TestCase):
    def test_sound_files_pass(self):
        with tempfile.TemporaryDirectory() as folder:
            (Path(folder) / "program").write_bytes(elf())
            (Path(folder) / "library.so").write_bytes(elf(program=False, pie=False))
            (Path(folder) / "of_arm64").write_bytes(elf(machine=check.EM_AARCH64, page=0x10000))
            (Path(folder) / "object.o").write_bytes(elf(kind=1, relro=False))
            (Path(folder) / "text").write_text("\x7fELF is how they begin")
            self.assertEqual(check.check_files(Path(folder)), (3, []))

    def test_finds_what_is_planted(self):
        for name, (data, words) in PLANTED.items():
            with self.subTest(name), tempfile.TemporaryDirectory() as folder:
                (Path(folder) / "planted").write_bytes(data)
                count, found = check.check_files(Path(folder))
                self.assertEqual(count, 1)
                self.assertEqual(len(found), 1, found)
                self.assertIn(words, found[0])

    def test_leaves_other_builds_within_alone(self):
        with tempfile.TemporaryDirectory() as folder:
            other = Path(folder) / "address"
            other.mkdir()
            (other / "CMakeCache.txt").write_text("")
            (other / "program").write_bytes(elf(relro=False))
            self.assertEqual(check.check_files(Path(folder)), (0, []))

    def test_leaves_programs_of_other_projects_alone(self):
        with tempfile.TemporaryDirectory() as folder:
            peers = Path(folder) / "test/peers"
            peers.mkdir(parents=True)
            (peers / "peer").write_bytes(elf(relro=False))
            self.assertEqual(check.check_files(Path(folder)), (0, []))

    def complaints(self, command, file="components/a.cpp", machine="x86_64"):
        commands = [{"directory": "/r/build", "command": command, "file": f"/r/{file}"}]
        return check.check_flags(commands, Path("/r"), Path("/r/build"), machine)

    def test_sound_flags_pass(self):
        self.assertEqual(self.complaints(GOOD), (1, []))
        self.assertEqual(self.complaints(GOOD, file="build/containers/runtime/Unity/a_0.cpp"), (1, []))
        self.assertEqual(self.complaints("c++ -c a.cpp", file="test/unit/a.cpp"), (0, []))
        self.assertEqual(self.complaints(GOOD + " -mbranch-protection=standard", machine="aarch64"), (1, []))

    def test_finds_a_flag_that_is_missing(self):
        for flag in check.FLAGS:
            with self.subTest(flag):
                count, found = self.complaints(GOOD.replace(flag, ""))
                self.assertEqual((count, len(found)), (1, 1))
                self.assertIn(flag, found[0])
        self.assertIn("-mbranch-protection", self.complaints(GOOD, machine="aarch64")[1][0])

    def test_finds_a_flag_that_is_taken_back(self):
        self.assertIn("_FORTIFY_SOURCE", self.complaints(GOOD + " -U_FORTIFY_SOURCE")[1][0])


if __name__ == "__main__":
    unittest.main()
