// SPDX-License-Identifier: Apache-2.0
#include "ekf/component/debug_output.hpp"

#include <fmt/format.h>

#include <iterator>

namespace nacelle::ekf {
namespace {

std::string stamp_text(WallTime stamp) {
  constexpr std::int64_t kBillion = 1'000'000'000;
  return fmt::format("{}.{:09}", stamp.nanoseconds() / kBillion, stamp.nanoseconds() % kBillion);
}

void append_state(WallTime stamp, const Belief& belief, std::string& out) {
  fmt::format_to(std::back_inserter(out), "{} state", stamp_text(stamp));
  for (int i = 0; i < kStates; ++i) {
    fmt::format_to(std::back_inserter(out), " {} {:.9g} ({:.4g})", kStateNames[static_cast<std::size_t>(i)],
                   belief.mean[i], belief.covariance(i, i));
  }
  out += '\n';
}

const char* word_of(UpdateFault fault) {
  switch (fault) {
    case UpdateFault::NoRows: return "nothing to fuse";
    case UpdateFault::NotFinite: return "not finite";
    case UpdateFault::SingularInnovation: return "its covariance is none";
    case UpdateFault::OutsideGate: return "outside the rejection threshold";
  }
  return "?";
}

}  // namespace

void DebugOutput::predicted(WallTime to, double dt_s, const Belief& belief) {
  std::string text = fmt::format("{} predict {:.9f}\n", stamp_text(to), dt_s);
  append_state(to, belief, text);
  put(text);
}

void DebugOutput::corrected(const Measurement& measurement, const Result<Fused, UpdateFault>& fused,
                            const Belief& belief) {
  std::string text = fmt::format("{} {}:", stamp_text(measurement.stamp), parts_.at(measurement.part));
  const Reading& r = measurement.reading;
  for (std::size_t k = 0; k < static_cast<std::size_t>(r.rows); ++k) {
    fmt::format_to(std::back_inserter(text), " {} {:.9g} ({:.9g}, {:.4g})", kStateNames[r.index[k]], r.value[k],
                   belief.mean[r.index[k]], r.covariance[k * (kStates + 1)]);
  }
  if (fused) {
    fmt::format_to(std::back_inserter(text), ": fused, {:.4g}\n", fused->mahalanobis_squared);
  } else {
    fmt::format_to(std::back_inserter(text), ": {}\n", word_of(fused.error()));
  }
  append_state(measurement.stamp, belief, text);
  put(text);
}

}  // namespace nacelle::ekf
