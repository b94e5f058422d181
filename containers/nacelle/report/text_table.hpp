// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <string>
#include <vector>

namespace nacelle::report {

/// A table as text whose columns are as wide as what stands in them, and which a narrow terminal gets without its least
/// important columns. Control characters in cells and lines are escaped (printable_line()).
class TextTable {
 public:
  struct Column {
    std::string title;
    bool right = true;   ///< Aligned to the right.
    int importance = 0;  ///< The least is left out first; those of the highest value never are.
  };
  explicit TextTable(std::vector<Column> columns) : columns_(std::move(columns)) {}

  /// One cell for each column.
  void add_row(std::vector<std::string> cells);
  /// A line below the last row, across all columns.
  void add_line(const std::string& text);

  /// The lines, at most `width` characters each where that can be; 0: as wide as it is. A last cell that is too long goes on in
  /// lines of its own. The first line names the columns that were left out.
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
