// SPDX-License-Identifier: Apache-2.0
#include <charconv>

#include "nacelle/qos/profiles.hpp"
#include "nacelle/qos/text.hpp"

namespace nacelle {
namespace {

// Sixteen million messages in one queue is a slip of the pen, not a wish.
constexpr std::size_t kMaxSamples = 1U << 24U;

template <typename T>
Result<void, Problem> put(std::optional<T>& into, const Result<T, Problem>& value) {
  if (!value) return err(value.error());
  into = *value;
  return {};
}

Result<std::size_t, Problem> parse_count(std::string_view key, std::string_view text) {
  std::size_t count = 0;
  const auto [end, fault] = std::from_chars(text.data(), text.data() + text.size(), count);
  if (fault == std::errc{} && end == text.data() + text.size() && count >= 1 && count <= kMaxSamples) return count;
  return err(Problem{"", std::string(key) + " must be a whole number from 1 to " + std::to_string(kMaxSamples), ""});
}

Result<Duration, Problem> parse_policy_duration(std::string_view key, std::string_view text) {
  if (text == "best_available" && (key == "deadline" || key == "lease")) return kBestAvailableDuration;
  auto value = parse_duration(text);
  if (!value) return value;
  if (*value == Duration::max()) return Duration::zero();
  if (*value > Duration::zero()) return value;
  return err(Problem{"", "a " + std::string(key) + " of 0 cannot be kept", "write infinite, or leave it out"});
}

}  // namespace

QoS QosPatch::applied_to(QoS base) const {
  if (reliability) base.reliability(*reliability);
  if (durability) base.durability(*durability);
  if (depth && !history) base.keep_last(*depth);
  if (history) {
    const std::size_t kept = depth.value_or(base.depth());
    if (*history == History::KeepAll) {
      base.keep_all();
    } else {
      base.keep_last(kept).history(*history);
    }
  }
  if (deadline) base.deadline(*deadline);
  if (lifespan) base.lifespan(*lifespan);
  if (liveliness) base.liveliness(*liveliness);
  if (lease) base.liveliness_lease_duration(*lease);
  if (max_samples) base.max_samples(*max_samples);
  if (max_blocking_time) base.max_blocking_time(*max_blocking_time);
  if (when_dry) base.when_dry(*when_dry);
  return base;
}

const std::vector<std::string>& qos_keys() {
  static const std::vector<std::string> keys{"profile", "reliability", "durability",        "history",
                                             "depth",   "deadline",    "lifespan",          "liveliness",
                                             "lease",   "max_samples", "max_blocking_time", "when_dry"};
  return keys;
}

Result<void, Problem> set_policy(QosPatch& patch, std::string_view key, std::string_view value) {
  if (key == "profile") {
    patch.profile = std::string(value);
    return {};
  }
  if (key == "reliability") return put(patch.reliability, parse_reliability(value));
  if (key == "durability") return put(patch.durability, parse_durability(value));
  if (key == "history") return put(patch.history, parse_history(value));
  if (key == "liveliness") return put(patch.liveliness, parse_liveliness(value));
  if (key == "depth") return put(patch.depth, parse_count(key, value));
  if (key == "max_samples") return put(patch.max_samples, parse_count(key, value));
  if (key == "deadline") return put(patch.deadline, parse_policy_duration(key, value));
  if (key == "lifespan") return put(patch.lifespan, parse_policy_duration(key, value));
  if (key == "lease" || key == "liveliness_lease_duration")
    return put(patch.lease, parse_policy_duration("lease", value));
  if (key == "max_blocking_time") return put(patch.max_blocking_time, parse_duration(value));
  if (key == "when_dry") return put(patch.when_dry, parse_pool_policy(value));
  return err(Problem{"", "unknown QoS key '" + std::string(key.substr(0, 60)) + "'",
                     suggestion(key.substr(0, 60), qos_keys())});
}

}  // namespace nacelle
