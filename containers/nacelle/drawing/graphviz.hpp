// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>

#include "nacelle/base/problem.hpp"
#include "nacelle/base/result.hpp"

namespace nacelle::drawing {

/// Returns a text as a quoted identifier of the DOT language. Pure.
[[nodiscard]] std::string dot_quoted(const std::string& text);
/// Escapes a text for an HTML-like label of the DOT language. Pure.
[[nodiscard]] std::string dot_label_text(const std::string& text);

/// Returns Graphviz's format for the ending of a file's name: "svg", "pdf", "png", "dot"; nothing for another ending.
/// Pure.
[[nodiscard]] std::optional<std::string> drawing_format(const std::string& path);

/// Writes a drawing in the format of the file name's ending. Graphviz's `dot` computes the layout.
///
/// If `dot` is not in PATH, writes the DOT text to a file with the ending .dot instead, and returns a message for the
/// user with the command that draws it. Otherwise returns an empty text. An existing file is replaced once the new one
/// is complete.
/// Errors: a file that cannot be written; a failure of `dot`, with its message. Threads: any; blocks while `dot` runs.
[[nodiscard]] Result<std::string, Problem> write_drawing(const std::string& path, const std::string& dot_text);

}  // namespace nacelle::drawing
