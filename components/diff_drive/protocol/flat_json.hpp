// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string_view>

namespace nacelle::diff_drive {

/// Reads the members of one flat JSON object, one after the other, without copying or allocating.
///
/// "Flat": values are numbers, strings, true, false or null; an object or array inside is a failure, since no line that
/// the base needs has one. Strings are checked for their end only, and handed out as they stand, escapes included.
///
///   for (FlatJsonReader json{line}; auto member = json.next();) ...; then ask failed()
///
/// Threads: belongs to one thread. Allocates: nothing.
/// Source:  RFC 8259; numbers beyond the range of a double are failures.
class FlatJsonReader {
 public:
  struct Member {
    std::string_view key;
    std::optional<double> number;  ///< Set when the value is a number; null, texts and truth values leave it empty.
  };

  explicit FlatJsonReader(std::string_view line) : rest_(line) {}

  /// The next member; empty after the last one and on a failure.
  [[nodiscard]] std::optional<Member> next();
  /// True when the line was not one whole flat object. Meaningful once next() was empty.
  [[nodiscard]] bool failed() const { return state_ == State::Failed; }

 private:
  enum class State : std::uint8_t { Start, Members, Done, Failed };

  void skip_space();
  [[nodiscard]] bool take(char expected);
  [[nodiscard]] std::optional<std::string_view> take_string();
  [[nodiscard]] bool take_word(std::string_view word);
  [[nodiscard]] std::optional<double> take_number();
  [[nodiscard]] std::optional<Member> take_member();
  std::nullopt_t fail();

  std::string_view rest_;
  State state_ = State::Start;
};

}  // namespace nacelle::diff_drive
