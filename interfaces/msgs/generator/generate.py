# SPDX-License-Identifier: Apache-2.0
"""Makes C++ of a package's interface definitions.

  generate.py list     --package NAME=DIRECTORY ...                  what would be made: four lines each, CMake lists
  generate.py generate --package NAME=DIRECTORY --depends N=DIR ... --output DIRECTORY

A package's DIRECTORY holds msg/, srv/ and action/. Run it as `/usr/bin/python3 -I`: other Pythons do not see Debian's
python3-rosidl.
"""
import argparse
import pathlib
import sys

sys.dont_write_bytecode = True  # The generator's folder may be read-only, and belongs to no build.
sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent))  # -I leaves the script's folder out.

# One translation unit holds about this many message types: compilers run side by side, headers are read once.
TYPES_PER_SOURCE = 70
_TYPES_PER_FILE = {'msg': 1, 'srv': 3, 'action': 10}


def chunks(files):
    """Splits (kind, ...) entries into the contents of the translation units."""
    parts, weight = [[]], 0
    for entry in files:
        size = _TYPES_PER_FILE[entry[0]]
        if parts[-1] and weight + size > TYPES_PER_SOURCE:
            parts.append([])
            weight = 0
        parts[-1].append(entry)
        weight += size
    return parts


def source_names(package, count):
    return [f'src/{package}_{index}.cpp' for index in range(count)]


def write_if_changed(path, text):
    data = text.encode('utf-8')
    if path.is_file() and path.read_bytes() == data:
        return
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_bytes(data)


def list_outputs(package, directory):
    """Headers, sources, definition files, packages used."""
    from cpp_names import header_path
    from definitions import find, used_packages
    files = find(directory)
    print(';'.join('include/' + header_path(package, kind, stem) for kind, stem, _ in files))
    print(';'.join(source_names(package, len(chunks(files)))))
    print(';'.join(str(path) for _, _, path in files))
    print(';'.join(sorted(used_packages(directory))))


def generate(package, directories, output):
    from cpp_names import header_path
    from definitions import Library
    from emit_header import header
    from emit_source import SourceEmitter
    library = Library(directories)
    definitions = library.package(package)
    emitter = SourceEmitter(library)
    for one in definitions:
        write_if_changed(output / 'include' / header_path(package, one.kind, one.stem), header(one))
    parts = chunks([(one.kind, one) for one in definitions])
    for index, (name, part) in enumerate(zip(source_names(package, len(parts)), parts)):
        # The first unit carries the library's entry, which lists the types of all of them.
        text = emitter.source(package, [one for _, one in part], definitions if index == 0 else ())
        write_if_changed(output / name, text)


def _named_directory(text):
    name, _, directory = text.partition('=')
    return name, pathlib.Path(directory).resolve()


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument('action', choices=('list', 'generate'))
    parser.add_argument('--package', type=_named_directory, nargs='+', required=True)
    parser.add_argument('--depends', type=_named_directory, nargs='*', default=[])
    parser.add_argument('--output', type=pathlib.Path)
    arguments = parser.parse_args()

    from model import DefinitionError
    try:
        if arguments.action == 'list':
            for package, directory in arguments.package:
                list_outputs(package, directory)
        else:
            (package, directory), = arguments.package
            generate(package, {**dict(arguments.depends), package: directory}, arguments.output)
    except DefinitionError as error:
        sys.exit(str(error))


if __name__ == '__main__':
    main()
