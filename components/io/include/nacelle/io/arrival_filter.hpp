// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>

#include "nacelle/base/time.hpp"

namespace nacelle::io {

/// Tells when a device that sends at a steady pace measured, from when its bytes came.
///
/// A receive time is never too early but often too late, because the reading thread had to wait for a processor. Therefore the
/// earliest times count: a sample is placed one device step after the one before, earlier if it arrived earlier, and later only
/// by as much as two quartz clocks can differ. A lasting delay is accepted after a while.
///
/// A very late sample follows a gap, or is the first of a burst that waited for a delayed thread. The next sample decides: in a
/// burst it arrives at once, and all samples keep their places; after a gap it arrives one step later, and the gap is accepted.
/// The first sample after a gap is therefore placed as if there were no gap.
/// Threads: one. Allocates: nothing.
class ArrivalFilter {
 public:
  /// How it believes steps.
  enum class Steps : std::uint8_t {
    Rough,   ///< From figures such as a motor's speed: a step may take 1/kCreep longer than it says.
    Steady,  ///< Counted by a quartz, perhaps with a rate that is only roughly known: that is learnt, second by second.
    Nominal  ///< The same, with a rate that only a data sheet gives: it is measured first, see is_settled().
  };
  explicit ArrivalFilter(Steps steps = Steps::Rough)
      : creep_(steps == Steps::Rough ? kCreep : kQuartzCreep),
        learns_(steps != Steps::Rough),
        is_nominal_(steps == Steps::Nominal) {}

  /// `read`: when the sample was read. `on_line`: how long before that it left the device at the least. `step`: the
  /// device's own time since the sample before.
  MonotonicTime settle(MonotonicTime read, Duration on_line, Duration step) {
    const Duration said = step;
    if (is_nominal_ && !is_rated_) learning_ += said;
    if (learns_ && step > Duration::zero())
      step += Duration{static_cast<std::int64_t>(static_cast<double>(step.count()) * rate_error_)};
    const MonotonicTime received = read - on_line;
    const MonotonicTime expected = last_ + step;
    const Duration late = received - expected;
    if (!started_ || step <= Duration::zero() || late > kLongestAway) {
      last_ = received;
      very_late_ = 0;
      begin_window();
    } else if (late <= kGap) {
      // After a loss was believed too late time still goes forward: at half the pace.
      last_ = std::max(expected + std::min(late, std::max(step / creep_, Duration{1})), last_ + step / 2);
      very_late_ = 0;
      if (learns_) learn(received, is_nominal_ ? step : said);
    } else {
      if (very_late_ == 0) first_very_late_ = read;
      const bool in_a_burst = very_late_ == 0 || read - first_very_late_ < very_late_ * step * 3 / 4;
      last_ = in_a_burst ? expected : received;
      begin_window();
      very_late_ = in_a_burst ? very_late_ + 1 : 0;
    }
    started_ = true;
    return last_;
  }
  /// False while the rate of nominal steps is measured, which takes a second or two: times are some milliseconds off until then. A rate
  /// that cannot be measured is taken as it is after kLongestLearning.
  [[nodiscard]] bool is_settled() const {
    return !is_nominal_ || learning_ > kLongestLearning || (is_rated_ && settling_ <= Duration{});
  }
  /// Forgets the pace: the line was opened again. What was learnt about its rate stays.
  void restart() {
    started_ = false;
    very_late_ = 0;
    begin_window();
  }

  /// A step may take a hundredth longer than the device says: crystals differ by 1/10000, motors' speed figures by
  /// more.
  static constexpr std::int64_t kCreep = 100;
  /// For steps of a quartz, whose rate is learnt.
  static constexpr std::int64_t kQuartzCreep = 10000;
  /// The rate of steady steps is learnt over this time; a lateness that lasts for half of it is believed.
  static constexpr Duration kWindow = 1s;
  static constexpr Duration kLasting = 600us;
  /// The rate of nominal steps is measured over two of these, again and again until it agrees with the one before; or for so long.
  static constexpr Duration kFirstWindow = 500ms, kLongestLearning = 5s;
  /// Rate errors of two windows that agree.
  static constexpr double kAgreement = 1e-3;
  /// A device that is farther from its nominal rate is another device.
  static constexpr double kMostRateError = 0.2;
  /// Later than this is very late.
  static constexpr Duration kGap = 100ms;
  /// What came in a longer time does not wait in the line's buffer (4096 bytes): a gap.
  static constexpr Duration kLongestAway = 1s;

 private:
  // The window under way, and the one before, count no more: a sample follows whose step says nothing.
  void begin_window() {
    window_ = paced_ = Duration{};
    least_late_ = least_ = before_ = Duration::max();
  }
  // `paced` is the device's time without all corrections. The least that samples are behind it in a window, beside the least of the
  // window before, is the error of the rate; delays of the thread do not change the least.
  void learn(MonotonicTime received, Duration step) {
    paced_ += step;
    window_ += step;
    if (is_rated_) settling_ -= step;
    const Duration behind = received.since_origin - paced_;
    least_ = std::min(least_, behind);
    if (window_ > kWindow / 2) least_late_ = std::min(least_late_, received - last_);
    if (window_ < (is_nominal_ && !is_rated_ ? kFirstWindow : kWindow)) return;
    if (before_ != Duration::max()) {
      const double error = static_cast<double>((least_ - before_).count()) / static_cast<double>(window_.count());
      if (is_nominal_ && !correct_nominal(error)) return;
      // A step that was counted wrong after a loss spoils one window; two that agree are believed.
      if (!is_nominal_ && std::abs(error - last_error_) < kAgreement) {
        rate_error_ =
            std::clamp(rate_error_ + (error - rate_error_) / (is_rated_ ? 4.0 : 1.0), -kMostRateError, kMostRateError);
        is_rated_ = true;
      }
      last_error_ = error;
    }
    // A window that ends at its half has seen none.
    if (least_late_ != Duration::max() && least_late_ > kLasting) last_ += least_late_;
    before_ = least_;
    least_ = least_late_ = Duration::max();
    window_ = Duration{};
  }
  // `error` is that of the rate in force, since `paced_` has it. Returns whether the windows go on.
  bool correct_nominal(double error) {
    const bool agrees = std::abs(error) < kAgreement;
    if (is_rated_ && !agrees) return true;  // a step that was counted wrong after a loss
    // A rate that agrees at once is exact, and better than what two windows measure.
    const bool is_exact = agrees && !is_rated_ && rate_error_ == 0.0;
    if (!is_exact)
      rate_error_ = std::clamp(rate_error_ + (is_rated_ ? error / 4.0 : error), -kMostRateError, kMostRateError);
    if (is_rated_) return true;
    is_rated_ = agrees;
    begin_window();  // of another rate
    return false;
  }

  const std::int64_t creep_;
  const bool learns_, is_nominal_;
  double rate_error_ = 0.0;  ///< A step takes 1 + this of what the device says.
  double last_error_ = 0.0;  ///< Of the last window.
  bool is_rated_ = false;
  Duration learning_{};                   ///< Spent on the rate of nominal steps.
  Duration settling_ = kFirstWindow / 2;  ///< Left after that, until what was placed before has gone.
  Duration window_{}, paced_{}, least_late_ = Duration::max(), least_ = Duration::max(), before_ = Duration::max();
  MonotonicTime last_{}, first_very_late_{};
  std::int64_t very_late_ = 0;  ///< Samples in a row that may belong to a burst.
  bool started_ = false;
};

}  // namespace nacelle::io
