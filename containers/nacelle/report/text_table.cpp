// SPDX-License-Identifier: Apache-2.0
#include "report/text_table.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "nacelle/base/printable.hpp"

namespace nacelle::report {
namespace {

constexpr std::size_t kLeastLastColumn = 12;  // characters; less holds no count of drops with its cause

std::string indented(const std::string& text, std::size_t width) {
  std::string out, line = " ";
  for (std::size_t at = 0; at < text.size();) {
    const std::size_t end = std::min(text.find(' ', at), text.size());
    if (line.size() > 1 && line.size() + 1 + end - at > width) {
      out += line + "\n";
      line = " ";
    }
    line += " " + text.substr(at, end - at);
    at = end + 1;
  }
  return out + line + "\n";
}

}  // namespace

void TextTable::add_row(std::vector<std::string> cells) {
  cells.resize(columns_.size());
  for (std::string& cell : cells) cell = printable_line(cell);
  lines_.push_back({std::move(cells), {}});
}

void TextTable::add_line(const std::string& text) { lines_.push_back({{}, printable_line(text)}); }

std::string TextTable::text(std::size_t width) const {
  const std::size_t last = columns_.size() - 1;
  std::vector<std::size_t> wide(columns_.size());
  for (std::size_t i = 0; i < columns_.size(); ++i) {
    wide[i] = columns_[i].title.size();
    for (const Line& line : lines_) {
      if (!line.cells.empty()) wide[i] = std::max(wide[i], line.cells[i].size());
    }
  }
  // The text that exceeds the last column continues below it.
  const bool last_wraps = width != 0 && !columns_[last].right;
  std::vector<bool> shown(columns_.size(), true);
  const auto needed = [&] {
    std::size_t sum = 0;
    for (std::size_t i = 0; i < columns_.size(); ++i) {
      if (shown[i])
        sum += (sum == 0 ? 0 : 1) + (i == last && last_wraps ? std::min(wide[i], kLeastLastColumn) : wide[i]);
    }
    return sum;
  };
  int most = 0;
  for (const Column& column : columns_) most = std::max(most, column.importance);
  for (int level = 0; width != 0 && level < most; ++level) {
    for (std::size_t i = columns_.size(); i-- > 0 && needed() > width;) {
      if (columns_[i].importance == level) shown[i] = false;
    }
  }

  std::string left_out;
  for (std::size_t i = 0; i < columns_.size(); ++i) {
    if (!shown[i]) left_out += (left_out.empty() ? "" : ", ") + columns_[i].title;
  }
  std::string out = left_out.empty() ? "" : fmt::format("({} columns: without {})\n", width, left_out);
  const auto write = [&](const std::vector<std::string>& cells) {
    std::string line;
    for (std::size_t i = 0; i < columns_.size(); ++i) {
      if (!shown[i]) continue;
      if (!line.empty()) line += ' ';
      if (i == last && last_wraps && line.size() + cells[i].size() > width) {
        line.erase(line.find_last_not_of(' ') + 1);
        out += line + "\n" + indented(cells[i], width);
        return;
      }
      line += columns_[i].right ? fmt::format("{:>{}}", cells[i], wide[i]) : fmt::format("{:<{}}", cells[i], wide[i]);
    }
    line.erase(line.find_last_not_of(' ') + 1);
    out += line + "\n";
  };
  std::vector<std::string> titles;
  for (const Column& column : columns_) titles.push_back(column.title);
  write(titles);
  for (const Line& line : lines_) {
    if (!line.cells.empty()) {
      write(line.cells);
    } else {
      out += width == 0 || line.text.size() <= width ? line.text + "\n" : indented(line.text, width);
    }
  }
  return out;
}

}  // namespace nacelle::report
