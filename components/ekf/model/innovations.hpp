// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "ekf/model/update.hpp"
#include "nacelle/base/time.hpp"

namespace nacelle::ekf {

struct InnovationOptions {
  std::vector<bool> adaptive;  ///< By part: raise its measurement noise to what is seen of it. Missing: false.
};

/// What the innovations of one state that a part measures say, over the last kWindow measurements.
struct AxisNoise {
  std::uint64_t count{};  ///< Measurements since the start; the other figures are 0 before kEnough of them.
  double nis{};           ///< Mean of innovation^2 / S. 1 if the filter's uncertainty is right.
  double offset{};        ///< Mean innovation, in standard deviations (sqrt S). 0 without a bias.
  double noise{};         ///< The white noise of the measurement, as a multiple of the stddev that it claims.
  double scale{1.0};      ///< What the claimed stddev is multiplied by; above 1 only with adaptive noise.
};

/// The filter measures itself: innovations beside the covariance that it expected of them, per part and state.
///
/// How noisy a measurement is, is told without the filter. With e[k] = z[k] - 2 z[k-1] + z[k-2] the second difference of what is
/// measured, white noise of the variance R on top of a quantity that wanders by the variance q per measurement gives
///
///   E[e[k]^2] = 6 R + 2 q,   E[e[k] e[k-1]] = -4 R - q,   hence   R = -E[e[k]^2 + 2 e[k] e[k-1]] / 2
///
/// A bias, a steady motion and a steady change of it leave e alone, and a manoeuvre makes R smaller. So neither is taken for noise,
/// whatever the filter believes of the motion. Over kWindow measurements the estimate scatters by 4 % of E[e^2]; within twice of
/// that the measurement is as noisy as it claims.
///
/// With `adaptive` the variance of a measurement is raised to that estimate: never lowered, and at most to kMostScale^2 of what
/// the measurement claims.
///
/// A measurement that is older than the last one of its part was counted before: a filter that replays its history counts nothing
/// twice. Readings outside their gate count as well, up to ten standard deviations: otherwise a claim that is far too small would
/// reject everything and look right.
///
/// Units:     those of the states; ratios have none.
/// Threads:   one. Allocates: in the constructor only.
/// Source:    NIS: Bar-Shalom, Li, Kirubarajan, "Estimation with Applications to Tracking and Navigation" (2001), section 5.4.
///            Means are exponential with the weight 1/min(count, kWindow).
class Innovations {
 public:
  static constexpr std::uint64_t kWindow = 200, kEnough = 30;
  static constexpr double kMostScale = 10.0;  ///< Of a standard deviation.

  /// `held`: states whose readings are constraints (two_d_mode), not measurements.
  Innovations(std::size_t parts, const InnovationOptions& options, StateMask held);

  /// Counts a reading that is about to correct `prior`, and returns the reading to fuse: the same one, or a copy with raised
  /// variances, valid until the next call.
  [[nodiscard]] const Reading& note(std::size_t part, WallTime stamp, const Belief& prior, const Reading& reading);

  /// Stamps begin anew (the clock was set back, the filter starts again). The figures stay.
  void restart();

  [[nodiscard]] AxisNoise axis(std::size_t part, StateIndex state) const;

 private:
  struct Axis {
    std::uint64_t count{}, differences{};
    double nis{}, offset{}, claimed{};
    double square{}, product{};                       // means of e[k]^2 and e[k] e[k-1]
    double last{}, last_difference{}, last_second{};  // of the measured values
    int run{};                                        // how many of these three are known
    double scale{1.0};                                // of the variance
  };
  struct Part {
    std::array<Axis, kStates> axes{};
    WallTime newest{};
    bool adaptive{false};
  };
  static void add(Axis& axis, double innovation, double prior_variance, double claimed);
  static void add_value(Axis& axis, int state, double value);
  [[nodiscard]] static double noise_variance(const Axis& axis);
  [[nodiscard]] const Reading& adapted(const Part& part, const Reading& reading);

  std::vector<Part> parts_;
  StateMask held_;
  Reading raised_;
};

}  // namespace nacelle::ekf
