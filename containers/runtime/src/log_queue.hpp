// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <string_view>

#include "nacelle/base/log.hpp"
#include "nacelle/base/mutex.hpp"
#include "nacelle/base/time.hpp"

namespace nacelle::runtime {

/// A queue of log lines for a thread that publishes them. Lines that find no room are dropped and counted.
///
/// It has two buffers that are swapped. Writing copies the text, under a lock that is never held for longer than that.
/// Threads: push() any; take() one.
/// Allocates: in the constructor only.
class LogQueue {
 public:
  static constexpr std::size_t kBytes = std::size_t{32} * 1024;  ///< Of each buffer.
  static constexpr std::size_t kLongestText = 4096;              ///< Longer texts are cut.

  /// A line, valid during the call of `show`.
  struct Line {
    LogLevel level = LogLevel::Info;
    WallTime when;
    std::string_view name, text, file, function;
    std::uint32_t number = 0;  ///< Line number in the file.
  };

  LogQueue();
  /// Returns false if there is no room.
  bool push(LogLevel level, WallTime when, std::string_view name, std::string_view text,
            const LogPlace& place) noexcept;
  /// Passes all queued lines to `show`, in order. Returns the number of lines that were dropped since the last call.
  std::uint64_t take(const std::function<void(const Line&)>& show);

 private:
  Mutex mutex_;
  std::string filling_ NACELLE_GUARDED_BY(mutex_), showing_;
  std::uint64_t dropped_ NACELLE_GUARDED_BY(mutex_) = 0;
};

}  // namespace nacelle::runtime
