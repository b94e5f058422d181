// SPDX-License-Identifier: Apache-2.0
#include "monitor/model/stream_watch.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace nacelle::monitor {

void StreamWatch::start(MonotonicTime now) {
  writer_count_ = 0;
  since_ = last_ = now;
  recent_ = recent_lost_ = 0;
  oldest_.reset();
  any_ = false;
}

void StreamWatch::record(MonotonicTime received, std::uint64_t writer, std::uint64_t sequence,
                         std::optional<Duration> age) {
  ++received_;
  ++recent_;
  any_ = true;
  last_ = received;
  if (age) oldest_ = std::max(oldest_.value_or(*age), *age);
  auto* const end = writers_.begin() + writer_count_;
  auto* const known = std::find_if(writers_.begin(), end, [&](const WriterCount& w) { return w.id == writer; });
  if (known == end) {
    if (writer_count_ == kMostWriters) return;
    ++writer_count_;
    *known = {writer, sequence};
    return;
  }
  if (sequence > known->last + 1) {
    const std::uint64_t missing = sequence - known->last - 1;
    lost_ += missing;
    recent_lost_ += missing;
  }
  known->last = sequence;
}

StreamReport StreamWatch::look(MonotonicTime now, const Expectation& expected) {
  StreamReport report;
  const double window_s = to_seconds(now - since_);
  report.rate_hz = window_s > 0 ? static_cast<double>(recent_) / window_s : 0.0;
  report.received = received_;
  report.lost = lost_;
  report.oldest = oldest_;
  if (any_) report.silent_for = now - last_;

  const Duration silence = now - last_;  // since start() if nothing came
  const double off = expected.rate_hz > 0 ? std::abs(report.rate_hz - expected.rate_hz) / expected.rate_hz : 0.0;
  const bool rate_counts = expected.rate_hz > 0 && window_s * expected.rate_hz >= 1;
  if (!any_) {
    report.level = expected.periodic ? Level::Stale : Level::Ok;
    report.message = "no message yet";
  } else if (expected.periodic && silence > expected.stale_after) {
    report.level = Level::Stale;
    report.message = fmt::format("silent for {:.1f} s", to_seconds(silence));
  } else if (rate_counts && report.rate_hz < 0.5 * expected.rate_hz) {
    report.level = Level::Error;
    report.message = fmt::format("{:.1f} Hz instead of {:.1f}", report.rate_hz, expected.rate_hz);
  } else if (rate_counts && off > expected.tolerance) {
    report.level = Level::Warn;
    report.message = fmt::format("{:.1f} Hz instead of {:.1f}", report.rate_hz, expected.rate_hz);
  } else if (recent_lost_ > 0) {
    report.level = Level::Warn;
    report.message = fmt::format("{} messages missing", recent_lost_);
  } else if (expected.most_age > Duration::zero() && oldest_ && *oldest_ > expected.most_age) {
    report.level = Level::Warn;
    report.message = fmt::format("{:.1f} ms old", to_milliseconds(*oldest_));
  } else {
    report.level = Level::Ok;
    report.message = recent_ == 0 ? "silent" : fmt::format("{:.1f} Hz", report.rate_hz);
  }
  since_ = now;
  recent_ = recent_lost_ = 0;
  oldest_.reset();
  return report;
}

}  // namespace nacelle::monitor
