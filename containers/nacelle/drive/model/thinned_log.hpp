// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <optional>
#include <utility>
#include <vector>

namespace nacelle::drive {

/// Keeps samples of a run of any length in bounded memory: when it is full, it forgets every second one, and from then on keeps every
/// second (then every fourth, ...) new one. The first and the newest sample are always there.
/// Threads: one.
template <typename T>
class ThinnedLog {
 public:
  /// `most`: an even number of samples.
  explicit ThinnedLog(std::size_t most) : most_(most) {}

  void add(T sample) {
    if (added_ % stride_ == 0 && kept_.size() == most_) {
      for (std::size_t i = 1; 2 * i < kept_.size(); ++i) kept_[i] = std::move(kept_[2 * i]);
      kept_.resize(most_ / 2);
      stride_ *= 2;
    }
    if (added_++ % stride_ == 0) {
      kept_.push_back(std::move(sample));
      newest_.reset();
    } else {
      newest_ = std::move(sample);
    }
  }

  /// Returns the samples in the order in which they were added, at most `most` + 1.
  [[nodiscard]] std::vector<T> samples() const {
    std::vector<T> all = kept_;
    if (newest_) all.push_back(*newest_);
    return all;
  }
  [[nodiscard]] bool empty() const { return kept_.empty(); }

 private:
  std::size_t most_, stride_ = 1, added_ = 0;
  std::vector<T> kept_;
  std::optional<T> newest_;  // if it is not the last one of kept_
};

}  // namespace nacelle::drive
