// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <deque>

namespace nacelle::cli {

/// The last messages, at most `longest`: the time of publication (s) and one figure of each.
/// least(), most(), mean() and span_s() require at least one message.
class Window {
 public:
  explicit Window(std::size_t longest) : longest_(longest) {}

  void add(double time_s, double value) {
    times_s_.push_back(time_s);
    values_.push_back(value);
    if (times_s_.size() <= longest_) return;
    times_s_.pop_front();
    values_.pop_front();
  }
  [[nodiscard]] std::size_t size() const { return values_.size(); }
  [[nodiscard]] double span_s() const { return times_s_.back() - times_s_.front(); }
  [[nodiscard]] double sum() const {
    double sum = 0;
    for (const double value : values_) sum += value;
    return sum;
  }
  [[nodiscard]] double mean() const { return sum() / static_cast<double>(size()); }
  [[nodiscard]] double least() const { return *std::ranges::min_element(values_); }
  [[nodiscard]] double most() const { return *std::ranges::max_element(values_); }
  [[nodiscard]] double deviation() const {
    double squares = 0;
    for (const double value : values_) squares += (value - mean()) * (value - mean());
    return std::sqrt(squares / static_cast<double>(size()));
  }

 private:
  const std::size_t longest_;
  std::deque<double> times_s_, values_;
};

}  // namespace nacelle::cli
