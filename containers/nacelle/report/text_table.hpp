// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <string>
#include <vector>

namespace nacelle::report {

/// Formats a table as text. A column is as wide as its longest cell. On a narrow terminal the least important columns
/// are left out. Control characters in cells and lines are escaped (printable_line()).
class TextTable {
 public:
  struct Column {
    std::string title;
    bool right = true;   ///< Aligned to the right.
    int importance = 0;  ///< The lowest is left out first, the highest never.
  };
  explicit TextTable(std::vector<Column> columns) : columns_(std::move(columns)) {}

  /// Adds a row with one cell for each column.
  void add_row(std::vector<std::string> cells);
  /// Adds a line across all columns.
  void add_line(const std::string& text);

  /// Returns the lines, at most `width` characters wide if possible; 0: no limit. A last cell that is too long
  /// continues in lines of its own. If columns are left out, the first line names them.
  [[nodiscard]] std::string text(std::size_t width = 0) const;

 private:
  struct Line {
    std::vector<std::string> cells;  ///< Empty: `text` alone.
    std::string text;
  };
  std::vector<Column> columns_;
  std::vector<Line> lines_;
};

}  // namespace nacelle::report
