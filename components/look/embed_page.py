#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""Writes the files of a folder as a C++ source with page_files(): embed_page.py FOLDER OUT"""
import pathlib
import sys

MEDIA_TYPES = {".html": "text/html; charset=utf-8", ".js": "text/javascript; charset=utf-8", ".css": "text/css; charset=utf-8",
               ".svg": "image/svg+xml", ".png": "image/png"}


def main() -> None:
    folder, out = pathlib.Path(sys.argv[1]), pathlib.Path(sys.argv[2])
    arrays, rows = [], []
    for number, file in enumerate(sorted(one for one in folder.rglob("*") if one.is_file())):
        if file.suffix not in MEDIA_TYPES:
            sys.exit(f"{file}: no media type is known for {file.suffix or 'a file without a suffix'}: add it to embed_page.py")
        body = file.read_bytes()
        arrays.append(f"constexpr std::uint8_t kFile{number}[] = {{{','.join(map(str, body))}}};")
        path = "/" + file.relative_to(folder).as_posix()
        rows.append(f'      {{"{path}", {{"{MEDIA_TYPES[file.suffix]}", {{std::begin(kFile{number}), std::end(kFile{number})}}}}}},')
        if path == "/index.html":
            rows.append(rows[-1].replace('"/index.html"', '"/"', 1))
    text = "\n".join(["// Made by embed_page.py: do not edit.", '#include "look/component/page_files.hpp"', "", "#include <cstdint>", "#include <iterator>",
                      "", "namespace nacelle::look {", "namespace {", *arrays, "}  // namespace", "",
                      "std::map<std::string, WebServer::File, std::less<>> page_files() {", "  return {", *rows, "  };", "}", "",
                      "}  // namespace nacelle::look", ""])
    if not out.exists() or out.read_text() != text:
        out.write_text(text)


if __name__ == "__main__":
    main()
