// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string_view>

#include "nacelle/base/bytes.hpp"

namespace nacelle::diff_drive {

// Lines of text as ODrives and home-made boards send them: a word or none, then numbers.
//
//   [WORD] NUMBER NUMBER ...[*CHECKSUM] [;COMMENT]\n
//
// The checksum is the XOR of all bytes before the '*', in decimal. Space, tab and comma separate. A CR before the LF is no part of the line.
// Source: ODrive documentation, ASCII protocol, "Command format".

/// One such line. The word is valid until the decoder is fed again.
struct NumberLine {
  static constexpr std::size_t kMostNumbers = 6;
  std::string_view word;  ///< Of letters; empty if the line begins with a number.
  std::array<double, kMostNumbers> numbers{};
  std::size_t count = 0;
  std::uint64_t first_byte = 0;  ///< The number of its first byte among all bytes that were fed.
};

/// Why a line is none of these.
enum class NumberLineFault : std::uint8_t {
  Malformed,    ///< Something else than finite numbers behind the word, or too many of them.
  BadChecksum,  ///< Another checksum than its bytes have.
};

/// Cuts bytes into lines and reads them; takes any chopping.
///
/// Every byte is accounted for: bytes == line_bytes + malformed_bytes + overlong_bytes + blank_bytes + pending().
/// Threads: belongs to one thread. Allocates: nothing.
class NumberLineDecoder {
 public:
  static constexpr std::size_t kMaxLineBytes = 128;
  struct Stats {
    std::uint64_t bytes = 0;
    std::uint64_t lines = 0, line_bytes = 0;
    std::uint64_t malformed_lines = 0, malformed_bytes = 0;  ///< Bad checksums too.
    std::uint64_t bad_checksums = 0;
    std::uint64_t overlong_lines = 0, overlong_bytes = 0;
    std::uint64_t blank_bytes = 0;
    friend bool operator==(const Stats&, const Stats&) = default;
  };

  /// Calls on_line(const NumberLine&) for each line that ends in these bytes, and on_bad_line() for each other that is not blank.
  template <typename Sink, typename Bad>
  void feed(ByteView bytes, Sink&& on_line, Bad&& on_bad_line) {
    while (!bytes.empty()) {
      switch (take(bytes)) {
        case Took::Line: on_line(line_); break;
        case Took::BadLine: on_bad_line(); break;
        case Took::Nothing: break;
      }
    }
  }
  /// Forgets the line that has begun; its bytes count as malformed.
  void restart();

  [[nodiscard]] const Stats& stats() const { return stats_; }
  [[nodiscard]] std::size_t pending() const { return pending_; }

 private:
  enum class Took : std::uint8_t { Line, BadLine, Nothing };
  [[nodiscard]] Took take(ByteView& bytes);
  [[nodiscard]] Took finish(std::size_t line_bytes);

  std::array<char, kMaxLineBytes> text_{};
  std::size_t pending_ = 0;  // may exceed kMaxLineBytes: then the line is overlong and text_ is void
  NumberLine line_;
  Stats stats_;
};

/// Returns the XOR of the bytes.
[[nodiscard]] std::uint8_t line_checksum(std::string_view text);

/// Writes commands of such lines into its own fixed buffer. Threads: belongs to one thread. Allocates: nothing.
class NumberLinePrinter {
 public:
  static constexpr std::size_t kCapacity = 192;
  /// Begins anew; the view of line() is void.
  void clear() { size_ = begun_ = 0; }
  /// Precondition: all fits into kCapacity, which is the caller's matter to know.
  NumberLinePrinter& text(std::string_view part);
  NumberLinePrinter& integer(std::int64_t value);
  /// Six decimals at most, without trailing zeros.
  NumberLinePrinter& decimal(double value);
  /// Ends a line, with its checksum.
  NumberLinePrinter& end_checked();
  NumberLinePrinter& end() { return text("\n"), begun_ = size_, *this; }
  [[nodiscard]] ByteView lines() const { return {reinterpret_cast<const std::uint8_t*>(text_.data()), size_}; }

 private:
  std::array<char, kCapacity> text_{};
  std::size_t size_ = 0, begun_ = 0;
};

}  // namespace nacelle::diff_drive
