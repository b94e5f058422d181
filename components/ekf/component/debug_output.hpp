// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "ekf/component/debug_file.hpp"
#include "ekf/model/filter_observer.hpp"

namespace nacelle::ekf {

/// The parameter `debug`: a line for each prediction and each measurement, with the state behind it, in a file in memory.
///
///     1700000000.020000000 predict 0.020000
///     1700000000.020000000 odom0 twist: vx 0.31 (0.3, 0.0001) vyaw 0.02 (0.01, 0.0001): fused, 1.52
///     1700000000.020000000 state x 0.1 (0.002) y 0 (0.002) ... az 0 (0.01)
///
/// A measurement has of each state that it measures: its value, in brackets the estimate behind it and the measurement's variance; then what
/// became of it and the squared Mahalanobis distance. A state has its variance in brackets.
/// Threads: one. Allocates: yes.
class DebugOutput final : public FilterObserver {
 public:
  /// `parts`: the names of the filter's parts, by their numbers.
  DebugOutput(DebugFile file, std::vector<std::string> parts) : file_(std::move(file)), parts_(std::move(parts)) {}

  void predicted(WallTime to, double dt_s, const Belief& belief) override;
  void corrected(const Measurement& measurement, const Result<Fused, UpdateFault>& fused,
                 const Belief& belief) override;
  [[nodiscard]] const std::string& path() const { return file_.path(); }
  /// Whether the file took everything so far.
  [[nodiscard]] bool complete() const { return complete_; }

 private:
  void put(const std::string& text) { complete_ = complete_ && file_.write(text); }

  DebugFile file_;
  std::vector<std::string> parts_;
  bool complete_{true};
};

}  // namespace nacelle::ekf
