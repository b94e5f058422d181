#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""Fails on an #include that goes up or sideways. The floors are the table in docs/floors.md; the rules beyond it are below.

usage: check_floors.py [ROOT]
"""
import re
import sys
from pathlib import Path
from typing import NamedTuple, Optional

SOURCES = {".cpp", ".hpp", ".h", ".cc", ".hpp.in", ".cpp.in"}
TREES = ("interfaces", "qos_profiles", "components", "containers", "launch", "test")
INCLUDE = re.compile(r'^\s*#\s*include\s*(?:"(?P<own>[^"]+)"|<(?P<angle>[^>]+)>)', re.MULTILINE)
MESSAGE = re.compile(r"^(?:[a-z][a-z0-9_]*/(?:msg|srv|action)/|nacelle/msgs/)")
PURE_ROLES = ("protocol", "model", "wire")
ROLES = (*PURE_ROLES, "port", "component")
IO_HEADER = re.compile(r"^(?:sys/|linux/|(?:fcntl|unistd|termios|pty|poll)\.h$|(?:fstream|iostream|thread)$)")
STRANGERS = (1, 2)  # floors whose folders do not know each other
ROOMS = ("containers", "nacelle")  # the package whose folders have storeys


class Place(NamedTuple):
    """Where a file stands: its folder of the table, the floor of that, and its role inside it."""

    folder: str
    floor: int
    role: Optional[str]

    @property
    def tree(self) -> str:
        return self.folder.split("/")[0]

    @property
    def pure(self) -> bool:
        return self.role in PURE_ROLES


def read_floors(text: str) -> dict:
    """The table of docs/floors.md: folder -> floor."""
    rows = re.findall(r"^\|\s*(\d+)\s*\|\s*`([^`]+)`\s*\|", text, re.MULTILINE)
    if not rows:
        raise SystemExit("docs/floors.md: no table of floors found")
    return {folder: int(floor) for floor, folder in rows}


def read_storeys(text: str) -> dict:
    """The table of rooms in docs/floors.md: room of containers/nacelle -> storey."""
    rows = re.findall(r"^\s*\|\s*S(\d+)\s*\|\s*`([^`]+)`\s*\|", text, re.MULTILINE)
    return {room: int(storey) for storey, room in rows}


class Floors:
    def __init__(self, root: Path):
        self.root = root
        table = (root / "docs/floors.md").read_text(encoding="utf-8")
        self.floor_of = read_floors(table)
        self.storey_of = read_storeys(table)
        self.files = sorted(
            path
            for tree in TREES
            for path in (root / tree).rglob("*")
            if path.suffix in SOURCES and path.is_file()
        )
        self.by_include = {}  # how a header is spelled in an #include -> where it is
        for path in self.files:
            for spelling in self._spellings(path.relative_to(root)):
                self.by_include.setdefault(spelling, path)

    @staticmethod
    def _spellings(path: Path):
        parts = path.parts
        if "include" in parts:
            yield "/".join(parts[parts.index("include") + 1 :])
        yield "/".join(parts)
        if parts[0] in ("components", "containers"):
            yield "/".join(parts[1:])
        if parts[:2] == ROOMS:
            yield "/".join(parts[2:])
        if parts[0] == "test":
            yield "/".join(parts[1:])

    def place(self, path: Path) -> Optional[Place]:
        parts = path.relative_to(self.root).parts
        for folder in ("/".join(parts[:2]), parts[0]):
            if folder in self.floor_of:
                break
        else:
            folder = "/".join(parts[:2])
            if f"{parts[0]}/*" not in self.floor_of:
                return None
        floor = self.floor_of.get(folder, self.floor_of.get(f"{parts[0]}/*"))
        inside = parts[folder.count("/") + 1 : -1]
        role = inside[0] if inside and inside[0] in ROLES and parts[0] in ("components", "containers") else None
        return Place(folder, floor, role)

    def target(self, source: Path, spelling: str) -> Optional[Path]:
        beside = (source.parent / spelling).resolve()
        if beside.is_file() and self.root in beside.parents:
            return beside
        return self.by_include.get(spelling)

    def mixed_targets(self):
        """One sentence for each library of the package with rooms whose sources stand in several of them."""
        lists = self.root.joinpath(*ROOMS, "CMakeLists.txt")
        for name, sources in re.findall(r"library\((\w+)\s+SOURCES([^)]*?)(?:USES|\))", lists.read_text(encoding="utf-8")):
            rooms = {source.split("/")[0] for source in sources.split()}
            if len(rooms) > 1:
                yield f"{'/'.join(ROOMS)}/CMakeLists.txt: {name} has files of {', '.join(sorted(rooms))}: a target compiles one room's"

    def _is_ours(self, spelling: str) -> bool:
        parts = spelling.split("/")
        if len(parts) > 2 and parts[1] in ROLES:
            return any((self.root / tree / parts[0]).is_dir() for tree in ("components", "containers"))
        return parts[0] == "nacelle" or parts[0] in self.storey_of

    def complaints(self):
        """One sentence for each include that breaks a rule."""
        for path in self.files:
            source = self.place(path)
            where = path.relative_to(self.root)
            if source is None:
                yield f"{where}: its folder has no floor in docs/floors.md"
                continue
            text = path.read_text(encoding="utf-8")
            for match in INCLUDE.finditer(text):
                line = text.count("\n", 0, match.start("own") if match["own"] else match.start("angle")) + 1
                spelling = match["own"] or match["angle"]
                problem = self._judge(path, source, spelling)
                if problem:
                    yield f"{where}:{line}: includes {spelling}: {problem}"

    def _judge(self, path: Path, source: Place, spelling: str) -> Optional[str]:
        if source.pure and IO_HEADER.match(spelling):
            return f"{source.role}/ is pure: no I/O and no threads; bytes and time are arguments"
        target_path = self.target(path, spelling)
        if target_path is None and MESSAGE.match(spelling):
            # Generated, so not in the tree.
            target = Place("interfaces/msgs", self.floor_of["interfaces/msgs"], None)
        elif target_path is None:
            return "no such header in the tree: the arrow cannot be checked" if self._is_ours(spelling) else None
        else:
            target = self.place(target_path)
            if target is None:
                return "its folder has no floor in docs/floors.md"
            if problem := self._judge_rooms(path, target_path):
                return problem
        return judge(source, target)

    def _room(self, path: Path) -> Optional[str]:
        inside = path.relative_to(self.root).parts
        return inside[2] if inside[:2] == ROOMS and len(inside) > 3 else None

    def _judge_rooms(self, path: Path, target: Path) -> Optional[str]:
        room, other = self._room(path), self._room(target)
        if room is None or other is None or room == other:
            return None
        for name in (room, other):
            if name not in self.storey_of:
                return f"the room {name}/ has no storey in docs/floors.md"
        if self.storey_of[other] < self.storey_of[room]:
            return None
        return f"a room includes lower storeys only: {room}/ is S{self.storey_of[room]}, {other}/ is S{self.storey_of[other]}"


def judge(source: Place, target: Place) -> Optional[str]:
    """Why an include from source to target is not allowed; None when it is."""
    if source.tree == "test":
        return None
    if source.folder == target.folder:
        return judge_roles(source, target)
    if target.floor > source.floor:
        return f"goes up, from {source.folder} (floor {source.floor}) to {target.folder} (floor {target.floor})"
    if source.folder == "launch" and target.floor > 1:
        return f"launch/ includes floors 0 and 1 only, and {target.folder} is floor {target.floor}"
    if target.floor == source.floor and (source.floor in STRANGERS or source.tree != target.tree):
        return f"goes sideways, from {source.folder} to {target.folder} (both floor {source.floor})"
    if source.tree == target.tree == "components" and source.floor == target.floor and not target.pure:
        return f"of another component only protocol/ and model/ may be included, not {target.role or 'this'}"
    if source.tree == "components" and target.folder == "interfaces/host":
        return "a component sees interfaces/node, which stands on interfaces/host"
    if source.pure and target.folder in ("interfaces/node", "components/io"):
        return f"{source.role}/ is pure: it knows neither topics nor byte streams"
    return None


def judge_roles(source: Place, target: Place) -> Optional[str]:
    if source.pure and target.role in ("port", "component"):
        return f"{source.role}/ and {target.role}/ do not see each other"
    if source.role == "port" and target.role in ("protocol", "component"):
        return f"port/ moves bytes and does not see {target.role}/"
    return None


def main() -> int:
    root = Path(sys.argv[1] if len(sys.argv) > 1 else Path(__file__).parents[2]).resolve()
    floors = Floors(root)
    complaints = [*floors.complaints(), *floors.mixed_targets()]
    for complaint in complaints:
        print(complaint)
    print(f"{len(floors.files)} files read, {len(complaints)} arrows that may not be")
    if not floors.files:
        print("no source found: a check of nothing proves nothing")
        return 1
    return 1 if complaints else 0


if __name__ == "__main__":
    sys.exit(main())
