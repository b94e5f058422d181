# SPDX-License-Identifier: Apache-2.0
"""What a program and its children change on file systems that are not in RAM, as strace sees it."""
import os
import pathlib
import re

RAM = {"tmpfs", "ramfs", "devtmpfs", "devpts", "proc", "sysfs", "cgroup", "cgroup2", "mqueue", "hugetlbfs", "debugfs", "tracefs", "securityfs", "bpf"}
OPENS = ("open", "openat", "openat2", "creat")
# A file is written through a descriptor that was opened for it, so write() itself need not be traced: with a filter in the kernel, these
# calls alone stop the robot's threads. Each of them changes a file or a folder.
CHANGES = ("mkdir", "mkdirat", "mknod", "mknodat", "symlink", "symlinkat", "link", "linkat", "unlink", "unlinkat", "rmdir", "rename", "renameat",
           "renameat2", "truncate", "chmod", "fchmod", "fchmodat", "chown", "lchown", "fchown", "fchownat", "utime", "utimes", "futimesat",
           "utimensat", "setxattr", "lsetxattr", "fsetxattr", "bind")
# "?": not every architecture has the call.
STRACE = ("strace", "-ff", "-qq", "-y", "--seccomp-bpf", "-e", "signal=none", "-e", "trace=" + ",".join("?" + name for name in (*OPENS, *CHANGES)))

CALL = re.compile(r"(?P<name>\w+)\((?P<words>.*)\)\s+= (?P<value>\d+)(?:<(?P<at>.*)>)?$")
TEXT = re.compile(r'(?:(?:AT_FDCWD|\d+)<(?P<folder>[^>]*)>, )?"(?P<text>(?:[^"\\]|\\.)*)"')
SOCKET = re.compile(r'sun_path="(?P<text>(?:[^"\\]|\\.)*)"')
DESCRIPTOR = re.compile(r"\d+<(?P<at>/[^>]*)>")


class FileSystems:
    """The type of the file system at a path, from /proc/self/mountinfo."""

    def __init__(self, mounts=None):
        self.types = {}
        for line in (mounts or pathlib.Path("/proc/self/mountinfo").read_text(encoding="utf-8")).splitlines():
            before, behind = line.split(" - ")
            point = re.sub(r"\\(\d{3})", lambda octal: chr(int(octal[1], 8)), before.split()[4])
            self.types[point] = behind.split()[0]  # a later mount hides an earlier one

    def type_of(self, path):
        while path not in self.types and path != "/":
            path = os.path.dirname(path)
        return self.types.get(path, "unknown")

    def are_in_ram(self, path):
        return path.startswith("/memfd:") or self.type_of(path) in RAM


def changed_by(line):
    """The paths that a line of strace -y changed; a relative path where the folder is not known. A call that failed changed nothing."""
    call = CALL.match(line.strip())
    if call is None:
        return []
    name, words = call["name"], call["words"]
    if name in OPENS:
        opened_to_write = name == "creat" or re.search(r"\bO_(WRONLY|RDWR|CREAT|TRUNC)\b", words)
        return [call["at"].removesuffix(" (deleted)")] if opened_to_write and (call["at"] or "").startswith("/") else []
    if name == "bind":
        return [found["text"] for found in SOCKET.finditer(words)]
    paths = [os.path.join(found["folder"] or "", found["text"]) for found in TEXT.finditer(words)]
    if name.startswith("symlink"):
        return paths[-1:]  # the first is what it says
    if name.endswith("xattr"):
        paths = paths[:1] if not name.startswith("f") else []
    through = DESCRIPTOR.match(words)
    return paths or ([through["at"]] if through else [])


def on_disk(traces, folder, systems=None):
    """The lines of all traces of a run, begun in `folder`, that changed something outside RAM."""
    systems = systems or FileSystems()
    found, calls = [], 0
    for trace in traces:
        for line in pathlib.Path(trace).read_text(encoding="utf-8", errors="replace").splitlines():
            for path in changed_by(line):
                calls += 1
                at = os.path.realpath(os.path.join(folder, os.path.dirname(path)))
                if not systems.are_in_ram(os.path.join(at, os.path.basename(path))):
                    found.append(line)
    return found, calls
