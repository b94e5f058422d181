// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <string_view>

#include "nacelle/base/clock_skews.hpp"
#include "nacelle/base/time.hpp"

namespace nacelle::spatial {

/// Why a transform could not be given; names and numbers are those of tf2's TF2Error.
enum class TransformError : std::uint8_t {
  Lookup = 1,                  ///< A frame is unknown.
  Connectivity = 2,            ///< Both frames are known, but no chain joins them.
  Extrapolation = 3,           ///< The general word for the three below; not given by this buffer.
  InvalidArgument = 4,         ///< A frame id is empty or begins with '/'.
  Timeout = 5,                 ///< The wait timed out.
  Transform = 6,               ///< Any other trouble.
  BackwardExtrapolation = 7,   ///< Asked for a time before the oldest sample of a frame on the way.
  ForwardExtrapolation = 8,    ///< Asked for a time after the newest one.
  NoDataForExtrapolation = 9,  ///< A frame on the way has one sample only, of another time.
};

/// A frame name inside a fault: a copy, so that a fault outlives the buffer and building one allocates nothing.
class FrameLabel {
 public:
  FrameLabel() = default;
  explicit FrameLabel(std::string_view name)
      : size_(static_cast<std::uint8_t>(name.copy(text_.data(), text_.size()))) {}
  [[nodiscard]] std::string_view view() const { return {text_.data(), size_}; }

 private:
  std::array<char, 63> text_{};  // a longer name is shortened in the text only
  std::uint8_t size_{};
};

/// Everything that the sentence about a failed lookup needs.
struct LookupFault {
  TransformError error{TransformError::Lookup};
  bool at_target{};      ///< Lookup, InvalidArgument: which argument was wrong.
  bool at_fixed{};       ///< The same for the frame to look through, which is then in `source`.
  bool would_starve{};   ///< Waited for by the thread that feeds the buffer, which does nothing else meanwhile.
  FrameLabel target;     ///< As asked.
  FrameLabel source;     ///< As asked.
  FrameLabel broken_at;  ///< Extrapolation: the frame whose samples do not reach the time.
  WallTime requested{};  ///< Extrapolation: the time asked for.
  WallTime available{};  ///< Extrapolation: the nearest time there is.
  ClockSkew skew;        ///< Extrapolation: of the machine that sent what does not reach the time, if it is known.

  /// One sentence in tf2's words with both times, the frame whose history ends there, and a clock that is the cause.
  /// Allocates: the text.
  [[nodiscard]] std::string text() const;
};

/// "LookupException", "ExtrapolationException" and so on: the name tf2 users search for.
[[nodiscard]] std::string_view exception_name(TransformError error);

}  // namespace nacelle::spatial
