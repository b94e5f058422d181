// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "ekf/model/measurement_queue.hpp"
#include "ekf/model/update.hpp"

namespace nacelle::ekf {

/// Sees what a filter does, in the order in which it does it. Threads: the filter's.
class FilterObserver {
 public:
  FilterObserver() = default;
  FilterObserver(const FilterObserver&) = delete;
  FilterObserver& operator=(const FilterObserver&) = delete;
  virtual ~FilterObserver() = default;

  /// The belief was carried on by dt_s to a stamp.
  virtual void predicted(WallTime to, double dt_s, const Belief& belief) = 0;
  /// A measurement was offered to a belief, which is given as it is now: corrected, or as it was if there is a fault.
  virtual void corrected(const Measurement& measurement, const Result<Fused, UpdateFault>& fused,
                         const Belief& belief) = 0;
};

}  // namespace nacelle::ekf
