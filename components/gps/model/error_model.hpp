// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <optional>

#include "gps/protocol/nmea_sentence.hpp"
#include "nacelle/base/time.hpp"

namespace nacelle::gps {

/// Standard deviation of a position in each horizontal direction at HDOP 1, by the quality of the fix (GGA). 1e6 m: not a position.
/// Source: nmea_navsat_driver's epe_quality0 to 9, but for quality 2: it has 0.1 m there, which needs more than SBAS.
inline constexpr std::array<double, 10> kDefaultErrors_m{1e6, 4.0, 1.0, 1e6, 0.02, 4.0, 1e6, 1e6, 1e6, 3.0};

/// Tells how far a fix may be from the truth.
///
/// The receiver's own estimate (GST) counts, if it is no older than three seconds and not 0; otherwise HDOP times the error of the fix's quality.
/// The height's error is VDOP (GSA) times that, or four times the horizontal one, as in nmea_navsat_driver.
/// Threads: one. Allocates: nothing.
class ErrorModel {
 public:
  enum class Source : std::uint8_t {
    None,      ///< Nothing is known; the variances are 0.
    Dilution,  ///< From HDOP.
    Receiver,  ///< From GST.
  };
  struct Variances {
    double east_m2{}, north_m2{}, up_m2{};
    Source source = Source::None;
  };

  explicit ErrorModel(const std::array<double, 10>& errors_m = kDefaultErrors_m) : errors_m_(errors_m) {}

  void add(const Gst& gst, MonotonicTime now);
  void add(const Gsa& gsa, MonotonicTime now);
  [[nodiscard]] Variances of(const Gga& gga, MonotonicTime now) const;
  /// Forgets what was added: the line was opened again.
  void restart();

  static constexpr Duration kFresh = 3s;

 private:
  const std::array<double, 10> errors_m_;
  std::optional<Gst> gst_;
  std::optional<double> vdop_;
  MonotonicTime gst_at_{}, vdop_at_{};
};

}  // namespace nacelle::gps
