// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <deque>

#include "nacelle/io/gpio_lines.hpp"

namespace nacelle::io {

/// Output lines that a test reads. Threads: one.
class ScriptedOutputs final : public GpioOutputs {
 public:
  bool set(std::uint64_t wanted) override {
    if (is_lost) return false;
    levels = wanted;
    return true;
  }
  bool reopen() override {
    if (is_lost) return false;
    levels = 0;
    return true;
  }

  std::uint64_t levels = 0;
  bool is_lost = false;  ///< The chip is gone.
};

/// Input lines that a test moves. Like the kernel, it keeps so many edges and loses the oldest. Threads: one.
class ScriptedInputs final : public GpioInputs {
 public:
  /// Sets the level of a line; an edge if it is another one.
  void set(unsigned line, bool high, MonotonicTime at);

  /// The last two edges, of different lines, are handed over in the wrong order: threads of the kernel overtook each other.
  void swap_last_two();
  /// The last two edges, of one line, are handed over as one: its interrupt came again before the kernel had looked.
  void merge_last_two();

  std::optional<std::uint64_t> levels() override;
  std::optional<std::span<const GpioEdge>> take() override;
  bool reopen() override;

  bool is_lost = false;  ///< The chip is gone.
  std::size_t kept = kKept;

 private:
  std::uint64_t levels_ = 0;
  std::deque<GpioEdge> edges_;
  std::array<std::uint32_t, 64> numbers_{};
  std::uint32_t sequence_ = 0;
  std::array<GpioEdge, kBatch> taken_{};
};

}  // namespace nacelle::io
