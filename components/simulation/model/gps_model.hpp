// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "nacelle/base/time.hpp"
#include "simulation/model/drive_model.hpp"
#include "simulation/protocol/nmea_receiver.hpp"

namespace nacelle::simulation {

/// A GPS receiver on the base: some fixes a second, with an error that is its HDOP times that of its ranges.
///
/// The errors of two fixes are independent. Those of a real receiver drift over minutes, too.
class GpsModel {
 public:
  explicit GpsModel(const WorldSettings& settings);

  /// What it reads at this time of the world, with noise. `pose` and `speed_mps`: of the base.
  [[nodiscard]] GpsReading measure(const Pose& pose, double speed_mps, Duration now);
  [[nodiscard]] Duration period() const { return from_seconds(1.0 / gps_.rate_hz); }

 private:
  const WorldGps gps_;
  Random draws_;
  double metres_per_degree_north_, metres_per_degree_east_;
};

}  // namespace nacelle::simulation
