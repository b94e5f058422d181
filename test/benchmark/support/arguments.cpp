// SPDX-License-Identifier: Apache-2.0
#include "support/arguments.hpp"

#include <charconv>
#include <cstdio>
#include <cstdlib>
#include <string_view>

namespace nacelle::bench {

Arguments::Arguments(int count, char** words) {
  for (int i = 1; i < count; ++i) {
    const std::string_view word = words[i];
    const auto equals = word.find('=');
    if (equals == std::string_view::npos) {
      std::fprintf(stderr, "%s: '%s' is no key=value\n", words[0], words[i]);
      std::exit(2);
    }
    values_[std::string(word.substr(0, equals))] = word.substr(equals + 1);
  }
}

std::string Arguments::text(const std::string& key, const std::string& otherwise) const {
  const auto found = values_.find(key);
  return found == values_.end() ? otherwise : found->second;
}

std::uint64_t Arguments::number(const std::string& key, std::uint64_t otherwise) const {
  const auto found = values_.find(key);
  if (found == values_.end()) return otherwise;
  std::uint64_t value = 0;
  const std::string& text = found->second;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc{} || end != text.data() + text.size()) {
    std::fprintf(stderr, "%s=%s is not a whole number\n", key.c_str(), text.c_str());
    std::exit(2);
  }
  return value;
}

void print_figures(const std::vector<std::pair<std::string, double>>& figures) {
  const char* separator = "{";
  for (const auto& [name, value] : figures) {
    std::printf("%s\"%s\": %.9g", separator, name.c_str(), value);
    separator = ", ";
  }
  std::printf("}\n");
  std::fflush(stdout);
}

}  // namespace nacelle::bench
