// SPDX-License-Identifier: Apache-2.0
// Any bytes, in any chopping: nothing crashes, every byte is accounted for, numbers are finite, and neither lines nor counts depend on
// the chopping.
#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <string>
#include <vector>

#include "diff_drive/protocol/number_lines.hpp"

namespace {

using nacelle::diff_drive::NumberLine;
using nacelle::diff_drive::NumberLineDecoder;

void require(bool holds) {
  if (!holds) std::abort();
}

struct Seen {
  std::vector<std::string> words;
  std::vector<double> numbers;
  std::size_t bad = 0;
  friend bool operator==(const Seen&, const Seen&) = default;
};

void feed(NumberLineDecoder& decoder, nacelle::ByteView bytes, Seen& seen) {
  decoder.feed(
      bytes,
      [&](const NumberLine& line) {
        seen.words.emplace_back(line.word);
        require(line.count <= NumberLine::kMostNumbers);
        for (std::size_t i = 0; i < line.count; ++i) {
          require(std::isfinite(line.numbers[i]));
          seen.numbers.push_back(line.numbers[i]);
        }
      },
      [&] { ++seen.bad; });
  const auto& stats = decoder.stats();
  require(stats.bytes ==
          stats.line_bytes + stats.malformed_bytes + stats.overlong_bytes + stats.blank_bytes + decoder.pending());
  require(seen.bad == stats.malformed_lines + stats.overlong_lines);
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const nacelle::ByteView bytes{data, size};
  NumberLineDecoder at_once, in_parts;
  Seen whole, chopped;
  feed(at_once, bytes, whole);
  for (std::size_t at = 0; at < size;) {
    const std::size_t part = std::min<std::size_t>(size - at, 1 + data[at] % 13U);
    feed(in_parts, bytes.subspan(at, part), chopped);
    at += part;
  }
  require(at_once.stats().bytes == size);
  require(at_once.stats() == in_parts.stats());
  require(whole == chopped);
  return 0;
}
