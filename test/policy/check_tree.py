#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""Fails where the tree breaks a promise that a reviewer would otherwise have to look for. Each rule is one function.

usage: check_tree.py [ROOT]
"""
import re
import subprocess
import sys
import xml.etree.ElementTree as xml
from pathlib import Path

TOP = {
    "components", "containers", "interfaces", "qos_profiles", "launch", "test", "docs", "debian", ".ci", "dev", "CMakeLists.txt",
    "colcon.meta", "colcon_defaults.yaml", "README.md", "CONTRIBUTING.md", "CHANGELOG.md", "LICENSE", ".gitignore",
    ".gitattributes", ".clang-format", ".clang-tidy", ".editorconfig",
}  # fmt: skip
PACKAGE_TREES = ("interfaces", "components", "containers")
SPDX = "SPDX-License-Identifier: Apache-2.0"
SPDX_ENDINGS = (".cpp", ".hpp", ".h", ".cc", ".py", ".sh", ".cmake", ".em", ".hpp.in", ".cpp.in")
# rosdep's keys may stand in a package.xml; Debian calls them so.
ROSDEP_KEYS = {
    "eigen": "libeigen3-dev", "fmt": "libfmt-dev", "spdlog": "libspdlog-dev", "nlohmann-json-dev": "nlohmann-json3-dev",
    "yaml-cpp": "libyaml-cpp-dev", "tinyxml2": "libtinyxml2-dev", "cli11": "libcli11-dev", "libjpeg": "libjpeg-dev",
    "gtest": "libgtest-dev", "google-mock": "libgmock-dev", "geographiclib": "libgeographiclib-dev",
}  # fmt: skip
TEXT_LIMIT = 1_000_000  # bytes; larger files are data

# Written so that this file does not contain what it forbids.
PRIVATE_PATHS = re.compile(r"(?<![\w.$}])/(?:" + "root|work|home/(?!user|pi|robot|you)[a-z]" + r")(?:/|\b)|/tmp/w/")
REGISTRY_HOSTS = re.compile(
    r"\b(?:" + "|".join(("deb", "ftp", "security", "archive", "mirror", "snapshot")) + r")\.(?:[a-z]+\.)?(?:debian|ubuntu|raspberrypi)\.(?:org|com)\b"
    r"|\b(?:registry\.(?:npmjs|yarnpkg)\.\w+|(?:files\.python" + r"hosted|py" + r"pi)\.org|(?:static\.)?crates\.io|proxy\.golang\.org)\b"
)
# What turns a text from outside into a value, or opens a file by a path from outside -> where alone that is done, with a bound.
ONE_PLACE = (
    ("JSON", re.compile(r"[jJ]son::(?:parse|accept|sax_parse)\("), ("interfaces/base/src/json_text.cpp",), "parse_json()"),
    ("XML", re.compile(r"(?:\.|->)(?:Parse|LoadFile)\("), ("interfaces/base/src/xml.cpp",), "parse_xml()"),
    ("YAML", re.compile(r"YAML::(?:Parser|Load\w*)\b"), ("qos_profiles/src/yaml_tree.cpp",), "parse_yaml()"),
    (
        "a file",
        re.compile(r"std::ifstream\b"),
        # Files of /proc and /sys, whose names are constants.
        (
            "containers/nacelle/doctor/machine.cpp",
            "containers/nacelle/networking/network_wish.cpp",
            "containers/nacelle/process/process_figures.cpp",
            "containers/transport_iceoryx/src/daemon_process.cpp",
        ),
        "read_regular_file()",
    ),
)
# Locks of the product are annotated ones: clang checks what they guard.
RAW_LOCK = re.compile(
    r"\bstd::(?:(?:recursive_|shared_|timed_|recursive_timed_|shared_timed_)?mutex|lock_guard|unique_lock|scoped_lock|shared_lock)\b"
    r"|\bpthread_mutex_\w+"
)
LOCK = re.compile(r"^\s*(?:mutable |static |inline |const )*(?:runtime::)?(?:Mutex|FutexMutex) (\w+);", re.MULTILINE)
# A lock that guards no variable that it could be named at -> what it is for.
LOCKS_OF_NO_VARIABLE = {
    ("components/estop/component/emergency_stop_component.hpp", "mutex_"): "button_ is written under it by the one thread that reads it without",
    ("components/transforms/model/robot_tree.cpp", "lock"): "guards console_bridge's output handler, which is the library's",
    ("containers/nacelle/isolation/isolated_component.hpp", "calling_"): "keeps calls one after another",
    ("containers/runtime/src/container_impl.hpp", "one_at_a_time"): "keeps transitions and unloading of a component one after another",
    ("containers/runtime/src/node_runtime.cpp", "noting_"): "keeps callbacks of a reentrant group apart in a histogram that is another class's",
    ("containers/transport_local/src/link_impl.hpp", "relaying"): "keeps the uses of a stand-in one after another",
    ("interfaces/node/include/nacelle/node/parameter.hpp", "mutex_"): "entries_ is changed under it by the one thread that reads it without",
}
ASSERTION = re.compile(r"\b(?:EXPECT_|ASSERT_|FAIL\(|ADD_FAILURE|TYPED_TEST|static_assert|self\.assert|assert |BENCHMARK\(|LLVMFuzzerTestOneInput|expect )")


class Tree:
    def __init__(self, root: Path):
        self.root = root
        self.files = self._listed()

    def _listed(self):
        """What git would commit; without git, everything but build folders."""
        listing = subprocess.run(
            ["git", "-c", "safe.directory=*", "-C", str(self.root), "ls-files", "-z", "--cached", "--others", "--exclude-standard"],
            capture_output=True, check=False,
        ) if (self.root / ".git").exists() else None  # fmt: skip
        if listing is not None and listing.returncode == 0:
            names = [name for name in listing.stdout.decode().split("\0") if name]
        else:
            names = [
                str(path.relative_to(self.root))
                for path in self.root.rglob("*")
                if path.is_file() and path.relative_to(self.root).parts[0] not in (".git", "build", "install", "log")
            ]
        return sorted({name for name in names if (self.root / name).is_file()})

    def text(self, name: str) -> str:
        path = self.root / name
        if not path.is_file() or path.stat().st_size > TEXT_LIMIT:
            return ""
        data = path.read_bytes()
        return "" if b"\0" in data else data.decode("utf-8", errors="replace")

    def packages(self):
        """Folder -> the root element of its package.xml (None where it is missing)."""
        folders = {"/".join(name.split("/")[:2]) for name in self.files if name.startswith(tuple(f"{t}/" for t in PACKAGE_TREES))}
        folders = {folder for folder in folders if (self.root / folder).is_dir()}
        folders |= {name for name in ("qos_profiles", "launch", "test") if (self.root / name / "CMakeLists.txt").is_file()}
        for folder in sorted(folders):
            file = self.root / folder / "package.xml"
            yield folder, xml.parse(file).getroot() if file.is_file() else None


def top_level_holds_only_what_is_allowed(tree: Tree):
    for name in sorted({file.split("/")[0] for file in tree.files} - TOP):
        yield f"{name}: not one of the allowed entries of the top level"


def every_source_names_its_licence(tree: Tree):
    for name in tree.files:
        is_source = name.endswith(SPDX_ENDINGS) or name.endswith("CMakeLists.txt") or name == "dev" or name.startswith("dev/")
        if not is_source and name.startswith(".ci/") and tree.text(name).startswith("#!"):
            is_source = True
        if is_source and not any(line.endswith(SPDX) for line in tree.text(name).splitlines()[:3]):
            yield f"{name}: none of its first lines ends with '{SPDX}'"


def nothing_names_a_private_place(tree: Tree):
    for name in tree.files:
        if name.startswith("test/policy/") or name == "LICENSE":
            continue
        for number, line in enumerate(tree.text(name).splitlines(), 1):
            for what, pattern in (("a path of a private machine", PRIVATE_PATHS), ("the host of a package registry", REGISTRY_HOSTS)):
                found = pattern.search(line)
                if found:
                    yield f"{name}:{number}: names {what}: {found.group(0)}"


def changelog_has_a_place_for_the_next_change(tree: Tree):
    if not re.search(r"^## \[?Unreleased\]?\s*$", tree.text("CHANGELOG.md"), re.MULTILINE):
        yield "CHANGELOG.md: no heading '## Unreleased'"


def every_package_says_the_same_to_cmake_and_to_colcon(tree: Tree):
    for folder, manifest in tree.packages():
        cmake = tree.text(f"{folder}/CMakeLists.txt") if (tree.root / folder / "CMakeLists.txt").is_file() else ""
        if not cmake:
            yield f"{folder}: no CMakeLists.txt"
            continue
        if manifest is None:
            yield f"{folder}: no package.xml"
            continue
        project = re.search(r"^project\(\s*(\S+)", cmake, re.MULTILINE)
        name = manifest.findtext("name")
        if not project or project.group(1) != name:
            yield f"{folder}: package.xml says '{name}', project() says '{project.group(1) if project else None}'"
        if manifest.findtext("license") != "Apache-2.0":
            yield f"{folder}/package.xml: licence is not Apache-2.0"
        if manifest.findtext("export/build_type") != "cmake":
            yield f"{folder}/package.xml: build_type is not cmake"
        words = re.search(r"nacelle_package\(([^)]*)\)", cmake)
        used = set(re.findall(r"\bnacelle_\w+", words.group(1).split("EXTERNAL")[0])) if words else set()
        declared = {
            entry.text for tag in ("depend", "build_depend", "exec_depend", "test_depend") for entry in manifest.iter(tag)
        }
        for missing in sorted(used - declared - {name}):
            yield f"{folder}/package.xml: no <depend>{missing}</depend>, though nacelle_package() lists it"
        for unused in sorted(name for name in declared - used if name.startswith("nacelle_")):
            yield f"{folder}/CMakeLists.txt: package.xml depends on {unused}, nacelle_package() does not list it"


def every_debian_package_is_in_the_one_list(tree: Tree):
    listed = {}
    for line in tree.text(".ci/packages.txt").splitlines():
        if ":" in line and not line.startswith("#"):
            word, names = line.split(":", 1)
            listed[word] = {name.partition("@")[0] for name in names.split()}  # name@13: in that release only
    everywhere = set().union(*listed.values()) if listed else set()
    for folder, manifest in tree.packages():
        if manifest is None:
            continue
        names = {entry.text for entry in manifest if entry.tag.endswith("depend") and not entry.text.startswith("nacelle_")}
        names = {ROSDEP_KEYS.get(name, name) for name in names}
        for name in sorted(names - everywhere):
            yield f"{folder}/package.xml: {name} is not in .ci/packages.txt"
        if folder != "test":
            for name in sorted(listed.get(folder, set()) - names):
                yield f".ci/packages.txt: '{folder}' lists {name}, its package.xml does not"
    for word in listed:
        if "/" in word and not (tree.root / word).is_dir():
            yield f".ci/packages.txt: there is no folder '{word}'"


def debian_control_asks_for_what_the_list_names(tree: Tree):
    control = tree.text("debian/control")
    if not control:
        return
    listed = set()
    for line in tree.text(".ci/packages.txt").splitlines():
        word, _, names = line.partition(":")
        if word == "build" or (word != "test" and (tree.root / word).is_dir()):
            listed |= {name.partition("@")[0] for name in names.split()}
    listed.discard("g++")  # build-essential, which every build of a package has
    fields = {name: set(re.findall(r"^ (?!debhelper-compat)([a-z0-9.+-]+)", text, re.MULTILINE))
              for name, text in re.findall(r"^(Build-Depends|Depends):((?:\n .*)+)", control, re.MULTILINE)}  # fmt: skip
    for name in sorted(listed - fields.get("Build-Depends", set())):
        yield f"debian/control: no {name} in Build-Depends, which .ci/packages.txt lists for a build"
    for name in sorted(fields.get("Build-Depends", set()) - listed):
        yield f"debian/control: {name} in Build-Depends is on no line of .ci/packages.txt that a build reads"


def every_folder_of_tests_can_fail(tree: Tree):
    for name in tree.files:
        if not (name.startswith("test/") and name.endswith("/CMakeLists.txt")) or name.startswith("test/data/"):
            continue
        folder = name.rsplit("/", 1)[0]
        cmake = tree.text(name)
        if not re.search(r"nacelle_test\(|nacelle_fuzz_target\(|nacelle_benchmark\(|add_test\(", cmake):
            continue  # a library of helpers for tests
        bodies = [tree.text(file) for file in tree.files if file.startswith(f"{folder}/") and not file.endswith("CMakeLists.txt")]
        if not any(ASSERTION.search(body) for body in bodies):
            yield f"{folder}: tests without an assertion"
    for name in tree.files:
        if name.startswith("test/") and name.endswith("_test.cpp"):
            if not ASSERTION.search(tree.text(name)):
                yield f"{name}: no assertion in it"
            # The CMakeLists.txt beside it, or one above it that names it by a longer path.
            above = ["/".join(name.split("/")[:depth]) + "/CMakeLists.txt" for depth in range(2, name.count("/") + 1)]
            if not any(Path(name).name in tree.text(cmake) for cmake in above):
                yield f"{name}: no CMakeLists.txt builds it"


def every_link_leads_to_a_file(tree: Tree):
    for name in tree.files:
        if not name.endswith(".md") or name.startswith(("test/data/", "interfaces/msgs/definitions/")):
            continue
        for link in re.findall(r"\]\(([^)\s#]+)(?:#[^)]*)?\)", re.sub(r"```.*?```", "", tree.text(name), flags=re.DOTALL)):
            if "://" not in link and not (tree.root / name).parent.joinpath(link).exists():
                yield f"{name}: links to {link}, which is not there"


def what_comes_from_outside_enters_at_one_place(tree: Tree):
    for name in tree.files:
        if not name.endswith((".cpp", ".hpp")) or name.startswith("test/") or name == "interfaces/base/cmake/fuzz_replay.cpp":
            continue
        for number, line in enumerate(tree.text(name).splitlines(), 1):
            for what, pattern, places, word in ONE_PLACE:
                if pattern.search(line) and name not in places:
                    yield f"{name}:{number}: reads {what} without a bound of its depth or size; use {word}"


def every_lock_says_what_it_guards(tree: Tree):
    left = set(LOCKS_OF_NO_VARIABLE)
    for name in tree.files:
        if not name.endswith((".cpp", ".hpp")) or not name.startswith(PACKAGE_TREES) or name == "interfaces/base/include/nacelle/base/mutex.hpp":
            continue
        text = re.sub(r"//.*", "", tree.text(name))
        for number, line in enumerate(text.splitlines(), 1):
            found = RAW_LOCK.search(line)
            if found:
                yield f"{name}:{number}: {found.group(0)} is not checked; use Mutex, LockGuard, UniqueLock (nacelle/base/mutex.hpp) or Guarded"
        for lock in LOCK.findall(text):
            if (name, lock) in LOCKS_OF_NO_VARIABLE:
                left.discard((name, lock))
            elif not re.search(rf"NACELLE_GUARDED_BY\(\*?{lock}\)", text):
                yield f"{name}: no variable is NACELLE_GUARDED_BY({lock})"
    for name, lock in sorted(left):
        if name in tree.files:
            yield f"test/policy/check_tree.py: {name} has no lock {lock} any more"


def every_silenced_lint_has_a_reason(tree: Tree):
    argued = set(re.findall(r"^### (\S+)$", tree.text("docs/lint_suppressions.md"), re.MULTILINE))
    for check in re.findall(r"^\s+-([a-z][\w.-]*?),?$", tree.text(".clang-tidy"), re.MULTILINE):
        if check not in argued:
            yield f".clang-tidy: -{check} has no heading in docs/lint_suppressions.md"
    for name in tree.files:
        if not name.endswith((".cpp", ".hpp")):
            continue
        for number, line in enumerate(tree.text(name).splitlines(), 1):
            for silenced in re.findall(r"NOLINT(?:NEXTLINE|BEGIN|END)?(?:\(([^)]*)\))?", line):
                for check in [entry.strip() for entry in silenced.split(",")]:
                    if check not in argued:
                        yield f"{name}:{number}: NOLINT({check}) has no heading in docs/lint_suppressions.md"


RULES = (
    top_level_holds_only_what_is_allowed,
    every_source_names_its_licence,
    nothing_names_a_private_place,
    changelog_has_a_place_for_the_next_change,
    every_package_says_the_same_to_cmake_and_to_colcon,
    every_debian_package_is_in_the_one_list,
    debian_control_asks_for_what_the_list_names,
    every_folder_of_tests_can_fail,
    every_link_leads_to_a_file,
    what_comes_from_outside_enters_at_one_place,
    every_lock_says_what_it_guards,
    every_silenced_lint_has_a_reason,
)


def main() -> int:
    root = Path(sys.argv[1] if len(sys.argv) > 1 else Path(__file__).parents[2]).resolve()
    tree = Tree(root)
    broken = 0
    for rule in RULES:
        for complaint in rule(tree):
            print(complaint)
            broken += 1
    print(f"{len(tree.files)} files, {len(RULES)} rules, {broken} broken promises")
    if not tree.files:
        print("no file found: a check of nothing proves nothing")
        return 1
    return 1 if broken else 0


if __name__ == "__main__":
    sys.exit(main())
