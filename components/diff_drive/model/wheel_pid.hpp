// SPDX-License-Identifier: Apache-2.0
#pragma once

namespace nacelle::diff_drive {

/// What a WheelPid works with. Its output is a share of the motor's supply: 1 is all of it forward, -1 all of it backward.
struct WheelPidSettings {
  double feed_forward = 0.0;  ///< Output per rad/s that is wanted: 1 / (speed at full supply).
  double p = 0.0;             ///< Output per rad/s of error.
  double i = 0.0;             ///< Output per rad of error that has added up.
  double d = 0.0;             ///< Output per rad/s^2 of the measured speed.
  double filter_s = 0.02;     ///< Time constant of the derivative's low pass; 0: none.
  double output_limit = 1.0;  ///< The output is within plus and minus this; in (0, 1].
};

/// Controls the speed of one wheel.
///
///   e = wanted - measured
///   u = feed_forward * wanted + p * e + I - d * v,   limited to +-output_limit
///   I: the sum of i * e * dt
///   v: the derivative of `measured` behind a low pass of the first order, v += dt / (filter + dt) * (change / dt - v)
///
/// The derivative is that of the measurement, so that a step of the wanted speed makes no kick. I stops growing while the output is limited
/// in its direction, and is itself within +-output_limit: a wheel that was held for a minute starts like one that was held for a moment.
/// Units:     rad/s, s; forward is positive.
/// Threads:   one.
/// Allocates: nothing.
/// Source:    K. J. Astrom, R. M. Murray, Feedback Systems (2nd edition), section 11.4: derivative on the measurement and its filter, anti-windup.
class WheelPid {
 public:
  explicit WheelPid(const WheelPidSettings& settings) : settings_(settings) {}

  /// Returns the output. `dt_s` is the time since the last call: none passes if it is not positive, and at most kLongestStep.
  [[nodiscard]] double update(double wanted_rps, double measured_rps, double dt_s);
  /// Forgets everything: the next update is the first.
  void reset();

  /// What the output owes to errors of the past.
  [[nodiscard]] double integral() const { return integral_; }

  /// Of a loop that did not run for longer, no step is a good guess.
  static constexpr double kLongestStep = 0.1;

 private:
  const WheelPidSettings settings_;
  double integral_ = 0.0;
  double slope_rps2_ = 0.0;  // the measured speed's, filtered
  double last_rps_ = 0.0;
  bool has_last_ = false;
};

/// Returns the share of time that a PWM output is on, for a motor that does not turn below `least`: 0 for an output of 0, between `least` and
/// `most` for all others, with the sign of the output. Precondition: 0 <= least < most <= 1.
[[nodiscard]] double beyond_dead_band(double output, double least, double most);

/// Notices a wheel that does not obey: one that stands still, or turns the wrong way, although its motor gets all it may.
///
/// Either way its controller would only push harder: into a blocked gear, or, with an encoder that is unplugged or counts backward, to full speed.
/// Threads: one. Allocates: nothing.
class WheelWatch {
 public:
  enum class Finding : unsigned char { None, Stands, Reversed };
  /// `limit_s`: for so long; 0 never.
  explicit WheelWatch(double limit_s) : limit_s_(limit_s) {}

  /// `is_limited`: the output is at its limit; `moved_rad`: of the wheel since the last call, in the output's direction.
  [[nodiscard]] Finding update(bool is_limited, double moved_rad, double dt_s);
  void reset() { since_s_ = moved_rad_ = 0.0; }

 private:
  const double limit_s_;
  double since_s_ = 0.0;
  double moved_rad_ = 0.0;
};

}  // namespace nacelle::diff_drive
