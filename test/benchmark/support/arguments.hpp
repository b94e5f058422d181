// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <utility>
#include <vector>

namespace nacelle::bench {

/// `key=value` words of the command line. Errors: a word without `=`, or a number that is none, ends the program with code 2.
class Arguments {
 public:
  Arguments(int count, char** words);
  [[nodiscard]] std::string text(const std::string& key, const std::string& otherwise) const;
  [[nodiscard]] std::uint64_t number(const std::string& key, std::uint64_t otherwise) const;

 private:
  std::map<std::string, std::string> values_;
};

/// Prints one JSON object of numbers on a line of its own, the form in which every benchmark program answers.
void print_figures(const std::vector<std::pair<std::string, double>>& figures);

}  // namespace nacelle::bench
