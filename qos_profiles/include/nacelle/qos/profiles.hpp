// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "nacelle/base/problem.hpp"
#include "nacelle/base/result.hpp"
#include "nacelle/qos/qos.hpp"

namespace nacelle {

/// What a file says about one side of a stream: only the values that it gives.
struct QosPatch {
  std::optional<std::string> profile;  ///< The values to start from: a profile's or a preset's name.
  std::optional<Reliability> reliability;
  std::optional<Durability> durability;
  std::optional<History> history;
  std::optional<std::size_t> depth;
  std::optional<Duration> deadline;  ///< Zero: infinite, said on purpose.
  std::optional<Duration> lifespan;
  std::optional<Liveliness> liveliness;
  std::optional<Duration> lease;
  std::optional<std::size_t> max_samples;
  std::optional<Duration> max_blocking_time;
  std::optional<PoolPolicy> when_dry;

  /// `base` with the given values in place of its own; `profile` is not looked at. A depth alone means keep_last.
  [[nodiscard]] QoS applied_to(QoS base) const;
  friend bool operator==(const QosPatch&, const QosPatch&) = default;
};

/// Sets the value of one key: profile, reliability, durability, history, depth, deadline, lifespan, liveliness, lease,
/// max_samples, max_blocking_time, when_dry.
/// Errors: unknown key or value, with the nearest valid one; `where` is empty. The patch is then unchanged.
[[nodiscard]] Result<void, Problem> set_policy(QosPatch& patch, std::string_view key, std::string_view value);
/// The keys that set_policy() knows.
[[nodiscard]] const std::vector<std::string>& qos_keys();

struct Profile {
  std::string name;
  QoS qos = QoS(10);
  std::string where;  ///< "robot.yaml:12"
};

/// Named profiles; ROS 2's presets are found behind them.
class ProfileSet {
 public:
  ProfileSet() = default;
  explicit ProfileSet(std::vector<Profile> profiles) : profiles_(std::move(profiles)) {}

  [[nodiscard]] const std::vector<Profile>& profiles() const { return profiles_; }
  /// The QoS of a profile, or of the preset with that name.
  /// Errors: unknown name, with the nearest valid one; `where` is empty.
  [[nodiscard]] Result<QoS, Problem> find(std::string_view name) const;
  /// `base`, or the patch's profile where it names one, with the patch's values in place.
  [[nodiscard]] Result<QoS, Problem> apply(const QosPatch& patch, const QoS& base) const;
  /// Profiles first, then presets.
  [[nodiscard]] std::vector<std::string> names() const;

 private:
  std::vector<Profile> profiles_;
};

/// Reads `profiles: {<name>: {<key>: <value>, ...}, ...}`; a profile may start from an earlier one or from a preset.
/// Errors: every problem of the file, each with "<file_name>:<line>". Never throws.
[[nodiscard]] Result<ProfileSet, std::vector<Problem>> parse_profiles(std::string_view text,
                                                                      const std::string& file_name);
/// The same from a file.
[[nodiscard]] Result<ProfileSet, std::vector<Problem>> load_profiles(const std::string& path);

}  // namespace nacelle
