#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""Fails on a program or library that is easier to attack than it has to be, and on a source that is compiled without its protection.

Of every ELF file below the folders given: no empty element in RUNPATH or RPATH (the loader takes it for the current directory),
RELRO and immediate binding, no executable stack, programs that are position-independent; of files for arm64, segments that a kernel with
pages of 16 KiB can map (a Raspberry Pi 5). Of compile_commands.json: the flags of
nacelle_harden() on every source of the product.

usage: check_binaries.py BUILD [--source ROOT] [--machine NAME] [--install]
  BUILD is a folder of CMake; --machine: what it compiles for (default: this machine); --install also checks what it installs
"""
import argparse
import json
import os
import platform
import re
import struct
import subprocess
import sys
import tempfile
from pathlib import Path
from typing import NamedTuple

ET_EXEC, ET_DYN = 2, 3
PT_LOAD, PT_DYNAMIC, PT_INTERP, PT_GNU_STACK, PT_GNU_RELRO = 1, 2, 3, 0x6474E551, 0x6474E552
DT_STRTAB, DT_RPATH, DT_BIND_NOW, DT_RUNPATH, DT_FLAGS, DT_FLAGS_1 = 5, 15, 24, 29, 30, 0x6FFFFFFB
DF_BIND_NOW, DF_1_NOW, DF_1_PIE, PF_X = 0x8, 0x1, 0x08000000, 0x1

EM_AARCH64, LARGE_PAGE = 183, 0x4000

PRODUCT = ("interfaces", "qos_profiles", "components", "containers", "launch")
EXEMPT = ("test/peers", "CMakeFiles")  # programs of other projects, as they are; CMake's own trials
FLAGS = ("-fstack-protector-strong", "-fstack-clash-protection", "-D_FORTIFY_SOURCE=3")


class Elf(NamedTuple):
    kind: int
    segments: dict  # type -> flags of the first one
    dynamic: dict  # tag -> list of values
    paths: list  # RUNPATH and RPATH as text
    machine: int
    page: int  # the largest page of which each segment that is loaded begins anew


def read_elf(data: bytes):
    """An Elf, or None for bytes that are no program or shared library of this machine's kind (64 bit, little-endian)."""
    if len(data) < 64 or data[:6] != b"\x7fELF\x02\x01":
        return None
    kind, machine = struct.unpack_from("<HH", data, 16)
    if kind not in (ET_EXEC, ET_DYN):
        return None
    table, size, count = struct.unpack_from("<Q", data, 32)[0], *struct.unpack_from("<HH", data, 54)
    segments, loads, dynamic, pages = {}, [], {}, []
    for i in range(count):
        what, flags, offset, address, _, length, _, alignment = struct.unpack_from("<IIQQQQQQ", data, table + i * size)
        segments.setdefault(what, flags)
        if what == PT_LOAD:
            loads.append((address, offset, length))
            pages.append(alignment)
        if what == PT_DYNAMIC:
            for at in range(offset, offset + length, 16):
                tag, value = struct.unpack_from("<qQ", data, at)
                if tag == 0:
                    break
                dynamic.setdefault(tag, []).append(value)
    paths = []
    for tag in (DT_RPATH, DT_RUNPATH):
        for value in dynamic.get(tag, []):
            address = dynamic[DT_STRTAB][0] + value
            begin = next(address - a + o for a, o, length in loads if a <= address < a + length)
            paths.append(data[begin : data.index(b"\0", begin)].decode())
    return Elf(kind, segments, dynamic, paths, machine, min(pages, default=LARGE_PAGE))


def complaints_about(elf: Elf):
    for path in elf.paths:
        if "" in path.split(":"):
            yield f"RUNPATH '{path}' has an empty element, which is the current directory"
    if PT_GNU_RELRO not in elf.segments:
        yield "no RELRO (-z relro)"
    flags, flags_1 = (elf.dynamic.get(tag, [0])[0] for tag in (DT_FLAGS, DT_FLAGS_1))
    if elf.dynamic and not (flags & DF_BIND_NOW or flags_1 & DF_1_NOW or DT_BIND_NOW in elf.dynamic):
        yield "symbols are bound lazily, so that RELRO is not full (-z now)"
    if PT_GNU_STACK not in elf.segments or elf.segments[PT_GNU_STACK] & PF_X:
        yield "its stack is executable (-z noexecstack)"
    if elf.kind == ET_EXEC:
        yield "not position-independent (-pie)"
    if elf.kind == ET_DYN and PT_INTERP in elf.segments and not flags_1 & DF_1_PIE:
        yield "a program that is not linked with -pie"
    if elf.machine == EM_AARCH64 and elf.page < LARGE_PAGE:
        yield f"its segments are aligned to {elf.page} bytes: a kernel with pages of 16 KiB cannot load it (-z max-page-size=65536)"


