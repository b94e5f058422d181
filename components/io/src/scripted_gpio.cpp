// SPDX-License-Identifier: Apache-2.0
#include "nacelle/io/scripted_gpio.hpp"

#include <algorithm>
#include <utility>

namespace nacelle::io {

void ScriptedInputs::set(unsigned line, bool high, MonotonicTime at) {
  const std::uint64_t bit = std::uint64_t{1} << line;
  if (((levels_ & bit) != 0) == high) return;
  levels_ ^= bit;
  edges_.push_back({line, high, at, ++numbers_.at(line), ++sequence_});
  if (edges_.size() > kept) edges_.pop_front();
}

void ScriptedInputs::swap_last_two() { std::swap(edges_.at(edges_.size() - 1), edges_.at(edges_.size() - 2)); }

void ScriptedInputs::merge_last_two() {
  const GpioEdge second = edges_.back();
  edges_.pop_back();
  const std::uint32_t number = edges_.back().number;
  edges_.back() = second;
  edges_.back().number = number;
  --numbers_.at(second.line);
}

std::optional<std::uint64_t> ScriptedInputs::levels() { return is_lost ? std::nullopt : std::optional{levels_}; }

std::optional<std::span<const GpioEdge>> ScriptedInputs::take() {
  if (is_lost) return std::nullopt;
  const std::size_t count = std::min(edges_.size(), taken_.size());
  std::copy_n(edges_.begin(), count, taken_.begin());
  edges_.erase(edges_.begin(), edges_.begin() + static_cast<std::ptrdiff_t>(count));
  return std::span<const GpioEdge>{taken_.data(), count};
}

bool ScriptedInputs::reopen() {
  if (is_lost) return false;
  edges_.clear();
  numbers_ = {};
  sequence_ = 0;
  return true;
}

}  // namespace nacelle::io
