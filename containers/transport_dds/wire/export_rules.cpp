// SPDX-License-Identifier: Apache-2.0
#include "transport_dds/wire/export_rules.hpp"

#include <algorithm>
#include <array>

namespace nacelle::transport_dds {
namespace {

constexpr std::string_view kCompressedImage = "sensor_msgs/msg/CompressedImage";
// Of image_transport's plugins in ROS 2 jazzy.
constexpr std::array<std::string_view, 5> kCompressedForms{"compressed", "compressedDepth", "ffmpeg", "theora", "zstd"};

bool is_compressed_form(const ExportRule& rule, std::string_view topic, std::string_view type) {
  if (topic == rule.topic) return type == kCompressedImage;
  if (topic.size() <= rule.topic.size() || !topic.starts_with(rule.topic) || topic[rule.topic.size()] != '/')
    return false;
  const std::string_view form = topic.substr(rule.topic.size() + 1);
  return std::find(kCompressedForms.begin(), kCompressedForms.end(), form) != kCompressedForms.end();
}

}  // namespace

const ExportRule* rule_of(const std::vector<ExportRule>& rules, std::string_view topic, std::string_view type) {
  const auto found = std::find_if(rules.begin(), rules.end(), [&](const ExportRule& rule) {
    return rule.compressed_only ? is_compressed_form(rule, topic, type) : rule.topic == topic;
  });
  return found == rules.end() ? nullptr : &*found;
}

ExportGate::ExportGate(const ExportRule& rule)
    : period_(rule.max_hz > 0 ? from_seconds(1 / rule.max_hz) : Duration::zero()),
      bytes_per_s_(static_cast<double>(rule.max_bytes_per_s)),
      store_(bytes_per_s_) {}

bool ExportGate::admits(MonotonicTime now, std::size_t bytes) {
  if (!looked_at_) looked_at_ = next_ = now;
  const bool is_limited = period_ > Duration::zero();
  if (is_limited && now < next_) return false;
  const double store = store_at(now);
  if (bytes_per_s_ > 0 && store < needed(bytes)) return false;
  store_ = store - static_cast<double>(bytes);
  looked_at_ = std::max(*looked_at_, now);
  // One that comes a little late does not put off those behind it; a pause is not made up for.
  if (is_limited) next_ = now - next_ < period_ ? next_ + period_ : now + period_ / 2;
  return true;
}

MonotonicTime ExportGate::due(MonotonicTime now, std::size_t bytes) const {
  MonotonicTime at = period_ > Duration::zero() ? std::max(now, next_) : now;
  if (bytes_per_s_ > 0) {
    const double lacking = needed(bytes) - store_at(now);
    // A nanosecond more, so that rounding does not bring us early.
    if (lacking > 0) at = std::max(at, now + from_seconds(lacking / bytes_per_s_) + Duration{1});
  }
  return at;
}

// Messages of several writers do not come quite in the order of their times.
double ExportGate::store_at(MonotonicTime now) const {
  const Duration since = looked_at_ ? std::max(now - *looked_at_, Duration::zero()) : Duration::zero();
  return std::min(bytes_per_s_, store_ + to_seconds(since) * bytes_per_s_);
}

double ExportGate::needed(std::size_t bytes) const { return std::min(static_cast<double>(bytes), bytes_per_s_); }

}  // namespace nacelle::transport_dds