def files_below(folder: Path):
    """Every file, but for those of another build within (the sanitizers' are in build/address and build/thread)."""
    for place, folders, names in os.walk(folder):
        folders[:] = sorted(name for name in folders if not (Path(place) / name / "CMakeCache.txt").exists())
        yield from (Path(place) / name for name in sorted(names))


def check_files(folder: Path):
    """(number of ELF files, complaints)"""
    count, found = 0, []
    for path in files_below(folder):
        name = str(path.relative_to(folder))
        if path.is_symlink() or not path.is_file() or any(part in name for part in EXEMPT):
            continue
        with path.open("rb") as file:
            if file.read(4) != b"\x7fELF":
                continue
        elf = read_elf(path.read_bytes())
        if elf is None:
            continue  # an object file
        count += 1
        found += [f"{name}: {complaint}" for complaint in complaints_about(elf)]
    return count, found


def is_product(file: str, source: Path, build: Path) -> bool:
    for root in (build, source):
        inside = os.path.relpath(file, root)
        if not inside.startswith(".."):
            return inside.split(os.sep)[0] in PRODUCT
    return False


def check_flags(commands: list, source: Path, build: Path, machine: str, optimised: bool = True):
    """(number of sources, complaints)"""
    wanted = [flag for flag in FLAGS if optimised or "FORTIFY" not in flag]
    if machine in ("aarch64", "arm64"):
        wanted.append("-mbranch-protection=standard")
    count, found = 0, []
    for entry in commands:
        file = os.path.normpath(os.path.join(entry["directory"], entry["file"]))
        if not is_product(file, source, build):
            continue
        count += 1
        words = entry["command"].split()
        missing = [flag for flag in wanted if flag not in words]
        fortified = [word for word in words if re.match(r"-[UD]_FORTIFY_SOURCE", word)]
        if not missing and optimised and not fortified[-1].startswith("-D"):
            missing = ["-D_FORTIFY_SOURCE as the last word about it"]
        if missing:
            found.append(f"{os.path.relpath(file, source)}: compiled without {' '.join(missing)}")
    return count, found


def check_installed(build: Path, strip: bool):
    with tempfile.TemporaryDirectory() as folder:
        command = ["cmake", "--install", str(build), "--prefix", folder, *(["--strip"] if strip else [])]
        done = subprocess.run(command, capture_output=True, text=True, check=False)
        if done.returncode != 0:
            return 0, [f"{' '.join(command)}: {(done.stderr or done.stdout)[-500:]}"]
        return check_files(Path(folder))


def main() -> int:
    parser = argparse.ArgumentParser()
    parser.add_argument("build", type=Path)
    parser.add_argument("--source", type=Path, default=Path(__file__).parents[2])
    parser.add_argument("--machine", default=platform.machine())
    parser.add_argument("--install", action="store_true")
    wish = parser.parse_args()
    build, source = wish.build.resolve(), wish.source.resolve()
    cache = (build / "CMakeCache.txt").read_text(encoding="utf-8")
    optimised = not re.search(r"^CMAKE_BUILD_TYPE:\w+=Debug$", cache, re.MULTILINE)
    commands = json.loads((build / "compile_commands.json").read_text(encoding="utf-8"))
    checks = {
        "ELF files of the build": check_files(build),
        "sources compiled": check_flags(commands, source, build, wish.machine, optimised),
    }
    if wish.install:
        checks["ELF files installed"] = check_installed(build, strip=False)
        checks["ELF files installed and stripped"] = check_installed(build, strip=True)
    failed = False
    for what, (count, found) in checks.items():
        for complaint in found:
            print(f"{what}: {complaint}")
        print(f"{count} {what}, {len(found)} complaints")
        failed = failed or bool(found) or count == 0  # a check of nothing proves nothing
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
