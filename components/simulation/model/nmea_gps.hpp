// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "simulation/model/gps_model.hpp"
#include "simulation/model/serial_device.hpp"

namespace nacelle::simulation {

/// A GPS receiver by itself, at rest: a burst of NMEA sentences per fix.
class NmeaGps final : public SerialDevice {
 public:
  explicit NmeaGps(std::uint64_t seed) : model_(WorldSettings{.seed = seed}) {}
  [[nodiscard]] unsigned baud() const override { return kBaud; }
  void advance(Duration now, const Send& send) override {
    for (; next_ <= now; next_ += model_.period())
      send(next_, as_bytes(print_nmea_burst(model_.measure({}, 0.0, next_))));
  }

  static constexpr unsigned kBaud = 38400;  // five bursts a second do not fit into 9600

 private:
  GpsModel model_;
  Duration next_{};
};

}  // namespace nacelle::simulation
